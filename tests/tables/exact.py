"""Ambient integrals at 40 digits, each by a quadrature of its own definition.

The point is the origin. Directions are unit vectors; polygons are lists of corners, a corner may be a direction. What a
shape takes away of a term is returned as its share of the open hemisphere's: solid angle over 2 pi, cosine over pi.
"""

from mpmath import mp, mpf

mp.dps = 40
UP = (0, 0, 1)
TOLERANCE = mpf("1e-33")


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def scale(a, s):
    return tuple(x * s for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return mp.sqrt(dot(a, a))


def unit(a):
    return scale(a, 1 / length(a))


def direction(normal, tangent, zenith, azimuth):
    """The direction at so many degrees from the normal, its azimuth from the tangent toward normal x tangent."""
    z, a = mp.radians(zenith), mp.radians(azimuth)
    side = add(scale(tangent, mp.cos(a)), scale(cross(normal, tangent), mp.sin(a)))
    return add(scale(normal, mp.cos(z)), scale(side, mp.sin(z)))


def integral(f, points, method="tanh-sinh"):
    """∫ f over consecutive points, held to TOLERANCE."""
    value, error = mp.quad(f, points, error=True, method=method)
    assert error <= TOLERANCE, (value, error, points)
    return value


def cuts(low, high, *middles):
    """low, high and, between them, steps of powers of a hundred away from each of `middles` and from both ends."""
    steps = [s * mpf(10) ** -k for k in (0, 2, 4) for s in (-1, 1)] + [mpf(0)]
    inner = {m + s for m in (low, high, *middles) for s in steps}
    return [low, *sorted(p for p in inner if low < p < high), high]


# ---------------------------------------------------------------------------------------------------
# The lobe of an open point


def power(n, theta, cosine):
    """∫ cos^n a cos(a - theta)^cosine over the azimuths a from the lobe's axis that the normal and the axis both face."""
    n, low = mpf(n), theta - mp.pi / 2
    # Scaled to 1 at its peak, for it may be as small as 1e-68 all over.
    peak = mp.cos(max(low, mpf(0)))

    def f(a):
        c = mp.cos(a)
        return (mp.exp(n * mp.log(c / peak)) if c > 0 else mpf(0)) * (mp.cos(a - theta) if cosine else 1)

    return peak**n * integral(f, cuts(low, mp.pi / 2, mpf(0)))


def latitudes(n):
    """∫ cos^n over -pi/2..pi/2."""
    return mp.sqrt(mp.pi) * mp.gamma((n + 1) / mpf(2)) / mp.gamma(n / mpf(2) + 1)


def specular(n, theta):
    """((n+1)/2 pi) ∫ (R.w)^n over the directions that face the normal and the lobe's axis R, theta apart.

    In latitude b from the plane of both and azimuth a: R.w = cos a cos b, dw = cos b da db. The quadrature is held to
    the regularised incomplete beta function, of which it is a tail.
    """
    value = (n + 1) / (2 * mp.pi) * latitudes(n + 1) * power(n, theta, False)
    tail = mp.betainc((n + 1) / mpf(2), mpf("0.5"), 0, mp.sin(theta) ** 2, regularized=True) / 2
    if theta <= mp.pi / 2:
        tail = 1 - tail
    assert abs(value - tail) <= mpf("1e-24") * tail, (n, theta, value, tail)
    return value


def specular_cosine(n, theta):
    """((n+2)/2 pi) ∫ (R.w)^n N.w over the same directions; N.w = cos(a - theta) cos b."""
    return (n + 2) / (2 * mp.pi) * latitudes(n + 2) * power(n, theta, True)


# ---------------------------------------------------------------------------------------------------
# Polygons, by Green's theorem around them


def cut(loop, plane):
    """The part of a loop with direction . plane >= 0."""
    kept = []
    for a, b in zip(loop, loop[1:] + loop[:1]):
        above_a, above_b = dot(a, plane), dot(b, plane)
        if above_a >= 0:
            kept.append(a)
        if (above_a >= 0) != (above_b >= 0):
            kept.append(add(a, scale(add(b, scale(a, -1)), above_a / (above_a - above_b))))
    return kept


def around(loop, axis, n):
    """∫ (axis.w)^n over the inside of a loop that faces the axis; its sign is that of the turn.

    With x = axis.w the field (1 - x^(n+1)) / ((n+1) (1 - x^2)) axis x w has the integrand as its curl on the sphere.
    """
    total = mpf(0)
    for a, b in zip(loop, loop[1:] + loop[:1]):
        turn = cross(a, b)
        size = length(turn)
        if size <= mpf("1e-36") * length(a) * length(b):
            assert dot(a, b) > 0, "no arc between opposite directions"
            continue
        pole, start = scale(turn, 1 / size), unit(a)
        side, angle = dot(axis, pole), mp.atan2(size, dot(a, b))
        if abs(side) > mpf("1e-36"):
            total += side * arc(dot(axis, start), dot(axis, cross(pole, start)), angle, n)
    return total / (n + 1)


def arc(a, b, angle, n):
    """∫ (1 - x^(n+1)) / (1 - x^2) over t in 0..angle, x = a cos t + b sin t >= 0."""
    if n == 1:
        return angle
    whole = n == int(n)
    exponent = int(n) + 1 if whole else n + 1

    def f(t):
        x = max(a * mp.cos(t) + b * mp.sin(t), mpf(0))
        rest = 1 - x
        if rest < mpf("1e-25"):
            return (n + 1) / mpf(2)
        return (1 - x**exponent) / (rest * (1 + x))

    # The power stands out at its peak, by the width of the lobe.
    peak, width = mp.atan2(b, a), 1 / mp.sqrt(n + 1)
    marks = {peak + s * width * k for s in (-1, 1) for k in (0, 1, 3, 9, 27)} | {angle / 2}
    points = [mpf(0), *sorted(p for p in marks if 0 < p < angle), angle]
    # Only a whole power is smooth where the arc ends on the plane x = 0.
    return integral(f, points, "gauss-legendre" if whole else "tanh-sinh")


def blocked(polygons, normal, axis, n):
    """What polygons that do not overlap take of the term with the lobe (axis.w)^n, cut to the normal's hemisphere and
    the lobe's. With the normal as axis: n = 0 visibility, n = 1 diffuse."""
    total = mpf(0)
    for corners in polygons:
        loop = cut([tuple(mpf(x) for x in p) for p in corners], normal)
        total += abs(around(cut(loop, axis), axis, n))
    return (n + 1) / (2 * mp.pi) * total


def tilted(shading, geometric, view, n):
    """The specular term of an open plane with a shading normal of its own: above both planes and in the lobe."""
    mirror = add(scale(shading, 2 * dot(shading, view)), scale(view, -1))
    ring = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    total = mpf(0)
    for a, b in zip(ring, ring[1:] + ring[:1]):
        loop = [tuple(mpf(x) for x in p) for p in (geometric, a, b)]
        total += around(cut(cut(loop, shading), mirror), mirror, n)
    return (n + 1) / (2 * mp.pi) * total


# ---------------------------------------------------------------------------------------------------
# Round shapes


def disc(centre, u, v):
    """Both shares of a disc centre + r (u cos s + v sin s), r in 0..1, wholly above the horizon: over its area."""
    normal = cross(u, v)

    def inner(r, term):
        def f(s):
            p = add(centre, scale(add(scale(u, mp.cos(s)), scale(v, mp.sin(s))), r))
            square = dot(p, p)
            return r * dot(normal, p) / square * (1 / (2 * mp.sqrt(square)) if term == 0 else p[2] / square)

        # A periodic integrand: the midpoint rule leaves some e^-0.9 of its error with each point, about 1e-50 here.
        count = 128
        return sum(f(2 * mp.pi * (k + mpf("0.5")) / count) for k in range(count)) * 2 * mp.pi / count / mp.pi

    return [abs(integral(lambda r, t=term: inner(r, t), [mpf(0), mpf(1)], "gauss-legendre")) for term in (0, 1)]


def ball(x, z, radius):
    """Both shares of a sphere around (x, 0, z), cut by the horizon where it reaches it: over the zenith angle."""
    half = mp.asin(radius / mp.hypot(x, z))
    middle = mp.atan2(x, z)
    low, high = abs(middle - half), min(middle + half, mp.pi / 2)
    whole = max(half - middle, mpf(0))

    def width(angle):
        c = (mp.cos(half) - mp.cos(angle) * mp.cos(middle)) / (mp.sin(angle) * mp.sin(middle))
        return 2 * mp.acos(min(max(c, -1), 1))

    # The cap around the zenith, where the sphere hides every azimuth.
    shares = [1 - mp.cos(whole), mp.sin(whole) ** 2]
    if middle > 0 and low < high:
        shares[0] += integral(lambda a: width(a) * mp.sin(a), cuts(low, high)) / (2 * mp.pi)
        shares[1] += integral(lambda a: width(a) * mp.sin(a) * mp.cos(a), cuts(low, high)) / mp.pi
    return shares


def bowl(angle):
    """The visibility inside a unit bowl: the rim's disc, by the azimuth about the point's foot in the rim's plane.

    The diffuse term is 1/2 everywhere: a part of a sphere is seen from all its points by its area over the sphere's.
    """
    out, height = mp.sin(angle), mp.cos(angle)

    def f(s):
        reach = -out * mp.cos(s) + mp.sqrt(1 - (out * mp.sin(s)) ** 2)
        return 1 - height / mp.hypot(height, reach)

    return integral(f, cuts(mpf(0), mp.pi, mp.pi / 2)) / mp.pi
