#!/usr/bin/env python3
"""Bakes the same texels with ambake and what else is installed: AMBAKE=PATH run.py SCENES WORK OUT [--size 512] [--rays 256].

SCENES holds room.obj and displaced.obj, and colonnade.obj if it is to be run (../scenes/generate.py). WORK keeps intermediate files and
the converged bakes, which are made once. OUT receives peers.csv, peers.svg and peers.md. CMD is put before each timed bake (a lock on the
machine). Peers are the packages bpy, mitsuba and open3d of the Python that runs this; one that is missing is a printed skip.
`ambake bench --peers -o DIR` sets all of that up and runs it.
"""

import argparse
import csv
import importlib.util
import json
import math
import os
import platform
import shlex
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
import mesh as meshes  # noqa: E402

HERE = Path(__file__).parent
THREADS = 2
AMBAKE_RAYS = [16, 32, 64, 128, 256, 512, 1024]
# Of a run with 256 rays; fewer rays, fewer here.
CONVERGED = {"ambake": 16384, "mitsuba": 4096, "open3d": 4096, "combined": 1024, "ao": 1024}
FAR = 1e10
# scene, distance, peers. A closed room is black under a white world, so COMBINED is asked without its ceiling.
CASES = [
    ("room", 1.0, ["ao", "mitsuba", "open3d"]),
    ("roofless", FAR, ["combined", "ao", "mitsuba", "open3d"]),
    ("displaced", FAR, ["combined", "ao", "mitsuba", "open3d"]),
    ("colonnade", FAR, ["combined", "ao", "mitsuba", "open3d"]),
]
NAMES = {
    "combined": "Cycles COMBINED",
    "ao": "Cycles AO",
    "mitsuba": "Mitsuba ray test",
    "open3d": "Open3D ray test",
    "ambake": "ambake",
}
SCRIPTS = {"combined": "cycles", "ao": "cycles", "mitsuba": "mitsuba", "open3d": "open3d"}
PACKAGES = {"cycles": "bpy", "mitsuba": "mitsuba", "open3d": "open3d"}


def installed(kind):
    return importlib.util.find_spec(PACKAGES[SCRIPTS[kind]]) is not None


def remove_ceiling(room, out):
    """Copies the room without the two triangles whose corners all have its greatest height."""
    lines = room.read_text().splitlines()
    heights = [line.split()[2] for line in lines if line.startswith("v ")]
    top = max(heights, key=float)
    ceiling = [line for line in lines if line.startswith("f ") and all(heights[int(k) - 1] == top for k in line.split()[1:])]
    assert len(ceiling) == 2, ceiling
    out.write_text("\n".join(line for line in lines if line not in ceiling) + "\n")


class Job:
    """The paths of one comparison."""

    def __init__(self, scene, distance, arguments):
        self.scene, self.distance, self.before = scene, distance, shlex.split(arguments.before)
        self.size, self.rays = arguments.size, arguments.rays
        self.source = (arguments.work if scene == "roofless" else arguments.scenes) / f"{scene}.obj"
        self.work = arguments.work / scene
        self.work.mkdir(parents=True, exist_ok=True)
        self.mesh = self.work / "mesh.npz"

    def timed(self, command, before):
        """Standard output and the CPU seconds, user and system, of the whole process."""
        log = open(self.work / "log.txt", "wb+")
        process = subprocess.Popen([*before, *map(str, command)], stdout=log, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        text = log.read().decode(errors="replace")
        if process.returncode != 0:
            lines = [line for line in text.splitlines() if line.strip()] or [f"status {process.returncode}"]
            said = [line for line in lines if "rror" in line] or lines
            raise RuntimeError(f"{self.scene}: {said[-1].strip()[:200]}")
        return text, usage.ru_utime + usage.ru_stime

    def ambake(self, rays, seed, before):
        out = self.work / "ambake"
        command = [os.environ["AMBAKE"], "bake", self.source, "-o", out, "--size", self.size, "--rays", rays, "--seed", seed]
        command += ["--threads", THREADS, "--quiet", "--only", "diffuse", "--denoise", "off"]
        if self.distance != FAR:
            command += ["--max-distance", self.distance]
        _, process = self.timed(command, before)
        report = json.loads((out / "bake.json").read_text())
        phases = {entry["phase"]: entry["seconds"] for entry in report["timings"]}
        wall = sum(phases[name] for name in ("plan", "build", "bake"))
        planes = meshes.read_exr(out / f"{self.scene}.0.exr")
        values = planes["diffuse"].ravel().copy()
        values[planes["coverage"].ravel() < 0.999] = np.nan
        # The report times by the wall clock; its phases cannot have used more than all threads.
        return values, min(process, THREADS * wall), process, wall, f"ambake {report['versions']['ambake']}, {report['versions']['backend_version']}"

    def peer(self, kind, rays, seed, before):
        out = self.work / "peer.npy"
        script = f"bake_{SCRIPTS[kind]}.py"
        command = [sys.executable, HERE / script, self.mesh, out, self.size, rays, seed, THREADS]
        command += [kind, self.distance] if SCRIPTS[kind] == "cycles" else [self.distance]
        text, process = self.timed(command, before)
        said = json.loads(next(line for line in text.splitlines() if line.startswith("PEER "))[5:])
        return np.load(out), said["cpu"], process, said["wall"], said["version"]

    def bake(self, kind, rays, seed, before):
        return self.ambake(rays, seed, before) if kind == "ambake" else self.peer(kind, rays, seed, before)

    def converged(self, kind):
        """Made once, under a seed that no timed bake uses."""
        rays = max(CONVERGED[kind] * self.rays // 256, 16)
        path = self.work / f"converged.{kind}.{self.size}.{rays}.npy"
        if not path.exists():
            np.save(path, self.bake(kind, rays, 9999, [])[0])
        return np.load(path)

    def prepare(self):
        """The mesh and lightmap coordinates that ambake writes become the mesh of every peer."""
        self.ambake(16, 0, [])
        positions, uv, faces = meshes.read_glb(self.work / "ambake" / f"{self.scene}.glb")
        texel, at, normal = meshes.texel_centres(positions, uv, faces, self.size)
        np.savez(self.mesh, positions=positions, uv=uv, faces=faces, texel=texel, at=at, normal=normal)


def rms(difference):
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))


def measure(job, peers, repeats):
    job.prepare()
    truth = {"ambake": job.converged("ambake")}
    for kind in list(peers):
        try:
            job.bake(kind, 16, 1, [])  # the first run of a peer compiles its kernels and warms the files
            truth[kind] = job.converged(kind)
        except RuntimeError as error:
            print(f"skip {NAMES[kind]}: {error}", flush=True)
            peers.remove(kind)
    kinds = ["ambake", *peers]
    common = np.all([np.isfinite(image) for image in truth.values()], axis=0)
    rows, images = [], {}
    for repeat in range(repeats):
        for kind in kinds:
            for rays in AMBAKE_RAYS if kind == "ambake" else [job.rays]:
                values, cpu, process, wall, version = job.bake(kind, rays, 100 + repeat, job.before)
                images[kind, rays, repeat] = values
                rows.append({
                    "scene": job.scene, "baker": kind, "version": version, "rays": rays, "repeat": repeat, "texels": int(common.sum()),
                    "cpu_bake": round(cpu, 4), "cpu_process": round(process, 4), "wall_bake": round(wall, 4),
                    "rmse_ambake": round(rms((values - truth["ambake"])[common]), 6),
                })  # fmt: skip
                print(rows[-1], flush=True)
    for row in rows:
        # Two bakes under different seeds differ by the root of 2 times the sampling error, free of any reference's own.
        pair = [images[row["baker"], row["rays"], (row["repeat"] + k) % repeats] for k in (0, 1)]
        row["rmse_own"] = round(rms((pair[0] - pair[1])[common]) / math.sqrt(2), 6)
    bias = {}
    for kind in peers:
        difference = (truth[kind] - truth["ambake"])[common]
        bias[kind] = (float(difference.mean()), float(np.median(np.abs(difference))), float(np.quantile(np.abs(difference), 0.99)), rms(difference))
    return rows, bias


def at_rmse(points, target):
    """Seconds at an RMSE, logarithms interpolated between ray counts. None outside of what was measured."""
    points = sorted(points, reverse=True)
    for (e0, c0), (e1, c1) in zip(points, points[1:]):
        if e0 >= target >= e1:
            t = math.log(target / e0) / math.log(e1 / e0)
            return c0 ** (1 - t) * c1**t
    return None


def summarise(rows, bias, arguments):
    def median(scene, kind, rays, column):
        return statistics.median(r[column] for r in rows if (r["scene"], r["baker"], r["rays"]) == (scene, kind, rays))

    lines = ["# CPU seconds at equal RMSE", "", "User + system, medians. `bake` is the bake alone, `process` the whole program."]
    for error, title in (
        ("rmse_own", "Sampling error alone: each baker against the value that it converges to."),
        ("rmse_ambake", "Error against ambake's converged average over the texel: the peers' different definition counts as error."),
    ):
        lines += ["", title, "",
                  f"| scene | peer, {arguments.rays} rays | RMSE | ambake rays | peer bake s | ambake bake s | ratio | peer process s | ambake process s | ratio |",
                  "|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
        for scene, kind in bias:
            target = median(scene, kind, arguments.rays, error)
            cells = [scene, NAMES[kind], f"{target:.5f}"]

            def reach(column):
                return at_rmse([(median(scene, "ambake", n, error), median(scene, "ambake", n, column)) for n in AMBAKE_RAYS], target)

            rays = reach("rays")
            cells.append(f"{rays:.0f}" if rays else "not measured")
            for column in ("cpu_bake", "cpu_process"):
                peer, own = median(scene, kind, arguments.rays, column), reach(column)
                each = [r[column] / own for r in rows if (r["scene"], r["baker"]) == (scene, kind)] if own else []
                ratio = f"{peer / own:.1f} ({min(each):.1f} to {max(each):.1f})" if own else ""
                cells += [f"{peer:.2f}", f"{own:.3f}" if own else "not measured", ratio]
            lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "ambake alone:", "", "| scene | rays | sampling error | against converged | bake s | process s |", "|---|---|---|---|---|---|"]
    for scene in dict.fromkeys(r["scene"] for r in rows):
        for n in AMBAKE_RAYS:
            e, a, b, p = (median(scene, "ambake", n, c) for c in ("rmse_own", "rmse_ambake", "cpu_bake", "cpu_process"))
            lines.append(f"| {scene} | {n} | {e:.5f} | {a:.5f} | {b:.3f} | {p:.3f} |")
    lines += ["", "Converged values, peer minus ambake, over texels wholly inside a chart:", "",
              "| scene | peer | mean | median of abs | 99 % of abs | RMS |", "|---|---|---|---|---|---|"]  # fmt: skip
    for (scene, kind), (mean, middle, high, spread) in bias.items():
        lines.append(f"| {scene} | {NAMES[kind]} | {mean:+.5f} | {middle:.5f} | {high:.4f} | {spread:.4f} |")
    versions = sorted({r["version"] for r in rows})
    lines += ["", f"Python {platform.python_version()}, {os.cpu_count()} CPUs, {THREADS} threads, {arguments.size}x{arguments.size} texels. " + "; ".join(versions) + "."]
    return "\n".join(lines) + "\n"


def picture(rows):
    """RMSE against CPU seconds of the bake, one frame a scene: ambake a line, each peer a dot."""
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    kinds = list(dict.fromkeys(r["baker"] for r in rows))
    colours = dict(zip(kinds, ["#1b6ca8", "#d1495b", "#edae49", "#66a182", "#7b5ea7"]))
    edge, pad = 260, 50
    points = {}
    for r in rows:
        points.setdefault((r["scene"], r["baker"], r["rays"]), []).append((r["cpu_bake"], r["rmse_ambake"]))
    points = {key: [statistics.median(axis) for axis in zip(*values)] for key, values in points.items()}
    spans = [[min(axis), max(axis)] for axis in zip(*points.values())]

    def place(axis, value):
        low, high = (math.log10(max(v, 1e-9)) for v in spans[axis])
        share = (math.log10(max(value, 1e-9)) - low) / max(high - low, 1e-9)
        return pad + (edge - 2 * pad) * (share if axis == 0 else 1 - share)

    parts = []
    for column, scene in enumerate(scenes):
        parts.append(f'<g transform="translate({column * edge})"><text x="{pad}" y="20">{scene}</text>')
        parts.append(f'<rect x="{pad - 8}" y="{pad - 8}" width="{edge - 2 * pad + 16}" height="{edge - 2 * pad + 16}" fill="none" stroke="#888"/>')
        parts.append(f'<text x="{pad}" y="{edge - 14}">CPU s, {spans[0][0]:.2g} to {spans[0][1]:.2g}</text>')
        parts.append(f'<text x="{pad}" y="36">RMSE, {spans[1][0]:.2g} to {spans[1][1]:.2g}</text>')
        for kind in kinds:
            at = [[place(0, c), place(1, e)] for (s, k, _), (c, e) in sorted(points.items(), key=str) if (s, k) == (scene, kind)]
            at.sort()
            line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colours[kind]}"/>')
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colours[kind]}"/>' for x, y in at]
        parts.append("</g>")
    for row, kind in enumerate(kinds):
        parts.append(f'<text x="{pad + 120 * row}" y="{edge + 14}" fill="{colours[kind]}">{NAMES[kind]}</text>')
    width = max(edge * len(scenes), pad + 120 * len(kinds))
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{edge + 24}" font-family="sans-serif" font-size="11">'
    return "\n".join([head, f'<rect width="{width}" height="{edge + 24}" fill="white"/>', *parts, "</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("scenes", "work", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--before", default="")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--rays", type=int, default=256, help="of the peers")
    arguments = parser.parse_args()
    if arguments.repeats < 2:
        parser.error("--repeats must be 2 or more: the sampling error comes from pairs of bakes")
    if "AMBAKE" not in os.environ:
        sys.exit("set AMBAKE to the path of a release build of ambake")
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    remove_ceiling(arguments.scenes / "room.obj", arguments.work / "roofless.obj")
    missing = sorted({PACKAGES[SCRIPTS[kind]] for kind in SCRIPTS if not installed(kind)})
    for package in missing:
        print(f"skip {package}: this Python does not have it", flush=True)
    rows, bias = [], {}
    for scene, distance, peers in CASES:
        job = Job(scene, distance, arguments)
        if not job.source.exists():
            continue
        more, measured = measure(job, [kind for kind in peers if installed(kind)], arguments.repeats)
        rows += more
        bias |= {(scene, kind): values for kind, values in measured.items()}
        with open(arguments.out / "peers.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        (arguments.out / "peers.svg").write_text(picture(rows))
        (arguments.out / "peers.md").write_text(summarise(rows, bias, arguments))


if __name__ == "__main__":
    main()
