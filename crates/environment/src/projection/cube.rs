//! The six faces of a cube in their arrangements.

use super::{Direction, Projection};

/// Face, and its two axes: where the picture goes right and down. OpenGL's convention.
const FACES: [[Direction; 3]; 6] = [
    [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]],
    [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
    [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
    [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
];

/// Column and row of each face in an arrangement, and whether the last face is turned by 180 degrees.
fn cells(projection: Projection, (width, height): (usize, usize)) -> ([(usize, usize); 6], bool) {
    match projection {
        Projection::Cross if width > height => {
            ([(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)], false)
        }
        Projection::Cross => ([(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (1, 3)], true),
        _ if width > height => (std::array::from_fn(|f| (f, 0)), false),
        _ => (std::array::from_fn(|f| (0, f)), false),
    }
}

/// Side of a face, in texels.
pub(super) fn side(projection: Projection, (width, height): (usize, usize)) -> usize {
    match projection {
        Projection::Cross => width.max(height) / 4,
        _ => width.min(height),
    }
}

/// The face at a place and the place on it, each coordinate in -1..1 to the right and down.
fn face_at(
    projection: Projection,
    size: (usize, usize),
    x: f64,
    y: f64,
) -> Option<(usize, f64, f64)> {
    let n = side(projection, size) as f64;
    let (cells, turned) = cells(projection, size);
    let clamp = |v: f64, limit: usize| (v / n).floor().clamp(0.0, limit as f64 / n - 1.0) as usize;
    let cell = (clamp(x, size.0), clamp(y, size.1));
    let face = cells.iter().position(|c| *c == cell)?;
    let s = 2.0 * (x / n - cell.0 as f64) - 1.0;
    let t = 2.0 * (y / n - cell.1 as f64) - 1.0;
    Some(if turned && face == 5 {
        (face, -s, -t)
    } else {
        (face, s, t)
    })
}

/// The direction through a place on a face; beyond -1..1 on the face's plane.
pub fn on_face(face: usize, s: f64, t: f64) -> Direction {
    let [axis, right, down] = FACES[face];
    let p: Direction = std::array::from_fn(|c| axis[c] + s * right[c] + t * down[c]);
    let length = (1.0 + s * s + t * t).sqrt();
    p.map(|v| v / length)
}

/// The face that a direction meets and where.
pub fn meet(d: Direction) -> (usize, f64, f64) {
    let largest = (0..3).fold(
        0,
        |best, c| if d[c].abs() > d[best].abs() { c } else { best },
    );
    let face = 2 * largest + usize::from(d[largest] < 0.0);
    let [_, right, down] = FACES[face];
    let dot = |a: Direction| (0..3).map(|c| a[c] * d[c]).sum::<f64>() / d[largest].abs();
    (face, dot(right), dot(down))
}

/// The place of a direction on the plane of a face, in -1..1 within the face; `None` for one that points away from the
/// plane.
pub fn on_plane(face: usize, d: Direction) -> Option<[f64; 2]> {
    let along = |a: Direction| (0..3).map(|c| a[c] * d[c]).sum::<f64>();
    let [depth, right, down] = FACES[face].map(along);
    (depth > 1e-6).then(|| [right / depth, down / depth])
}

pub(super) fn direction(
    projection: Projection,
    size: (usize, usize),
    x: f64,
    y: f64,
) -> Option<Direction> {
    face_at(projection, size, x, y).map(|(face, s, t)| on_face(face, s, t))
}

pub(super) fn place(projection: Projection, size: (usize, usize), d: Direction) -> (f64, f64) {
    let (face, s, t) = meet(d);
    let n = side(projection, size) as f64;
    let (cells, turned) = cells(projection, size);
    let (s, t) = if turned && face == 5 {
        (-s, -t)
    } else {
        (s, t)
    };
    let (column, row) = cells[face];
    (
        (column as f64 + 0.5 * (s + 1.0)) * n,
        (row as f64 + 0.5 * (t + 1.0)) * n,
    )
}

/// Texels of a face as indices into the picture: the four neighbours of a place with their bilinear weights. Beyond the
/// face's edge stands the nearest texel of the next face.
pub(crate) fn taps(
    projection: Projection,
    size: (usize, usize),
    d: Direction,
) -> [(usize, f64); 4] {
    let n = side(projection, size) as f64;
    let (face, s, t) = meet(d);
    let (x, y) = (0.5 * (s + 1.0) * n - 0.5, 0.5 * (t + 1.0) * n - 0.5);
    let (i, j) = (x.floor(), y.floor());
    let (fx, fy) = (x - i, y - j);
    let corner = |di: f64, dj: f64, weight: f64| {
        let centre = |k: f64| 2.0 * (k + 0.5) / n - 1.0;
        let place = place(
            projection,
            size,
            on_face(face, centre(i + di), centre(j + dj)),
        );
        (texel(size, place), weight)
    };
    [
        corner(0.0, 0.0, (1.0 - fx) * (1.0 - fy)),
        corner(1.0, 0.0, fx * (1.0 - fy)),
        corner(0.0, 1.0, (1.0 - fx) * fy),
        corner(1.0, 1.0, fx * fy),
    ]
}

/// The texel a step away from one, beyond the face's edge that of the next face. `None` beside the faces.
pub(super) fn neighbour(
    projection: Projection,
    size: (usize, usize),
    (i, j): (usize, usize),
    (di, dj): (isize, isize),
) -> Option<usize> {
    let (face, s, t) = face_at(projection, size, i as f64 + 0.5, j as f64 + 0.5)?;
    let step = 2.0 / side(projection, size) as f64;
    let there = on_face(face, s + di as f64 * step, t + dj as f64 * step);
    Some(texel(size, place(projection, size, there)))
}

/// Index of the texel at a place.
fn texel(size: (usize, usize), (x, y): (f64, f64)) -> usize {
    (y as usize).min(size.1 - 1) * size.0 + (x as usize).min(size.0 - 1)
}

/// The corner function A of the solid angle: four of them make a rectangle.
pub(super) fn solid_angle(projection: Projection, size: (usize, usize), i: usize, j: usize) -> f64 {
    let n = side(projection, size);
    let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
    if face_at(projection, size, x, y).is_none() {
        return 0.0;
    }
    let edge = |k: usize| 2.0 * (k % n) as f64 / n as f64 - 1.0;
    let (x0, y0, step) = (edge(i), edge(j), 2.0 / n as f64);
    let (x1, y1) = (x0 + step, y0 + step);
    let corner = |x: f64, y: f64| (x * y).atan2((1.0 + x * x + y * y).sqrt());
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

pub(super) fn density(projection: Projection, size: (usize, usize), x: f64, y: f64) -> f64 {
    face_at(projection, size, x, y).map_or(0.0, |(_, s, t)| (1.0 + s * s + t * t).powf(-1.5))
}
