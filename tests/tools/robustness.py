"""Bake under damage, faults and signals, and print what came of it as the table of docs/robustness.md.

Usage: robustness.py PROGRAM [SEED]. Needs a Unix system; takes about four minutes. Run it from the repository's root. The rows of full disks
need root on Linux, who may mount them.
"""

import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
DICE = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes" / "corner.obj"
WORK = ["--size", "128", "--rays", "64", "--only", "diffuse,visibility", "--quiet"]
SMALL = ["--size", "16", "--rays", "1", "--quiet"]


def bake(scene, out, words=WORK, **options):
    command = [PROGRAM, "bake", scene, "-o", out, *words]
    return subprocess.run(command, capture_output=True, **{"timeout": 120, **options})


def results(out):
    """The files of a finished bake but for its report, which holds times."""
    return {f.name: f.read_bytes() for f in sorted(out.iterdir()) if f.name != "bake.json"}


def told(run):
    """True where a failure is one line, and no panic."""
    text = run.stderr.decode("utf-8", "replace")
    return text.startswith("ambake: ") and text.count("\n") == 1 and "panicked" not in text


class Row:
    def __init__(self, what):
        self.what, self.tried, self.good, self.refused, self.lost = what, 0, 0, 0, 0

    def judge(self, well, refused=False):
        self.tried += 1
        self.good += well and not refused
        self.refused += well and refused
        self.lost += not well


def damaged(data):
    data = bytearray(data)
    for _ in range(DICE.randint(1, 4)):
        if data:
            data[DICE.randrange(len(data))] = DICE.choice([0, 255, *b"0123456789-.e{}[],", DICE.randrange(256)])
    return bytes(data[: DICE.randrange(1, len(data) + 1)] if DICE.random() < 0.2 else data)


def inputs(folder, kinds, copies):
    row = Row(f"damaged {', '.join(kinds)} files")
    for kind in kinds:
        for seed in sorted((ROOT / "fuzz/corpus" / kind).iterdir()):
            for _ in range(copies):
                scene = folder / ("a." + kind)
                scene.write_bytes(damaged(seed.read_bytes()))
                run = bake(scene, folder / "out", SMALL)
                row.judge(run.returncode == 0 or (run.returncode == 1 and told(run)), run.returncode != 0)
                shutil.rmtree(folder / "out", ignore_errors=True)
    return row


def beside(folder, what, kind, copies, words):
    """A sound scene with a damaged file beside it; `words` make of the file's path the words of a bake."""
    row = Row(what)
    for seed in sorted((ROOT / "fuzz/corpus" / kind).iterdir()):
        for _ in range(copies):
            file = folder / seed.name
            file.write_bytes(damaged(seed.read_bytes()))
            scene, more = words(file)
            run = bake(scene, folder / "out", [*SMALL, *more])
            row.judge(run.returncode == 0 or (run.returncode == 1 and told(run)), run.returncode != 0)
            shutil.rmtree(folder / "out", ignore_errors=True)
    return row


def with_library(library):
    """A square whose materials stand in `library`, named as those of the corpus are."""
    names = [line.split()[1] for line in library.read_bytes().decode("latin-1").splitlines() if line.startswith("newmtl ") and len(line.split()) > 1]
    scene = library.with_name("square.obj")
    material = names[0] if names else "none"
    text = f"mtllib {library.name}\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nvt 0 0\nusemtl {material}\nf 1/1 2/1 3/1 4/1\n"
    scene.write_bytes(text.encode("latin-1"))
    return scene, []


def with_picture(picture):
    """A square that shows `picture`."""
    library = picture.with_name("shown.mtl")
    library.write_text(f"newmtl shown\nmap_Kd {picture.name}\n")
    return with_library(library)


def parts(folder, times):
    """A bake in two parts, of which one is damaged before the merge."""
    row = Row("a part of a bake damaged, then `merge`")
    out, whole = folder / "parts", folder / "small"
    bake(SCENE, whole, SMALL)
    for shard in "12":
        bake(SCENE, out, [*SMALL, "--shard", f"{shard}/2"])
    sound = {part: part.read_bytes() for part in sorted(out.glob("*.part"))}
    for number in range(times):
        for part, data in sound.items():
            part.write_bytes(data)
        part = list(sound)[number % 2]
        part.write_bytes(flipped(sound[part]))
        run = subprocess.run([PROGRAM, "merge", out, "--quiet"], capture_output=True, timeout=120)
        refused = run.returncode == 1 and told(run) and not (out / "bake.json").exists()
        row.judge(refused or (run.returncode == 0 and results(out).items() >= results(whole).items()), refused)
        if run.returncode == 0:
            for name in results(whole) | {"bake.json": b""}:
                (out / name).unlink()
    return row


def flipped(data):
    data = bytearray(data)
    data[DICE.randrange(len(data))] ^= 1 << DICE.randrange(8)
    return data


def killed(folder, whole, name, times):
    row = Row(f"{name} at a random moment, then `--resume`")
    for number in range(times):
        out = folder / f"{name}{number}"
        child = subprocess.Popen([PROGRAM, "bake", SCENE, "-o", out, *WORK], stderr=subprocess.PIPE)
        time.sleep(DICE.random() * 1.5 * SECONDS)
        child.send_signal(getattr(signal, name))
        child.communicate(timeout=60)
        # A report says that all of it is there, also where the kill came between the last file and the end of the program.
        plain = lambda: {name: data for name, data in results(out).items() if not name.startswith(".")}
        half = (out / "bake.json").exists() and plain() != whole
        run = bake(SCENE, out, [*WORK, "--resume"])
        row.judge(not half and run.returncode == 0 and results(out) == whole)
    return row


def killed_after_a_save(folder, times):
    """Kills a bake once its state has been saved, which is 20 seconds after its first tile."""
    row = Row("SIGKILL after a save, then `--resume`")
    rays = str(max(64, int(30 / SECONDS) * 64))
    words = ["--size", "128", "--rays", rays, "--only", "diffuse,visibility", "--quiet"]
    whole = folder / "long"
    for number in range(times):
        out = folder / f"save{number}"
        child = subprocess.Popen([PROGRAM, "bake", SCENE, "-o", out, *words], stderr=subprocess.PIPE)
        saved = lambda: any(state.stat().st_size > 100_000 for state in out.glob(".*ambake-resume"))
        while child.poll() is None and not saved():
            time.sleep(0.05)
        ended = child.poll() is not None
        child.kill()
        child.communicate()
        kept = saved()
        run = bake(SCENE, out, [*words, "--resume"], timeout=600)
        if not whole.exists():
            bake(SCENE, whole, words, timeout=600)
        # A machine that is faster than a moment before may end the bake before it is saved.
        row.judge((ended or kept) and run.returncode == 0 and results(out) == results(whole))
    return row


def hopeless(folder, what, out, words):
    row = Row(what)
    run = bake(SCENE, out or folder / "hopeless", [*WORK, *words])
    row.judge(run.returncode == 1 and told(run) and not (folder / "hopeless" / "bake.json").exists(), True)
    return row


def failed_then_well(folder, whole, what, fault, mend, clean=lambda out: None):
    """A bake that must fail in one line, and succeed with --resume once the fault is mended."""
    row = Row(what)
    out = folder / str(abs(hash(what)))
    options = fault(out)
    run = bake(SCENE, out, **options)
    one_line = run.returncode == 1 and told(run) and not (out / "bake.json").is_file()
    mend(out)
    again = bake(SCENE, out, [*WORK, "--resume"])
    row.judge(one_line and again.returncode == 0 and results(out) == whole, True)
    clean(out)
    return row


def mounted(size):
    """A disk of so many bytes, which is the output folder."""
    def mount(out):
        out.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", out], check=True)
        return {}
    return mount


def enlarged(out):
    subprocess.run(["mount", "-o", "remount,size=64m", "none", out], check=True)


def may_mount(folder):
    try:
        mounted(4096)(folder / "tried")
    except (OSError, subprocess.CalledProcessError):
        return False
    subprocess.run(["umount", folder / "tried"], check=True)
    return True


def file_limit(bytes_):
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, bytes_))
    return lambda out: {"preexec_fn": limit}


def addresses(folder, whole):
    """Bakes for which the system has too few addresses, now here, now there."""
    row = Row("less memory than it takes (`ulimit -v`), then `--resume`")
    for number, mib in enumerate(range(150, 650, 50)):
        out = folder / f"addresses{number}"
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (mib << 20, mib << 20))
        run = bake(SCENE, out, [*WORK, "--max-memory", "1000G"], preexec_fn=limit)
        ended = run.returncode == 0 or (run.returncode == 1 and told(run))
        again = bake(SCENE, out, [*WORK, "--resume"])
        row.judge(ended and again.returncode == 0 and results(out) == whole, run.returncode != 0)
    return row


def blocked(name):
    return lambda out: (out / name).mkdir(parents=True) or {}


def streams(folder, whole):
    row = Row("standard output or error closed or full")
    for number, words in enumerate(["2>&-", "2>/dev/full", ">&-", ">&- 2>&-"]):
        out = folder / f"streams{number}"
        line = f'exec "$0" bake "$1" -o "$2" {" ".join(WORK[:-1])} {words}'
        run = subprocess.run(["sh", "-c", line, PROGRAM, SCENE, out], capture_output=True, timeout=120)
        row.judge(run.returncode == 0 and results(out) == whole and b"panicked" not in run.stderr)
    return row


def states(folder, whole, times):
    row = Row("saved state damaged, then `--resume`")
    for number in range(times):
        out = folder / f"state{number}"
        (out / "corner.glb").mkdir(parents=True)
        bake(SCENE, out)
        (out / "corner.glb").rmdir()
        for state in out.glob(".*ambake-resume"):
            state.write_bytes(flipped(state.read_bytes()))
        run = bake(SCENE, out, [*WORK, "--resume"])
        refused = run.returncode == 1 and told(run)
        row.judge(refused or (run.returncode == 0 and results(out) == whole), refused)
    return row


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    started = time.time()
    assert bake(SCENE, folder / "whole").returncode == 0
    SECONDS = time.time() - started
    whole = results(folder / "whole")
    rows = [
        inputs(folder, ["obj"], 40),
        inputs(folder, ["gltf", "glb"], 40),
        beside(folder, "damaged material libraries", "mtl", 40, with_library),
        beside(folder, "damaged pictures as textures", "picture", 40, with_picture),
        beside(folder, "damaged Radiance HDR files as skies", "hdr", 40, lambda sky: (SCENE, ["--sky", sky])),
        beside(folder, "damaged EXR files as skies", "exr", 40, lambda sky: (SCENE, ["--sky", sky])),
        parts(folder, 24),
        killed(folder, whole, "SIGKILL", 6),
        killed(folder, whole, "SIGHUP", 6),
        killed_after_a_save(folder, 1),
        killed(folder, whole, "SIGINT", 6),
        killed(folder, whole, "SIGTERM", 6),
        failed_then_well(folder, whole, "a directory where the GLB goes", blocked("corner.glb"),
                         lambda out: (out / "corner.glb").rmdir()),
        failed_then_well(folder, whole, "a directory where `bake.json` goes", blocked("bake.json"),
                         lambda out: (out / "bake.json").rmdir()),
        failed_then_well(folder, whole, "no file may grow beyond 20 kB", file_limit(20_000), lambda out: None),
        failed_then_well(folder, whole, "no file may grow beyond 1 byte", file_limit(1), lambda out: None),
        *([failed_then_well(folder, whole, f"a disk of {size // 1000} kB, which is full, then `--resume`", mounted(size), enlarged,
                            lambda out: subprocess.run(["umount", out], check=True)) for size in (40_000, 200_000, 800_000)]
          if may_mount(folder) else []),
        hopeless(folder, "a folder that takes no files", "/proc/ambake", []),
        hopeless(folder, "a limit of 10 MB of memory", None, ["--max-memory", "10M"]),
        addresses(folder, whole),
        streams(folder, whole),
        states(folder, whole, 12),
    ]
print("| what was done | times | right result | refused in one line | results lost or wrong |")
print("|---|---|---|---|---|")
for row in rows:
    print(f"| {row.what} | {row.tried} | {row.good} | {row.refused} | {row.lost} |")
total = [sum(getattr(row, key) for row in rows) for key in ("tried", "good", "refused", "lost")]
print(f"| **all** | {' | '.join(map(str, total))} |")
sys.exit(1 if total[3] else 0)
