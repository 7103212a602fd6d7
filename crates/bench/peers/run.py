#!/usr/bin/env python3
"""Bakes the same texels with ambake and what else is installed: AMBAKE=PATH run.py SCENES WORK OUT [--size 512] [--rays 256] [--only SCENE].

SCENES holds room.obj, displaced.obj and colonnade.obj, or those of them that are to be run (../scenes/generate.py). WORK keeps intermediate
files and the converged bakes, which are made once. OUT receives peers.csv, peers.svg and peers.md. CMD is put before each timed bake (a lock
on the machine). Peers are the packages bpy, mitsuba, open3d and pymeshlab of the Python that runs this; one that is missing is a printed skip.
`ambake bench --peers -o DIR` sets all of that up and runs it.
"""

import argparse
import csv
import importlib.util
import json
import math
import os
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
import mesh as meshes  # noqa: E402
from summary import picture, summarise  # noqa: E402

HERE = Path(__file__).parent
THREADS = 2
# ambake by its defaults, all layers and seams; the diffuse term alone, denoised and plain; and both with samples at texel
# centres alone: options and rays a texel.
DIFFUSE = ["--only", "diffuse,validity", "--seams", "off"]
CENTRE = [*DIFFUSE, "--footprint", "centre"]
MODES = {
    "default": ([], [8, 16, 32, 64, 128, 256]),
    "diffuse": (DIFFUSE, [8, 16, 32, 64, 128, 256]),
    "plain": ([*DIFFUSE, "--denoise", "off"], [64, 256, 512, 1024]),
    "centre": (CENTRE, [8, 16, 32, 64, 128, 256]),
    "centre plain": ([*CENTRE, "--denoise", "off"], [64, 256, 512, 1024]),
}
# Rays of the two plain bakes of ambake that every error is against, area averages and texel centres.
CONVERGED = 2048
FAR = 1e10
# A texel that a peer's first 16 rays find so far off is left out. By chance that needs five standard errors.
GUESS = 0.625
# scene, distance, peers. A closed room is black under a white world, so COMBINED is asked without its ceiling.
CASES = [
    ("roofless", FAR, ["combined", "mitsuba", "open3d", "pymeshlab"]),
    ("displaced", FAR, ["combined", "mitsuba", "open3d", "pymeshlab"]),
    ("colonnade", FAR, ["combined", "mitsuba", "open3d", "pymeshlab"]),
    ("room", 1.0, ["ao", "mitsuba", "open3d"]),
]
NAMES = {
    "combined": "Cycles COMBINED",
    "ao": "Cycles AO",
    "mitsuba": "Mitsuba ray test",
    "open3d": "Open3D ray test",
    "pymeshlab": "MeshLab ambient occlusion",
    "default": "ambake",
    "diffuse": "ambake, diffuse alone",
    "plain": "diffuse alone, --denoise off",
    "centre": "diffuse alone, --footprint centre",
    "centre plain": "diffuse alone, --footprint centre --denoise off",
}
SCRIPTS = {"combined": "cycles", "ao": "cycles", "mitsuba": "mitsuba", "open3d": "open3d", "pymeshlab": "pymeshlab"}
PACKAGES = {"cycles": "bpy", "mitsuba": "mitsuba", "open3d": "open3d", "pymeshlab": "pymeshlab"}


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

    def ambake(self, mode, rays, seed, before):
        """Diffuse, the seconds of a bake, its version, and the share of each texel that is charted and not buried."""
        out = self.work / "ambake"
        command = [os.environ["AMBAKE"], "bake", self.source, "-o", out, "--size", self.size, "--rays", rays, "--seed", seed]
        command += ["--threads", THREADS, "--quiet", "--pages", 1, *MODES[mode][0]]
        if self.distance != FAR:
            command += ["--max-distance", self.distance]
        _, process = self.timed(command, before)
        report = json.loads((out / "bake.json").read_text())
        phases = [entry for entry in report["timings"] if entry["phase"] in ("plan", "build", "bake")]
        cpu, wall = (sum(entry[key] for entry in phases) for key in ("cpu_seconds", "seconds"))
        planes = meshes.read_exr(out / f"{self.scene}.0.exr")
        seen = np.minimum(planes["coverage"], planes.get("validity", 1.0)).ravel()
        version = f"ambake {report['versions']['ambake']}, {report['versions']['backend_version']}"
        return planes["diffuse"].ravel(), cpu, process, wall, version, seen

    def peer(self, kind, rays, seed, before):
        out = self.work / "peer.npy"
        script = f"bake_{SCRIPTS[kind]}.py"
        command = [sys.executable, HERE / script, self.mesh, out, self.size, rays, seed, THREADS]
        command += [kind, self.distance] if SCRIPTS[kind] == "cycles" else [self.distance]
        text, process = self.timed(command, before)
        said = json.loads(next(line for line in text.splitlines() if line.startswith("PEER "))[5:])
        return np.load(out), said["cpu"], process, said["wall"], said["version"]

    def bake(self, kind, rays, seed, before):
        return self.ambake(kind, rays, seed, before)[:5] if kind in MODES else self.peer(kind, rays, seed, before)

    def converged(self, mode):
        """Made once, under a seed that no timed bake uses. Texels that a chart or the air does not wholly fill are left out."""
        path = self.work / f"converged.{mode}.{self.size}.npy".replace(" ", "_")
        if not path.exists():
            values, *_, seen = self.ambake(mode, CONVERGED, 9999, [])
            values = values.copy()
            values[seen < 0.999] = np.nan
            np.save(path, values)
        return np.load(path)

    def prepare(self):
        """The mesh and lightmap coordinates that ambake writes become the mesh of every peer."""
        self.ambake("plain", 16, 0, [])
        positions, uv, faces = meshes.read_glb(self.work / "ambake" / f"{self.scene}.glb")
        texel, at, normal = meshes.texel_centres(positions, uv, faces, self.size)
        np.savez(self.mesh, positions=positions, uv=uv, faces=faces, texel=texel, at=at, normal=normal)


def find_llvm():
    """Names Mitsuba's compiler, where Debian has one that it accepts and nobody named another: 15 and 16 crash under AVX-512."""
    found = sorted(Path("/usr/lib").glob("*/libLLVM.so.19*")) + sorted(Path("/usr/lib").glob("llvm-19/lib/libLLVM.so*"))
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(found[0]))
    elif "DRJIT_LIBLLVM_PATH" not in os.environ and installed("mitsuba"):
        print("Mitsuba needs LLVM: apt-get install libllvm19, or DRJIT_LIBLLVM_PATH", flush=True)


def rms(difference):
    return float(np.sqrt(np.mean(np.square(difference, dtype=np.float64))))


def measure(job, peers, repeats):
    """Rows of every bake, and what each peer converges to: mean and RMS of its difference to area averages and to texel centres."""
    job.prepare()
    area, centre = job.converged("plain"), job.converged("centre plain")
    common = np.isfinite(area)
    for kind in list(peers):
        try:
            # The first run of a peer compiles its kernels, warms the files and shows which texels it covers.
            # Where surfaces coincide, such as the tops of equally high boxes that overlap, what is open is anybody's guess.
            common &= np.abs(job.bake(kind, 16, 1, [])[0] - area) < GUESS
        except RuntimeError as error:
            print(f"skip {NAMES[kind]}: {error}", flush=True)
            peers.remove(kind)
    rows, images = [], {}
    for repeat in range(repeats):
        for kind in [*peers, *MODES]:
            for rays in MODES[kind][1] if kind in MODES else [job.rays]:
                values, cpu, process, wall, version = job.bake(kind, rays, 100 + repeat, job.before)
                images[kind, rays, repeat] = values[common]
                rows.append({
                    "scene": job.scene, "baker": kind, "version": version, "rays": rays, "repeat": repeat, "texels": int(common.sum()),
                    "cpu_bake": round(cpu, 4), "cpu_process": round(process, 4), "wall_bake": round(wall, 4),
                    "rmse_area": round(rms((values - area)[common]), 6), "rmse_centre": round(rms((values - centre)[common]), 6),
                })  # fmt: skip
                print(rows[-1], flush=True)
    for row in rows:
        # Two bakes under different seeds differ by the root of 2 times the sampling error, free of any reference's own.
        pair = [images[row["baker"], row["rays"], (row["repeat"] + k) % repeats] for k in (0, 1)]
        row["rmse_own"] = round(rms(pair[0] - pair[1]) / math.sqrt(2), 6)
    bias = {}
    for kind in peers:
        # The noise of two bakes is independent, so that the product of their differences is what they have in common.
        first, second = (images[kind, job.rays, k] for k in (0, 1))
        for truth in (area, centre):
            a, b = first - truth[common], second - truth[common]
            bias.setdefault(kind, []).extend([float((a + b).mean() / 2), math.sqrt(max(float(np.mean(a * b)), 0))])
    return rows, bias


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("scenes", "work", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--before", default="")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--rays", type=int, default=256, help="of the peers")
    parser.add_argument("--only", action="append", choices=[scene for scene, _, _ in CASES], help="a scene; all that are there without it")
    arguments = parser.parse_args()
    if arguments.repeats < 2:
        parser.error("--repeats must be 2 or more: the sampling error comes from pairs of bakes")
    if "AMBAKE" not in os.environ:
        sys.exit("set AMBAKE to the path of a release build of ambake")
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    remove_ceiling(arguments.scenes / "room.obj", arguments.work / "roofless.obj")
    find_llvm()
    missing = sorted({PACKAGES[SCRIPTS[kind]] for kind in SCRIPTS if not installed(kind)})
    for package in missing:
        print(f"skip {package}: this Python does not have it", flush=True)
    rows, bias = [], {}
    for scene, distance, peers in CASES:
        job = Job(scene, distance, arguments)
        if scene not in (arguments.only or [scene]) or not job.source.exists():
            continue
        more, measured = measure(job, [kind for kind in peers if installed(kind)], arguments.repeats)
        rows += more
        bias |= {(scene, kind): values for kind, values in measured.items()}
        with open(arguments.out / "peers.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        (arguments.out / "peers.svg").write_text(picture(rows, NAMES))
        (arguments.out / "peers.md").write_text(summarise(rows, bias, NAMES, arguments))


if __name__ == "__main__":
    main()
