#!/usr/bin/env python3
"""Bakes the same texels with ambake, Cycles and Mitsuba: AMBAKE=PATH run.py SCENES WORK OUT [--repeats 3] [--before CMD].

SCENES holds room.obj and displaced.obj (../scenes/generate.py). WORK keeps intermediate files and the converged bakes,
which are made once. OUT receives rows.csv and summary.md. CMD is put before each timed bake (a lock on the machine).
Run it with the Python that has bpy, mitsuba and numpy (README.md).
"""

import argparse
import csv
import json
import math
import os
import platform
import shlex
import statistics
import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

sys.dont_write_bytecode = True
import mesh as meshes  # noqa: E402

HERE = Path(__file__).parent
SIZE, THREADS, PEER_RAYS = 512, 2, 256
AMBAKE_RAYS = [16, 32, 64, 128, 256]
CONVERGED = {"ambake": 16384, "mitsuba": 4096, "combined": 1024, "ao": 1024}
FAR = 1e10
# scene, distance, peers. A closed room is black under a white world, so COMBINED is asked without its ceiling.
CASES = [
    ("room", 1.0, ["ao", "mitsuba"]),
    ("roofless", FAR, ["combined", "ao", "mitsuba"]),
    ("displaced", FAR, ["combined", "ao", "mitsuba"]),
]
NAMES = {"combined": "Cycles COMBINED", "ao": "Cycles AO", "mitsuba": "Mitsuba ray test", "ambake": "ambake"}


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
            sys.exit(f"{command[0]} failed on {self.scene}:\n{text}")
        return text, usage.ru_utime + usage.ru_stime

    def ambake(self, rays, seed, before):
        out = self.work / "ambake"
        command = [os.environ["AMBAKE"], "bake", self.source, "-o", out, "--size", SIZE, "--rays", rays, "--seed", seed]
        command += ["--threads", THREADS, "--quiet", "--only", "diffuse"]
        if self.distance != FAR:
            command += ["--max-distance", self.distance]
        _, process = self.timed(command, before)
        report = json.loads((out / "bake.json").read_text())
        phases = {entry["phase"]: entry["seconds"] for entry in report["timings"]}
        wall = sum(phases[name] for name in ("plan", "build", "bake"))
        image = mi.Bitmap(str(out / f"{self.scene}.0.exr"))
        names = [field.name for field in image.struct_()]
        pixels = np.array(image).reshape(SIZE * SIZE, len(names))
        values = pixels[:, names.index("diffuse")].copy()
        values[pixels[:, names.index("coverage")] < 0.999] = np.nan
        # The report times by the wall clock; its phases cannot have used more than all threads.
        return values, min(process, THREADS * wall), process, wall, f"ambake {report['versions']['ambake']}, {report['versions']['backend_version']}"

    def peer(self, kind, rays, seed, before):
        out = self.work / "peer.npy"
        script = "bake_mitsuba.py" if kind == "mitsuba" else "bake_cycles.py"
        command = [sys.executable, HERE / script, self.mesh, out, SIZE, rays, seed, THREADS]
        command += [self.distance] if kind == "mitsuba" else [kind, self.distance]
        text, process = self.timed(command, before)
        said = json.loads(next(line for line in text.splitlines() if line.startswith("PEER "))[5:])
        return np.load(out), said["cpu"], process, said["wall"], said["version"]

    def bake(self, kind, rays, seed, before):
        return self.ambake(rays, seed, before) if kind == "ambake" else self.peer(kind, rays, seed, before)

    def converged(self, kind):
        """Made once, under a seed that no timed bake uses."""
        path = self.work / f"converged.{kind}.{CONVERGED[kind]}.npy"
        if not path.exists():
            np.save(path, self.bake(kind, CONVERGED[kind], 9999, [])[0])
        return np.load(path)

    def prepare(self):
        """The mesh and lightmap coordinates that ambake writes become the mesh of every peer."""
        self.ambake(16, 0, [])
        positions, uv, faces = meshes.read_glb(self.work / "ambake" / f"{self.scene}.glb")
        texel, at, normal = meshes.texel_centres(positions, uv, faces, SIZE)
        np.savez(self.mesh, positions=positions, uv=uv, faces=faces, texel=texel, at=at, normal=normal)


def rms(difference):
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))


def measure(job, peers, repeats):
    job.prepare()
    kinds = ["ambake", *peers]
    truth = {kind: job.converged(kind) for kind in kinds}
    for kind in peers:  # the first run of a peer compiles its kernels and warms the files
        job.bake(kind, 16, 1, [])
    common = np.all([np.isfinite(image) for image in truth.values()], axis=0)
    rows, images = [], {}
    for repeat in range(repeats):
        for kind in kinds:
            for rays in AMBAKE_RAYS if kind == "ambake" else [PEER_RAYS]:
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
    """CPU seconds at an RMSE: logarithms interpolated between ray counts, extended by the outer pair; the rays, too."""
    points = sorted(points)
    k = next((k for k in range(1, len(points) - 1) if points[k][0] >= target), len(points) - 1)
    (e0, c0, n0), (e1, c1, n1) = points[k - 1], points[k]
    t = math.log(target / e0) / math.log(e1 / e0)
    return math.exp(math.log(c0) + t * math.log(c1 / c0)), math.exp(math.log(n0) + t * math.log(n1 / n0))


def summarise(rows, bias):
    def median(scene, kind, rays, column):
        return statistics.median(r[column] for r in rows if (r["scene"], r["baker"], r["rays"]) == (scene, kind, rays))

    lines = ["CPU seconds (user + system) at equal RMSE; medians. `bake` is the bake alone, `process` the whole program.",
             "RMSE is sampling error, from bakes under different seeds. ambake's rays and time are interpolated to the peer's RMSE.", "",
             "| scene | peer, 256 rays | RMSE | peer bake s | ambake rays | ambake bake s | ratio bake | peer process s | ambake process s | ratio process |",
             "|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for scene, kind in bias:
        target = median(scene, kind, PEER_RAYS, "rmse_own")
        own = {}
        for column in ("cpu_bake", "cpu_process"):
            points = [(median(scene, "ambake", n, "rmse_own"), median(scene, "ambake", n, column), n) for n in AMBAKE_RAYS]
            own[column], rays = at_rmse(points, target)
        bake, process = (median(scene, kind, PEER_RAYS, c) for c in ("cpu_bake", "cpu_process"))
        lines.append(f"| {scene} | {NAMES[kind]} | {target:.5f} | {bake:.2f} | {rays:.0f} | {own['cpu_bake']:.3f} | {bake / own['cpu_bake']:.1f} "
                     f"| {process:.2f} | {own['cpu_process']:.3f} | {process / own['cpu_process']:.1f} |")  # fmt: skip
    lines += ["", "ambake alone:", "", "| scene | rays | RMSE | bake s | process s |", "|---|---|---|---|---|"]
    for scene in dict.fromkeys(r["scene"] for r in rows):
        for n in AMBAKE_RAYS:
            e, b, p = (median(scene, "ambake", n, c) for c in ("rmse_own", "cpu_bake", "cpu_process"))
            lines.append(f"| {scene} | {n} | {e:.5f} | {b:.3f} | {p:.3f} |")
    lines += ["", "Converged values, peer minus ambake, over texels wholly inside a chart:", "",
              "| scene | peer | mean | median of abs | 99 % of abs | RMS | RMSE of 256 rays against ambake's converged |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    for (scene, kind), (mean, middle, high, spread) in bias.items():
        against = median(scene, kind, PEER_RAYS, "rmse_ambake")
        lines.append(f"| {scene} | {NAMES[kind]} | {mean:+.5f} | {middle:.5f} | {high:.4f} | {spread:.4f} | {against:.5f} |")
    versions = sorted({r["version"] for r in rows})
    lines += ["", f"Python {platform.python_version()}, {os.cpu_count()} CPUs, {THREADS} threads, {SIZE}x{SIZE} texels. " + "; ".join(versions) + "."]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("scenes", "work", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--before", default="")
    arguments = parser.parse_args()
    if arguments.repeats < 2:
        parser.error("--repeats must be 2 or more: the sampling error comes from pairs of bakes")
    if "AMBAKE" not in os.environ:
        sys.exit("set AMBAKE to the path of a release build of ambake")
    mi.set_variant("scalar_rgb")
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    remove_ceiling(arguments.scenes / "room.obj", arguments.work / "roofless.obj")
    rows, bias = [], {}
    for scene, distance, peers in CASES:
        more, measured = measure(Job(scene, distance, arguments), peers, arguments.repeats)
        rows += more
        bias |= {(scene, kind): values for kind, values in measured.items()}
        with open(arguments.out / "rows.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        (arguments.out / "summary.md").write_text(summarise(rows, bias))
    print(summarise(rows, bias))


if __name__ == "__main__":
    main()
