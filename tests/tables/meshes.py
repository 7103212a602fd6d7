"""The triangles of `meshes.csv`: OBJ texts, where they are placed, and the rims of what they hide.

Coordinates are double precision, as a test reads them: a placed corner is corner * scale + shift, rounded twice.
"""

import math

from exact import cross, dot, mpf

RHOS = ("0.01", "0.1", "0.25", "0.5", "1", "2", "4", "10")
TINY, THIN = 2.0**-13, 2.0**-20
TRIANGLES = {
    "front": [(1, 0.25, 0.5), (0.25, 1, 1), (1, 0.75, 2)],
    "cut": [(1, -0.5, -0.5), (0.5, 1, -0.25), (0.75, 0.25, 1.5)],
    "below": [(1, 0, -1), (0, 1, -1), (-1, -1, -2)],
    "sliver": [(1, 0, 0.5), (1, THIN, 0.5), (1, 0, 1.5)],
    "huge": [(-1000, -1000, 1), (1500, -500, 1), (0, 2000, 1)],
    "tiny": [(1, 1, 1), (1 + TINY, 1, 1), (1, 1 + TINY, 1)],
    "over": [(-1, -1, 0.5), (2, -0.5, 0.75), (0, 2, 1)],
}
# y from, y to, height.
WALLS = {"1_1": (-1, 1, 1), "0_2": (0, 2, 1), "10_10": (-10, 10, 1), "1000_1000": (-1000, 1000, 1)}
WALLS |= {"low": (-1, 1, 2.0**-10), "high": (-1, 1, 1024)}
WALL_NAMES = ["fwall_y-1_1_h1", "fwall_y0_2_h1", "fwall_y-10_10_h1", "fwall_y-1000_1000_h1"]
WALL_NAMES += ["fwall_y-1_1_h0.000976562", "fwall_y-1_1_h1024"]
# x from and to, y from and to, z.
RECTANGLES = {
    "unit": (-1, 1, -1, 1, 1),
    "off": (0.5, 2, 0, 1, 0.5),
    "near": (-100, 100, -100, 100, 2.0**-7),
    "strip": (-1000, 1000, 1, 1 + THIN, 1),
}
# x and z of the centre, radius.
SPHERES = {
    "above": ("0", "2", "1"),
    "side": ("1.5", "1", "0.5"),
    "half": ("2", "0", "1"),
    "low": ("2", "-0.5", "1"),
    "high": ("2", "0.5", "1"),
    "close": ("1.2", "0.3", "1"),
}
# Corners of a box by their bits, and its faces counter-clockwise from outside.
BOX_FACES = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]

FILES = ["plane.obj", "corner.obj", "box.obj", "room.obj", "sphere.obj"]
FILES += ["disc.obj", "disc_upright.obj", "disc_tilted.obj"]
FILES += [f"wall_{name}.obj" for name in WALLS]
FILES += [f"rectangle_{name}.obj" for name in RECTANGLES]
FILES += [f"triangle_{name}.obj" for name in TRIANGLES]


def text(file, levels):
    """The OBJ text of a file."""
    kind, _, rest = file.removesuffix(".obj").partition("_")
    if kind == "plane":
        points, faces = [], []
    elif kind == "corner":
        points = [(1, -4, 0), (1, 2, 0), (1, 2, 1), (1, -4, 1), (-4, 2, 0), (-4, 2, 1)]
        faces = [(0, 1, 2, 3), (1, 4, 5, 2)]
    elif kind == "wall":
        low, high, height = WALLS[rest]
        points, faces = [(1, low, 0), (1, high, 0), (1, high, height), (1, low, height)], [(0, 1, 2, 3)]
    elif kind == "rectangle":
        a, b, c, d, z = RECTANGLES[rest]
        points, faces = [(a, c, z), (b, c, z), (b, d, z), (a, d, z)], [(0, 1, 2, 3)]
    elif kind == "triangle":
        points, faces = TRIANGLES[rest], [(0, 1, 2)]
    elif kind == "box":
        points, faces = box((1, -0.5, 0), (2, 0.5, 1.5)), BOX_FACES
    elif kind == "room":
        points, faces = box((-1, -1, 0), (1, 2, 3)), BOX_FACES
    elif kind == "sphere":
        points, faces = icosphere(levels)
    else:
        points, faces = disc(rest)
    lines = ["v " + " ".join(repr(float(x)).removesuffix(".0") for x in p) for p in points]
    fans = [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]
    return "\n".join(lines + ["f " + " ".join(str(i + 1) for i in f) for f in fans] + [""])


def box(low, high):
    return [tuple((high if k >> axis & 1 else low)[axis] for axis in range(3)) for k in range(8)]


def disc(place):
    """A disc of 64 sides: of radius 1 level with the origin; upright and cut by the horizon; tilted."""
    centre, u, v = {
        "": ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
        "upright": ((1.5, 0, 0.2), (0, 0.8, 0), (0, 0, 0.8)),
        "tilted": ((0.5, 0, 1), (math.sqrt(0.5), 0, -math.sqrt(0.5)), (0, 1, 0)),
    }[place]
    turns = [2 * math.pi * k / 64 for k in range(64)]
    rim = [tuple(c + math.cos(s) * a + math.sin(s) * b for c, a, b in zip(centre, u, v)) for s in turns]
    return rim, [tuple(range(64))]


def icosphere(levels):
    """An icosahedron with corners at the cyclic permutations of (±1, ±golden ratio, 0); faces split in four so often."""
    golden = (1 + math.sqrt(5)) / 2
    points = []
    for a in (-1, 1):
        for b in (-golden, golden):
            points += [(a, b, 0), (0, a, b), (b, 0, a)]
    near = lambda i, j: abs(sum((p - q) ** 2 for p, q in zip(points[i], points[j])) - 4) < 1e-9
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if near(i, j) and near(j, k) and near(i, k):
                    out = dot(cross(points[i], points[j]), points[k]) > 0
                    faces.append((i, j, k) if out else (i, k, j))
    points = [normalised(p) for p in points]
    for _ in range(levels):
        known = {}

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in known:
                known[key] = len(points)
                points.append(normalised(tuple((p + q) / 2 for p, q in zip(points[i], points[j]))))
            return known[key]

        faces = [
            face
            for i, j, k in faces
            for a, b, c in [(middle(i, j), middle(j, k), middle(k, i))]
            for face in [(i, a, c), (j, b, a), (k, c, b), (a, b, c)]
        ]
    return points, faces


def normalised(p):
    size = math.sqrt(sum(x * x for x in p))
    return tuple(x / size for x in p)


def placements():
    """Name, file, scale, shift, and what the triangles are: a sheet, a convex body, or a room around the point."""
    here = (0.0, 0.0, 0.0)
    yield "plane", "plane.obj", 1.0, here, "sheet"
    for name, wall in zip(WALL_NAMES, WALLS):
        yield name, f"wall_{wall}.obj", 1.0, here, "sheet"
    yield "corner_fin", "corner.obj", 1.0, here, "sheet"
    for offset in ("0", "0.5", "0.9", "1", "2"):
        yield f"disc_a{offset}", "disc.obj", 1.0, (float(offset), 0.0, 1.0), "sheet"
    yield "disc_vert_cut", "disc_upright.obj", 1.0, here, "sheet"
    yield "disc_tilt", "disc_tilted.obj", 1.0, here, "sheet"
    for name in RECTANGLES:
        yield f"rect_{name}", f"rectangle_{name}.obj", 1.0, here, "sheet"
    for name, (x, z, r) in SPHERES.items():
        yield f"sphere_{name}", "sphere.obj", float(r), (float(x), 0.0, float(z)), "body"
    for rho in RHOS:
        yield f"restsphere_r{rho}", "sphere.obj", 1.0, (float(rho), 0.0, 1.0), "body"
    yield "closed_box", "room.obj", 1.0, here, "room"
    for name in TRIANGLES:
        yield f"tri_{name}", f"triangle_{name}.obj", 1.0, here, "sheet"
    yield "box", "box.obj", 1.0, here, "body"


def placed(obj, scale, shift):
    """Triangles of an OBJ text: corner numbers and points."""
    lines = [line.split() for line in obj.splitlines() if line and not line.startswith("#")]
    points = [tuple(float(x) * scale + s for x, s in zip(line[1:], shift)) for line in lines if line[0] == "v"]
    points = [tuple(mpf(x) for x in p) for p in points]
    return points, [tuple(int(i) - 1 for i in line[1:]) for line in lines if line[0] == "f"]


def rims(mesh, kind):
    """Loops around what the triangles hide from the origin: made of the edges that only one triangle has.

    Of a body count the faces that look at the origin; other faces are turned to it. Seen edge-on, a face hides nothing.
    The faces of a room stay apart, for the rim of them all would be the horizon, which has opposite corners.
    """
    points, faces = mesh
    seen = []
    for i, j, k in faces:
        side = dot(points[i], cross(points[j], points[k]))
        if side < 0 or (side > 0 and kind != "body"):
            seen.append((i, j, k) if side < 0 else (i, k, j))
    if kind == "room":
        return [[points[i] for i in face] for face in seen]
    edges = {edge for face in seen for edge in zip(face, face[1:] + face[:1])}
    follows = {a: b for a, b in edges if (b, a) not in edges}
    loops = []
    while follows:
        at = next(iter(follows))
        loop = []
        while at in follows:
            loop.append(points[at])
            at = follows.pop(at)
        loops.append(loop)
    return loops
