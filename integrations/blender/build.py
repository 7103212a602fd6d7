#!/usr/bin/env python3
"""Makes the extension's zip, which Blender 4.2 and later install: `python3 integrations/blender/build.py [-o FOLDER]`.

With `--program PATH` the zip carries that ambake, so that nobody needs Rust. The same sources give the same bytes."""

import argparse
import pathlib
import re
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
LICENCE = HERE.parent.parent / "LICENSE-MIT"
# Where the extension looks for its own program.
INSIDE = "bin/ambake"


def build(folder, program=None):
    """Writes `ambake-VERSION.zip`, or with a program `ambake-VERSION-linux-x64.zip`, into `folder` and returns its
    path. A ValueError where the program is for another system."""
    source = HERE / "ambake"
    manifest = (source / "blender_manifest.toml").read_text()
    version = re.search(r'^version = "(.+)"$', manifest, re.MULTILINE)[1]
    name = f"ambake-{version}"
    files = {file.name: file.read_bytes() for file in [*sorted(source.glob("*.py")), LICENCE]}
    if program:
        files[INSIDE] = _linux(program)
        name += "-linux-x64"
        manifest = manifest.replace("\n[permissions]", '\nplatforms = ["linux-x64"]\n\n[permissions]', 1)
    files["blender_manifest.toml"] = manifest.encode()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for inside, data in files.items():
            entry = zipfile.ZipInfo(inside, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if inside == INSIDE else 0o644) << 16
            archive.writestr(entry, data)
    return path


def _linux(program):
    """The bytes of a program for Linux on x86-64."""
    data = program.read_bytes()
    # ELF, 64 bits, and the machine's number at byte 18.
    if data[:5] != b"\x7fELF\x02" or data[18:20] != b"\x3e\x00":
        raise ValueError(f"{program} is no program for Linux on x86-64")
    return data


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="makes the zip of the Blender extension")
    parser.add_argument("-o", default="target", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--program", type=pathlib.Path, metavar="PATH", help="the ambake that the zip carries")
    asked = parser.parse_args()
    try:
        print(build(asked.o, asked.program))
    except (OSError, ValueError) as problem:
        parser.error(str(problem))
