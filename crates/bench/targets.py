#!/usr/bin/env python3
"""What a bake with a target costs beside one with the fixed number of rays that has the same error, diffuse term alone.

    AMBAKE=target/release/ambake python3 crates/bench/targets.py SCENE... [--size 1024] [--targets 0.02,0.01,0.004]

prints a table in Markdown. *RMSE over target* is the stated error of the page over what was asked for. *Over fixed* is
the processor time of the bake's phase over that of a fixed number of rays with the same stated error, by a line
between the logarithms of bakes of 8 to 1,024 rays. Times are the less of two runs.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import tempfile

AMBAKE = os.environ.get("AMBAKE", "target/release/ambake")
FIXED = [8 << k for k in range(8)]


def bake(scene, size, *flags):
    """Stated RMSE, processor seconds of the bake's phase and rays a texel."""
    with tempfile.TemporaryDirectory() as folder:
        words = [AMBAKE, "bake", scene, "-o", folder, "--quiet", "--size", size]
        words += ["--only", "diffuse,validity", "--seams", "off"]
        subprocess.run(words + list(flags), check=True, stdout=subprocess.DEVNULL)
        report = json.loads((pathlib.Path(folder) / "bake.json").read_text())
    phase = [p for p in report["timings"] if p["phase"] == "bake"][0]
    texels = sum(page["texels"] for page in report["pages"])
    squares = sum(page["rmse_rays"] ** 2 * page["texels"] for page in report["pages"])
    rays = sum(page["rays"] for page in report["pages"])
    return math.sqrt(squares / texels), phase.get("cpu_seconds", phase["seconds"]), rays / texels


def twice(*words):
    first, second = bake(*words), bake(*words)
    return first[0], min(first[1], second[1]), first[2]


def between(error, fixed):
    """Processor seconds of the fixed number of rays of this error."""
    rows = sorted(fixed)
    low = max((row for row in rows if row[0] <= error), default=rows[0])
    high = min((row for row in rows if row[0] >= error), default=rows[-1])
    if low[0] == high[0]:
        return low[1]
    share = math.log(error / low[0]) / math.log(high[0] / low[0])
    return low[1] * (high[1] / low[1]) ** share


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="1024")
    parser.add_argument("--targets", default="0.02,0.01,0.004")
    args = parser.parse_args()
    print("| scene | target | RMSE over target | rays a texel | CPU s | over fixed |\n|---|---|---|---|---|---|")
    for scene in args.scenes:
        fixed = [twice(scene, args.size, "--rays", str(rays))[:2] for rays in FIXED]
        for target in args.targets.split(","):
            error, seconds, rays = twice(scene, args.size, "--target-error", target)
            row = [pathlib.Path(scene).stem, target, f"{error / float(target):.2f}", f"{rays:.0f}"]
            print("|", " | ".join(row + [f"{seconds:.2f}", f"{seconds / between(error, fixed):.2f}"]), "|", flush=True)


if __name__ == "__main__":
    main()
