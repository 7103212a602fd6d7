#!/usr/bin/env python3
"""What an artist asks of a lightmap first, as a Markdown table: lightmaps.py AMBAKE SCENE.. [--size 512] [--rays 64] [--flags "--seed 1"].

Bakes each scene twice into a temporary folder, plain and denoised, and prints what both bake.json say: pages, page use, the share inside
charts, the largest object, buried texels, steps across seams before and after, stated error plain and denoised. Needs nothing but Python.
"""

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

HEAD = [
    "scene", "pages", "in use", "inside charts", "largest object", "buried",
    "RMS step at seams", "largest step", "grain, plain > denoised",
]


def bake(ambake, scene, flags):
    """The bake.json of a bake, or None where it fails, with the program's line."""
    with tempfile.TemporaryDirectory() as folder:
        command = [ambake, "bake", str(scene), "-o", folder, "--only", "diffuse,error,validity", "-q", *flags]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"{scene.name}: {done.stderr.strip()}", file=sys.stderr)
            return None
        return json.loads((Path(folder) / "bake.json").read_text())


def grain(report):
    """Stated root mean square error of the diffuse term over all pages."""
    pages = report["pages"]
    texels = sum(page["texels"] for page in pages)
    return (sum(page["rmse_rays"] ** 2 * page["texels"] for page in pages) / max(texels, 1)) ** 0.5


def row(scene, plain, denoised):
    layout = denoised["layout"]
    largest = max(layout["objects"], key=lambda o: o["share"], default={"share": 0.0})
    seams = denoised.get("seams")
    steps = ("none", "none") if seams is None else tuple(
        f"{seams[name + '_before']:.4f} > {seams[name + '_after']:.4f}" for name in ("rms", "max")
    )
    buried = denoised.get("buried")
    return [
        scene.stem, str(denoised["atlas"]["pages"]), f"{layout['page_use']:.1%}", f"{layout['covered']:.1%}",
        f"{largest['share']:.1%}", f"{buried['share'] if buried else 0:.1%}", *steps,
        f"{grain(plain):.4f} > {grain(denoised):.4f}",
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ambake")
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--size", default="512")
    parser.add_argument("--rays", default="64")
    parser.add_argument("--flags", default="", help="more flags of `ambake bake`, as one word")
    given = parser.parse_args()
    flags = ["--size", given.size, "--rays", given.rays, *shlex.split(given.flags)]
    for line in (HEAD, ["---"] * len(HEAD)):
        print("| " + " | ".join(line) + " |")
    failed = 0
    for scene in given.scenes:
        plain, denoised = (bake(given.ambake, scene, [*flags, "--denoise", how]) for how in ("off", "regression"))
        if plain is None or denoised is None:
            failed += 1
            continue
        print("| " + " | ".join(row(scene, plain, denoised)) + " |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
