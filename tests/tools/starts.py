"""Start many bakes into one folder at once while strace delays their system calls, and check that none fails.

Usage: starts.py PROGRAM [ROUNDS]. Needs Linux and strace. Each of 25 rounds starts 40 programs that write into a
folder that is absent: ten parts of each of two bakes, and twenty pictures, whose files wait in folders of their own for
their names. Every program is given other delays, of up to 20 ms, at the calls that make, open, lock and remove. What a
round leaves is compared with the first.
"""

import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 25
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = [ROOT / "scenes" / name for name in ("corner.obj", "ball.obj")]
WORDS = ["--size", "64", "--rays", "1", "--only", "diffuse", "--threads", "1", "--quiet"]
CALLS = {
    "?mkdir,mkdirat": "enter",
    "?open,openat": "exit",
    "flock": "enter",
    "unlinkat,?rmdir,?unlink": "enter",
    "?rename,renameat,renameat2": "enter",
}
DICE = random.Random(1)
PARTS = 10


def start(words):
    strace = ["strace", "-f", "-qqq", "-o", os.devnull, "-e", "trace=" + ",".join(CALLS)]
    for calls, when in CALLS.items():
        first, step = DICE.randint(1, 4), DICE.randint(1, 4)
        strace += ["-e", f"inject={calls}:delay_{when}={DICE.randint(0, 20000)}:when={first}+{step}"]
    return subprocess.Popen([*strace, PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def merged(scene, folder, into):
    """The files that the parts of a scene in a folder make together, which are moved away."""
    into.mkdir()
    for part in folder.glob(f"{scene.stem}.*"):
        shutil.move(part, into)
    run = subprocess.run([PROGRAM, "merge", into, "--quiet"], capture_output=True)
    if run.returncode:
        sys.exit(run.stderr.decode())
    return {f.name: f.read_bytes() for f in into.iterdir() if f.name.endswith((".exr", ".png", ".obj"))}


def commands(folder):
    """What a round starts, in any order."""
    for scene in SCENES:
        for part in range(1, PARTS + 1):
            yield ["bake", scene, "-o", folder, *WORDS, "--shard", f"{part}/{PARTS}"]
            yield ["render", scene, "-o", folder / f"{part}-{scene.stem}.png", "--size", "8x8", "--quiet"]


def main():
    started = failed = 0
    first = None
    for number in range(ROUNDS):
        with tempfile.TemporaryDirectory() as work:
            folder = pathlib.Path(work) / "absent" / "out"
            words = list(commands(folder))
            DICE.shuffle(words)
            for run in [start(each) for each in words]:
                told = run.communicate()[1].decode()
                started += 1
                if run.returncode:
                    failed += 1
                    print(f"round {number}: {told.strip()}", flush=True)
            pictures = {f.name: f.read_bytes() for f in folder.glob("*.png")}
            result = [pictures] + [merged(scene, folder, pathlib.Path(work) / scene.stem) for scene in SCENES]
            first = first or result
            left = {f.name for f in folder.iterdir()} - set(pictures)
            if result != first or left:
                sys.exit(f"round {number}: other files than in the first one, or left behind: {left}")
    print(f"{started} programs started at once, {failed} failed")
    sys.exit(failed > 0)


if not shutil.which("strace"):
    sys.exit("starts.py: strace is not installed")
main()
