#!/usr/bin/env python3
"""Writes the tables of exact values in this folder. Run it by hand; it needs mpmath 1.3 and two minutes:

    python3 tests/tables/generate.py [DIR [LEVELS]]

Nothing here is taken from ambake. Values come from quadrature at 40 digits in `exact.py`, or from the formula that
stands in the row, and are printed with 20 digits (`meshes.csv` with 18). LEVELS is how often the faces of the
icosahedron of `meshes/sphere.obj` are split: 2 for the 320 triangles that are committed, 3 for 1,280.

* `open_specular.csv`: the specular term of an open point, and the same lobe with N.L, by exponent and angle of view.
* `scenes.csv`: visibility and diffuse term under simple shapes. Where the text says no other, the point is the origin
  and the normal +z.
* `lobes.csv`: the specular term under those of them that are made of planes. The lobe's axis is given by its zenith
  and azimuth about the normal, the azimuth from +x to +y; in the slits, whose normal is +x, from +z to -y.
* `hard_cases.csv`: cases that break bakers. AO_uniform is the visibility, AO_cos the diffuse term.
* `meshes.csv`: all three terms under the triangles of `meshes/`, each scaled, then moved. They are exact for the
  triangles, not for the round bodies that these stand for.
"""

import os
import sys

sys.dont_write_bytecode = True
import exact
import meshes
from exact import UP, mp, mpf

COMMAND = "python3 tests/tables/generate.py"
VIEWS = [(0, 0)] + [(zenith, azimuth) for zenith in (30, 60, 80) for azimuth in (0, 90, 180)]
EXPONENTS = ["1", "2.5", "5", "10", "50", "200", "1000"]
MESH_LOBES = [(n, view) for n in (5, 50) for view in [(0, 0), (30, 0), (60, 90)]]
X, Y, Z = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
DOWN = (0, 0, -1)


def digits(value, count=20):
    """A number as text, to 30 decimals at most: differences of quadratures have no more."""
    return mp.nstr(mp.nint(value * mpf(10) ** 30) / mpf(10) ** 30, count)


def short(*values):
    """Numbers of a text."""
    return " ".join(f"{float(v):.14g}" for v in values)


def write(folder, name, header, rows):
    text = "\n".join([f"# Written by {COMMAND}, where every column is explained.", header, *rows]) + "\n"
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        file.write(text)
    print(f"{name}: {len(rows)} rows, {len(text)} bytes", flush=True)


# ---------------------------------------------------------------------------------------------------
# Open points


def open_specular():
    for n in (1, 2, 5, 10, 20, 50, 100, 200):
        for degrees in range(0, 91, 10):
            theta = mp.radians(degrees)
            yield f"{n},{degrees},{digits(exact.specular(n, theta))},{digits(exact.specular_cosine(n, theta))}"


# ---------------------------------------------------------------------------------------------------
# Scenes of planes: polygons that do not overlap as seen from the origin. A corner may be a direction, infinitely far.


def upright(x, y, z):
    return [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])]


def sideways(y, x, z):
    return [(x[0], y, z[0]), (x[1], y, z[0]), (x[1], y, z[1]), (x[0], y, z[1])]


def flat(x, y, z):
    return [(x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)]


def endless(low, high):
    """A strip between two directions, endless along the y axis; in two parts, so that no two corners are opposite."""
    return [[low, high, Y], [low, high, (0, -1, 0)]]


def planar_scenes():
    """Name, text, polygons, normal."""
    yield "plane", "nothing above the plane", [], UP
    for h in ("0.25", "1", "4"):
        yield f"wall_h{h}", f"endless wall x = 1; height {h}", endless(X, (1, 0, mpf(h))), UP
    yield "wall_hinf", "endless wall x = 1; without end upward", endless(X, Z), UP
    for name, (low, high, height) in zip(meshes.WALL_NAMES, meshes.WALLS.values()):
        text = f"wall x = 1; y from {low} to {high}; height {short(height)}"
        yield name, text, [upright(1, (low, high), (0, height))], UP
    # Open is the octant -x, -y, +z.
    octants = [[X, Y, Z], [(0, -1, 0), X, Z], [Y, (-1, 0, 0), Z]]
    yield "corner3_inf", "corner of three endless planes; any point of one", octants, UP
    walls = [upright(1, (-4, 2), (0, 1)), sideways(2, (-4, 1), (0, 1))]
    yield "corner_fin", "walls x = 1 (y from -4 to 2) and y = 2 (x from -4 to 1); height 1", walls, UP
    for name, (a, b, c, d, z) in meshes.RECTANGLES.items():
        text = f"rectangle x from {short(a)} to {short(b)}; y from {short(c)} to {short(d)}; z = {short(z)}"
        yield f"rect_{name}", text, [flat((a, b), (c, d), z)], UP
    side = (-1, 1)
    sides = [upright(s, side, (0, 1)) for s in side] + [sideways(s, side, (0, 1)) for s in side]
    yield "closed_box", "inside of a closed box", [*sides, flat(side, side, 1)], UP
    for depth, x in [("1", "0.5"), ("1", "0.1"), ("5", "0.5"), ("0.2", "0.5"), ("100", "0.5")]:
        d, near = mpf(depth), mpf(x)
        strips = endless((-1, 0, 0), (-near, 0, d)) + endless(X, (1 - near, 0, d))
        text = f"endless trench 1 wide; depth {depth}; floor point at {x} from a wall"
        yield f"trench_w1_h{depth}_x{x}", text, strips, UP
    for depth in ("0.5", "2", "50"):
        # All but the sky over the far rim, from straight down; two parts, for straight down to the rim is over 90 degrees.
        strips = endless(DOWN, X) + endless(X, (1, 0, mpf(depth)))
        text = f"endless slit 1 wide; point of the wall x = 0 with normal +x; {depth} below the rims"
        yield f"canyonwall_w1_t{depth}", text, strips, X
    for name, corners in meshes.TRIANGLES.items():
        text = "triangle " + " ".join(f"({short(*p)})" for p in corners)
        yield f"tri_{name}", text, [corners], UP
    # Its front hides the rest.
    text = "box on the floor; x from 1 to 2; y from -0.5 to 0.5; height 1.5"
    yield "box", text, [upright(1, (-0.5, 0.5), (0, 1.5))], UP


def round_scenes():
    """Name, text, visibility, diffuse term."""
    for offset in ("0", "0.5", "0.9", "1", "2"):
        blocked = exact.disc((mpf(offset), 0, 1), X, Y)
        text = f"disc of radius 1 in z = 1; its centre {offset} off the axis"
        yield f"disc_a{offset}", text, *(1 - b for b in blocked)
    leaning = (mp.sqrt(0.5), 0, -mp.sqrt(0.5))
    blocked = exact.disc((mpf("0.5"), 0, 1), leaning, Y)
    yield "disc_tilt", "disc of radius 1 around (0.5 0 1); its normal (1 0 1)", *(1 - b for b in blocked)
    for name, (x, z, r) in meshes.SPHERES.items():
        blocked = exact.ball(mpf(x), mpf(z), mpf(r))
        yield f"sphere_{name}", f"sphere of radius {r} around ({x} 0 {z})", *(1 - b for b in blocked)
    for rho in meshes.RHOS:
        blocked = exact.ball(mpf(rho), mpf(1), mpf(1))
        yield f"restsphere_r{rho}", f"unit sphere on the floor; {rho} from where it touches", *(1 - b for b in blocked)
    for degrees in (0, 30, 60, 80, 89):
        text = f"inside of a hemispherical bowl; {degrees} degrees from its bottom; normal to the centre"
        yield f"bowl_psi{degrees}", text, exact.bowl(mp.radians(degrees)), mpf("0.5")


def scenes():
    for name, text, polygons, normal in planar_scenes():
        values = [1 - exact.blocked(polygons, normal, normal, n) for n in (0, 1)]
        yield f"{name},{digits(values[0])},{digits(values[1])},{text}"
    for name, text, *values in round_scenes():
        yield f"{name},{digits(values[0])},{digits(values[1])},{text}"


def lobes():
    """Every scene from every view; exponents take turns, so that each stands with each view."""
    for k, (name, _, polygons, normal) in enumerate(planar_scenes()):
        tangent = Z if normal == X else X
        for j, (zenith, azimuth) in enumerate(VIEWS):
            n = EXPONENTS[(j + k) % len(EXPONENTS)]
            axis = exact.direction(normal, tangent, zenith, azimuth)
            value = exact.specular(mpf(n), mp.radians(zenith)) - exact.blocked(polygons, normal, axis, mpf(n))
            yield f"{name},{zenith},{azimuth},{n},{digits(value)}"


def mesh_rows(levels):
    for name, file, scale, shift, kind in meshes.placements():
        triangles = meshes.placed(meshes.text(file, levels), scale, shift)
        loops = meshes.rims(triangles, kind)
        values = [1 - exact.blocked(loops, UP, UP, n) for n in (0, 1)]
        for n, (zenith, azimuth) in MESH_LOBES:
            axis = exact.direction(UP, X, zenith, azimuth)
            values.append(exact.specular(n, mp.radians(zenith)) - exact.blocked(loops, UP, axis, n))
        place = ",".join(repr(v) for v in (scale, *shift))
        yield f"{name},{file},{place}," + ",".join(digits(v, 18) for v in values)


# ---------------------------------------------------------------------------------------------------
# Hard cases


def wall(d, h):
    """Both terms at the distance d from an endless wall of height h."""
    visibility, diffuse = 1 - mp.atan(h / d) / mp.pi, (1 + d / mp.hypot(d, h)) / 2
    return ("AO_uniform", visibility, "1-atan(h/d)/pi"), ("AO_cos", diffuse, "(1+d/sqrt(d^2+h^2))/2")


def hole(r, h):
    """Only a round hole right above is open."""
    cosine = h / mp.hypot(r, h)
    return ("AO_uniform", 1 - cosine, "1-h/sqrt(h^2+r^2)"), ("AO_cos", 1 - cosine**2, "r^2/(h^2+r^2)")


def polygon(corners, complement):
    """Both terms under one polygon, or what it takes away of them."""
    blocked = [exact.blocked([corners], UP, UP, n) for n in (0, 1)]
    if complement:
        return [(name, b, "") for name, b in zip(("1-AO_uniform", "1-AO_cos"), blocked)]
    return [(name, 1 - b, "") for name, b in zip(("AO_uniform", "AO_cos"), blocked)]


def hard_cases():
    def rows(case, entries):
        for quantity, value, formula in entries:
            # The smallest, 1.6e-68, is no difference.
            text = mp.nstr(value, 20) if value > mpf("1e-69") else "0.0"
            yield f'"{case}","{quantity}",{text},"{formula}"'

    for d, h in [("1e-6", "1"), ("1e-3", "1"), ("1", "1e-6"), ("1", "1e6")]:
        yield from rows(f"infinite wall d={d} h={h}", wall(mpf(d), mpf(h)))
    for opening in ("1e-3", "0.1"):
        b = mpf(opening)
        terms = ("AO_uniform", b / mp.pi, "beta/pi"), ("AO_cos", mp.sin(b / 2) ** 2, "sin^2(beta/2)")
        yield from rows(f"V-groove, opening {opening} rad, infinite faces", terms)
    for z in ("1e-2", "1e-6"):
        yield from rows(f"plate [-1,1]^2 at height {z} over the point", polygon(flat((-1, 1), (-1, 1), mpf(z)), False))
    for width in ("1e-6", "1e-3"):
        strip = flat((-1000, 1000), (1, 1 + mpf(width)), 1)
        yield from rows(f"strip 2000 x {width} at (y=1,z=1)", polygon(strip, True))
    tiny = mpf(2) ** -13
    triangle = [(1, 1, 1), (1 + tiny, 1, 1), (1, 1 + tiny, 1)]
    yield from rows("tiny triangle legs 2^-13 at (1,1,1)", polygon(triangle, True))
    for r in ("1e-1", "1e-3"):
        yield from rows(f"closed box with round hole radius {r} overhead at height 1", hole(mpf(r), mpf(1)))
    yield from rows("cylinder well depth 1000 radius 1, centre", hole(mpf(1), mpf(1000)))
    for rho in ("1e-3", "1e-2"):
        s = 1 + mpf(rho) ** 2
        visibility, diffuse = mpf(rho) / mp.sqrt(s), 1 - s ** mpf("-1.5")
        terms = ("AO_uniform", visibility, "rho/sqrt(1+rho^2)"), ("AO_cos", diffuse, "1-(1+rho^2)^-1.5")
        yield from rows(f"unit sphere resting, rho={rho}", terms)
    for a, b in [("0", "0.01"), ("0", "0.1"), ("1", "1.1")]:
        width = mpf(b) - mpf(a)
        means = [mp.quad(lambda d: wall(d, mpf(1))[k][1], [mpf(a), mpf(b)]) / width for k in (0, 1)]
        terms = [(name, mean, "quadrature over d") for name, mean in zip(("AO_uniform", "AO_cos"), means)]
        yield from rows(f"infinite wall h=1, texel average d in [{a},{b}]", terms)
    for n in ("1", "100", "1e4", "1e6"):
        for degrees in ("0", "60", "89", "89.9", "89.99", "90", "90.01", "90.1", "91"):
            value = exact.specular(mpf(n), mp.radians(mpf(degrees)))
            yield from rows(f"open plane Phong n={n} theta={degrees}", [("G=(n+1)/(2pi) J_s/(i_a k_s)", value, "")])
    for n in (10, 1000, 100000):
        # The lower half of the lobe, without what lies below the floor: 135 degrees from its axis faces the other way.
        hidden = mpf("0.5") - exact.specular(n, mp.radians(135))
        case = f"wall h=d=1, lobe axis exactly on the silhouette, n={n}"
        yield from rows(case, [("occluded share of 2pi/(n+1)", hidden, "")])
    for tilt in (10, 30, 60):
        delta = mp.radians(tilt)
        visibility, diffuse = 1 - delta / mp.pi, (1 + mp.cos(delta)) / 2
        terms = ("AO_uniform (about Ns)", visibility, "1-delta/pi"), ("AO_cos (about Ns)", diffuse, "(1+cos delta)/2")
        yield from rows(f"plane, shading normal tilted {tilt} deg", terms)
        for zenith in (60, 80):
            for azimuth in (0, 180):
                shading, view = exact.direction(UP, X, tilt, 0), exact.direction(UP, X, zenith, azimuth)
                value = exact.tilted(shading, UP, view, 20)
                entry = ("norm. Phong n=20: lune(Ns,Ng,R)", value, "above both planes and within 90 degrees of R")
                yield from rows(f"  view {zenith} deg az {azimuth}, Ns tilt {tilt}", [entry])


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    levels = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    os.makedirs(os.path.join(folder, "meshes"), exist_ok=True)
    for file in meshes.FILES:
        with open(os.path.join(folder, "meshes", file), "w", encoding="ascii") as out:
            out.write(f"# Written by {COMMAND}.\n" + meshes.text(file, levels))
    write(folder, "open_specular.csv", "exponent,theta_deg,specular,specular_cosine", list(open_specular()))
    write(folder, "scenes.csv", "id,visibility,diffuse,scene", list(scenes()))
    write(folder, "hard_cases.csv", "case,quantity,expected,formula", list(hard_cases()))
    write(folder, "lobes.csv", "id,zenith_deg,azimuth_deg,exponent,specular", list(lobes()))
    header = "id,obj,scale,x,y,z,visibility,diffuse," + ",".join(f"specular_n{n}_z{z}_a{a}" for n, (z, a) in MESH_LOBES)
    write(folder, "meshes.csv", header, list(mesh_rows(levels)))


if __name__ == "__main__":
    main()
