#!/usr/bin/env python3
"""Writes two rooms that see little of the sky, on which nothing was tuned: python3 dark.py DIR.

library  a room with one window, beams, shelves of 297 books, a table with a globe; 4,638 triangles
tower    a spiral stair about a pillar, behind four gaps in a round wall; 1,132 triangles

They need nothing but Python's own library. Faces look into the rooms, and outward from what stands in them.
"""

import math
import random
import sys
from pathlib import Path

TURN = 2 * math.pi


class Mesh:
    """Objects of polygons, written as they come."""

    def __init__(self):
        self.lines = []
        self.vertices = 0
        self.normals = 0

    def name(self, name):
        self.lines.append(f"o {name}")

    def vertex(self, point):
        self.lines.append("v %.7g %.7g %.7g" % tuple(point))
        self.vertices += 1

    def polygon(self, points):
        first = self.vertices + 1
        for point in points:
            self.vertex(point)
        self.lines.append("f " + " ".join(str(first + i) for i in range(len(points))))

    def box(self, centre, half, angle=0.0):
        """A box turned about the vertical axis."""
        cos, sin = math.cos(angle), math.sin(angle)

        def corner(x, y, z):
            x, y, z = x * half[0], y * half[1], z * half[2]
            return centre[0] + cos * x - sin * z, centre[1] + y, centre[2] + sin * x + cos * z

        at = [[[corner(x, y, z) for z in (-1, 1)] for y in (-1, 1)] for x in (-1, 1)]
        for face in ("000 001 011 010", "100 110 111 101", "000 100 101 001", "010 011 111 110", "000 010 110 100", "001 101 111 011"):
            self.polygon([at[int(x)][int(y)][int(z)] for x, y, z in face.split()])

    def smooth(self, surface, across, down):
        """A smooth surface of (u, v) in the unit square, in quads."""
        first, first_normal, step = self.vertices + 1, self.normals + 1, 1e-4
        for i in range(across + 1):
            for j in range(down + 1):
                u, v = i / across, j / down
                self.vertex(surface(u, v))
                a = [p - q for p, q in zip(surface(u + step, v), surface(u - step, v))]
                b = [p - q for p, q in zip(surface(u, v + step), surface(u, v - step))]
                n = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
                length = math.sqrt(sum(x * x for x in n)) or 1
                self.lines.append("vn %.5g %.5g %.5g" % tuple(x / length for x in n))
                self.normals += 1
        row = down + 1
        for i in range(across):
            for j in range(down):
                quad = (i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1)
                self.lines.append("f " + " ".join(f"{first + k}//{first_normal + k}" for k in quad))


def column(x, z, radius, height):
    return lambda u, v: (x + radius * math.cos(-u * TURN), v * height, z + radius * math.sin(-u * TURN))


def tower():
    mesh = Mesh()
    mesh.name("wall")
    sides = 36
    on = lambda turn, y: (3 * math.cos(turn), y, 3 * math.sin(turn))
    for i in range(sides):
        a, b = TURN * i / sides, TURN * (i + 1) / sides
        for y in range(6):
            if not (i in (4, 5, 20, 21) and y in (2, 4)):
                mesh.polygon([on(a, y), on(a, y + 1), on(b, y + 1), on(b, y)])
    mesh.name("floor")
    mesh.polygon([on(-TURN * i / sides, 0) for i in range(sides)])
    mesh.name("roof")
    mesh.polygon([on(TURN * i / sides, 6) for i in range(sides)])
    mesh.name("pillar")
    mesh.smooth(column(0, 0, 0.4, 6), 24, 6)
    for i in range(30):
        mesh.name(f"step{i}")
        turn = i * 0.35
        mesh.box((1.6 * math.cos(turn), 0.1 + i * 0.18, 1.6 * math.sin(turn)), (1.3, 0.06, 0.3), turn)
    return mesh


def library():
    chance = random.Random(7)
    mesh = Mesh()
    mesh.name("room")
    wide, high, deep = 4, 2.8, 5
    for wall in ("000 001 101 100", "010 110 111 011", "000 010 011 001", "001 011 111 101", "100 101 111 110"):
        mesh.polygon([(int(x) * wide, int(y) * high, int(z) * deep) for x, y, z in wall.split()])
    # About the window.
    for x0, x1, y0, y1 in ((0, 1.2, 0, high), (2.8, wide, 0, high), (1.2, 2.8, 0, 0.9), (1.2, 2.8, 2.2, high)):
        mesh.polygon([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)])
    for beam in range(5):
        mesh.name(f"beam{beam}")
        mesh.box((2, 2.7, 0.5 + beam), (2, 0.1, 0.08))
    books = 0
    for side in (0.16, 3.84):
        for shelf in range(5):
            mesh.name(f"shelf{side}{shelf}")
            mesh.box((side, 0.3 + 0.45 * shelf, 2.8), (0.15, 0.015, 2.0))
            z = 0.85
            while z < 4.7:
                thick, tall = chance.uniform(0.02, 0.06), chance.uniform(0.22, 0.36) / 2
                if chance.random() < 0.8:
                    mesh.name(f"book{books}")
                    books += 1
                    half = (chance.uniform(0.08, 0.13), tall, thick * 0.95)
                    mesh.box((side, 0.315 + 0.45 * shelf + tall, z + thick), half, chance.uniform(-0.05, 0.05))
                z += 2 * thick + chance.uniform(0, 0.05)
    mesh.name("table")
    mesh.box((2, 0.75, 2.6), (0.7, 0.03, 0.45), 0.3)
    cos, sin = math.cos(0.3), math.sin(0.3)
    for i, (x, z) in enumerate(((-0.6, -0.35), (0.6, -0.35), (-0.6, 0.35), (0.6, 0.35))):
        mesh.name(f"leg{i}")
        mesh.smooth(column(2 + cos * x - sin * z, 2.6 + sin * x + cos * z, 0.04, 0.72), 12, 3)
    mesh.name("globe")

    def globe(u, v):
        from_pole, turn = math.pi * (v * 0.998 + 0.001), -u * TURN
        r = 0.15 * math.sin(from_pole)
        return 2.2 + r * math.cos(turn), 0.93 - 0.15 * math.cos(from_pole), 2.6 + r * math.sin(turn)

    mesh.smooth(globe, 24, 12)
    return mesh


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for scene in (library, tower):
        (folder / f"{scene.__name__}.obj").write_text("\n".join(scene().lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
