#!/usr/bin/env python3
"""Draws opaque presets as glTF in programs that are not ours, beside our preview.

  apt-get install chromium nodejs npm; npm install --prefix /tmp/independent three@0.187 puppeteer-core@25
  python3.11 -m venv /tmp/independent/venv; /tmp/independent/venv/bin/pip install numpy pillow openexr bpy==4.5.15
  cargo build --release; /tmp/independent/venv/bin/python tests/benches/independent/run.py --burnish target/release/burnish --modules /tmp/independent/node_modules --work /tmp/independent/work

Each preset is written by `burnish convert --bare` on a ball, drawn by our preview on the mesh of that file, by three.js in
headless Chromium (`page.html`), and by Blender's importer and Cycles (`blender.py`; left out without bpy): same camera, same
environment as a file. Pictures are linear; `burnish compare` shows all through the same display transform.
What stands in WORK already is not made again. The table goes to WORK/table.md, the pictures to
WORK/sheet.jpg; both stand with what explains them in `tests/benches/results/independent_gltf.md`.
"""
import argparse, importlib.util, json, math, os, subprocess, sys

import numpy as np, OpenEXR

import report

PRESETS = [
    "Porcelain, glazed", "Moulded plastic, red", "Granite, polished", "Terracotta", "Tyre rubber", "Grey card, 18 %",
    "Chromium plate", "Gold, polished", "Titanium, satin", "Iron, rusted",
    "Aluminium, brushed", "Copper, brushed", "PLA print",
    "Car paint, metallic blue", "Car paint, solid red", "Walnut, lacquered", "Mahogany, polished", "Aluminium, anodised red",
    "Silk, mulberry", "Velvet, crimson", "Wool felt, green", "SDR screen white", "Iron, glowing",
]
# The ball of `--mesh sphere` in metres, seen so that it nearly fills the picture.
CENTER, RADIUS, DISTANCE, AZIMUTH, ELEVATION, FOV = (0.0, 0.127, 0.0), 0.1, 0.5, 20.0, 15.0, 24.0
# Share of the picture that is ball.
COVER = math.pi / 4 * (math.tan(math.asin(RADIUS / DISTANCE)) / math.tan(math.radians(FOV / 2))) ** 2
# Soft boxes: direction as azimuth and elevation, half sizes, all in degrees; radiance.
BOXES = [((-50, 44), (17, 20), (14.6, 14.0, 13.0)), ((68, 16), (8, 28), (5.0, 5.4, 6.0)), ((148, 30), (6, 26), (19, 20, 22)),
         ((-142, 22), (5, 22), (14.0, 12.8, 10.8)), ((0, 82), (20, 8), (12.8, 13.0, 13.3)), ((20, 55), (3, 3), (40, 40, 40))]


def toward(azimuth, elevation):
    a, e = math.radians(azimuth), math.radians(elevation)
    return np.array([math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a)])


def environment(width=1024):
    """A studio: soft boxes in a room that is brighter above. Our mapping: -Z at the left edge, +Z in the middle, the zenith in row 0."""
    v, u = np.mgrid[0:width // 2, 0:width] + 0.5
    phi, theta = u / width * 2 * np.pi, v / (width // 2) * np.pi
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], -1)
    sky = (0.12 + 0.28 * (0.5 + 0.5 * d[..., 1:2]) ** 2) * np.array([0.9, 1.0, 1.1])
    for where, (half_width, half_height), radiance in BOXES:
        middle = toward(*where)
        side = np.cross([0, 1, 0], middle); side /= np.linalg.norm(side)
        x, y = np.degrees(np.arcsin(d @ side)), np.degrees(np.arcsin(d @ np.cross(middle, side)))
        inside = np.clip(half_width + 0.75 - abs(x), 0, 1.5) / 1.5 * np.clip(half_height + 0.75 - abs(y), 0, 1.5) / 1.5 * (d @ middle > 0)
        sky += inside[..., None] * np.array(radiance)
    return sky.astype(np.float32)


def write(path, rgb):
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": rgb}).write(path)


def read(path):
    return OpenEXR.File(path).channels()["RGB"].pixels.astype(np.float32)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--burnish", required=True)
    parser.add_argument("--modules", required=True, help="node_modules with three and puppeteer-core")
    parser.add_argument("--work", required=True)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=64, help="samples of our preview and of Cycles")
    parser.add_argument("--only", help="presets whose name holds this")
    a = parser.parse_args()
    a.work, a.modules = os.path.abspath(a.work), os.path.abspath(a.modules)
    os.makedirs(a.work, exist_ok=True)
    file = lambda name: os.path.join(a.work, name)

    presets = {"".join(c if c.isalnum() else "-" for c in p.lower()): p for p in PRESETS if not a.only or a.only in p.lower()}
    origin = np.array(CENTER) + DISTANCE * toward(AZIMUTH, ELEVATION)
    scene = {"size": a.size, "spp": a.spp, "fov_deg": FOV, "origin": origin.tolist(), "target": CENTER}
    json.dump({"scene": scene}, open(file("scene.json"), "w"))
    sky = environment()
    write(file("environment.exr"), sky)
    # three.js and Blender put -Z a quarter further to the right.
    write(file("environment-quarter.exr"), np.roll(sky, sky.shape[1] // 4, axis=1))

    burnish = lambda *words: subprocess.run([a.burnish, *words], check=False, capture_output=True, text=True)
    view = ["--backdrop", "none", "--environment", file("environment.exr"), "--camera", f"{AZIMUTH},{ELEVATION},{DISTANCE}",
            "--fov", str(FOV), "--size", f"{a.size}x{a.size}"]
    for name, preset in presets.items():
        steps = [(f"{name}.glb", ["convert", f"preset:{preset}", file(f"{name}.glb"), "--mesh", "sphere", "--bare"])]
        steps += [(f"{name}.{kind}.exr", ["render", f"preset:{preset}", "--mesh", file(f"{name}.glb"), *view, "--view", kind,
                   "--spp", str(a.spp), "--out", file(f"{name}.{kind}.exr")]) for kind in ("preview", "final")]
        for made, words in steps:
            if os.path.exists(file(made)): continue
            done = burnish(*words)
            if done.returncode: sys.exit(f"{preset}: {done.stderr.strip()}")
            print(f"burnish: {made}", file=sys.stderr, flush=True)

    here = os.path.dirname(os.path.abspath(__file__))
    missing = lambda ending: [name for name in presets if not os.path.exists(file(f"{name}.{ending}"))]
    if todo := missing("three.f32"):
        subprocess.run(["node", os.path.join(here, "chromium.mjs"), a.modules, a.work, a.chromium, *todo], check=True)
    if importlib.util.find_spec("bpy") and (todo := missing("cycles.exr")):
        subprocess.run([sys.executable, os.path.join(here, "blender.py"), a.work, *todo], check=True, stdout=subprocess.DEVNULL)

    rows = []
    for name, preset in presets.items():
        pictures = {kind: read(file(f"{name}.{kind}.exr")) for kind in ("preview", "final", "cycles") if os.path.exists(file(f"{name}.{kind}.exr"))}
        pictures["three"] = np.fromfile(file(f"{name}.three.f32"), np.float32).reshape(a.size, a.size, 3)
        write(file(f"{name}.three.exr"), pictures["three"])

        def compare(one, other):
            if one not in pictures or other not in pictures: return None
            heat = file(f"{name}.{one}-{other}.png")
            done = burnish("compare", file(f"{name}.{one}.exr"), file(f"{name}.{other}.exr"), "--heatmap", heat, "--json")
            if done.returncode: sys.exit(f"{preset}: {done.stderr.strip()}")
            return json.loads(done.stdout)
        pairs = {pair: compare(*pair) for pair in [("three", "preview"), ("cycles", "preview"), ("cycles", "final"), ("final", "preview")]}
        rows.append({"name": name, "preset": preset, "pairs": pairs, "pictures": pictures})
    report.write(rows, a.work, COVER)


if __name__ == "__main__": main()
