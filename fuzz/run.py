#!/usr/bin/env python3
"""Fuzz every target in turn, by equal slices, and keep count: executions, CPU seconds, findings, coverage.

Usage: run.py [--minutes N] [--slice N] [--until HH:MM] [--once] [TARGET..]. Needs nightly Rust and cargo-fuzz. It stops when each target has had N
CPU minutes (30), over all runs so far, or at a time of day. What it finds stands in fuzz/artifacts, what it learns in fuzz/work, and its
counts in counts.json beside it; they are printed as a table. With --once every target has a single slice, and a finding is a failure.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
WORK = HERE / "work"
COUNTS = WORK / "counts.json"
TARGETS = re.findall(r'^name = "(\w+)"\npath = "fuzz_targets', (HERE / "Cargo.toml").read_text(), re.M)
# A scene of hundreds of kilobytes shows nothing that one of eight does not.
LONGEST = 8192


def build():
    """The folder of the built targets."""
    # Embree is not what is fuzzed, and knows no sanitizer.
    env = {**os.environ, "AMBAKE_NO_EMBREE": "1"}
    # What is fuzzed is what is shipped: the same versions of everything.
    shutil.copy(HERE.parent / "Cargo.lock", HERE / "Cargo.lock")
    subprocess.run(["cargo", "+nightly", "fuzz", "build"], cwd=HERE.parent, env=env, check=True)
    return next((HERE / "target").glob("*/release/obj")).parent


def fuzz(program, target, seconds):
    """Fuzzes for so long; a line of counts."""
    learnt, found = WORK / target, HERE / "artifacts" / target
    learnt.mkdir(parents=True, exist_ok=True)
    found.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    words = [program, f"-max_total_time={seconds}", f"-max_len={LONGEST}", "-timeout=20", "-rss_limit_mb=3000"]
    words += ["-print_final_stats=1", f"-artifact_prefix={found}/", learnt, HERE / "corpus" / target]
    dictionary = HERE / "dictionaries" / f"{target}.dict"
    words += [f"-dict={dictionary}"] if dictionary.exists() else []
    with open(WORK / f"{target}.log", "w+", errors="replace") as log:
        # A C++ library that is linked twice under it has its constants twice, which the sanitizer takes for a fault before the first run.
        env = {**os.environ, "ASAN_OPTIONS": "detect_odr_violation=0"}
        child = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT, env=env)
        _, _, used = os.wait4(child.pid, 0)
        log.seek(0)
        text = log.read()
    number = lambda pattern: max((int(n) for n in re.findall(pattern, text)), default=0)
    return {
        "runs": number(r"number_of_executed_units: (\d+)"),
        "cpu": used.ru_utime + used.ru_stime,
        "findings": len(set(found.iterdir()) - before),
        "coverage": number(r"cov: (\d+)"),
        "features": number(r"ft: (\d+)"),
    }


def table(counts):
    print("| target | executions | CPU minutes | findings | edges | features |\n|---|---|---|---|---|---|")
    for target, c in counts.items():
        print(f"| {target} | {c['runs']:,} | {c['cpu'] / 60:.1f} | {c['findings']} | {c['coverage']} | {c['features']} |")


def main():
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--minutes", type=float, default=30)
    words.add_argument("--slice", type=float, default=3)
    words.add_argument("--until", type=datetime.time.fromisoformat, default=None)
    words.add_argument("--once", action="store_true")
    words.add_argument("targets", nargs="*", default=[])
    given = words.parse_args()
    targets = given.targets or TARGETS
    if unknown := set(targets) - set(TARGETS):
        sys.exit(f"run.py: no target {', '.join(unknown)}; there are {', '.join(TARGETS)}")
    WORK.mkdir(exist_ok=True)
    counts = json.loads(COUNTS.read_text()) if COUNTS.exists() else {}
    none = {"runs": 0, "cpu": 0.0, "findings": 0, "coverage": 0, "features": 0}
    folder = build()
    late = lambda: given.until and datetime.datetime.now().time() >= given.until
    findings = 0
    short = lambda: [t for t in targets if given.once or counts.get(t, none)["cpu"] < 60 * given.minutes]
    while not late() and (wanted := short()):
        for target in wanted:
            if late():
                break
            new, old = fuzz(folder / target, target, round(60 * given.slice)), counts.get(target, none)
            if new["runs"] == new["findings"] == 0:
                sys.exit(f"run.py: {target} ran nothing: see {WORK / target}.log")
            sums = {key: old[key] + new[key] for key in ("runs", "cpu", "findings")}
            # Of a slice that a finding ended, the log does not say all.
            counts[target] = {**sums, **{key: max(old[key], new[key]) for key in ("coverage", "features")}}
            findings += new["findings"]
            COUNTS.write_text(json.dumps(counts, indent=1) + "\n")
            print(datetime.datetime.now().strftime("%H:%M"), target, counts[target], flush=True)
        if given.once:
            break
    table({target: counts[target] for target in TARGETS if target in counts})
    return 1 if given.once and findings else 0


sys.exit(main())
