//! The unfolded octahedron. Coordinates in -1..1, y up, +z in the middle.

use super::Direction;

/// The point of the octahedron at a place: |x| + |y| + |z| = 1.
fn point(x: f64, y: f64) -> Direction {
    let z = 1.0 - x.abs() - y.abs();
    if z >= 0.0 {
        return [x, y, z];
    }
    [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y), z]
}

fn length(p: Direction) -> f64 {
    p.iter().map(|v| v * v).sum::<f64>().sqrt()
}

pub(super) fn direction(x: f64, y: f64) -> Direction {
    let p = point(x, y);
    p.map(|v| v / length(p))
}

pub(super) fn place([x, y, z]: Direction) -> (f64, f64) {
    let scale = x.abs() + y.abs() + z.abs();
    let (x, y) = (x / scale, y / scale);
    if z >= 0.0 {
        (x, y)
    } else {
        ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y))
    }
}

/// dω by dx dy, up to a constant: 1 / |p|³.
pub(super) fn density(x: f64, y: f64) -> f64 {
    length(point(x, y)).powi(-3)
}

/// Two flat triangles, cut along the diagonal that the fold follows; their edges are great circles.
pub(super) fn solid_angle(side: usize, i: usize, j: usize) -> f64 {
    let edge = |k: usize| 2.0 * k as f64 / side as f64 - 1.0;
    let corner = |di: usize, dj: usize| {
        let (x, y) = (edge(i + di), -edge(j + dj));
        // On the fold z is 0 exactly; rounding must not lift it to the other side's fold.
        direction(x, y)
    };
    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
    // The fold |x| + |y| = 1 runs from the top right to the bottom left where x and the downward y have one sign.
    let right = 2 * i >= side;
    let low = 2 * j >= side;
    if right == low {
        triangle(a, b, c) + triangle(b, c, d)
    } else {
        triangle(a, b, d) + triangle(a, c, d)
    }
}

/// A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle" (1983).
fn triangle(a: Direction, b: Direction, c: Direction) -> f64 {
    let dot = |a: Direction, b: Direction| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // The volume from edge vectors: corners close to each other cancel less.
    let minus = |a: Direction, b: Direction| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let (u, v) = (minus(b, a), minus(c, a));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    2.0 * dot(a, cross)
        .abs()
        .atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
}
