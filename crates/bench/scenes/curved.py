#!/usr/bin/env python3
"""Large curved meshes without texture coordinates, for `ambake layout`: python3 curved.py FOLDER writes ramp, drape, knot, cliffs and scan as OBJ."""

import math
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import generate  # noqa: E402


def sheet(path, title, across, down, at, closed=(False, False), turned=False):
    """Squares of a grid, each cut in two; `at` takes whole steps."""
    mesh = generate.Mesh(path, title)
    positions = [at(i, j) for i in range(across) for j in range(down)]
    faces = []
    for i in range(across - (not closed[0])):
        for j in range(down - (not closed[1])):
            a, b = i * down + j, (i + 1) % across * down + j
            c, d = (i + 1) % across * down + (j + 1) % down, i * down + (j + 1) % down
            faces += [(c, b, a), (d, c, a)] if turned else [(a, b, c), (a, c, d)]
    mesh.group(path.stem, positions, faces)
    mesh.close()


def ramp(path):
    """A spiral of five turns, which covers every place below it five times."""

    def at(i, j):
        angle, radius = i / 1499 * 10 * math.pi, 2 + 2 * j / 19
        return (radius * math.cos(angle), 0.4 * angle, radius * math.sin(angle))

    sheet(path, "spiral ramp of five turns", 1500, 20, at, turned=True)


def drape(path):
    """A cloth that hangs in folds."""
    rough = generate.noise(329, 9, 7, 0.5)

    def at(i, j):
        x, y = 4 * i / 329 - 2, 4 * j / 329 - 2
        return (x, y, 0.25 * math.sin(6 * x + 0.8 * math.sin(2 * y)) * (1.2 + 0.5 * y) / 1.5 + 0.1 * rough[j][i])

    sheet(path, "cloth in folds", 330, 330, at)


def knot(path):
    """A tube along a trefoil knot."""

    def middle(t):
        return ((2 + math.cos(3 * t)) * math.cos(2 * t), math.sin(3 * t), (2 + math.cos(3 * t)) * math.sin(2 * t))

    def unit(v):
        length = math.sqrt(sum(x * x for x in v))
        return [x / length for x in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def at(i, j):
        t, s = 2 * math.pi * i / 1600, 2 * math.pi * j / 60
        along = unit([b - a for a, b in zip(middle(t - 1e-4), middle(t + 1e-4))])
        side = unit(cross(along, (0, 1, 0)))
        up = cross(along, side)
        return tuple(c + 0.35 * (math.cos(s) * n + math.sin(s) * b) for c, n, b in zip(middle(t), side, up))

    sheet(path, "tube along a knot", 1600, 60, at, closed=(True, True), turned=True)


def cliffs(path):
    """A terrain of plateaus, with steps that are too steep to be seen from above."""
    height = generate.noise(559, 3, 7, 0.5)

    def at(i, j):
        h = 2 * height[i][j]
        return (40 * i / 559, 3 * h + 3 * math.tanh(8 * h), 40 * j / 559)

    sheet(path, "plateaus and cliffs", 560, 560, at, turned=True)


def scan(path, edge=259):
    """A lumpy ball whose corners are rough, as a scanner leaves them."""
    mesh = generate.Mesh(path, "rough lumpy ball")
    angle = [math.tan((2 * i / edge - 1) * math.pi / 4) for i in range(edge + 1)]
    for face in range(6):
        axis, sign = face // 2, 1 - 2 * (face % 2)
        positions, faces = [], []
        for u in angle:
            for v in angle:
                p = [0.0, 0.0, 0.0]
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = float(sign), u, v
                length = math.sqrt(sum(x * x for x in p))
                x, y, z = (round(c / length, 7) for c in p)
                rough = math.sin(12.9898 * x + 78.233 * y + 37.719 * z) * 43758.5453 % 1 - 0.5
                r = 1 + 0.25 * math.sin(3 * x + 1) * math.sin(4 * y) + 0.1 * math.sin(9 * z * x) + 0.0024 * rough
                positions.append((x * r, y * r, z * r))
        for i in range(edge):
            for j in range(edge):
                a, b = i * (edge + 1) + j, (i + 1) * (edge + 1) + j
                quad = [(a, b, b + 1), (a, b + 1, a + 1)]
                faces += quad if sign > 0 else [(z, y, x) for x, y, z in quad]
        mesh.group(f"side{face}", positions, faces)
    mesh.close()


SCENES = {"ramp": ramp, "drape": drape, "knot": knot, "cliffs": cliffs, "scan": scan}

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in SCENES.items():
        make(folder / f"{name}.obj")
