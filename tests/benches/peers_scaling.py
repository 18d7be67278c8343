"""How our speed grows with threads and our cost with triangles; part of peers.py."""
import array, json, math, os

MATERIAL = "preset:Moulded plastic, red"
TRIANGLES = (1e4, 3e4, 1e5, 3e5, 1e6, 5e6)


def write_ball(path, triangles):
    """A ball with waves of about so many triangles as binary PLY; returns how many there are."""
    rows = max(4, int(math.sqrt(triangles / 4)))
    columns = 2 * rows
    vertices = array.array("f")
    for i in range(rows + 1):
        theta = math.pi * i / rows
        y, s = math.cos(theta), math.sin(theta)
        for j in range(columns + 1):
            phi = 2 * math.pi * j / columns
            nx, nz = s * math.cos(phi), s * math.sin(phi)
            r = 1 + 0.02 * math.sin(24 * theta) * math.sin(24 * phi) * s
            vertices.extend((r * nx, r * y, r * nz, nx, y, nz, j / columns, i / rows))
    faces = bytearray()
    count = 0
    for i in range(rows):
        line = bytearray()
        for j in range(columns):
            a = i * (columns + 1) + j
            b = a + columns + 1
            # At the poles one of the two triangles has no area.
            two = [(a, a + 1, b)] * (i > 0) + [(a + 1, b + 1, b)] * (i < rows - 1)
            for triangle in two: line += b"\x03" + array.array("i", triangle).tobytes()
            count += len(two)
        faces += line
    names = "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz", "u", "v"))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices) // 8}\n{names}element face {count}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "wb") as f:
        f.write(head.encode())
        f.write(vertices.tobytes())
        f.write(faces)
    return count


def run(bench):
    a = bench.a
    size = f"{a.size}x{a.size}"
    render = lambda *words: json.loads(bench.call([a.burnish, "render", *words, "--size", size, "--out", bench.file("scaling.exr"), "--json"]))
    scenes = [s for s in bench.scenes if s.partition("_")[0] in ("s1", "s4", "s6", "s7")]
    cases = {s: ["--scene", bench.scenes[s]] for s in scenes} or {"default scene": [MATERIAL]}
    for name, words in cases.items():
        for round in range(max(3, a.rounds)):
            for threads in (1, 2):
                pick = lambda d: {"samples_per_second": d["samples_per_second"]}
                make = lambda: pick(render(*words, "--spp", 32 if name != "s7_wax" else 8, "--threads", threads))
                bench.job(f"threads {name} {threads} {size} round {round}", make)
    for wanted in counts(a):
        path = bench.file(f"ball_{int(wanted)}.ply")
        def make():
            triangles = write_ball(path, wanted)
            d = render(MATERIAL, "--mesh", path, "--spp", 32, "--threads", a.threads)
            return {"triangles": triangles, **{k: d[k] for k in ("samples_per_second", "load_seconds", "peak_memory_bytes")}}
        bench.job(f"triangles {int(wanted)} {size} {a.threads}", make)
        if os.path.exists(path): os.remove(path)


def counts(a): return [float(n) for n in a.triangles.split(",")] if a.triangles else TRIANGLES


def report(bench, out):
    """Lines for the report; also scaling.csv and scaling.svg in the work folder."""
    a, size, text = bench.a, f"{bench.a.size}x{bench.a.size}", []
    names = {k.split(" ")[1] if not k.startswith("threads default") else "default scene" for k in bench.rows if k.startswith("threads ")}
    for name in sorted(names):
        ratios = []
        for round in range(max(3, a.rounds)):
            pair = [bench.rows.get(f"threads {name} {n} {size} round {round}") for n in (1, 2)]
            if all(pair): ratios.append(pair[1]["samples_per_second"] / pair[0]["samples_per_second"])
        if ratios: out.setdefault("thread_ratio", {})[name] = sorted(ratios)[len(ratios) // 2]
    if out.get("thread_ratio"): text += ["", "Two threads over one, median of interleaved pairs: " + ", ".join(f"{n} {r:.2f}" for n, r in out["thread_ratio"].items()) + "."]
    rows = [bench.rows.get(f"triangles {int(n)} {size} {a.threads}") for n in counts(a)]
    rows = [r for r in rows if r]
    if len(rows) < 2: return text
    first, last = rows[0], rows[-1]
    table = [(r["triangles"], 1e6 / r["samples_per_second"], r["load_seconds"], r["peak_memory_bytes"]) for r in rows]
    memory = (last["peak_memory_bytes"] - first["peak_memory_bytes"]) / (last["triangles"] - first["triangles"])
    growth = first["samples_per_second"] / last["samples_per_second"]
    logarithm = math.log(last["triangles"]) / math.log(first["triangles"])
    out["triangles"] = {"rows": [dict(zip(("triangles", "us_per_sample", "load_seconds", "peak_memory_bytes"), r)) for r in table],
                        "bytes_per_triangle": memory, "cost_growth": growth, "logarithmic_growth": logarithm}
    text += ["", f"Cost of a sample from {first['triangles']} to {last['triangles']} triangles grows by {growth:.2f}; the logarithm of their number by {logarithm:.2f}. "
             f"Peak memory per triangle, loading included: {memory:.0f} bytes.", "", "| triangles | us per sample | seconds to load | peak MB |", "| --: | --: | --: | --: |"]
    text += [f"| {n} | {c:.3f} | {s:.2f} | {m / 1e6:.0f} |" for n, c, s, m in table]
    with open(bench.file("scaling.csv"), "w") as f:
        f.write("triangles,us_per_sample,load_seconds,peak_memory_bytes\n" + "".join(f"{n},{c},{s},{m}\n" for n, c, s, m in table))
    with open(bench.file("scaling.svg"), "w") as f: f.write(chart([(n, c) for n, c, _, _ in table]))
    return text


def chart(points):
    """Cost against triangles, the latter on a log axis; the dashed line grows as their logarithm."""
    low, high = math.floor(math.log10(points[0][0])), math.ceil(math.log10(points[-1][0]))
    first = points[0]
    law = [(n, first[1] * math.log(n) / math.log(first[0])) for n, _ in points]
    top = 1.1 * max(c for _, c in points + law)
    x = lambda n: 60 + 420 * (math.log10(n) - low) / (high - low)
    y = lambda c: 260 - 240 * c / top
    line = lambda p: " ".join(f"{x(n):.1f},{y(c):.1f}" for n, c in p)
    parts = [f'<line x1="{x(10 ** d):.1f}" y1="20" x2="{x(10 ** d):.1f}" y2="260" stroke="#ccc"/><text x="{x(10 ** d):.1f}" y="278" text-anchor="middle">1e{d}</text>' for d in range(low, high + 1)]
    parts += [f'<line x1="60" y1="{y(top * k / 4):.1f}" x2="480" y2="{y(top * k / 4):.1f}" stroke="#ccc"/><text x="54" y="{y(top * k / 4) + 4:.1f}" text-anchor="end">{top * k / 4:.2f}</text>' for k in range(5)]
    parts += [f'<polyline points="{line(law)}" fill="none" stroke="#a34700" stroke-width="2" stroke-dasharray="6 4"/>', f'<polyline points="{line(points)}" fill="none" stroke="#0b5cad" stroke-width="2"/>']
    parts += [f'<rect x="{x(n) - 3:.1f}" y="{y(c) - 3:.1f}" width="6" height="6" fill="#0b5cad"/>' for n, c in points]
    parts += ['<text x="270" y="300" text-anchor="middle">triangles</text><text x="70" y="34">us per sample (solid); logarithm of the count (dashed)</text>']
    return ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 500 310" role="img" font-family="sans-serif" font-size="12"><title>Cost of a sample against triangles</title>'
            '<rect width="500" height="310" fill="#fff"/>' + "".join(parts) + "</svg>\n")
