#!/usr/bin/env python3
"""Counts the lines of Rust in the checkout that it is called in, by kind; `--long` counts lines of over 120 columns.

A file is a test if it lies in a folder `tests` or its name ends in `tests.rs`. In other files everything from the first
`#[cfg(test)]` that opens a module to the end of the file is counted as test. Blank lines count, as for `wc -l`.
"""
import re
import subprocess
import sys

TESTS = re.compile(r"(^|/)tests/|tests\.rs$")
MODULE = re.compile(r"^#\[cfg\(test\)\]\nmod \w+ \{", re.MULTILINE)
BENCH = re.compile(r"^crates/(bench|cli/bench)/")

names = subprocess.run(["git", "ls-files", "*.rs"], check=True, capture_output=True, text=True).stdout.split("\n")
lines = {"product": 0, "bench": 0, "tests": 0, "examples, fuzzing, integrations": 0}
files = dict.fromkeys(lines, 0)
long = 0
for name in filter(None, names):
    text = open(name, encoding="utf-8").read()
    long += sum(len(line) > 120 for line in text.split("\n"))
    count = text.count("\n")
    module = MODULE.search(text)
    inside = text.count("\n", module.start()) if module else 0
    if TESTS.search(name):
        kind = "tests"
    elif BENCH.search(name):
        kind = "bench"
    elif name.startswith(("crates/", "build.rs")):
        kind = "product"
    else:
        kind = "examples, fuzzing, integrations"
    files[kind] += 1
    if kind in ("product", "bench"):
        lines["tests"] += inside
        count -= inside
    lines[kind] += count

if "--long" in sys.argv:
    print(long)
else:
    for kind, count in lines.items():
        print(f"{kind}: {count:,} lines in {files[kind]} files")
    print(f"all: {sum(lines.values()):,} lines in {sum(files.values())} files")
