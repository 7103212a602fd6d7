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
AMBAKE_RAYS = [16, 32, 64, 128, 256, 512, 1024]
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
    """Seconds at an RMSE, logarithms interpolated between ray counts. None outside of what was measured."""
    points = sorted(points, reverse=True)
    for (e0, c0), (e1, c1) in zip(points, points[1:]):
        if e0 >= target >= e1:
            t = math.log(target / e0) / math.log(e1 / e0)
            return c0 ** (1 - t) * c1**t
    return None


def summarise(rows, bias):
    def median(scene, kind, rays, column):
        return statistics.median(r[column] for r in rows if (r["scene"], r["baker"], r["rays"]) == (scene, kind, rays))

    lines = ["# CPU seconds at equal RMSE", "", "User + system, medians. `bake` is the bake alone, `process` the whole program."]
    for error, title in (
        ("rmse_own", "Sampling error alone: each baker against the value that it converges to."),
        ("rmse_ambake", "Error against ambake's converged average over the texel: the peers' different definition counts as error."),
    ):
        lines += ["", title, "",
                  "| scene | peer, 256 rays | RMSE | ambake rays | peer bake s | ambake bake s | ratio | peer process s | ambake process s | ratio |",
                  "|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
        for scene, kind in bias:
            target = median(scene, kind, PEER_RAYS, error)
            cells = [scene, NAMES[kind], f"{target:.5f}"]

            def reach(column):
                return at_rmse([(median(scene, "ambake", n, error), median(scene, "ambake", n, column)) for n in AMBAKE_RAYS], target)

            rays = reach("rays")
            cells.append(f"{rays:.0f}" if rays else "not measured")
            for column in ("cpu_bake", "cpu_process"):
                peer, own = median(scene, kind, PEER_RAYS, column), reach(column)
                cells += [f"{peer:.2f}", f"{own:.3f}", f"{peer / own:.1f}"] if own else [f"{peer:.2f}", "not measured", ""]
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
