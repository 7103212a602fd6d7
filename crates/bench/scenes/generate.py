#!/usr/bin/env python3
"""Writes the large scenes of the benchmarks: python3 generate.py DIR [--only NAME].

room       a closed room with 200 boxes and columns on its floor, 2,412 triangles (12 + 200 x 12)
colonnade  two rows of fluted columns with capitals under beams, 100,000+ triangles, open to the sky between them
terrain    a fractal height field, 1,000,000 triangles, with planar texture coordinates
displaced  a sphere of 300,000+ triangles, displaced, over a plane

All are deterministic, wind outward, have no triangle without area, and need nothing but Python's own library.
"""

import math
import sys
from pathlib import Path


class Random:
    """SplitMix64, so that every Python gives the same scene."""

    def __init__(self, seed):
        self.state = seed

    def unit(self):
        mask = (1 << 64) - 1
        self.state = (self.state + 0x9E3779B97F4A7C15) & mask
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        return ((z ^ (z >> 31)) >> 11) / (1 << 53)

    def between(self, low, high):
        return low + (high - low) * self.unit()


class Mesh:
    """Groups of positions, optional texture coordinates and faces, written as they come."""

    def __init__(self, path, title):
        self.out = open(path, "w", encoding="ascii")
        self.out.write(f"# {title}\n")
        self.count = 0
        self.triangles = 0

    def group(self, name, positions, faces, uvs=None):
        write = self.out.write
        write(f"o {name}\n")
        for x, y, z in positions:
            write(f"v {x:.7g} {y:.7g} {z:.7g}\n")
        for u, v in uvs or ():
            write(f"vt {u:.8g} {v:.8g}\n")
        base = self.count + 1
        for a, b, c in faces:
            if uvs:
                write(f"f {a + base}/{a + base} {b + base}/{b + base} {c + base}/{c + base}\n")
            else:
                write(f"f {a + base} {b + base} {c + base}\n")
        self.count += len(positions)
        self.triangles += len(faces)

    def close(self):
        self.out.close()


def box(low, high, inward=False):
    corners = [
        (
            (low, high)[i & 1][0],
            (low, high)[i >> 1 & 1][1],
            (low, high)[i >> 2 & 1][2],
        )
        for i in range(8)
    ]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    faces = []
    for a, b, c, d in quads:
        faces += [(a, b, c), (a, c, d)]
    if inward:
        faces = [(a, c, b) for a, b, c in faces]
    return corners, faces


def turned(positions, centre, angle):
    s, c = math.sin(angle), math.cos(angle)
    cx, cz = centre
    return [(cx + c * (x - cx) + s * (z - cz), y, cz - s * (x - cx) + c * (z - cz)) for x, y, z in positions]


def room(path):
    mesh = Mesh(path, "closed room with 200 boxes; the exact ambient light is 0 everywhere without a distance limit")
    random = Random(1)
    mesh.group("room", *box((0, 0, 0), (10, 3, 8), inward=True))
    for k in range(200):
        x, z = random.between(0.4, 9.6), random.between(0.4, 7.6)
        w, d = random.between(0.05, 0.3), random.between(0.05, 0.3)
        h = random.between(0.1, 1.2) if k % 8 else 2.9
        positions, faces = box((x - w, 0.001, z - d), (x + w, 0.001 + h, z + d))
        mesh.group(f"box{k}", turned(positions, (x, z), random.between(0, math.pi)), faces)
    return mesh


def revolved(profile, around, radius_of):
    """A closed body of revolution about y: profile of (y, radius), bottom to top; fluted by radius_of(angle, radius)."""
    positions, faces = [], []
    for y, radius in profile:
        for k in range(around):
            angle = 2 * math.pi * k / around
            r = radius_of(angle, radius)
            positions.append((r * math.cos(angle), y, r * math.sin(angle)))
    for ring in range(len(profile) - 1):
        for k in range(around):
            a, b = ring * around + k, ring * around + (k + 1) % around
            c, d = a + around, b + around
            faces += [(a, c, b), (b, c, d)]
    bottom, top = len(positions), len(positions) + 1
    positions += [(0, profile[0][0], 0), (0, profile[-1][0], 0)]
    last = (len(profile) - 1) * around
    for k in range(around):
        faces += [(bottom, k, (k + 1) % around), (top, last + (k + 1) % around, last + k)]
    return positions, faces


def colonnade(path):
    mesh = Mesh(path, "two rows of fluted columns with capitals under beams, walls behind them, open to the sky")
    mesh.group("floor", *box((-12, -0.2, -5), (12, 0, 5)))
    around, flutes = 96, 16
    profile = [(0.001, 0.52), (0.18, 0.52), (0.2, 0.44)]
    profile += [(0.2 + 3.2 * k / 24, 0.42 - 0.07 * (k / 24) ** 2) for k in range(1, 25)]
    profile += [(3.5, 0.40), (3.56, 0.46), (3.62, 0.46), (3.7, 0.55), (3.95, 0.58)]

    def fluted(angle, radius):
        return radius * (1 - 0.06 * abs(math.sin(flutes * angle / 2))) if radius < 0.43 else radius

    for side in (-1, 1):
        for k in range(12):
            x, z = -11 + 2 * k, 2.6 * side
            positions, faces = revolved(profile, around, fluted)
            mesh.group(f"column{side}{k}", [(px + x, py, pz + z) for px, py, pz in positions], faces)
            mesh.group(f"abacus{side}{k}", *box((x - 0.62, 3.951, z - 0.62), (x + 0.62, 4.1, z + 0.62)))
        z = 2.6 * side
        mesh.group(f"beam{side}", *box((-12, 4.101, z - 0.5), (12, 4.9, z + 0.5)))
        low, high = sorted((4.6 * side, 4.9 * side))
        mesh.group(f"wall{side}", *box((-12, 0.001, low), (12, 5.2, high)))
        low, high = sorted((2.6 * side, 4.9 * side))
        mesh.group(f"roof{side}", *box((-12, 5.201, low), (12, 5.35, high)))
    return mesh


def noise(size, seed, octaves, falloff):
    """Value noise with smooth interpolation over a (size + 1)^2 grid, in rows."""
    rows = [[0.0] * (size + 1) for _ in range(size + 1)]
    amplitude, cells = 1.0, 4
    for octave in range(octaves):
        random = Random(seed + octave)
        lattice = [[random.between(-1, 1) for _ in range(cells + 1)] for _ in range(cells + 1)]
        at = []
        for i in range(size + 1):
            t = i / size * cells
            k = min(int(t), cells - 1)
            f = t - k
            at.append((k, f * f * (3 - 2 * f)))
        for y in range(size + 1):
            ky, fy = at[y]
            low, high, row = lattice[ky], lattice[ky + 1], rows[y]
            blend = [low[i] + (high[i] - low[i]) * fy for i in range(cells + 1)]
            for x in range(size + 1):
                kx, fx = at[x]
                row[x] += amplitude * (blend[kx] + (blend[kx + 1] - blend[kx]) * fx)
        amplitude *= falloff
        cells *= 2
    return rows


def terrain(path, edge=708):
    mesh = Mesh(path, "fractal height field with planar texture coordinates")
    height = noise(edge, 7, 8, 0.48)
    scale = 10.0 / edge
    positions = [(x * scale, 0.9 * height[z][x], z * scale) for z in range(edge + 1) for x in range(edge + 1)]
    margin = 0.004
    texture = [
        (margin + (1 - 2 * margin) * x / edge, margin + (1 - 2 * margin) * z / edge)
        for z in range(edge + 1)
        for x in range(edge + 1)
    ]
    faces = []
    for z in range(edge):
        for x in range(edge):
            a = z * (edge + 1) + x
            b, c, d = a + 1, a + edge + 1, a + edge + 2
            faces += [(a, c, b), (b, c, d)]
    mesh.group("terrain", positions, faces, texture)
    return mesh


def displaced(path, edge=160):
    mesh = Mesh(path, "displaced sphere of 307,200 triangles over a plane; cube-face texture charts")
    plane = [(-4, -1.3, -4), (4, -1.3, -4), (4, -1.3, 4), (-4, -1.3, 4)]
    cell, inner = 1 / 3, 0.01

    def chart(column, row, u, v):
        return ((column + inner + (1 - 2 * inner) * u) * cell, (row + inner + (1 - 2 * inner) * v) * cell)

    mesh.group("plane", plane, [(0, 2, 1), (0, 3, 2)], [chart(0, 2, u, v) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))])

    def swell(x, y, z):
        return 1 + 0.05 * math.sin(9 * x) * math.sin(11 * y + 1) * math.sin(10 * z + 2) + 0.015 * math.sin(31 * x + 5 * y) * math.sin(
            29 * y + 4 * z
        ) * math.sin(33 * z + 6 * x)

    axes = [(0, 1, 2), (0, 2, 1), (1, 2, 0)]
    for face in range(6):
        a, b, c = axes[face // 2]
        sign = 1 if face % 2 == 0 else -1
        positions, texture, faces = [], [], []
        for j in range(edge + 1):
            for i in range(edge + 1):
                p = [0.0, 0.0, 0.0]
                p[a] = math.tan((2 * i / edge - 1) * math.pi / 4)
                p[b] = math.tan((2 * j / edge - 1) * math.pi / 4)
                p[c] = float(sign)
                length = math.sqrt(sum(x * x for x in p))
                p = [x / length for x in p]
                r = swell(*p)
                positions.append(tuple(x * r for x in p))
                texture.append(chart(face % 3, face // 3, i / edge, j / edge))
        e = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
        e[0][a], e[1][b], e[2][c] = 1, 1, sign
        turn = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0])
        turn += e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])
        for j in range(edge):
            for i in range(edge):
                k = j * (edge + 1) + i
                quad = [(k, k + 1, k + edge + 2), (k, k + edge + 2, k + edge + 1)]
                faces += quad if turn > 0 else [(x, z, y) for x, y, z in quad]
        mesh.group(f"face{face}", positions, faces, texture)
    return mesh


SCENES = {"room": room, "colonnade": colonnade, "terrain": terrain, "displaced": displaced}


def main():
    arguments = sys.argv[1:]
    wanted = list(SCENES)
    if len(arguments) == 3 and arguments[1] == "--only" and arguments[2] in SCENES:
        wanted = [arguments[2]]
    elif len(arguments) != 1 or arguments[0].startswith("-"):
        sys.exit(__doc__)
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name in wanted:
        mesh = SCENES[name](folder / f"{name}.obj")
        mesh.close()
        print(f"{name}: {mesh.triangles} triangles")


if __name__ == "__main__":
    main()
