#!/usr/bin/env python3
"""Whether the errors that a default bake states are those that it has.

    AMBAKE=target/release/ambake python3 crates/bench/stated.py SCENE... [--size 256] [--rays 64 256] [--truth 4096]

prints a table in Markdown: of each term the true root mean square error over texels that can be seen, that over the stated one, which
should be 1, and the share of texels within 1.96 stated errors, which should be .95. Bakes are denoised and their seams are solved; the truth is a plain bake
of another seed without seams. Needs numpy and OpenEXR's Python package.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile

import numpy
import OpenEXR

AMBAKE = os.environ.get("AMBAKE", "target/release/ambake")
ERRORS = {
    "diffuse": "error",
    "visibility": "error.visibility",
    "reflection": "error.reflection",
}


def planes(scene, folder, *flags):
    """Every channel of all pages of a bake, one after the other."""
    layers = ",".join([*ERRORS, *ERRORS.values(), "validity"])
    words = [AMBAKE, "bake", scene, "-o", folder, "--quiet", "--layers", layers, *flags]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    found = {}
    for page in sorted(pathlib.Path(folder).glob("*.[0-9]*.exr")):
        with OpenEXR.File(str(page), separate_channels=True) as exr:
            for name, channel in exr.channels().items():
                found.setdefault(name, []).append(channel.pixels.ravel())
    return {name: numpy.concatenate(parts) for name, parts in found.items()}


def term(bake, name):
    """The mean of a term's channels."""
    rgb = [bake.get(f"{name}.{channel}") for channel in "RGB"]
    return bake[name] if rgb[0] is None else sum(rgb) / 3


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="256")
    parser.add_argument("--rays", nargs="+", default=["64", "256"])
    parser.add_argument("--truth", default="4096")
    asked = parser.parse_args()
    size = ["--size", asked.size]
    print("| scene | rays | " + " | ".join(f"{name}: RMSE, over stated, within" for name in ERRORS) + " |")
    print("|---|---|" + "---|" * len(ERRORS))
    for scene in asked.scenes:
        with tempfile.TemporaryDirectory() as folder:
            plain = ["--denoise", "off", "--seams", "off", "--seed", "99"]
            truth = planes(scene, folder, *size, "--rays", asked.truth, *plain)
        seen = (truth["coverage"] > 0) & (truth["validity"] > 0)
        for rays in asked.rays:
            with tempfile.TemporaryDirectory() as folder:
                bake = planes(scene, folder, *size, "--rays", rays)
            cells = [pathlib.Path(scene).name, rays]
            for name, error in ERRORS.items():
                off = (term(bake, name) - term(truth, name))[seen]
                stated = bake[error][seen]
                rmse, mean = [numpy.sqrt(numpy.mean(numpy.square(a, dtype=float))) for a in (off, stated)]
                within = numpy.mean(numpy.abs(off) <= 1.96 * stated + 1e-7)
                cells.append(f"{rmse:.5f}, {rmse / mean:.2f}, {within:.3f}")
            print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
