#!/usr/bin/env python3
"""Writes every scene of this folder, and a sky. Same bytes on every run; the standard library is enough.

    python3 scenes/generate.py [DIR [DETAIL]]

DETAIL is the airliner's, 24 for 6,932 triangles; 96 makes 71,228.

Authored scenes are y-up. In OBJ scenes an object's name says how a test reads it:
`receiver*` is compared with the exact value, `sheet*` blocks from both sides, `convex*` is a closed
convex body (only the faces that look at a point block it). Every scene but the courtyard and the
instanced one carries a lightmap UV set: receivers lie on whole texels of a 16, 32 or 64 texel page.
"""

import base64
import json
import math
import os
import struct
import sys
import zlib

FAR = 4096.0


def number(x):
    text = f"{x:.7f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return mul(a, 1.0 / math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))


def turn_y(p, degrees):
    """`p` turned about +y, counter-clockwise seen from above."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c * p[0] + s * p[2], p[1], -s * p[0] + c * p[2])


class Obj:
    """An OBJ file under construction: numbers are shared, faces refer to them."""

    def __init__(self, *header):
        self.header, self.lines = header, []
        self.known = {"v": {}, "vt": {}, "vn": {}}

    def index(self, kind, values):
        text = " ".join(number(x) for x in values)
        table = self.known[kind]
        if text not in table:
            table[text] = len(table) + 1
            self.lines.append(f"{kind} {text}")
        return table[text]

    def object(self, name, material=None):
        self.lines.append(f"o {name}")
        if material:
            self.lines.append(f"usemtl {material}")

    def face(self, points, uvs=None, normals=None):
        """Corners counter-clockwise seen from the front; `uvs` in page coordinates, v down."""
        corners = []
        for i, p in enumerate(points):
            v = self.index("v", p)
            vt = self.index("vt", (uvs[i][0], 1.0 - uvs[i][1])) if uvs else ""
            vn = self.index("vn", normals[i]) if normals else None
            corners.append(f"{v}/{vt}/{vn}" if vn else f"{v}/{vt}" if uvs else f"{v}")
        self.lines.append("f " + " ".join(corners))

    def quad(self, corner, down, right, rect, normal=None):
        """A parallelogram whose picture is the page rectangle (u0, v0, u1, v1); front = down x right."""
        u0, v0, u1, v1 = rect
        points = [corner, add(corner, down), add(add(corner, down), right), add(corner, right)]
        self.face(points, [(u0, v0), (u0, v1), (u1, v1), (u1, v0)], [normal] * 4 if normal else None)

    def text(self):
        head = [f"# {line}" for line in self.header] + ["# Written by scenes/generate.py."]
        return "\n".join(head + self.lines) + "\n"


def cell(x, y, width, height):
    """A page rectangle in sixteenths."""
    return (x / 16, y / 16, (x + width) / 16, (y + height) / 16)


def shelf(count):
    """`count` page rectangles in the right part of the page, a gap of half a sixteenth between them."""
    step = 16 / count
    return [cell(9, i * step, 7, step - 0.5) for i in range(count)]


RECEIVER = cell(0, 0, 8, 8)


def floor(obj, x, z, width, rect=RECEIVER, normal=None, name="receiver_floor"):
    """A square of the plane y = 0 that looks up; rows of the page run along +z, columns along +x."""
    obj.object(name)
    obj.quad((x, 0, z), (0, 0, width), (width, 0, 0), rect, normal)


# ---------------------------------------------------------------------------------------------------
# Scenes whose answer is known on paper


def plane():
    obj = Obj("Open plane, 4 x 4.", "Answer: visibility 1, diffuse 1, specular 1 at normal view, everywhere.")
    floor(obj, -2, -2, 4, cell(0, 0, 16, 16))
    return obj


def tilted():
    obj = Obj(
        "Plane whose shading normal is tilted 30 degrees from the geometric one, towards +x.",
        "The hemisphere is the shading normal's; what lies below the plane is blocked.",
        "Answer: visibility 5/6, diffuse cos^2(15 deg) = 0.9330127, everywhere.",
    )
    floor(obj, -2, -2, 4, cell(0, 0, 16, 16), (math.sin(math.radians(30)), math.cos(math.radians(30)), 0))
    return obj


def wall_long():
    obj = Obj(
        "Floor before a wall of height 1 that looks infinitely long (8192).",
        "Answer at distance d, up to 1e-6: visibility 1 - atan(1/d)/pi, diffuse (1 + d/sqrt(d^2 + 1))/2.",
    )
    floor(obj, 0, -2, 4)
    obj.object("sheet_wall")
    obj.quad((0, 1, FAR), (0, -1, 0), (0, 0, -2 * FAR), shelf(1)[0])
    return obj


def wall_finite():
    obj = Obj(
        "Floor 4 x 4 with a free-standing wall z in [-1, 1], y in [0, 1] in the plane x = 0.",
        "Answer for one half [0, w] x [0, h] at distance d (add or subtract halves), blocked part:",
        "visibility atan(w h / (d sqrt(d^2 + w^2 + h^2))) / 2 pi;",
        "diffuse (atan(w/d) - d/sqrt(d^2 + h^2) atan(w/sqrt(d^2 + h^2))) / 2 pi.",
    )
    floor(obj, -2, -2, 4)
    obj.object("sheet_wall")
    obj.quad((0, 1, 1), (0, -1, 0), (0, 0, -2), shelf(1)[0])
    return obj


def groove(degrees):
    b = math.radians(degrees)
    obj = Obj(
        f"V groove with an opening of {degrees} degrees; faces {FAR:.0f} wide and {2 * FAR:.0f} long.",
        f"Answer for infinite faces: visibility {degrees}/180 = {degrees / 180:.7f}, "
        f"diffuse sin^2({degrees}/2 deg) = {math.sin(b / 2) ** 2:.7f}, everywhere (here within 4e-4).",
    )
    floor(obj, 0, -2, 4)
    cells = shelf(5)
    obj.object("sheet_same_face")
    obj.quad((0, 0, -FAR), (0, 0, FAR - 2), (4, 0, 0), cells[0])
    obj.quad((0, 0, 2), (0, 0, FAR - 2), (4, 0, 0), cells[1])
    obj.quad((4, 0, -FAR), (0, 0, 2 * FAR), (FAR - 4, 0, 0), cells[2])
    # A strip of its own along the crease: f32 cannot place a huge slanted triangle well enough for points beside it.
    obj.object("sheet_other_face")
    near, far = (4 * math.cos(b), 4 * math.sin(b), FAR), (FAR * math.cos(b), FAR * math.sin(b), FAR)
    obj.quad(near, sub((0, 0, FAR), near), (0, 0, -2 * FAR), cells[3])
    obj.quad(far, sub(near, far), (0, 0, -2 * FAR), cells[4])
    return obj


def corner():
    obj = Obj(
        f"Corner of three planes: floor, and two walls {FAR:.0f} wide and high.",
        "Answer for infinite walls: visibility 1/4 and diffuse 1/4 everywhere (here within 4e-4).",
    )
    floor(obj, 0, 0, 4)
    cells = shelf(2)
    obj.object("sheet_walls")
    obj.quad((0, FAR, FAR), (0, -FAR, 0), (0, 0, -FAR), cells[0])
    obj.quad((0, FAR, 0), (0, -FAR, 0), (FAR, 0, 0), cells[1])
    return obj


def rectangle_overhead():
    obj = Obj(
        "Floor 4 x 4 under a horizontal rectangle [-1, 1]^2 at height 1.",
        "Answer at the middle: visibility 2/3, diffuse 0.4458736; corner formulas elsewhere.",
    )
    floor(obj, -2, -2, 4)
    obj.object("sheet_rectangle")
    obj.quad((-1, 1, 1), (0, 0, -2), (2, 0, 0), shelf(1)[0])
    return obj


def triangle_overhead():
    obj = Obj(
        "Floor 4 x 4 under a slanted triangle.",
        "Answer at the middle: visibility 0.5616508, diffuse 0.3263809; Lambert's edge sum elsewhere.",
    )
    floor(obj, -2, -2, 4)
    obj.object("sheet_triangle")
    obj.face([(-1, 0.5, 1), (2, 0.75, 0.5), (0, 1, -2)], [(10 / 16, 1 / 16), (10 / 16, 15 / 16), (15 / 16, 8 / 16)])
    return obj


def sphere_faces(obj, centre, radius, segments, rings, rect, smooth=False):
    """A globe with its poles on the y axis; its picture is the latitude-longitude map."""
    u0, v0, u1, v1 = rect

    def direction(i, j):
        polar = math.pi * j / rings
        turn = 2 * math.pi * (i % segments) / segments
        flat = 0.0 if j in (0, rings) else math.sin(polar)
        height = 1.0 if j == 0 else -1.0 if j == rings else math.cos(polar)
        return (flat * math.cos(turn), height, -flat * math.sin(turn))

    def corner(i, j, shift=0.0):
        uv = (u0 + (u1 - u0) * (i + shift) / segments, v0 + (v1 - v0) * j / rings)
        d = direction(i, j)
        return add(centre, mul(d, radius)), uv, d

    for j in range(rings):
        for i in range(segments):
            if j == 0:
                corners = [corner(i, 0, 0.5), corner(i, 1), corner(i + 1, 1)]
            elif j == rings - 1:
                corners = [corner(i, j), corner(i, rings, 0.5), corner(i + 1, j)]
            else:
                corners = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)]
            points, uvs, normals = zip(*corners)
            obj.face(points, uvs if rect != NO_UV else None, normals if smooth else None)


NO_UV = (0, 0, 0, 0)


def resting_sphere():
    obj = Obj(
        "Unit sphere resting on a floor 8 x 8; a pole vertex touches the floor at the origin.",
        "Answer for the smooth sphere at distance r of the contact: visibility r/sqrt(r^2 + 1), diffuse",
        "1 - (r^2 + 1)^-1.5. The sphere here has 32 x 16 faces: compare with the silhouette of this mesh.",
    )
    floor(obj, -4, -4, 8)
    obj.object("convex_sphere")
    sphere_faces(obj, (0, 1, 0), 1, 32, 16, cell(9, 0, 7, 16))
    return obj


def trench():
    obj = Obj(
        f"Trench of width 1 and depth 1, {2 * FAR:.0f} long; a square of its floor and one of its wall receive.",
        "Answer on the floor, rims seen at elevations a and b: visibility 1 - (a + b)/pi, diffuse (cos a + cos b)/2.",
        "On the wall at depth t, d = atan t: visibility 1/2 - d/pi, diffuse (1 - sin d)/2.",
    )
    floor(obj, 0, -0.5, 1)
    obj.object("receiver_wall")
    obj.quad((0, 1, 0.5), (0, -1, 0), (0, 0, -1), cell(0, 8, 8, 8))
    cells = shelf(5)
    obj.object("sheet_floor")
    obj.quad((0, 0, -FAR), (0, 0, FAR - 0.5), (1, 0, 0), cells[0])
    obj.quad((0, 0, 0.5), (0, 0, FAR - 0.5), (1, 0, 0), cells[1])
    obj.object("sheet_walls")
    obj.quad((0, 1, FAR), (0, -1, 0), (0, 0, 0.5 - FAR), cells[2])
    obj.quad((0, 1, -0.5), (0, -1, 0), (0, 0, 0.5 - FAR), cells[3])
    obj.quad((1, 1, -FAR), (0, -1, 0), (0, 0, 2 * FAR), cells[4])
    return obj


def inward_panels(size, counts):
    """Panels (corner, down, right) of a box [0, size] that look inwards; `counts` panels along x, y, z."""
    step = [size[k] / counts[k] for k in range(3)]

    def vector(axis, length):
        return tuple(length if k == axis else 0 for k in range(3))

    panels = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            for i in range(counts[a]):
                for j in range(counts[b]):
                    at = add(add(vector(axis, side * size[axis]), vector(a, i * step[a])), vector(b, j * step[b]))
                    down, right = vector(a, step[a]), vector(b, step[b])
                    if side:
                        at, down = add(at, down), mul(down, -1)
                    panels.append((at, down, right))
    return panels


def closed_box():
    obj = Obj("Closed box 4 x 2 x 3, seen from inside.", "Answer: visibility, diffuse and specular exactly 0 everywhere.")
    obj.object("receiver_box")
    for i, (at, down, right) in enumerate(inward_panels((4, 2, 3), (1, 1, 1))):
        obj.quad(at, down, right, cell(5 * (i % 3) + 0.5, 8 * (i // 3) + 0.5, 4, 7))
    return obj


def closed_room():
    obj = Obj(
        "Closed room 4 x 2.5 x 4 of 16 abutting panels, separate objects, turned 17 degrees.",
        "Answer: visibility, diffuse and specular exactly 0 everywhere: a leak shows as more.",
    )
    for i, (at, down, right) in enumerate(inward_panels((4, 2.5, 4), (2, 1, 2))):
        obj.object(f"receiver_panel_{i:02}")
        rect = cell(4 * (i % 4), 4 * (i // 4), 3, 3)
        u0, v0, u1, v1 = rect
        points = [at, add(at, down), add(add(at, down), right), add(at, right)]
        obj.face([turn_y(p, 17) for p in points], [(u0, v0), (u0, v1), (u1, v1), (u1, v0)])
    return obj


def bowl():
    segments, rings = 24, 8
    obj = Obj(
        "Hemispherical bowl of radius 1, seen from inside; one strip of its faces receives.",
        "Answer for the smooth bowl: diffuse 1/2 everywhere; visibility 1 - 1/sqrt(2) at the bottom, 1/2 at the rim.",
        "The bowl here has 24 x 8 flat faces: compare with this mesh. The strip is unrolled without distortion.",
    )

    def point(i, j):
        polar = 0.5 * math.pi * j / rings
        turn = 2 * math.pi * (i % segments) / segments
        flat = 0.0 if j == 0 else math.sin(polar)
        height = 0.0 if j == rings else -math.cos(polar)
        return (flat * math.cos(turn), height, -flat * math.sin(turn))

    def faces(i):
        for j in range(rings):
            if j == 0:
                yield j, [point(i, 0), point(i, 1), point(i + 1, 1)]
            else:
                yield j, [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)]

    obj.object("receiver_strip")
    length = 2 * rings * math.sin(0.25 * math.pi / rings)
    scale = 15 / 16 / length
    half = [math.sin(0.5 * math.pi * j / rings) * math.sin(math.pi / segments) for j in range(rings + 1)]
    slant = [0.0]
    for j in range(rings):
        a, b = point(0, j), point(0, j + 1)
        chord = sub(b, a)
        rise = math.sqrt(sum(x * x for x in chord) - (half[j + 1] - half[j]) ** 2)
        slant.append(slant[-1] + rise)
    middle = 3 / 16

    def flat_uv(j, side):
        return (middle + side * half[j] * scale, slant[j] * scale + 0.5 / 16)

    for j, points in faces(0):
        if j == 0:
            obj.face(points, [flat_uv(0, 0), flat_uv(1, -1), flat_uv(1, 1)])
        else:
            obj.face(points, [flat_uv(j, -1), flat_uv(j + 1, -1), flat_uv(j + 1, 1), flat_uv(j, 1)])
    obj.object("sheet_bowl")
    for i in range(1, segments):
        for j, points in faces(i):
            left, right = 6 / 16 + (i - 1) * 10 / 16 / (segments - 1), 6 / 16 + i * 10 / 16 / (segments - 1)
            top, bottom = j / rings, (j + 1) / rings
            if j == 0:
                obj.face(points, [(0.5 * (left + right), top), (left, bottom), (right, bottom)])
            else:
                obj.face(points, [(left, top), (left, bottom), (right, bottom), (right, top)])
    return obj


def convex_body():
    obj = Obj(
        "A convex body alone: an icosahedron with every face split in four, flat shaded.",
        "Answer: visibility 1, diffuse 1 everywhere: a convex body cannot block itself; no ray is needed.",
    )
    g = 0.5 + math.sqrt(1.25)
    corners = []
    for a in (-1, 1):
        for b in (-g, g):
            corners += [(0, a, b), (a, b, 0), (b, 0, a)]
    corners = [unit(c) for c in corners]
    edge = min(sum(x * x for x in sub(corners[0], c)) for c in corners[1:]) * 1.01
    near = [[sum(x * x for x in sub(p, q)) < edge for q in corners] for p in corners]
    triangles = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if near[i][j] and near[j][k] and near[i][k]:
                    a, b, c = corners[i], corners[j], corners[k]
                    if sum(x * y for x, y in zip(cross(sub(b, a), sub(c, a)), a)) < 0:
                        b, c = c, b
                    ab, bc, ca = unit(add(a, b)), unit(add(b, c)), unit(add(c, a))
                    triangles += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    obj.object("convex_body")
    for n, points in enumerate(triangles):
        x, y = n % 10 * 1.6, n // 10 * 2
        u0, v0, u1, v1 = cell(x + 0.1, y + 0.1, 1.4, 1.8)
        obj.face(points, [(0.5 * (u0 + u1), v0), (u0, v1), (u1, v1)])
    return obj


# ---------------------------------------------------------------------------------------------------
# glTF: a masked card and instances, each with an OBJ twin that says the same in plain triangles


class Gltf:
    """A glTF file with one embedded buffer."""

    def __init__(self, answer):
        self.bytes = bytearray()
        self.json = {
            "asset": {"version": "2.0", "generator": "scenes/generate.py", "extras": {"answer": answer}},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }

    def accessor(self, rows, kind, component, target, bounds=False):
        code = {5126: "f", 5123: "H"}[component]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[kind]
        flat = [x for row in rows for x in (row if width > 1 else [row])]
        data = struct.pack(f"<{len(flat)}{code}", *flat)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), "target": target}
        self.bytes += data + bytes(-len(data) % 4)
        self.json["bufferViews"].append(view)
        entry = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component}
        entry |= {"count": len(rows), "type": kind}
        if bounds:
            entry |= {"min": [min(c) for c in zip(*rows)], "max": [max(c) for c in zip(*rows)]}
        self.json["accessors"].append(entry)
        return len(self.json["accessors"]) - 1

    def mesh(self, name, positions, normals, uv_sets, indices, material=None):
        attributes = {"POSITION": self.accessor(positions, "VEC3", 5126, 34962, bounds=True)}
        attributes["NORMAL"] = self.accessor(normals, "VEC3", 5126, 34962)
        for i, uvs in enumerate(uv_sets):
            attributes[f"TEXCOORD_{i}"] = self.accessor(uvs, "VEC2", 5126, 34962)
        primitive = {"attributes": attributes, "indices": self.accessor(indices, "SCALAR", 5123, 34963)}
        if material is not None:
            primitive["material"] = material
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def node(self, name, root=True, **fields):
        self.json["nodes"].append({"name": name} | fields)
        if root:
            self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return len(self.json["nodes"]) - 1

    def text(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.bytes)).decode()
        return json.dumps(self.json | {"buffers": [{"byteLength": len(self.bytes), "uri": uri}]}, indent=1) + "\n"


def png(width, height, rgba):
    """An RGBA PNG with stored (uncompressed) blocks, so that its bytes depend on no compressor."""
    raw = b"".join(b"\0" + bytes(rgba[4 * width * y : 4 * width * (y + 1)]) for y in range(height))
    stored = b"\x78\x01\x01" + struct.pack("<HH", len(raw), 0xFFFF - len(raw)) + raw + struct.pack(">I", zlib.adler32(raw))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", stored) + chunk(b"IEND", b"")


QUAD_INDICES = [0, 1, 2, 0, 2, 3]


def quad_rows(corner, down, right, rect):
    u0, v0, u1, v1 = rect
    points = [corner, add(corner, down), add(add(corner, down), right), add(corner, right)]
    return points, [unit(cross(down, right))] * 4, [(u0, v0), (u0, v1), (u1, v1), (u1, v0)]


def masked_card():
    gltf = Gltf(
        "floor under a 4 x 4 card at height 1 whose alpha mask keeps the cells (i + j even) of an 8 x 8 board: "
        "masked_card_twin.obj holds the kept cells as plain quads and has the same answer"
    )
    gltf.json["images"] = [{"uri": "masked_card.png"}]
    gltf.json["samplers"] = [{"magFilter": 9728, "minFilter": 9728, "wrapS": 10497, "wrapT": 10497}]
    gltf.json["textures"] = [{"source": 0, "sampler": 0}]
    gltf.json["materials"] = [
        {
            "name": "card",
            "alphaMode": "MASK",
            "alphaCutoff": 0.5,
            "doubleSided": True,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 1},
        },
    ]
    points, normals, uvs = quad_rows((-2, 0, -2), (0, 0, 4), (4, 0, 0), RECEIVER)
    mesh = gltf.mesh("receiver_floor", points, normals, [[(0, 0)] * 4, uvs], QUAD_INDICES)
    gltf.node("receiver_floor", mesh=mesh)
    points, normals, uvs = quad_rows((-2, 1, -2), (0, 0, 4), (4, 0, 0), shelf(1)[0])
    tiles = [(0, 0), (0, 4), (4, 4), (4, 0)]
    mesh = gltf.mesh("card", points, normals, [tiles, uvs], QUAD_INDICES, 0)
    gltf.node("card", mesh=mesh)
    return gltf


def masked_card_image():
    return png(2, 2, [200, 220, 180, 128, 0, 0, 0, 127, 0, 0, 0, 127, 200, 220, 180, 128])


def masked_card_twin():
    obj = Obj("The kept cells of masked_card.gltf as quads: 32 squares of edge 1/2 at height 1 over a floor.",
              "Answer: form factors of the squares; both files bake to the same floor.")
    floor(obj, -2, -2, 4)
    obj.object("sheet_cells")
    n = 0
    for j in range(8):
        for i in range(8):
            if (i + j) % 2 == 0:
                rect = cell(9 + n % 4 * 1.75, n // 4 * 2, 1.5, 1.75)
                obj.quad((-2 + 0.5 * i, 1, -2 + 0.5 * j), (0, 0, 0.5), (0.5, 0, 0), rect)
                n += 1
    return obj


APEX = (0.25, 1, 0.125)
BASE = [(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5), (-0.5, 0, 0.5)]
PYRAMID = [(BASE[0], BASE[1], BASE[2]), (BASE[0], BASE[2], BASE[3])] + [
    (BASE[(k + 1) % 4], BASE[k], APEX) for k in range(4)
]


def placed(scale, degrees, translation, parent=(1, 1, 1)):
    """The map of a node under a parent that only scales: parent * (translate * turn * scale)."""

    def apply(p):
        q = tuple(p[k] * scale[k] for k in range(3))
        q = add(turn_y(q, degrees), translation)
        return tuple(q[k] * parent[k] for k in range(3))

    return apply


# Name, scale, turn in degrees, translation, scale of the parent node.
PLACES = [
    ("plain", (1, 1, 1), 0, (2, 0, 0), None),
    ("turned", (1, 1, 1), 30, (0, 0, 2.25), None),
    ("mirrored", (-1, 1, 1), 0, (-2, 0, 0), None),
    ("squeezed", (1, 2, 0.25), 0, (0, 0, -2), None),
    ("point_mirrored", (-0.5, -0.5, -0.5), 0, (2, 0.5, -2), None),
    ("sheared", (1, 1, 1), 45, (-2.25, 0, 1.125), (1, 1, 2)),
    ("twin_of_plain", (1, 1, 1), 0, (2, 0, 0), None),
]


def instances():
    gltf = Gltf(
        "floor among seven instances of one pyramid (mirrored, squeezed, sheared, two coincident): "
        "instances_twin.obj holds them flattened and has the same answer"
    )
    points, normals, uvs = quad_rows((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0), (0, 0, 1, 1))
    gltf.node("receiver_floor", mesh=gltf.mesh("receiver_floor", points, normals, [uvs], QUAD_INDICES))
    positions = [p for t in PYRAMID for p in t]
    normals = [unit(cross(sub(t[1], t[0]), sub(t[2], t[0]))) for t in PYRAMID for _ in t]
    uvs = []
    for n in range(len(PYRAMID)):
        u0, v0, u1, v1 = cell(n % 3 * 5 + 0.5, n // 3 * 8 + 0.5, 4, 7)
        uvs += [(u0, v0), (u0, v1), (u1, v1)]
    mesh = gltf.mesh("pyramid", positions, normals, [uvs], list(range(len(positions))))
    for name, scale, degrees, translation, parent in PLACES:
        half = math.radians(degrees) / 2
        fields = {"mesh": mesh, "translation": translation, "scale": scale}
        if degrees:
            fields["rotation"] = [0, round(math.sin(half), 9), 0, round(math.cos(half), 9)]
        child = gltf.node(name, root=parent is None, **fields)
        if parent is not None:
            gltf.node(name + "_parent", scale=parent, children=[child])
    return gltf


def instances_twin():
    obj = Obj("instances.gltf flattened: six pyramids around a floor (the coincident seventh is left out).",
              "Answer: form factors of the faces that look at the point; the bodies do not overlap as seen from the floor.")
    floor(obj, -0.5, -0.5, 1)
    n = 0
    for name, scale, degrees, translation, parent in PLACES[:-1]:
        place = placed(scale, degrees, translation, parent or (1, 1, 1))
        mirrored = scale[0] * scale[1] * scale[2] < 0
        obj.object("convex_" + name)
        for triangle in PYRAMID:
            points = [place(p) for p in triangle]
            u0, v0, u1, v1 = cell(9 + n % 6 * 1.15, n // 6 * 2.5, 1, 2)
            obj.face(points[::-1] if mirrored else points, [(u0, v0), (u0, v1), (u1, v1)])
            n += 1
    return obj


# ---------------------------------------------------------------------------------------------------
# The showcase


COURTYARD_MATERIALS = {
    "paving": ((0.52, 0.47, 0.41), None),
    "plaster": ((0.80, 0.74, 0.63), None),
    "stone": ((0.66, 0.62, 0.55), None),
    "marble": ((0.72, 0.71, 0.69), ((0.12, 0.12, 0.12), 60)),
    "bronze": ((0.26, 0.17, 0.09), ((0.46, 0.36, 0.22), 30)),
    "terracotta": ((0.62, 0.32, 0.20), ((0.05, 0.05, 0.05), 10)),
    "wood": ((0.45, 0.31, 0.19), None),
}


def materials(scene, table):
    lines = [f"# Materials of {scene}.obj: the Phong model itself (Kd albedo, Ks specular, Ns exponent).",
             "# Written by scenes/generate.py."]
    for name, (albedo, gloss) in table.items():
        lines += ["", f"newmtl {name}", "Kd " + " ".join(number(x) for x in albedo)]
        if gloss:
            lines += ["Ks " + " ".join(number(x) for x in gloss[0]), f"Ns {number(gloss[1])}"]
    return "\n".join(lines) + "\n"


def flat_face(obj, points):
    normal = unit(cross(sub(points[1], points[0]), sub(points[2], points[0])))
    obj.face(points, None, [normal] * len(points))


def block(obj, low, high, degrees=0.0, bottom=False):
    """A box; `degrees` turns it about its own vertical axis. Without `bottom` it stands on something."""
    middle = mul(add(low, high), 0.5)

    def at(x, y, z):
        p = (x - middle[0], y, z - middle[2])
        return add(turn_y(p, degrees), (middle[0], 0, middle[2]))

    (x0, y0, z0), (x1, y1, z1) = low, high
    sides = [
        [(x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)],
        [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
        [(x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)],
        [(x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)],
        [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)],
    ]
    if bottom:
        sides.append([(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)])
    for side in sides:
        flat_face(obj, [at(*p) for p in side])


def lathe(obj, centre, profile, segments):
    """A body of revolution about +y from (radius, height) pairs, upwards outside; smooth round the axis, hard
    where two pairs of the profile meet. Radius 0 closes it."""

    def ring(i):
        turn = 2 * math.pi * (i % segments) / segments
        return math.cos(turn), -math.sin(turn)

    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        slope = unit((y1 - y0, r0 - r1, 0))
        for i in range(segments):
            (c0, s0), (c1, s1) = ring(i), ring(i + 1)
            n0 = (slope[0] * c0, slope[1], slope[0] * s0)
            n1 = (slope[0] * c1, slope[1], slope[0] * s1)
            corners = [((r0, y0), c0, s0, n0), ((r0, y0), c1, s1, n1), ((r1, y1), c1, s1, n1), ((r1, y1), c0, s0, n0)]
            if r0 == 0:
                corners = [corners[0], corners[2], corners[3]]
            elif r1 == 0:
                corners = corners[:3]
            points = [add(centre, (r * c, y, r * s)) for (r, y), c, s, _ in corners]
            obj.face(points, None, [n for *_, n in corners])


def column(obj, x, y, z):
    """Base, tapered shaft with a slight swelling, and capital: 2.25 high."""
    block(obj, (x - 0.26, y, z - 0.26), (x + 0.26, y + 0.14, z + 0.26))
    shaft = [(0.22, 0.14), (0.22, 0.20), (0.17, 0.24), (0.172, 0.8), (0.165, 1.4), (0.145, 1.96), (0.18, 2.0), (0.21, 2.06)]
    lathe(obj, (x, y, z), shaft, 24)
    block(obj, (x - 0.25, y + 2.06, z - 0.25), (x + 0.25, y + 2.25, z + 0.25), bottom=True)


def arch_wall(obj, xs, spring, radius, top, front, back):
    """A wall over columns at `xs`, one round arch from column to column, between z = front and z = back."""
    steps = 24
    for x0, x1 in zip(xs, xs[1:]):
        middle = 0.5 * (x0 + x1)
        curve = []
        for k in range(steps + 1):
            turn = math.pi * (1 - k / steps)
            curve.append((middle + radius * math.cos(turn), spring + radius * math.sin(turn) if 0 < k < steps else spring))
        for (xa, ya), (xb, yb) in zip(curve, curve[1:]):
            flat_face(obj, [(xa, ya, front), (xb, yb, front), (xb, top, front), (xa, top, front)])
            flat_face(obj, [(xb, yb, back), (xa, ya, back), (xa, top, back), (xb, top, back)])
            flat_face(obj, [(xb, yb, front), (xa, ya, front), (xa, ya, back), (xb, yb, back)])
    width = 0.5 * (xs[1] - xs[0]) - radius
    for x in xs:
        a, b = max(x - width, xs[0]), min(x + width, xs[-1])
        flat_face(obj, [(a, spring, front), (b, spring, front), (b, top, front), (a, top, front)])
        flat_face(obj, [(b, spring, back), (a, spring, back), (a, top, back), (b, top, back)])


def courtyard():
    obj = Obj(
        "Courtyard with an arcade, steps, a bronze sphere on a marble plinth, crates, urns and a bench (y-up, metres).",
        "No lightmap UVs: ambake unwraps it. A view: eye 5.5,3.8,9.5 look -0.6,1.2,-2.",
    )
    obj.lines.append("mtllib courtyard.mtl")
    obj.object("ground", "paving")
    flat_face(obj, [(-7, 0, -7), (-7, 0, 7), (7, 0, 7), (7, 0, -7)])
    obj.object("walls", "plaster")
    block(obj, (-7.4, 0, -7.4), (7.4, 4.2, -7))
    block(obj, (-7.4, 0, -7), (-7, 3, 7))
    block(obj, (7, 0, -7), (7.4, 3, -2.4))
    block(obj, (7, 0, -2.4), (7.4, 0.9, 7))
    obj.object("copings", "stone")
    block(obj, (-7.48, 3, -7), (-6.92, 3.12, 7.06), bottom=True)
    block(obj, (6.92, 0.9, -2.4), (7.48, 1.02, 7.06), bottom=True)
    block(obj, (6.92, 3, -7), (7.48, 3.12, -2.34), bottom=True)
    obj.object("platform", "stone")
    block(obj, (-7, 0, -7), (7, 0.45, -3.5))
    block(obj, (-7, 0, -3.5), (7, 0.30, -3.15))
    block(obj, (-7, 0, -3.15), (7, 0.15, -2.8))
    xs = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0]
    for n, x in enumerate(xs):
        obj.object(f"column_{n}", "marble")
        column(obj, x, 0.45, -3.95)
    obj.object("arcade", "plaster")
    arch_wall(obj, xs, 2.7, 0.78, 4.0, -3.75, -4.15)
    flat_face(obj, [(-6, 2.7, -4.15), (-6, 2.7, -3.75), (-6, 4.0, -3.75), (-6, 4.0, -4.15)])
    flat_face(obj, [(6, 2.7, -3.75), (6, 2.7, -4.15), (6, 4.0, -4.15), (6, 4.0, -3.75)])
    obj.object("roof", "terracotta")
    block(obj, (-7, 4.0, -7), (7, 4.2, -3.45), bottom=True)
    obj.object("plinth", "marble")
    lathe(obj, (0, 0, 1), [(1.6, 0), (1.6, 0.16), (1.2, 0.16), (1.2, 0.32), (0, 0.32)], 48)
    block(obj, (-0.4, 0.32, 0.6), (0.4, 1.12, 1.4), 22.5)
    block(obj, (-0.48, 1.12, 0.52), (0.48, 1.22, 1.48), 22.5, bottom=True)
    obj.object("sphere", "bronze")
    sphere_faces(obj, (0, 1.92, 1), 0.7, 64, 32, NO_UV, smooth=True)
    obj.object("crates", "wood")
    block(obj, (3.2, 0, 0.2), (4.4, 1.2, 1.4), 12)
    block(obj, (4.55, 0, 0.9), (5.45, 0.9, 1.8), -20)
    block(obj, (3.35, 1.2, 0.4), (4.15, 2.0, 1.2), 35)
    block(obj, (4.1, 0, 2.0), (4.7, 0.6, 2.6), 50)
    for n, (x, z) in enumerate([(-5.6, -1.9), (5.6, -1.9)]):
        obj.object(f"urn_{n}", "terracotta")
        urn = [(0.22, 0), (0.22, 0.06), (0.14, 0.12), (0.30, 0.42), (0.38, 0.70), (0.34, 0.92), (0.24, 1.02)]
        urn += [(0.34, 1.12), (0.34, 1.16), (0.28, 1.16), (0.20, 1.02), (0.30, 0.90), (0.30, 0.62), (0, 0.40)]
        lathe(obj, (x, 0, z), urn, 32)
    obj.object("bench", "stone")
    block(obj, (-6.6, 0, 1.2), (-6.0, 0.42, 1.5))
    block(obj, (-6.6, 0, 3.7), (-6.0, 0.42, 4.0))
    block(obj, (-6.68, 0.42, 1.0), (-5.92, 0.54, 4.2), bottom=True)
    return obj


AIRLINER_MATERIALS = {
    "apron": ((0.55, 0.55, 0.53), None),
    "skin": ((0.42, 0.46, 0.52), ((0.38, 0.38, 0.38), 12)),
    "glass": ((0.02, 0.02, 0.03), ((0.30, 0.32, 0.35), 100)),
    "metal": ((0.20, 0.20, 0.21), ((0.55, 0.55, 0.55), 60)),
    "rubber": ((0.06, 0.06, 0.06), None),
}


def loft(obj, rings):
    """A smooth skin over closed rings of equally many points, each ring seen counter-clockwise from the later ones."""
    count = len(rings[0])

    def at(r, i):
        return rings[r][i % count]

    def normal(r, i):
        along = sub(at(min(r + 1, len(rings) - 1), i), at(max(r - 1, 0), i))
        around = sub(at(r, i + 1), at(r, i - 1))
        n = cross(around, along)
        if sum(x * x for x in n) < 1e-18:
            # A ring that is a point: out along the axis.
            n = sub(centre(rings[r]), centre(rings[1 if r == 0 else r - 1]))
        return unit(n)

    for r in range(len(rings) - 1):
        for i in range(count):
            corners = [(r, i), (r, i + 1), (r + 1, i + 1), (r + 1, i)]
            points = [at(*c) for c in corners]
            keep = [k for k in range(4) if points[k] != points[k - 1]]
            if len(keep) >= 3:
                obj.face([points[k] for k in keep], None, [normal(*corners[k]) for k in keep])


def centre(ring):
    return tuple(sum(p[axis] for p in ring) / len(ring) for axis in range(3))


def cap(obj, ring):
    """The flat lid over a ring seen counter-clockwise."""
    middle = centre(ring)
    for a, b in zip(ring, ring[1:] + ring[:1]):
        flat_face(obj, [middle, a, b])


def foil(thickness, steps):
    """Points (along, up) of a symmetrical wing section of chord 1, the nose at 0, counter-clockwise; NACA four digits."""
    def half(x):
        return 5 * thickness * (0.2969 * math.sqrt(x) - 0.126 * x - 0.3516 * x * x + 0.2843 * x**3 - 0.1036 * x**4)

    xs = [0.5 - 0.5 * math.cos(math.pi * k / steps) for k in range(steps + 1)]
    return [(x, half(x)) for x in reversed(xs)] + [(x, -half(x)) for x in xs[1:-1]]


def blade(obj, root, tip, chords, thickness, steps, spans, upright=False):
    """A tapered wing from root to tip, noses at these points, the chord along +z; `upright` for a fin."""
    section = foil(thickness, steps)
    rings = []
    for k in range(spans + 1):
        t = k / spans
        nose = add(mul(root, 1 - t), mul(tip, t))
        chord = chords[0] * (1 - t) + chords[1] * t
        ring = [add(nose, (u * chord, 0, x * chord) if upright else (0, u * chord, x * chord)) for x, u in section]
        rings.append(ring if (tip[0] > root[0]) != upright else ring[::-1])
    loft(obj, rings)
    cap(obj, rings[-1])


def fuselage(z):
    """Radius and height of the axis of the airliner's body at the distance z along it, nose at -34, tail at 35."""
    radius, axis = 2.9, 5.2
    if z < -25:
        x = (z + 34) / 9
        return radius * math.sqrt(max(0.0, 1 - (1 - x) ** 2)), axis - 0.7 * (1 - x) ** 2
    if z <= 10:
        return radius, axis
    x = ((z - 10) / 25) ** 1.6
    return radius * (1 - 0.94 * x), axis + 1.9 * x


def pane(obj, z, angles, steps):
    """A window on the body from z[0] to z[1], between two angles in degrees above the horizon on the side of +x; two
    centimetres in front of the skin, in `steps` by `steps` facets."""
    def at(i, j):
        z_here = z[0] + (z[1] - z[0]) * i / steps
        a = math.radians(angles[0] + (angles[1] - angles[0]) * j / steps)
        r, y = fuselage(z_here)
        return ((r + 0.02) * math.cos(a), y + (r + 0.02) * math.sin(a), z_here)

    for i in range(steps):
        for j in range(steps):
            corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]
            flat_face(obj, corners if angles[0] < angles[1] else corners[::-1])


def airliner(detail):
    """The triangle count of the bodies grows with the square of `detail`."""
    obj = Obj(
        "An airliner parked on a platform, after Fig. 3 of the ambient reflection paper (y-up, metres).",
        "Lofted fuselage, wings, tail, four engines, gear. A view: eye -60,23,-68 look -2,3,-2, 30 degrees high.",
    )
    obj.lines.append("mtllib airliner.mtl")
    obj.object("platform", "apron")
    block(obj, (-40, -1.5, -42), (40, 0, 44))
    obj.object("fuselage", "skin")
    around = 2 * detail
    turns = [2 * math.pi * i / around for i in range(around)]
    rings = []
    for k in range(detail + 1):
        t = k / detail
        # Dense at the nose.
        z = -25 - 9 * math.cos(2 * math.pi * t) if t < 0.25 else -25 + 60 * (t - 0.25) / 0.75
        r, y = fuselage(z)
        rings.append([(r * math.cos(a), y + r * math.sin(a), z) for a in turns])
    loft(obj, rings)
    cap(obj, rings[-1])
    obj.object("windows", "glass")
    for right in (True, False):
        def side(angles):
            return angles if right else (180 - angles[0], 180 - angles[1])

        for k in range(44):
            pane(obj, (-24 + k, -23.65 + k), side((12, 21)), 1)
        for low, high, z in [(28, 46, -30.3), (49, 67, -30.5), (70, 88, -30.6)]:
            pane(obj, (z - 0.8, z), side((low, high)), 4)
    steps, spans = max(4, detail // 2), max(2, detail // 4)
    obj.object("wings", "skin")
    for side in (-1, 1):
        blade(obj, (side * 1.5, 4.0, -8), (side * 30, 6.6, 13), (12.5, 3.2), 0.12, steps, spans)
    obj.object("tailplane", "skin")
    for side in (-1, 1):
        blade(obj, (side * 0.4, 6.9, 26), (side * 10.5, 7.8, 32.5), (6.5, 2.2), 0.1, steps, spans)
    obj.object("fin", "skin")
    blade(obj, (0, 7.4, 22.5), (0, 18.0, 32), (10, 3.6), 0.1, steps, spans, upright=True)
    obj.object("engines", "metal")
    profile = [(0.9, 1.7), (1.25, 0.3), (1.38, 0.0), (1.5, 0.35), (1.45, 2.2), (1.05, 4.4), (0.55, 4.5), (0.2, 5.6), (0.02, 5.7)]
    for x, y, z in [(-19.5, 3.4, 0.5), (-10.5, 2.7, -5.5), (10.5, 2.7, -5.5), (19.5, 3.4, 0.5)]:
        turns = [2 * math.pi * i / detail for i in range(detail)]
        loft(obj, [[(x + r * math.cos(a), y + r * math.sin(a), z + d) for a in turns] for r, d in profile])
        cap(obj, [(x + 0.9 * math.cos(a), y + 0.9 * math.sin(a), z + 1.7) for a in reversed(turns)])
    obj.object("pylons", "skin")
    for x, y, z in [(-19.5, 4.7, 2), (-10.5, 4.0, -4), (10.5, 4.0, -4), (19.5, 4.7, 2)]:
        block(obj, (x - 0.18, y - 0.1, z), (x + 0.18, y + 1.1, z + 3.8), bottom=True)
    obj.object("legs", "metal")
    feet = [(0, -24), (-1.9, 3), (1.9, 3), (-5.5, 1), (5.5, 1)]
    for x, z in feet:
        block(obj, (x - 0.14, 0.5, z - 0.14), (x + 0.14, 4.2, z + 0.14))
    obj.object("wheels", "rubber")
    for x, z in feet:
        for dx in (-0.5, 0.5):
            turns = [2 * math.pi * i / detail for i in range(detail)]
            discs = [[(x + dx + w, 0.62 + 0.6 * math.cos(a), z + 0.6 * math.sin(a)) for a in turns] for w in (-0.2, 0.2)]
            loft(obj, discs)
            cap(obj, discs[0][::-1])
            cap(obj, discs[1])
    return obj


def ball():
    obj = Obj(
        "A smooth Lambertian globe of radius 1. Seen from far away, lit from the eye with irradiance pi:",
        "Answer: radiance sqrt(1 - r^2) at the distance r from the middle of the disc. The full moon is near 1 all over:",
        "the moon is not Lambertian. Its facets chord the globe by 3e-4.",
    )
    obj.object("globe")
    sphere_faces(obj, (0, 0, 0), 1, 128, 64, NO_UV, smooth=True)
    return obj


def wall_lit():
    obj = Obj(
        "An endless wall z = 0 (8192 x 8192), white.",
        "Answer: under a distant light of irradiance pi at 60 degrees, radiance 1/2 everywhere, from every eye.",
    )
    obj.object("wall")
    flat_face(obj, [(-FAR, -FAR, 0), (FAR, -FAR, 0), (FAR, FAR, 0), (-FAR, FAR, 0)])
    return obj


LAMP_MATERIALS = """# Materials of lamp.obj: a radiance of 2, 3, 5 and black.
# Written by scenes/generate.py.

newmtl lamp
Kd 0 0 0
Ke 2 3 5

newmtl black
Kd 0 0 0
"""


def lamp():
    obj = Obj(
        "A luminous unit square (Ke 2 3 5) at height 1 over the origin, and a screen at height 0.5 around (6, 0.5, 0).",
        "Answer for the map captured at 0,0,0 under a black sky: D looking up is 0.2394565 Ke, the square's form factor",
        "(4/pi) h/sqrt(1+h^2) atan(h/sqrt(1+h^2)) with h = 1/2; D looking down is 0.",
    )
    obj.lines.append("mtllib lamp.mtl")
    obj.object("lamp", "lamp")
    flat_face(obj, [(-0.5, 1, -0.5), (0.5, 1, -0.5), (0.5, 1, 0.5), (-0.5, 1, 0.5)])
    obj.object("screen", "black")
    flat_face(obj, [(3, 0.5, -3), (3, 0.5, 3), (9, 0.5, 3), (9, 0.5, -3)])
    return obj


# ---------------------------------------------------------------------------------------------------
# Scenes that failed: what a game level asks of a lightmap baker. Single-sided materials, so that a body has an inside.


class Level:
    """A glTF scene that takes the same calls as `Obj`: objects of one material, placed as often as asked."""

    def __init__(self, answer, palette):
        self.gltf, self.places, self.faces = Gltf(answer), {}, {}
        self.names = list(palette)
        self.gltf.json["materials"] = [
            {"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": 1}}
            for name, color in palette.items()
        ]

    def object(self, name, material, places=None):
        """Faces from here on belong to `name`; `places` are (name, fields of a node) instead of one at the origin."""
        self.faces[name] = (material, [])
        self.places[name] = places or [(name, {})]
        self.current = self.faces[name][1]

    def face(self, points, uvs=None, normals=None):
        self.current.append((points, uvs, normals))

    def build(self):
        for name, (material, faces) in self.faces.items():
            known, rows, indices = {}, [], []
            for points, uvs, normals in faces:
                corners = []
                for k, point in enumerate(points):
                    key = tuple(single(x) for x in (*point, *normals[k], *(uvs[k] if uvs else ())))
                    if key not in known:
                        known[key] = len(rows)
                        rows.append(key)
                    corners.append(known[key])
                for k in range(1, len(corners) - 1):
                    indices += [corners[0], corners[k], corners[k + 1]]
            uv_sets = [[row[6:] for row in rows]] if len(rows[0]) > 6 else []
            mesh = self.gltf.mesh(name, [r[:3] for r in rows], [r[3:6] for r in rows], uv_sets, indices, self.names.index(material))
            for node, fields in self.places[name]:
                self.gltf.node(node, mesh=mesh, **fields)
        return self.gltf


def single(x):
    """`x` to seven decimals as a 32-bit number, so that no processor's last digit shows."""
    return struct.unpack("<f", struct.pack("<f", round(x, 7) + 0.0))[0]


def stand(x, y, z, degrees=0.0, **fields):
    """Fields of a node at a place, turned about +y."""
    half = math.radians(degrees) / 2
    place = {"translation": [x, y, z]}
    if degrees:
        place["rotation"] = [0, round(math.sin(half), 9), 0, round(math.cos(half), 9)]
    return place | fields


def box(level, low, high):
    """A closed box, bottom included."""
    block(level, low, high, bottom=True)


def prism(level, outline, low, high):
    """A closed body between z = low and z = high over a convex outline in x and y, counter-clockwise seen from +z."""
    flat_face(level, [(x, y, high) for x, y in outline])
    flat_face(level, [(x, y, low) for x, y in reversed(outline)])
    for (xa, ya), (xb, yb) in zip(outline, outline[1:] + outline[:1]):
        flat_face(level, [(xa, ya, high), (xa, ya, low), (xb, yb, low), (xb, yb, high)])


def tube(level, centre, radius, low, high, segments):
    """A closed cylinder along z, smooth round its axis."""
    ring = [(math.cos(2 * math.pi * k / segments), math.sin(2 * math.pi * k / segments)) for k in range(segments)]
    for k, (xa, ya) in enumerate(ring):
        xb, yb = ring[(k + 1) % segments]
        points = [(xa, ya, high), (xa, ya, low), (xb, yb, low), (xb, yb, high)]
        points = [(centre[0] + radius * x, centre[1] + radius * y, centre[2] + z) for x, y, z in points]
        level.face(points, None, [(xa, ya, 0), (xa, ya, 0), (xb, yb, 0), (xb, yb, 0)])
    for z, turn in ((high, 1), (low, -1)):
        flat_face(level, [(centre[0] + radius * x, centre[1] + radius * y, centre[2] + z) for x, y in ring[::turn]])


TOWN_COLORS = {"grass": (0.25, 0.35, 0.15), "asphalt": (0.2, 0.2, 0.2), "paving": (0.5, 0.5, 0.48), "plaster": (0.7, 0.65, 0.55),
               "tiles": (0.45, 0.2, 0.12), "wood": (0.35, 0.25, 0.15), "glass": (0.1, 0.12, 0.14)}


def town():
    level = Level(
        "24 houses of three kinds along a street on a ground of 2 km x 2 km (y-up, metres): one plane holds 99.8 % of the area",
        TOWN_COLORS,
    )
    level.object("ground", "grass")
    flat_face(level, [(-1000, 0, -1000), (-1000, 0, 1000), (1000, 0, 1000), (1000, 0, -1000)])
    level.object("street", "asphalt")
    box(level, (-70, -0.2, -3), (70, 0.05, 3))
    for side, name in [(-1, "north"), (1, "south")]:
        level.object(f"pavement_{name}", "paving")
        box(level, (-70, -0.2, min(3 * side, 5 * side)), (70, 0.17, max(3 * side, 5 * side)))
    for kind, (width, depth, eaves, rise) in enumerate([(9, 7, 5.4, 2.6), (7, 8, 3.0, 3.4), (11, 7.5, 5.8, 2.0)]):
        places = []
        for k in range(8):
            n = 3 * k + kind
            side = 1 if n % 2 else -1
            places.append((n, stand(-63.25 + 11.5 * (n // 2), 0, side * (11.5 + 0.4 * ((5 * n) % 4)), 180 if side > 0 else 0)))
        def named(part):
            return [(f"house_{n:02}_{part}", dict(fields)) for n, fields in sorted(places, key=lambda place: place[0])]

        w, d = width / 2, depth / 2
        level.object(f"walls_{kind}", "plaster", named("walls"))
        # The outline of a gable along z, sunk in the ground.
        prism(level, [(-w, -0.3), (w, -0.3), (w, eaves), (0, eaves + rise), (-w, eaves)], -d, d)
        level.object(f"roof_{kind}", "tiles", named("roof"))
        slope = rise / w
        for s in (-1, 1):
            # A slab 0.18 thick that overhangs by 0.45 and sinks 0.06 into the walls.
            run = w + 0.45
            slab = [(0, eaves + rise - 0.06), (s * run, eaves + rise - 0.06 - slope * run),
                    (s * run, eaves + rise + 0.12 - slope * run), (0, eaves + rise + 0.12)]
            prism(level, slab if s > 0 else slab[::-1], -d - 0.4, d + 0.4)
        box(level, (w * 0.4, eaves + rise * 0.3, -0.9), (w * 0.4 + 0.6, eaves + rise + 0.8, -0.3))
        level.object(f"frames_{kind}", "wood", named("frames"))
        holes = []
        for floor_y in (1.0, 3.6) if eaves > 4 else (1.0,):
            for x in (-0.6 * w, 0, 0.6 * w):
                if (x, floor_y) != (0, 1.0):
                    holes.append((x, floor_y))
        for x, y in holes:
            for z, out in ((d, 1), (-d, -1)):
                lo, hi = sorted((z - 0.1 * out, z + 0.07 * out))
                box(level, (x - 0.6, y, lo), (x - 0.5, y + 1.3, hi))
                box(level, (x + 0.5, y, lo), (x + 0.6, y + 1.3, hi))
                box(level, (x - 0.7, y - 0.1, lo), (x + 0.7, y, hi + 0.08 * (out > 0)))
                box(level, (x - 0.6, y + 1.3, lo), (x + 0.6, y + 1.4, hi))
        box(level, (-0.55, 0, d - 0.1), (0.55, 2.1, d + 0.05))
        box(level, (-0.9, -0.1, d - 0.1), (0.9, 0.15, d + 0.9))
        level.object(f"panes_{kind}", "glass", named("panes"))
        for x, y in holes:
            for z, out in ((d, 1), (-d, -1)):
                lo, hi = sorted((z - 0.1 * out, z + 0.02 * out))
                box(level, (x - 0.5, y, lo), (x + 0.5, y + 1.3, hi))
    return level.build()


INTERIOR_COLORS = {"plaster": (0.75, 0.72, 0.66), "boards": (0.45, 0.3, 0.18), "wood": (0.5, 0.36, 0.22), "cloth": (0.4, 0.12, 0.1),
                   "glaze": (0.2, 0.35, 0.5)}


def interior():
    level = Level(
        "a furnished room of 6 m x 2.8 m x 4 m made of abutting panels 0.2 m thick, with a door opening and a window (y-up, metres)",
        INTERIOR_COLORS,
    )
    tiles = [(f"{i}{j}", 2 * i - 2.0, 2 * j - 1.0) for i in range(3) for j in range(2)]
    level.object("floor_panel", "boards", [(f"floor_{n}", stand(x, 0, z)) for n, x, z in tiles])
    box(level, (-1, -0.2, -1), (1, 0, 1))
    level.object("ceiling_panel", "plaster", [(f"ceiling_{n}", stand(x, 2.8, z)) for n, x, z in tiles])
    box(level, (-1, 0, -1), (1, 0.2, 1))
    # Panels look along +z from their origin; the back wall is whole, the front has the door, the left side the window.
    back = [(f"wall_back_{i}", stand(2 * i - 2.0, 0, -2)) for i in range(3)]
    front = [(f"wall_front_{i}", stand(2 * i - 2.0, 0, 2, 180)) for i in range(2)]
    right = [(f"wall_right_{j}", stand(3, 0, 2 * j - 1.0, -90)) for j in range(2)]
    level.object("wall_panel", "plaster", back + front + right + [("wall_left_1", stand(-3, 0, 1, 90))])
    box(level, (-1, 0, -0.2), (1, 2.8, 0))
    level.object("door_panel", "plaster", [("wall_front_2", stand(2, 0, 2, 180))])
    for low, high in [((-1, 0), (-0.45, 2.8)), ((0.45, 0), (1, 2.8)), ((-0.45, 2.05), (0.45, 2.8))]:
        box(level, (*low, -0.2), (*high, 0))
    level.object("window_panel", "plaster", [("wall_left_0", stand(-3, 0, -1, 90))])
    for low, high in [((-1, 0), (-0.6, 2.8)), ((0.6, 0), (1, 2.8)), ((-0.6, 0), (0.6, 0.9)), ((-0.6, 2.1), (0.6, 2.8))]:
        box(level, (*low, -0.2), (*high, 0))
    level.object("skirting", "wood")
    box(level, (-3, 0, -2), (3, 0.08, -1.985))
    level.object("table", "wood")
    box(level, (-1.2, 0.72, -0.45), (0.4, 0.76, 0.45))
    for x in (-1.15, 0.29):
        for z in (-0.4, 0.34):
            box(level, (x, 0, z), (x + 0.06, 0.73, z + 0.06))
    seats = [(-0.8, 0.6, 180), (0.05, 0.62, 172), (-0.75, -0.62, 4), (0.0, -0.6, -9)]
    level.object("chair", "wood", [(f"chair_{n}", stand(x, 0, z, turn)) for n, (x, z, turn) in enumerate(seats)])
    box(level, (-0.21, 0.43, -0.21), (0.21, 0.46, 0.21))
    for x in (-0.2, 0.16):
        for z in (-0.2, 0.16):
            box(level, (x, 0, z), (x + 0.04, 0.44 if z > 0 else 0.92, z + 0.04))
    box(level, (-0.19, 0.62, -0.195), (0.19, 0.9, -0.175))
    level.object("shelf", "wood")
    for x in (1.4, 2.77):
        box(level, (x, 0, -1.985), (x + 0.03, 2.0, -1.65))
    for y in (0.05, 0.5, 0.95, 1.4, 1.85):
        box(level, (1.42, y, -1.98), (2.78, y + 0.03, -1.66))
    level.object("books", "cloth")
    for n in range(14):
        x, y = 1.5 + 0.06 * (n % 7) + 0.5 * (n // 7), 0.53 + 0.45 * (n // 7)
        box(level, (x, y, -1.97), (x + 0.045, y + 0.22 + 0.02 * (n * n % 5), -1.76))
    level.object("rug", "cloth")
    box(level, (-1.9, 0, -1.1), (1.1, 0.012, 1.1))
    level.object("vase", "glaze", [("vase_table", stand(-0.4, 0.76, 0)), ("vase_shelf", stand(2.1, 1.43, -1.82))])
    lathe(level, (0, 0, 0), [(0, 0), (0.05, 0), (0.085, 0.07), (0.08, 0.13), (0.035, 0.2), (0.05, 0.24)], 24)
    lathe(level, (0, 0, 0), [(0.05, 0.24), (0.03, 0.2), (0.07, 0.12), (0, 0.02)], 24)
    return level.build()


VEHICLE_COLORS = {"asphalt": (0.22, 0.22, 0.22), "kerb": (0.5, 0.5, 0.48), "red": (0.5, 0.06, 0.05), "white": (0.7, 0.7, 0.68),
                  "rubber": (0.05, 0.05, 0.05), "chrome": (0.5, 0.5, 0.5), "dark": (0.1, 0.11, 0.13)}


def vehicles():
    level = Level(
        "two cars and a van on a parking place, wheels sunk in bodies and ground, parts that stand in one another (y-up, metres)",
        VEHICLE_COLORS,
    )
    level.object("parking", "asphalt")
    flat_face(level, [(-9, 0, -6), (-9, 0, 6), (9, 0, 6), (9, 0, -6)])
    level.object("kerb", "kerb")
    box(level, (-9, -0.1, -5), (9, 0.14, -4.4))
    parked = {"car": [("car_0", -4, 0.2, 86), ("car_1", -0.4, -0.1, 93)], "van": [("van", 3.6, -0.3, 90)]}

    def on(kind, part):
        return [(f"{name}_{part}", stand(x, 0, z, turn)) for name, x, z, turn in parked[kind]]

    side = [(-2.1, 0.28), (2.1, 0.28), (2.15, 0.62), (1.9, 0.78), (-2.1, 0.86), (-2.15, 0.5)]
    level.object("car_body", "red", on("car", "body"))
    prism(level, side, -0.85, 0.85)
    level.object("car_cabin", "dark", on("car", "cabin"))
    # Sunk 0.2 into the body.
    prism(level, [(-1.6, 0.6), (1.1, 0.6), (0.45, 1.4), (-1.1, 1.42)], -0.74, 0.74)
    level.object("car_trim", "chrome", on("car", "trim"))
    for x in (-2.2, 2.08):
        box(level, (x, 0.36, -0.88), (x + 0.14, 0.52, 0.88))
    box(level, (-1.15, 1.36, -0.8), (0.4, 1.46, -0.7))
    box(level, (-1.15, 1.36, 0.7), (0.4, 1.46, 0.8))
    tube(level, (-2.2, 0.3, 0.0), 0.04, -0.55, -0.47, 12)
    for z in (-0.85, 0.85):
        box(level, (0.7, 0.86, min(z, z * 1.2)), (0.82, 0.98, max(z, z * 1.2)))
        box(level, (-0.2, 0.7, z - 0.02), (0.0, 0.74, z + 0.02))
    level.object("van_body", "white", on("van", "body"))
    prism(level, [(-2.6, 0.35), (2.6, 0.35), (2.65, 0.95), (1.9, 1.25), (1.5, 2.15), (-2.6, 2.2)], -0.98, 0.98)
    level.object("van_trim", "dark", on("van", "trim"))
    box(level, (-2.66, 0.4, -1.0), (-2.5, 0.62, 1.0))
    box(level, (2.5, 0.4, -1.0), (2.72, 0.66, 1.0))
    for x in (-2.2, -0.9, 0.4):
        box(level, (x, 2.1, -0.9), (x + 0.08, 2.32, 0.9))
    for z in (-0.8, 0.74):
        box(level, (-2.4, 2.26, z), (0.8, 2.32, z + 0.06))
    # A ladder that passes through the rack, and a box that stands half in the roof.
    for z in (-0.3, 0.1):
        box(level, (-2.9, 2.28, z), (1.4, 2.36, z + 0.06))
    for k in range(9):
        box(level, (-2.7 + 0.45 * k, 2.3, -0.3), (-2.66 + 0.45 * k, 2.34, 0.16))
    box(level, (-1.9, 1.9, 0.25), (-0.9, 2.5, 0.7))
    wheels = []
    for kind, axles, track in [("car", (-1.35, 1.35), 0.78), ("van", (-1.7, 1.75), 0.9)]:
        for name, x, z, turn in parked[kind]:
            for a, along in enumerate(axles):
                for b, across in enumerate((-track, track)):
                    hub = add(turn_y((along, 0.29, across), turn), (x, 0, z))
                    wheels.append((f"{name}_wheel_{a}{b}", stand(*(round(c, 6) for c in hub), turn)))
    level.object("wheel", "rubber", wheels)
    # 0.03 into the ground, half of its width in the body.
    tube(level, (0, 0, 0), 0.32, -0.11, 0.11, 24)
    level.object("rim", "chrome", [(name.replace("wheel", "rim"), dict(fields)) for name, fields in wheels])
    tube(level, (0, 0, 0), 0.2, -0.125, 0.125, 16)
    level.object("bollards", "kerb")
    for x in (-6.5, 1.6, 7.4):
        lathe(level, (x, -0.2, -3.9), [(0.11, 0), (0.11, 1.1), (0, 1.16)], 16)
    return level.build()


PALM_COLORS = {"water": (0.05, 0.2, 0.25), "sand": (0.7, 0.6, 0.4), "bark": (0.35, 0.27, 0.18), "leaf": (1, 1, 1)}


def palm():
    level = Level(
        "three palms with alpha-masked leaves on a sandbank in a water plane of 4 km x 4 km (y-up, metres)", PALM_COLORS
    )
    leaf = level.gltf.json["materials"][3]
    leaf |= {"alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": True}
    leaf["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    level.gltf.json["images"] = [{"uri": "palm_leaf.png"}]
    level.gltf.json["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}]
    level.gltf.json["textures"] = [{"source": 0, "sampler": 0}]
    level.object("water", "water")
    flat_face(level, [(-2000, 0, -2000), (-2000, 0, 2000), (2000, 0, 2000), (2000, 0, -2000)])
    level.object("sandbank", "sand")
    # The outer rings lie under the water.
    lathe(level, (0, 0, 0), [(14, -1.6), (11, -0.5), (8.5, 0.05), (5, 0.7), (2, 0.95), (0, 1.0)], 32)
    places = [("a", 0, 0.9, 0, 10, 1.0), ("b", 2.6, 0.75, 1.4, 140, 0.8), ("c", -2.2, 0.8, 1.9, 255, 0.7)]
    trunk = [(f"palm_{n}_trunk", stand(x, y, z, turn, scale=[s, s, s])) for n, x, y, z, turn, s in places]
    level.object("trunk", "bark", trunk)
    rings = []
    for k in range(13):
        t = k / 12
        r = 0.24 * (1 - 0.5 * t) + (0.14 * (1 - 6 * t) if k < 2 else 0)
        turns = [-2 * math.pi * i / 14 for i in range(14)]
        rings.append([(1.3 * t * t + r * math.cos(a), -0.3 + 6.8 * t, r * math.sin(a)) for a in turns])
    loft(level, rings)
    cap(level, rings[-1])
    level.object("crown", "leaf", [(f"palm_{n}_crown", dict(fields)) for (n, *_), (_, fields) in zip(places, trunk)])
    for n in range(13):
        turn, lift = 360 * n / 13 + 9 * (n % 3), 0.5 - 0.28 * (n % 4)
        spine = []
        for k in range(6):
            t = k / 5
            spine.append((0.1 + 2.7 * t, 6.45 + 2.0 * lift * t - (1.2 + 0.3 * lift) * t * t))
        for k, ((xa, ya), (xb, yb)) in enumerate(zip(spine, spine[1:])):
            for s in (-1, 1):
                # Two halves that hang like a roof.
                inner, outer = (xa, ya, 0), (xa, ya - 0.22, s * 0.5)
                points = [inner, outer, (xb, yb - 0.22, s * 0.5), (xb, yb, 0)]
                uvs = [(k / 5, 0.5), (k / 5, 0.5 + 0.5 * s), ((k + 1) / 5, 0.5 + 0.5 * s), ((k + 1) / 5, 0.5)]
                if s < 0:
                    points, uvs = points[::-1], uvs[::-1]
                points = [add(turn_y(p, turn), (1.3, 0, 0)) for p in points]
                normal = unit(cross(sub(points[1], points[0]), sub(points[2], points[0])))
                level.face(points, uvs, [normal] * 4)
    return level.build()


def palm_leaf():
    """A feather leaf: the base left, the tip right, fronds slanting off the rib."""
    width, height, rgba = 96, 48, []
    for y in range(height):
        for x in range(width):
            along, off = (x + 0.5) / width, abs((y + 0.5) / height - 0.5) * 2
            reach = 0.95 * math.sqrt(max(0.0, 1 - (1.6 * along - 0.7) ** 2)) if along > 0.06 else 0
            frond = (16 * (along - 0.25 * off)) % 1 < 0.62
            keep = off < 0.06 or (off < reach and frond)
            rgba += [60 + 40 * frond, 110, 45, 255 if keep else 0]
    return png(width, height, rgba)


# ---------------------------------------------------------------------------------------------------
# An environment


def sky_radiance(d):
    """A clear day by the unit direction, y up: pale at the horizon, blue overhead, brown ground, paler around the sun.

    Exposed so that white paper square to the sun, its brightest place, comes out at 0.85.
    """
    if d[1] < 0:
        return (0.10, 0.08, 0.06)
    haze = (1 - d[1]) ** 3
    glow = 0.3 * max(0.0, sum(a * b for a, b in zip(d, SUN))) ** 24
    return tuple(b + (h - b) * haze + g * glow for b, h, g in zip((0.08, 0.16, 0.38), (0.38, 0.42, 0.46), (1.0, 0.9, 0.7)))


SUN = unit((0.55, 0.65, 0.52))
# Its four texels cover 0.030 sr. A level floor gets an irradiance of (1.4, 1.2, 1.0) from them, (0.4, 0.6, 1.2) from the sky.
SUN_RADIANCE = (74.0, 66.0, 52.0)


def rgbe(color):
    """Four bytes of Radiance's RGBE: mantissas of 8 bits under the exponent of the largest."""
    _, exponent = math.frexp(max(color))
    return bytes(min(255, int(c * 2.0 ** (8 - exponent) + 0.5)) for c in color) + bytes([exponent + 128])


def sky():
    """A polar map of 64 x 32 texels, flat: row 0 looks up, +z is in the middle, +x to the right of it."""
    width, height = 64, 32
    column = int((math.atan2(SUN[0], SUN[2]) / (2 * math.pi) + 0.5) * width + 0.5)
    row = int(math.acos(SUN[1]) / math.pi * height + 0.5)
    data = b"#?RADIANCE\n# Written by scenes/generate.py: a blue sky with a sun of four texels.\n"
    data += b"FORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width)
    for y in range(height):
        polar = math.pi * (y + 0.5) / height
        for x in range(width):
            turn = 2 * math.pi * (x + 0.5) / width - math.pi
            d = (math.sin(polar) * math.sin(turn), math.cos(polar), math.sin(polar) * math.cos(turn))
            in_sun = x in (column - 1, column) and y in (row - 1, row)
            data += rgbe(SUN_RADIANCE if in_sun else sky_radiance(d))
    return data


def scenes(detail):
    yield "plane.obj", plane().text()
    yield "tilted_normal.obj", tilted().text()
    yield "wall_long.obj", wall_long().text()
    yield "wall_finite.obj", wall_finite().text()
    for degrees in (60, 90, 120):
        yield f"groove_{degrees}.obj", groove(degrees).text()
    yield "corner.obj", corner().text()
    yield "rectangle_overhead.obj", rectangle_overhead().text()
    yield "triangle_overhead.obj", triangle_overhead().text()
    yield "resting_sphere.obj", resting_sphere().text()
    yield "trench.obj", trench().text()
    yield "bowl.obj", bowl().text()
    yield "closed_box.obj", closed_box().text()
    yield "closed_room.obj", closed_room().text()
    yield "convex_body.obj", convex_body().text()
    yield "masked_card.gltf", masked_card().text()
    yield "masked_card.png", masked_card_image()
    yield "masked_card_twin.obj", masked_card_twin().text()
    yield "instances.gltf", instances().text()
    yield "instances_twin.obj", instances_twin().text()
    yield "courtyard.obj", courtyard().text()
    yield "courtyard.mtl", materials("courtyard", COURTYARD_MATERIALS)
    yield "airliner.obj", airliner(detail).text()
    yield "airliner.mtl", materials("airliner", AIRLINER_MATERIALS)
    yield "ball.obj", ball().text()
    yield "wall_lit.obj", wall_lit().text()
    yield "lamp.obj", lamp().text()
    yield "lamp.mtl", LAMP_MATERIALS
    yield "sky.hdr", sky()
    yield "town.gltf", town().text()
    yield "interior.gltf", interior().text()
    yield "vehicles.gltf", vehicles().text()
    yield "palm.gltf", palm().text()
    yield "palm_leaf.png", palm_leaf()


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    # Of the airliner: the larger, the more triangles.
    detail = int(sys.argv[2]) if len(sys.argv) > 2 else 24
    os.makedirs(folder, exist_ok=True)
    for name, content in scenes(detail):
        data = content if isinstance(content, bytes) else content.encode()
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


if __name__ == "__main__":
    main()
