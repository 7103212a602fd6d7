#!/usr/bin/env python3
"""What `ambake plan` says against what a bake takes: python3 plan.py AMBAKE OUT [SCENE...].

Memory is the peak of the process (getrusage), processor time that of the whole process less what both verbs do before the first ray (load,
plan, build, atlas). OUT receives plan.csv. Scenes are those of the repository and further ones that are named. Only the standard library is used.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SCENES = Path(__file__).resolve().parents[2] / "scenes"
BAKES = [
    ("courtyard.obj", "--size 1024 --rays 64"),
    ("courtyard.obj", "--size 2048 --rays 16"),
    ("airliner.obj", "--size 1024 --rays 16"),
    ("interior.gltf", "--size 1024 --rays 16 --bounces 1"),
    ("town.gltf", "--size 1024 --rays 64 --denoise off"),
    ("vehicles.gltf", "--size 1024 --rays 32 --sky SKY"),
    ("palm.gltf", "--size 1024 --rays 64 --only diffuse"),
]


def run(words):
    """Peak memory in bytes, processor seconds and output of a command."""
    process = subprocess.Popen(list(map(str, words)), stdout=subprocess.PIPE)
    output = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{words} ended with status {os.waitstatus_to_exitcode(status)}")
    return usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime, output


def row(program, scene, options, folder):
    words = [scene, *(str(SCENES / "sky.hdr") if word == "SKY" else word for word in options.split()), "--threads", 2]
    _, _, output = run([program, "plan", *words, "--json"])
    planned = json.loads(output)["estimate"]
    memory, cpu, _ = run([program, "bake", *words, "-o", folder, "--quiet"])
    said = json.loads((folder / "bake.json").read_text())
    phases = {entry["phase"]: entry.get("cpu_seconds") or entry["seconds"] for entry in said["timings"]}
    cpu -= sum(phases[name] for name in ("load", "plan", "build", "atlas"))
    files = {path.name: path.stat().st_size for path in folder.iterdir()}
    disk, state = sum(files.values()), sum(size for name, size in files.items() if name.endswith(".state"))
    return {
        "scene": scene.name,
        "options": options,
        "memory_planned": planned["memory_bytes"],
        "memory": memory,
        "memory_ratio": round(planned["memory_bytes"] / memory, 3),
        "cpu_planned": round(planned["cpu_seconds"], 2),
        "cpu": round(cpu, 2),
        "cpu_ratio": round(planned["cpu_seconds"] / cpu, 3),
        "disk_planned": planned["disk_bytes"],
        "disk": disk,
        "disk_ratio": round(planned["disk_bytes"] / disk, 3),
        "state_planned": planned["state_bytes"],
        "state": state,
        "state_ratio": round(planned["state_bytes"] / state, 3),
    }


def main():
    program, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    bakes = [(SCENES / name, options) for name, options in BAKES]
    bakes += [(Path(name).resolve(), "--size 1024 --rays 32") for name in sys.argv[3:]]
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "plan.csv", "w", newline="") as file:
        writer = None
        for scene, options in bakes:
            with tempfile.TemporaryDirectory() as folder:
                found = row(program, scene, options, Path(folder))
            writer = writer or csv.DictWriter(file, found, lineterminator="\n")
            if file.tell() == 0:
                writer.writeheader()
            writer.writerow(found)
            file.flush()
            print({key: value for key, value in found.items() if key.endswith("ratio") or key in ("scene", "cpu", "memory")}, flush=True)


if __name__ == "__main__":
    main()
