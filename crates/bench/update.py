"""What an update costs, against a whole bake: one object of a scene moves.

    python3 crates/bench/update.py target/release/ambake [MODELS]

prints a table: boxes on a floor, the courtyard and the interior of scenes/ and, where the folder MODELS holds it, game_level_zdm2.glb with a
crate on its largest floor; with --max-distance, and the first without a limit too. Times are processor seconds of the whole command, loading
and writing included. Every file of the update but bake.json must have the bytes of the whole bake. Only the standard library is used.
"""

import filecmp
import json
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
PAGE = ["--size", "512", "--rays", "256", "--quiet"]


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


def chunks(glb):
    """JSON and binary chunk of a GLB file."""
    length = struct.unpack_from("<I", glb, 12)[0]
    return json.loads(glb[20 : 20 + length]), bytearray(glb[28 + length :])


def largest_floor(scene, binary):
    """Centre of the largest triangle that faces along +z, in the space of the first mesh."""
    most, centre = 0, None
    for primitive in scene["meshes"][0]["primitives"]:

        def numbers(accessor, kind, size, width):
            accessor = scene["accessors"][accessor]
            view = scene["bufferViews"][accessor["bufferView"]]
            first = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            stride = view.get("byteStride", width * size)
            return [struct.unpack_from(f"<{width}{kind}", binary, first + k * stride) for k in range(accessor["count"])]

        points = numbers(primitive["attributes"]["POSITION"], "f", 4, 3)
        kind = {5123: ("H", 2), 5125: ("I", 4)}[scene["accessors"][primitive["indices"]]["componentType"]]
        corners = [k for (k,) in numbers(primitive["indices"], *kind, 1)]
        for a, b, c in zip(corners[::3], corners[1::3], corners[2::3]):
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[a], points[b], points[c]
            area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            if abs(az - bz) + abs(az - cz) < 1e-3 and abs(area) > most:
                most = abs(area)
                centre = [(ax + bx + cx) / 3, (ay + by + cy) / 3, az]
    return centre


def with_crate(glb):
    """The GLB with a crate of half a unit, a child of its first node."""
    scene, binary = chunks(glb)
    centre = largest_floor(scene, binary)
    corners = [(x, y, z) for x in (-0.25, 0.25) for y in (-0.25, 0.25) for z in (-0.25, 0.25)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    indices = [k for a, b, c, d in sides for k in (a, b, c, a, c, d)]
    binary += bytes(-len(binary) % 4)
    first = len(binary)
    binary += struct.pack("<24f", *(c for corner in corners for c in corner)) + struct.pack("<36H", *indices)
    views, accessors = scene["bufferViews"], scene["accessors"]
    views += [
        {"buffer": 0, "byteOffset": first, "byteLength": 96},
        {"buffer": 0, "byteOffset": first + 96, "byteLength": 72},
    ]
    bounds = {"min": [-0.25] * 3, "max": [0.25] * 3}
    accessors += [
        {"bufferView": len(views) - 2, "componentType": 5126, "count": 8, "type": "VEC3", **bounds},
        {"bufferView": len(views) - 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1}
    scene["meshes"].append({"primitives": [primitive]})
    # A hand's breadth off the floor, on either side of it.
    node = {"name": "crate", "mesh": len(scene["meshes"]) - 1, "translation": [*centre[:2], centre[2] + 0.3]}
    scene["nodes"].append(node)
    scene["nodes"][0].setdefault("children", []).append(len(scene["nodes"]) - 1)
    scene["buffers"][0]["byteLength"] = len(binary)
    return packed(scene, binary)


def packed(scene, binary):
    """A GLB file."""
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(binary) + bytes(-len(binary) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary


def move_glb(glb, name, step):
    """The GLB with one node moved."""
    scene, binary = chunks(glb)
    return packed(json.loads(move_gltf(json.dumps(scene), name, step)), binary)


def run(words):
    """Processor seconds of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(program, folder, name, words):
    """Bakes before and after the change, updates, and compares."""
    old, new, whole, layout = (str(folder / kind) for kind in ("old", "new", "whole", "layout"))
    before, after = (str(folder / side / name) for side in "ab")
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
        ("196 boxes", "boxes.obj", boxes(14), move_obj, "box_100", (0.4, 0, 0), PAGE),
        ("courtyard", "courtyard.obj", (SCENES / "courtyard.obj").read_text(), move_obj, "urn_0", (0.2, 0, 0.2), PAGE),
        ("interior", "interior.gltf", (SCENES / "interior.gltf").read_text(), move_gltf, "chair_0", (0.1, 0, 0), PAGE),
    ]
    models = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "models")
    level = models / "game_level_zdm2.glb"
    if level.is_file():
        # A level is one object, of whose texels a crate would take its share.
        page = ["--size", "1024", "--rays", "64", "--density-of", "crate=8", "--quiet"]
        content = with_crate(level.read_bytes())
        cases.append(("game_level_zdm2, a crate", "level.glb", content, move_glb, "crate", (0.2, 0, 0), page))
    else:
        print(f"skip: no {level}", file=sys.stderr)
    print("| scene | max distance | baked | update | whole | ratio | same bytes |")
    print("|---|---|---|---|---|---|---|")
    for title, name, text, move, moved, step, page in cases:
        # A room of a few units needs shorter rays.
        limit = "0.5" if title == "interior" else "2"
        for more in [["--max-distance", limit], *([[]] if title == cases[0][0] else [])]:
            with tempfile.TemporaryDirectory() as place:
                folder = pathlib.Path(place)
                for side, content in (("a", text), ("b", move(text, moved, step))):
                    (folder / side).mkdir()
                    (folder / side / name).write_bytes(content if isinstance(content, bytes) else content.encode())
                    for other in SCENES.glob(name.split(".")[0] + ".*"):
                        if other.name != name:
                            (folder / side / other.name).write_bytes(other.read_bytes())
                share, update, full, same = row(program, folder, name, [*page, *more])
            shown = more[1] if more else "none"
            print(f"| {title} | {shown} | {share:.1%} | {update:.1f} s | {full:.1f} s | {update / full:.0%} | {same} |", flush=True)


if __name__ == "__main__":
    main()
