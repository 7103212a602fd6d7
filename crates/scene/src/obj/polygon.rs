//! Cuts a polygon of an OBJ face into triangles.

use glam::{DVec2, DVec3, Vec3};

/// Corner count beyond which a concave polygon is fanned instead of clipped: clipping may take the cube of it.
const MOST_CLIPPED: usize = 512;

/// Appends triangles, as numbers of corners, that cover the polygon once and keep its orientation.
///
/// A convex polygon gives the fan from its first corner, a concave one is clipped ear by ear in the plane of its mean
/// (Newell) normal. There are always `corners.len() - 2` triangles; a degenerate polygon gives degenerate ones.
pub(crate) fn triangulate(corners: &[Vec3], out: &mut Vec<[usize; 3]>) {
    let n = corners.len();
    let plane = flattened(corners);
    let convex = (0..n).all(|i| turn(plane[i], plane[(i + 1) % n], plane[(i + 2) % n]) >= 0.0);
    if n <= 3 || convex || n > MOST_CLIPPED {
        out.extend((1..n - 1).map(|i| [0, i, i + 1]));
        return;
    }
    let mut left: Vec<usize> = (0..n).collect();
    while left.len() > 3 {
        let m = left.len();
        let ear = (0..m).find(|&i| is_ear(&plane, &left, i)).unwrap_or(0);
        out.push([left[(ear + m - 1) % m], left[ear], left[(ear + 1) % m]]);
        left.remove(ear);
    }
    out.push([left[0], left[1], left[2]]);
}

/// The polygon seen against its mean normal, so that it turns counter-clockwise.
fn flattened(corners: &[Vec3]) -> Vec<DVec2> {
    let points = corners.iter().map(|p| p.as_dvec3());
    let next = points.clone().cycle().skip(1);
    let origin = corners[0].as_dvec3();
    let normal: DVec3 = points
        .clone()
        .zip(next)
        .map(|(a, b)| (a - origin).cross(b - origin))
        .sum();
    let size = normal.abs();
    // Dropping the largest axis keeps the polygon as open as possible; the sign keeps its orientation.
    points
        .map(|p| p - origin)
        .map(|p| match size {
            s if s.x >= s.y && s.x >= s.z => DVec2::new(p.y * normal.x.signum(), p.z),
            s if s.y >= s.z => DVec2::new(p.z * normal.y.signum(), p.x),
            _ => DVec2::new(p.x * normal.z.signum(), p.y),
        })
        .collect()
}

/// Positive where a, b, c turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

fn is_ear(plane: &[DVec2], left: &[usize], i: usize) -> bool {
    let m = left.len();
    let [a, b, c] = [(i + m - 1) % m, i, (i + 1) % m].map(|k| plane[left[k]]);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    left.iter().map(|&k| plane[k]).all(|p| {
        let inside = turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        !inside || p == a || p == b || p == c
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of the triangles' area vectors and of their absolute areas, twice.
    fn areas(corners: &[Vec3]) -> (DVec3, f64) {
        let mut triangles = Vec::new();
        triangulate(corners, &mut triangles);
        assert_eq!(triangles.len(), corners.len() - 2);
        let vectors = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| corners[i].as_dvec3());
            (b - a).cross(c - a)
        });
        (vectors.clone().sum(), vectors.map(|v| v.length()).sum())
    }

    #[test]
    fn concave_polygons_are_covered_once_whatever_corner_comes_first() {
        let arrow = [[0., 0.], [4., 0.], [1., 1.], [0., 4.]];
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [0., 1.],
        ];
        for (shape, twice) in [(&arrow[..], 8.0), (&comb[..], 18.0)] {
            for turned in 0..shape.len() {
                for axis in 0..3 {
                    for side in [1.0, -1.0] {
                        let corners: Vec<Vec3> = (0..shape.len())
                            .map(|i| shape[(i + turned) % shape.len()])
                            .map(|[x, y]| match axis {
                                0 => Vec3::new(7.0, x * side, y),
                                1 => Vec3::new(y, 7.0, x * side),
                                _ => Vec3::new(x * side, y, 7.0),
                            })
                            .collect();
                        let (sum, total) = areas(&corners);
                        assert_eq!(
                            (sum[axis], total),
                            (twice * side as f64, twice),
                            "first {turned}, axis {axis}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn degenerate_polygons_give_degenerate_triangles() {
        assert_eq!(areas(&[Vec3::ONE; 6]).1, 0.0);
        assert_eq!(areas(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X]).1, 0.0);
    }
}
