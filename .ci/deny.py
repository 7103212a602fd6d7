#!/usr/bin/env python3
"""Holds Cargo.lock to deny.toml: licences, versions and sources of every package, for every platform and feature.

Stands in for `cargo deny check licenses bans sources`, which takes minutes to build where this takes a second. Reads what
cargo itself says of each package; Python 3.11 or newer, the standard library alone.
"""

import json
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path


def allowed(expression, licences):
    """Whether an SPDX expression can be met by `licences`. The old slash means OR; AND binds tighter than OR."""
    tokens = re.findall(r"[()]|[^\s()/]+|/", expression)
    tokens = ["OR" if t == "/" else t for t in tokens]

    def either():
        value = both()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            value = both() or value
        return value

    def both():
        value = one()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            value = one() and value
        return value

    def one():
        token = tokens.pop(0)
        if token == "(":
            value = either()
            if tokens.pop(0) != ")":
                raise IndexError
            return value
        if tokens and tokens[0] == "WITH":
            tokens.pop(0)
            token = f"{token} WITH {tokens.pop(0)}"
        return token in licences

    value = either()
    if tokens:
        raise IndexError
    return value


def covers(version, wanted):
    """Whether `version` begins with the parts of `wanted`: 2 covers 2.0.119."""
    parts = wanted.split(".")
    return version.split(".")[: len(parts)] == parts


def findings(rules, packages):
    """One line for each thing that deny.toml does not allow."""
    versions = defaultdict(list)
    for package in packages:
        name, version, source = package["name"], package["version"], package["source"]
        versions[name].append(version)
        licence = package["license"] or ""
        try:
            fits = allowed(licence, rules["licenses"]["allow"])
        except IndexError:
            fits = False
        if not fits:
            yield f"{name} {version}: licence {licence or 'not stated'} is not in deny.toml's list"
        if source and not re.fullmatch(r"registry\+https://\S+/crates\.io-index", source):
            yield f"{name} {version}: comes from {source}, not from the default registry"
        for dependency in package["dependencies"]:
            # A path of the workspace states a version as well, or it could not be packaged.
            if source is None and dependency["req"] == "*":
                yield f"{name} {version}: depends on any version of {dependency['name']}"
    skip = [entry["crate"].split("@") for entry in rules["bans"]["skip"]]
    for name, wanted in skip:
        if not any(covers(version, wanted) for version in versions[name]):
            yield f"deny.toml skips {name} {wanted}, which is no longer in Cargo.lock: remove the line"
    for name, found in versions.items():
        left = [v for v in found if not any(n == name and covers(v, w) for n, w in skip)]
        if len(left) > 1:
            yield f"{name}: {len(left)} versions, {' and '.join(sorted(left))}"


def main():
    root = Path(__file__).resolve().parent.parent
    rules = tomllib.loads((root / "deny.toml").read_text())
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"]
    metadata = subprocess.run(command, cwd=root, check=True, stdout=subprocess.PIPE).stdout
    packages = json.loads(metadata)["packages"]
    lines = list(findings(rules, packages))
    for line in lines:
        print(f"error: {line}")
    if lines:
        return 1
    print(f"deny: {len(packages)} packages fit deny.toml (licences, versions, sources)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
