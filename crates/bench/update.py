"""What an update costs, against a whole bake: one object of a scene moves.

    python3 tests/tools/update_table.py target/release/ambake

prints a table for three scenes, with --max-distance and without a limit. Times are processor seconds of the whole command, loading and
writing included. Every file of the update but bake.json must have the bytes of the whole bake. Only the standard library is used.
"""

import filecmp
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
OPTIONS = ["--size", "512", "--rays", "256", "--quiet"]


def boxes(across):
    """across² boxes above a floor as OBJ text."""
    edge = 3 * across
    lines = ["o floor", "v 0 0 0", f"v 0 0 {edge}", f"v {edge} 0 {edge}", f"v {edge} 0 0", "f 1 2 3 4"]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    first = 4
    for k in range(across * across):
        x, z = 3 * (k // across) + 1, 3 * (k % across) + 1
        lines.append(f"o box_{k}")
        lines += [f"v {x + a} {0.1 + b} {z + c}" for a in (0, 1) for b in (0, 1) for c in (0, 1)]
        lines += ["f " + " ".join(str(first + corner) for corner in face) for face in faces]
        first += 8
    return "\n".join(lines) + "\n"


def move_obj(text, name, step):
    """The OBJ text with the vertices of one object moved."""
    lines, inside = [], False
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["o"]:
            inside = words[1:] == [name]
        if inside and words[:1] == ["v"]:
            line = "v " + " ".join(str(float(a) + b) for a, b in zip(words[1:4], step))
        lines.append(line)
    return "\n".join(lines) + "\n"


def move_gltf(text, name, step):
    """The glTF text with one node moved."""
    scene = json.loads(text)
    node = next(node for node in scene["nodes"] if node.get("name") == name)
    node["translation"] = [a + b for a, b in zip(node.get("translation", [0, 0, 0]), step)]
    return json.dumps(scene)


def run(words):
    """Processor seconds of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(program, folder, name, more):
    """Bakes before and after the change, updates, and compares."""
    old, new, whole, layout = (str(folder / kind) for kind in ("old", "new", "whole", "layout"))
    before, after = (str(folder / side / name) for side in "ab")
    words = [*OPTIONS, *more]
    run([program, "bake", before, "-o", old, *words])
    update = run([program, "bake", after, "-o", new, "--update", old, *words])
    # An update from other options keeps the layout and bakes everything.
    run([program, "bake", before, "-o", layout, *words, "--seed", "1"])
    full = run([program, "bake", after, "-o", whole, "--update", layout, *words])
    names = sorted(path.name for path in pathlib.Path(whole).iterdir() if path.name != "bake.json")
    _, different, missing = filecmp.cmpfiles(whole, new, names, shallow=False)
    said = json.loads((pathlib.Path(new) / "bake.json").read_text())["update"]
    same = "yes" if not different + missing else "NO: " + ", ".join(different + missing)
    return said["share"], update, full, same


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    cases = [
        ("196 boxes", "boxes.obj", boxes(14), move_obj, "box_100", (0.4, 0, 0)),
        ("courtyard", "courtyard.obj", (SCENES / "courtyard.obj").read_text(), move_obj, "urn_0", (0.2, 0, 0.2)),
        ("interior", "interior.gltf", (SCENES / "interior.gltf").read_text(), move_gltf, "chair_0", (0.1, 0, 0)),
    ]
    print("| scene | max distance | baked | update | whole | ratio | same bytes |")
    print("|---|---|---|---|---|---|---|")
    for title, name, text, move, moved, step in cases:
        # A room of a few units needs shorter rays.
        limit = "0.5" if title == "interior" else "2"
        for more in (["--max-distance", limit], []):
            with tempfile.TemporaryDirectory() as place:
                folder = pathlib.Path(place)
                for side, content in (("a", text), ("b", move(text, moved, step))):
                    (folder / side).mkdir()
                    (folder / side / name).write_text(content)
                    for other in SCENES.glob(name.split(".")[0] + ".*"):
                        if other.name != name:
                            (folder / side / other.name).write_bytes(other.read_bytes())
                share, update, full, same = row(program, folder, name, more)
            shown = more[1] if more else "none"
            print(f"| {title} | {shown} | {share:.1%} | {update:.1f} s | {full:.1f} s | {update / full:.0%} | {same} |", flush=True)


if __name__ == "__main__":
    main()
