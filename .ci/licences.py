#!/usr/bin/env python3
"""Prints the notices of every crate that is linked into the program: `.ci/licences.py > THIRD-PARTY.txt`.

The crates are those that cargo would build for this kind of machine, without what only builds or tests. Equal texts are
printed once."""

import json
import pathlib
import subprocess

NAMES = ("LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE")


def linked(meta):
    """The packages below the root one, by name."""
    nodes = {node["id"]: node for node in meta["resolve"]["nodes"]}
    packages = {package["id"]: package for package in meta["packages"]}
    found, waiting = set(), [meta["resolve"]["root"]]
    while waiting:
        number = waiting.pop()
        if number in found:
            continue
        found.add(number)
        for dep in nodes[number]["deps"]:
            # A kind of null is neither "dev" nor "build". What a procedural macro needs ends in the compiler.
            macro = any("proc-macro" in target["kind"] for target in packages[dep["pkg"]]["targets"])
            if not macro and any(kind["kind"] is None for kind in dep["dep_kinds"]):
                waiting.append(dep["pkg"])
    others = [packages[number] for number in found if packages[number]["source"]]
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def texts(package):
    """The files beside its manifest that hold licences."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [file for file in sorted(folder.iterdir()) if file.is_file() and file.name.upper().startswith(NAMES)]
    return [file.read_text(errors="replace").strip() for file in files]


if __name__ == "__main__":
    host = next(
        line.split()[1]
        for line in subprocess.check_output(["rustc", "-vV"], text=True).splitlines()
        if line.startswith("host:")
    )
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", host]
    users = {}
    for package in linked(json.loads(subprocess.check_output(command, text=True))):
        name = f"{package['name']} {package['version']} ({package['license']})"
        print(name, *package["authors"], sep=", ")
        for text in texts(package):
            users.setdefault(text, []).append(name)
    for text, names in users.items():
        print("\n" + "=" * 78, ", ".join(names), "=" * 78, text, sep="\n")
