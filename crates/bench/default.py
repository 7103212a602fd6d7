#!/usr/bin/env python3
"""What a default bake costs: all layers and no flags, beside the diffuse term alone, another program, and targets.

    AMBAKE=target/release/ambake python3 crates/bench/default.py SCENE... [--size 512] [--rays 64] [--other PROGRAM] [--pairs 5]

prints a table in Markdown: processor seconds of whole processes (user and system), medians of interleaved runs.

* over diffuse: the default bake over `--only diffuse,validity --seams off --buried keep` with the same rays.
* over other: the default bake over that of another build of ambake, with the same flags.
* bounces: `--bounces auto` over none.
* seams: the default bake over the same with `--seams off`.
* a texel: microseconds of the bake's own phase for a covered texel that do not grow with the rays, diffuse term alone, from 8 and 32 rays:
  without the denoiser, and what that adds.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile

AMBAKE = os.environ.get("AMBAKE", "target/release/ambake")
DIFFUSE = ["--only", "diffuse,validity", "--seams", "off", "--buried", "keep"]


def spent(words):
    """Processor seconds of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ratio(a, b, pairs):
    """Median of a, of b, and of their ratios pair by pair."""
    rows = [(spent(a), spent(b)) for _ in range(pairs)]
    median = statistics.median
    return median(r[0] for r in rows), median(r[1] for r in rows), median(r[0] / r[1] for r in rows)


def fixed(scene, size, folder):
    """Microseconds a covered texel that do not grow with the rays: without the denoiser, and what that adds."""

    def spent_by_bake(rays, *more):
        words = [AMBAKE, "bake", scene, "-o", folder, "--quiet", "--size", size, "--rays", str(rays)]
        subprocess.run(words + DIFFUSE + list(more), check=True)
        report = json.loads((pathlib.Path(folder) / "bake.json").read_text())
        bake = [p for p in report["timings"] if p["phase"] == "bake"][0]
        texels = sum(page["texels"] for page in report["pages"])
        return 1e6 * bake.get("cpu_seconds", bake["seconds"]) / texels

    def once():
        few, many = spent_by_bake(8, "--denoise", "off"), spent_by_bake(32, "--denoise", "off")
        return few - 8 * (many - few) / 24, spent_by_bake(8) - few

    plain, denoiser = zip(*(once() for _ in range(3)))
    return statistics.median(plain), statistics.median(denoiser)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="512")
    parser.add_argument("--rays", default="64")
    parser.add_argument("--other")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--bounces", action="store_true")
    asked = parser.parse_args()
    print("| scene | default, CPU s | over diffuse | over other | seams | bounces | a texel, µs | its denoiser, µs |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in asked.scenes:
        with tempfile.TemporaryDirectory() as folder:
            def words(program, *more):
                flags = ["--quiet", "--size", asked.size, "--rays", asked.rays]
                return [program, "bake", scene, "-o", folder] + flags + list(more)

            plain, _, over = ratio(words(AMBAKE), words(AMBAKE, *DIFFUSE), asked.pairs)
            cells = [f"{plain:.2f}", f"{over:.2f}"]
            if asked.other:
                cells.append(f"{ratio(words(AMBAKE), words(asked.other), asked.pairs)[2]:.2f}")
            else:
                cells.append("-")
            cells.append(f"{ratio(words(AMBAKE), words(AMBAKE, '--seams', 'off'), asked.pairs)[2]:.2f}")
            if asked.bounces:
                light = words(AMBAKE, "--bounces", "auto")
                cells.append(f"{ratio(light, words(AMBAKE), asked.pairs)[2]:.2f}")
            else:
                cells.append("-")
            cells += [f"{each:.2f}" for each in fixed(scene, asked.size, folder)]
        print(f"| {pathlib.Path(scene).name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
