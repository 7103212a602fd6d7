#!/usr/bin/env python3
"""How a bake's cost grows with texels and with triangles: AMBAKE=PATH python3 scaling.py WORK OUT [--rays 16] [--repeats 3] [--largest 4096].

Displaced spheres of generate.py, 512 to 4,096 texels wide at 307,202 triangles, and 30,002 to 3,072,002 triangles at 512 texels. WORK keeps
the scenes. OUT receives scaling.csv and scaling.md. Times are user + system seconds of the whole program and of its phases.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import generate  # noqa: E402

PHASES = ["plan", "build", "atlas", "bake"]
# Edge of each face of the cube in squares, and of the page in texels.
TEXELS = [(160, 512), (160, 1024), (160, 2048), (160, 4096)]
TRIANGLES = [(50, 512), (160, 512), (506, 512)]


def bake(scene, size, arguments):
    """CPU seconds of the process and of its phases, and texels baked."""
    out = arguments.work / "out"
    command = [os.environ["AMBAKE"], "bake", scene, "-o", out, "--size", size, "--rays", arguments.rays, "--threads", 2, "--quiet"]
    process = subprocess.Popen(list(map(str, command)))
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{scene}: ambake ended with status {os.waitstatus_to_exitcode(status)}")
    report = json.loads((out / "bake.json").read_text())
    phases = {entry["phase"]: entry.get("cpu_seconds") for entry in report["timings"]}
    return {
        "process": usage.ru_utime + usage.ru_stime,
        **{phase: phases[phase] for phase in PHASES},
        "texels": sum(page["texels"] for page in report["pages"]),
    }


def table(title, rows, work):
    """Medians, and the ratio of each step to the one before it: cost over cost, then that over work over work."""
    lines = ["", f"{title}:", "", "| triangles | page | texels baked | " + " | ".join(PHASES) + " | process | step | step over its work |",
             "|---|---|---|" + "---|" * (len(PHASES) + 3)]  # fmt: skip
    before = None
    for key, group in rows.items():
        middle = {column: statistics.median(row[column] for row in group) for column in group[0]}
        steps = ["", ""]
        if before:
            cost = [row["process"] / earlier["process"] for row, earlier in zip(group, before[1])]
            grown = middle[work] / before[0][work]
            steps = [f"{statistics.median(cost):.2f}", f"{statistics.median(cost) / grown:.2f}"]
        cells = [f"{int(middle['triangles']):,}", f"{key[1]}²", f"{int(middle['texels']):,}", *(f"{middle[p]:.2f}" for p in PHASES)]
        lines.append("| " + " | ".join([*cells, f"{middle['process']:.2f}", *steps]) + " |")
        before = (middle, group)
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--rays", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--largest", type=int, default=4096, help="page in texels")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = {key: [] for key in dict.fromkeys(TRIANGLES + TEXELS) if key[1] <= arguments.largest}
    for repeat in range(arguments.repeats):
        for edge, size in rows:
            scene = arguments.work / f"displaced{edge}.obj"
            if not scene.exists():
                generate.displaced(scene, edge).close()
            row = {"triangles": 12 * edge * edge + 2, "size": size, "repeat": repeat, **bake(scene, size, arguments)}
            rows[edge, size].append(row)
            print(row, flush=True)
    every = [row for group in rows.values() for row in group]
    with open(arguments.out / "scaling.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, every[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: round(v, 4) if isinstance(v, float) else v for k, v in row.items()} for row in every)
    lines = [f"# CPU seconds by size, {arguments.rays} rays a texel", "", "User + system, medians. A step over its work of 1 is linear growth."]
    lines += table("Texels", {key: rows[key] for key in TEXELS if key in rows}, "texels")
    lines += table("Triangles", {key: rows[key] for key in TRIANGLES}, "triangles")
    (arguments.out / "scaling.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
