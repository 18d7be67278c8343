#!/usr/bin/env python3
"""Burnish beside other path tracers, in one run on the same cores.

  peers.py MODE [MODE ...] --work DIR [--runner run_peer.py] [--mitsuba PY] [--cycles PY] [--luxcore PY] [options]

MODE: errors   seconds to relMSE 0.01 and 0.001 (and trimmed 0.003), ratios to the fastest peer, their geometric mean
      latency  process start to first image, edit to first image
      scaling  one thread against two; cost and memory from 1e4 to 5e6 triangles (ours alone)
      report   only writes the report from what --work holds

PY is the Python of the environment that holds the peer; a peer without one is left out. The runner renders one scene with one
peer and prints a JSON line per render. Results go to DIR/results.jsonl as they come: a run that was cut short continues where
it stopped, and a peer that fails costs only its own rows. The report is DIR/report.json and DIR/report.md.

Everybody is compared with an own reference of other seeds. Peers: two references h1, h2 of different seeds; the error of x is the mean
of relMSE(x, h1) and relMSE(x, h2) less half of relMSE(h1, h2). Ours: `burnish converge` against a rendering with a layer `variance`, which is
taken off.
Seconds leave loading out: ours are rendering alone, a peer's are its samples times the slope of wall seconds over samples.
Times between two counts are interpolated on log axes; beyond the last count they are extrapolated and marked with *.

--reuse-references  peers' references and their noise from `reference/index.json` beside the runner, where the size fits
--reuse-errors      peers' error per sample from `results/errors_measured.json` beside the runner; only their speed is measured
--quick             both, shorter curves and fewer scenes for latency: about 25 minutes on two free cores at 256x256
"""
import argparse, json, math, os, shutil, subprocess, sys, tempfile, time

import peers_scaling

PEERS = {"mitsuba": "mitsuba:llvm_ad_rgb", "mitsuba-mj": "mitsuba:llvm_ad_rgb+multijitter", "cycles": "cycles", "luxcore": "luxcore"}
COUNTS = {"mitsuba": [1, 4, 16, 64, 256], "mitsuba-mj": [4, 16, 64, 256], "cycles": [1, 4, 16, 64, 256], "luxcore": [1, 4, 16, 64]}
REFERENCE = {"mitsuba": 1024, "cycles": 384, "luxcore": 256}
SPEED = {"mitsuba": [1, 33], "mitsuba-mj": [4, 36], "cycles": [1, 13], "luxcore": [1, 13]}
UNCONVERGED = ("s3_mirror_sun", "s8b_dispersion")
TARGETS = (0.01, 0.001)


def family(peer): return peer.partition("-")[0]


class Bench:
    def __init__(self, a):
        self.a = a
        os.makedirs(a.work, exist_ok=True)
        self.path = os.path.join(a.work, "results.jsonl")
        self.rows = {}
        if os.path.exists(self.path):
            for line in open(self.path):
                try: row = json.loads(line)
                except ValueError: continue            # the line that was being written when a run was cut short
                if "failed" not in row: self.rows[row["key"]] = row
        self.pin = ["taskset", "-c", a.cores] if a.cores and shutil.which("taskset") else []
        self.home = os.path.dirname(os.path.abspath(a.runner)) if a.runner else None
        folder = a.scenes or (os.path.join(self.home, "scenes") if self.home else None)
        names = sorted(f[:-5] for f in os.listdir(folder) if f.endswith(".json")) if folder else []
        only = a.only.split(",") if a.only else None
        self.scenes = {n: os.path.join(folder, n + ".json") for n in names if not only or n in only or n.partition("_")[0] in only}
        wanted = a.peers.split(",") if a.peers else list(PEERS)
        self.peers = [p for p in PEERS if p in wanted and getattr(a, family(p)) and a.runner]

    def file(self, name): return os.path.join(self.a.work, name)

    def call(self, words):
        """Runs pinned; standard output, or an exception that says what went wrong."""
        done = subprocess.run(self.pin + [str(w) for w in words], capture_output=True, text=True, timeout=self.a.timeout)
        if done.returncode not in (0, 1) or not done.stdout.strip():
            raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()[-400:]}")
        return done.stdout

    def job(self, key, make):
        """The row of a key: from an earlier run, else made now. None where making it failed."""
        if key in self.rows: return self.rows[key]
        start = time.time()
        try: row = dict(make(), key=key)
        except (RuntimeError, subprocess.SubprocessError, OSError, ValueError, KeyError, IndexError) as error:
            row = {"key": key, "failed": str(error)}
        row["took_s"] = round(time.time() - start, 2)
        with open(self.path, "a") as f: f.write(json.dumps(row) + "\n")
        print(f"{row['took_s']:8.1f} s  {key}" + (f"  FAILED {row['failed']}" if "failed" in row else ""), file=sys.stderr, flush=True)
        if "failed" in row: return None
        self.rows[key] = row
        return row

    def peer(self, peer, scene, *words):
        python = getattr(self.a, family(peer))
        out = self.call([python, self.a.runner, PEERS[peer], self.scenes[scene], "--threads", self.a.threads, *words])
        return [json.loads(line) for line in out.splitlines() if line.startswith("{")]

    def ours(self, *words): return json.loads(self.call([self.a.burnish, *words, "--threads", self.a.threads, "--json"]))

    def compare(self, x, reference):
        d = json.loads(self.call([self.a.burnish, "compare", x, reference, "--json"]))
        return d["relmse"], d["relmse_trimmed"]

    def can(self, peer, scene):
        """Whether the scene has a mapping for the peer."""
        with open(self.scenes[scene]) as f: materials = json.load(f)["materials"]
        return materials["test"].get("peers", {}).get(family(peer)) is not None

    # ------------------------------------------------------------------ errors

    def run_errors(self):
        a = self.a
        for scene, path in self.scenes.items():
            size = f"{a.size}x{a.size}"
            common = ["--scene", path, "--size", size]
            speed = lambda: self.ours("render", *common, "--spp", 8 if scene == "s7_wax" else 32, "--out", self.file("speed.exr"))
            keep = lambda d: {k: d[k] for k in ("samples_per_second", "seconds")}
            self.job(f"drift {scene} before {size}", lambda: keep(speed()))
            own = self.own_reference(scene, common)
            for round in range(a.rounds):
                words = ["converge", *common, "--seconds", a.seconds, "--reference", own, "--seed", round]
                if own: self.job(f"ours {scene} {size} round {round}", lambda: {"curve": self.ours(*words)})
                for peer in self.peers:
                    if self.can(peer, scene): self.job(f"speed {peer} {scene} {size} round {round}", lambda: self.speed(peer, scene))
            for peer in self.peers:
                if self.can(peer, scene): self.errors_of(peer, scene)
            self.job(f"drift {scene} after {size}", lambda: keep(speed()))

    def own_reference(self, scene, common):
        """Our reference with the variance of its pixels, made once for all rounds."""
        a = self.a
        stop = ["--spp", a.reference_spp] if a.reference_spp else ["--time", 8 * a.seconds]
        out = self.file(f"ref_burnish_{scene}_{a.size}_{stop[1]}.exr")
        words = ["render", *common, *stop, "--seed", 424242, "--aov", "variance", "--out", out]
        key = f"reference burnish {scene} {a.size} {' '.join(map(str, stop))}"
        row = self.job(key, lambda: {k: v for k, v in self.ours(*words).items() if k in ("spp", "seconds", "relmse_estimate")})
        return out if row and os.path.exists(out) else None

    def speed(self, peer, scene):
        counts = [max(1, n // 4) if scene == "s7_wax" and n > 1 else n for n in SPEED[peer]]
        rows = self.peer(peer, scene, "--res", self.a.size, "--spp", ",".join(map(str, counts)), "--repeat", 2, "--warm", 1)
        low, high = rows[0], rows[-1]
        samples = high["spp_done"] - low["spp_done"]
        per_spp = (min(high["walls"]) - min(low["walls"])) / samples
        if per_spp <= 0: raise ValueError("more samples took no longer")
        cpu = (min(high["cpus"]) - min(low["cpus"])) / samples
        return {"seconds_per_spp": per_spp, "cpu_seconds_per_spp": cpu, "msamples_s": self.a.size ** 2 / per_spp / 1e6, "load_s": low["load_s"]}

    def errors_of(self, peer, scene):
        a, size = self.a, self.a.size
        if a.reuse_errors and self.stored_errors(peer, scene): return
        reference = self.reference(peer, scene)
        if not reference: return
        counts = COUNTS[peer][:-1] if a.quick or scene == "s7_wax" else COUNTS[peer]
        def make():
            out = self.file(f"{peer}_{scene}")
            points = []
            for row in self.peer(peer, scene, "--res", size, "--spp", ",".join(map(str, counts)), "--seed", 1, "--out", out):
                x = [self.compare(f"{out}_{row['spp']}.exr", h) for h in reference["files"]]
                mean = [sum(v[k] for v in x) / len(x) for k in (0, 1)]
                n, noise = row["spp_done"], reference.get("noise")
                if noise is None:                        # nothing known of the reference but its count
                    e = [v / (1 + n / reference["spp"]) for v in mean]
                else: e = [max(v - w, 0.0) for v, w in zip(mean, noise)]
                points.append({"spp": n, "relmse": e[0], "relmse_trimmed": e[1]})
            return {"points": points, "size": size, "reference": {k: v for k, v in reference.items() if k != "files"}}
        self.job(f"errors {peer} {scene} {size}", make)

    def stored_errors(self, peer, scene):
        """Points (spp, error) of an earlier run, or None."""
        path = self.home and os.path.join(self.home, "results", "errors_measured.json")
        if not path or not os.path.exists(path): return None
        with open(path) as f: rows = [r for r in json.load(f) if r["peer"] == peer and r["scene"] == scene]
        points = [{"spp": r["n"], "relmse": r["e"], "relmse_trimmed": r["et"]} for r in sorted(rows, key=lambda r: r["n"])]
        return points if len(points) > 1 else None

    def reference(self, peer, scene):
        """Files to compare with, and their noise (plain, trimmed). Both samplers of Mitsuba share a reference."""
        a, kind = self.a, family(peer)
        if a.reuse_references and self.home:
            name = f"{scene}.exr" if kind == "mitsuba" else f"{kind}/{scene}.exr"
            with open(os.path.join(self.home, "reference", "index.json")) as f: entry = json.load(f).get(name)
            if entry and entry["res"] == a.size:
                noise = [entry["noise_relmse"]] * 2 if "noise_relmse" in entry else None
                return {"files": [os.path.join(self.home, "reference", name)], "noise": noise, "spp": entry["spp"], "is_stored": True}
        spp = a.peer_reference_spp or (REFERENCE[kind] // 4 if a.quick else REFERENCE[kind])
        files = [self.file(f"ref{k}_{kind}_{scene}_{a.size}.exr") for k in (1, 2)]
        for k, out in enumerate(files):
            make = lambda: self.peer(kind, scene, "--res", a.size, "--spp", spp, "--seed", 777 + k, "--out", out)[-1]
            if not self.job(f"reference {kind} {scene} {a.size} {spp} seed {777 + k}", make) or not os.path.exists(out): return None
        # Half of what tells the two apart is the noise of one.
        noise = self.job(f"noise {kind} {scene} {a.size} {spp}", lambda: {"noise": [e / 2 for e in self.compare(*files)]})
        return noise and {"files": files, "noise": noise["noise"], "spp": spp, "is_stored": False}

    # ----------------------------------------------------------------- latency

    def run_latency(self):
        a = self.a
        scenes = [s for s in self.scenes if not a.quick or s.partition("_")[0] in ("s1", "s4", "s6")]
        for scene in scenes:
            for round in range(a.rounds):
                self.job(f"latency ours {scene} round {round}", lambda: self.own_latency(scene))
                for peer in self.peers:
                    if peer != "mitsuba-mj" and self.can(peer, scene):
                        words = ["--res", a.latency_size, "--latency"]
                        pick = lambda d: {"start_s": d["start_to_first_s"], "edit_s": d["edit_median_s"]}
                        self.job(f"latency {peer} {scene} round {round}", lambda: pick(self.peer(peer, scene, *words)[-1]))

    def own_latency(self, scene):
        """From the start of the process to the end of it with one sample per pixel written: more than to the first image."""
        size = f"{self.a.latency_size}x{self.a.latency_size}"
        start = time.time()
        d = self.ours("render", "--scene", self.scenes[scene], "--size", size, "--spp", 1, "--out", self.file("first.exr"))
        row = {"start_s": time.time() - start, "first_image_seconds": d["first_image_seconds"]}
        if self.a.first_image:
            edit = json.loads(self.call([self.a.first_image, self.scenes[scene], self.a.latency_size]))
            row.update(edit_s=edit["edit_to_first_s"], edit_full_s=edit["edit_to_full_resolution_s"])
        return row


# ---------------------------------------------------------------------- report

def seconds_to(points, target):
    """Seconds to an error and whether they are extrapolated, of points (seconds, error) in order of seconds."""
    x = [(math.log(t), math.log(e)) for t, e in points if t > 0 and e > 0]
    goal = math.log(target)
    if len(x) < 2: return None
    for (a, ea), (b, eb) in zip(x, x[1:]):
        if ea >= goal >= eb and ea > eb: return math.exp(a + (goal - ea) / (eb - ea) * (b - a)), False
    if goal > x[0][1]: return math.exp(x[0][0] + x[0][1] - goal), True
    tail = x[-4:]
    mx, my = (sum(p[k] for p in tail) / len(tail) for k in (0, 1))
    slope = -sum((p[0] - mx) * (p[1] - my) for p in tail) / sum((p[0] - mx) ** 2 for p in tail)
    slope = min(max(slope, 0.8), 1.6)
    return math.exp(mx + (my - goal) / slope), True


def median(values):
    values = sorted(v for v in values if v is not None)
    return values[len(values) // 2] if values else None


def curves(bench, scene):
    """Per renderer points (seconds, relmse, trimmed); what the errors of a peer were taken from."""
    size = bench.a.size
    found = {}
    ours = [bench.rows.get(f"ours {scene} {size}x{size} round {r}") for r in range(bench.a.rounds)]
    ours = [[(p["seconds"], p["relmse"], p["relmse_trimmed"]) for p in r["curve"]["rows"]] for r in ours if r]
    if ours: found["burnish"] = ours, "this run"
    for peer in PEERS:
        speeds = [bench.rows.get(f"speed {peer} {scene} {size}x{size} round {r}") for r in range(bench.a.rounds)]
        per_spp = median([s["seconds_per_spp"] for s in speeds if s])
        row = bench.rows.get(f"errors {peer} {scene} {size}")
        points, source = (row["points"], "this run") if row else (None, None)
        if row and row["reference"]["is_stored"]: source = "this run, stored reference"
        if not points and bench.a.reuse_errors: points, source = bench.stored_errors(peer, scene), "stored errors"
        if per_spp and points: found[peer] = [[(p["spp"] * per_spp, p["relmse"], p["relmse_trimmed"]) for p in points]], source
    return found


def scene_report(bench, scene):
    rows = {}
    for name, (runs, source) in curves(bench, scene).items():
        row = {"errors_from": source}
        for label, index, target in (("0.01", 1, 0.01), ("0.001", 1, 0.001), ("trimmed 0.01", 2, 0.01), ("trimmed 0.003", 2, 0.003), ("trimmed 0.001", 2, 0.001)):
            times = sorted(t for t in (seconds_to([(p[0], p[index]) for p in run], target) for run in runs) if t)
            row[label] = times[len(times) // 2] if times else None
        rows[name] = row
    return rows


def ratio(rows, ours, theirs):
    """The fastest peer's seconds to `theirs` over ours to `ours`."""
    own = rows.get("burnish", {}).get(ours)
    peers = [(row[theirs][0], name) for name, row in rows.items() if name != "burnish" and row.get(theirs)]
    if not own or not peers: return None
    best, name = min(peers)
    return {"ratio": best / own[0], "peer": name}


def geometric_mean(values): return math.exp(sum(map(math.log, values)) / len(values)) if values else None


def show(t): return "-" if not t else f"{t[0]:.3g}{'*' if t[1] else ''}"


def report(bench):
    a = bench.a
    out = {"size": a.size, "threads": a.threads, "cores": a.cores, "scenes": {}, "ratios": {}, "geometric_mean": {}, "latency": {}, "drift": {}}
    text = [f"Seconds of rendering at {a.size}x{a.size} on {a.threads} threads (cores {a.cores}); * extrapolated; ratio: the fastest peer's seconds over ours.", ""]
    pairs = {"0.01": ("0.01",) * 2, "0.001": ("0.001",) * 2, "trimmed 0.01": ("trimmed 0.01",) * 2, "trimmed 0.001": ("trimmed 0.001",) * 2,
             "ours trimmed 0.001, theirs trimmed 0.003": ("trimmed 0.001", "trimmed 0.003")}
    labels = ["0.01", "0.001", "trimmed 0.01", "trimmed 0.003", "trimmed 0.001"]
    text += ["| scene | renderer | " + " | ".join(labels) + " | errors from |", "| --- | --- |" + " --: |" * len(labels) + " --- |"]
    for scene in bench.scenes:
        rows = scene_report(bench, scene)
        if not rows: continue
        out["scenes"][scene] = rows
        out["ratios"][scene] = {label: ratio(rows, *pair) for label, pair in pairs.items()}
        for name, row in rows.items():
            text.append(f"| {scene} | {name} | " + " | ".join(show(row[k]) for k in labels) + f" | {row['errors_from']} |")
        drift = [bench.rows.get(f"drift {scene} {w} {a.size}x{a.size}") for w in ("before", "after")]
        if all(drift): out["drift"][scene] = drift[1]["samples_per_second"] / drift[0]["samples_per_second"]
    text += ["", "| scene | " + " | ".join(pairs) + " |", "| --- |" + " --: |" * len(pairs)]
    for scene, ratios in out["ratios"].items():
        text.append(f"| {scene} | " + " | ".join(f"{r['ratio']:.2f} ({r['peer']})" if r else "-" for r in ratios.values()) + " |")
    for label in pairs:
        values = [r[label]["ratio"] for s, r in out["ratios"].items() if r[label] and s not in UNCONVERGED]
        out["geometric_mean"][label] = geometric_mean(values)
    text.append("| geometric mean without " + ", ".join(s.partition("_")[0] for s in UNCONVERGED) + " | "
                + " | ".join(f"{v:.2f}" if v else "-" for v in out["geometric_mean"].values()) + " |")
    if not out["scenes"]: text = []
    if out["drift"]: text += ["", "Own speed after the peers over before them: " + ", ".join(f"{s} {v:.2f}" for s, v in out["drift"].items()) + "."]

    lines = []
    for scene in bench.scenes:
        found = {}
        for name in ["ours", *PEERS]:
            rows = [bench.rows.get(f"latency {name} {scene} round {r}") for r in range(a.rounds)]
            rows = [r for r in rows if r]
            if rows: found[name] = {k: median([r.get(k) for r in rows]) for k in ("start_s", "edit_s", "edit_full_s")}
        if not found: continue
        out["latency"][scene] = found
        f = lambda v: f"{v:.3f}" if v is not None else "-"
        lines += [f"| {scene} | {name} | {f(v['start_s'])} | {f(v['edit_s'])} | {f(v['edit_full_s'])} |" for name, v in found.items()]
    if lines:
        text += ["", f"First image at {a.latency_size}x{a.latency_size}, seconds. Ours from the start: until the process has ended with its file written. From an edit: the first "
                 "whole picture, which may be coarse, and the first one at full resolution.", "",
                 "| scene | renderer | from the start | from an edit | full resolution |", "| --- | --- | --: | --: | --: |", *lines]
    text += peers_scaling.report(bench, out)
    with open(bench.file("report.json"), "w") as f: json.dump(out, f, indent=1)
    with open(bench.file("report.md"), "w") as f: f.write("\n".join(text) + "\n")
    print("\n".join(text))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("modes", nargs="+", choices=("errors", "latency", "scaling", "report"), metavar="MODE")
    ap.add_argument("--work", required=True, help="folder for results; give the same one again to continue")
    ap.add_argument("--runner", help="path of run_peer.py; without it, ours alone")
    ap.add_argument("--scenes", help="folder of asm-bench-scene/1 files [default: scenes beside the runner]")
    for kind in ("mitsuba", "cycles", "luxcore"): ap.add_argument("--" + kind, metavar="PY")
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    ap.add_argument("--burnish", default=os.path.join(root, "target", "release", "burnish"))
    ap.add_argument("--first-image", metavar="PROGRAM", help="bench `first_image` (target/release/deps/first_image-*), for edit to first image")
    ap.add_argument("--only", help="scenes, such as s1,s4"); ap.add_argument("--peers", help="among " + ",".join(PEERS))
    ap.add_argument("--size", type=int, default=256); ap.add_argument("--latency-size", type=int, default=512)
    ap.add_argument("--threads", type=int, default=2); ap.add_argument("--cores", default="0,1", help="for taskset; empty: not pinned")
    ap.add_argument("--seconds", type=float, help="of our curve [20; quick 6]"); ap.add_argument("--rounds", type=int, help="of ours and of speeds, in turn [3; quick 2]")
    ap.add_argument("--reference-spp", type=int, help="of our reference [as many as fit into 8 times --seconds]")
    ap.add_argument("--peer-reference-spp", type=int, help="of each of a peer's two references")
    ap.add_argument("--triangles", help="of the meshes for scaling, such as 1e4,1e5")
    ap.add_argument("--timeout", type=float, default=3600.0, help="seconds for one process")
    ap.add_argument("--reuse-references", action="store_true"); ap.add_argument("--reuse-errors", action="store_true"); ap.add_argument("--quick", action="store_true")
    a = ap.parse_args()
    if a.quick: a.reuse_references = a.reuse_errors = True
    a.seconds = a.seconds or (6.0 if a.quick else 20.0)
    a.rounds = a.rounds or (2 if a.quick else 3)
    if not os.access(a.burnish, os.X_OK): ap.error(f"--burnish: {a.burnish}: expected the built program")
    bench = Bench(a)
    if "errors" in a.modes: bench.run_errors()
    if "latency" in a.modes: bench.run_latency()
    if "scaling" in a.modes: peers_scaling.run(bench)
    report(bench)


if __name__ == "__main__": main()
