#!/usr/bin/env python3
"""Makes the extension's zip, which Blender 4.2 and later install: `python3 integrations/blender/build.py [-o FOLDER]`.

The same sources give the same bytes."""

import argparse
import pathlib
import re
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
LICENCE = HERE.parent.parent / "LICENSE-MIT"


def build(folder):
    """Writes `ambake-VERSION.zip` into `folder` and returns its path."""
    source = HERE / "ambake"
    manifest = (source / "blender_manifest.toml").read_text()
    version = re.search(r'^version = "(.+)"$', manifest, re.MULTILINE)[1]
    files = [*sorted(source.glob("*.py")), source / "blender_manifest.toml", LICENCE]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"ambake-{version}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files:
            entry = zipfile.ZipInfo(file.name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, file.read_bytes())
    return path


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="makes the zip of the Blender extension")
    parser.add_argument("-o", default="target", type=pathlib.Path, metavar="FOLDER")
    print(build(parser.parse_args().o))
