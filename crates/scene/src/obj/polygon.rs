//! Cuts a polygon of an OBJ face into triangles.
//!
//! Ear by ear, as G. H. Meisters, "Polygons have ears" (1975). Only corners that do not turn left can lie inside of an
//! ear, so those alone stand in a grid and are asked; and a cut changes only whether its two neighbours are ears. Both
//! keep the work near the number of corners. `vendor-notes/obj.md` says why no library does it.

use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// Appends triangles, as numbers of corners, that cover the polygon once and keep its orientation.
///
/// A convex polygon gives the fan from its first corner, any other is cut ear by ear in the plane of its mean (Newell)
/// normal; a hole may hang on it by a slit. There are always `corners.len() - 2` triangles; a degenerate polygon gives
/// degenerate ones, and one that crosses itself some that overlap.
pub(crate) fn triangulate(corners: &[DVec3], out: &mut Vec<[usize; 3]>) {
    let n = corners.len();
    let plane = flattened(corners);
    let convex = (0..n).all(|i| turn(plane[i], plane[(i + 1) % n], plane[(i + 2) % n]) >= 0.0);
    if n <= 3 || convex {
        out.extend((1..n - 1).map(|i| [0, i, i + 1]));
    } else {
        Ring::of(&plane).cut(out);
    }
}

/// The polygon seen against its mean normal, so that it turns counter-clockwise.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let points = corners.iter().copied();
    let next = points.clone().cycle().skip(1);
    let origin = corners[0];
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

/// What is left of a polygon that is being cut.
struct Ring<'a> {
    plane: &'a [DVec2],
    /// The corners before and after each; a corner that is cut off stands before itself.
    around: Vec<[usize; 2]>,
    left: usize,
    grid: Grid,
}

impl<'a> Ring<'a> {
    fn of(plane: &'a [DVec2]) -> Self {
        let n = plane.len();
        let mut ring = Ring {
            plane,
            around: (0..n).map(|i| [(i + n - 1) % n, (i + 1) % n]).collect(),
            left: n,
            grid: Grid::default(),
        };
        let blunt: Vec<usize> = (0..n).filter(|&i| ring.turn(i) <= 0.0).collect();
        ring.grid = Grid::of(plane, &blunt);
        ring
    }

    fn cut(mut self, out: &mut Vec<[usize; 3]>) {
        let mut open: VecDeque<usize> = (0..self.plane.len()).collect();
        // A sound polygon is cut at one go. What is in line, or crosses itself, needs other measures, each once over
        // all that is left.
        let measures: [fn(&Self, usize) -> bool; 4] =
            [Ring::is_ear, Ring::is_flat, Ring::is_ear, |_, _| true];
        for measure in measures {
            if open.is_empty() {
                open.extend((0..self.plane.len()).filter(|&i| !self.is_cut(i)));
            }
            while let Some(i) = open.pop_front() {
                if self.left < 3 {
                    return;
                }
                if self.is_cut(i) || !measure(&self, i) {
                    continue;
                }
                let [before, after] = self.around[i];
                out.push([before, i, after]);
                self.around[before][1] = after;
                self.around[after][0] = before;
                self.around[i] = [i, i];
                self.left -= 1;
                open.extend([before, after]);
            }
        }
    }

    fn is_cut(&self, i: usize) -> bool {
        self.around[i][0] == i
    }

    fn turn(&self, i: usize) -> f64 {
        let [before, after] = self.around[i].map(|k| self.plane[k]);
        turn(before, self.plane[i], after)
    }

    /// Whether the corner and its neighbours lie in line.
    fn is_flat(&self, i: usize) -> bool {
        self.turn(i) == 0.0
    }

    /// Whether the corner turns left and no other lies in its triangle, border included.
    fn is_ear(&self, i: usize) -> bool {
        let [before, after] = self.around[i];
        let [a, b, c] = [before, i, after].map(|k| self.plane[k]);
        if turn(a, b, c) <= 0.0 {
            return false;
        }
        self.grid.near([a, b, c]).all(|k| {
            let p = self.plane[k];
            let inside = turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            !inside || p == a || p == b || p == c || self.is_cut(k) || self.turn(k) > 0.0
        })
    }
}

/// Corners by where they lie: about one to a cell.
#[derive(Default)]
struct Grid {
    low: DVec2,
    /// Cells for a unit.
    scale: DVec2,
    side: usize,
    /// Where the corners of each cell begin, row by row, and the end.
    starts: Vec<usize>,
    corners: Vec<usize>,
}

impl Grid {
    fn of(plane: &[DVec2], corners: &[usize]) -> Self {
        let low = plane.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = plane.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = (corners.len() as f64).sqrt().ceil() as usize;
        let mut grid = Grid {
            low,
            scale: (high - low).map(|size| if size > 0.0 { side as f64 / size } else { 0.0 }),
            side,
            starts: vec![0; side * side + 1],
            corners: vec![0; corners.len()],
        };
        let cell = |&k: &usize| {
            let [x, y] = ((plane[k] - low) * grid.scale).to_array();
            grid.clamped(y) * side + grid.clamped(x)
        };
        let cells: Vec<usize> = corners.iter().map(cell).collect();
        cells.iter().for_each(|&cell| grid.starts[cell] += 1);
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        for (&corner, cell) in corners.iter().zip(cells) {
            grid.starts[cell] -= 1;
            grid.corners[grid.starts[cell]] = corner;
        }
        grid
    }

    fn clamped(&self, at: f64) -> usize {
        // A cast ends at 0.
        (at as usize).min(self.side.saturating_sub(1))
    }

    /// The corners of all cells that a triangle touches, and of some beside them.
    fn near(&self, triangle: [DVec2; 3]) -> impl Iterator<Item = usize> {
        let [a, b, c] = triangle.map(|p| (p - self.low) * self.scale);
        let [first, last] = [a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y)].map(|y| self.clamped(y));
        let rows = first..if self.side == 0 { first } else { last + 1 };
        rows.flat_map(move |row| {
            // What the triangle spans in the row, from where its edges are there; rounding is far less than the cell
            // beside it.
            let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let ends =
                    [row as f64, row as f64 + 1.0].map(|y| y.clamp(p.y.min(q.y), p.y.max(q.y)));
                if ends[0] > row as f64 + 1.0 || ends[1] < row as f64 {
                    continue;
                }
                for y in ends {
                    let along = if p.y == q.y {
                        0.0
                    } else {
                        (y - p.y) / (q.y - p.y)
                    };
                    let x = p.x + (q.x - p.x) * along;
                    (low, high) = (low.min(x), high.max(x));
                }
            }
            let [low, high] = [low - 1.0, high + 1.0].map(|x| row * self.side + self.clamped(x));
            // No range where a coordinate is not finite.
            let range = self.starts[low]..self.starts[high + 1];
            self.corners.get(range).unwrap_or_default()
        })
        .copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn triangles(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let corners: Vec<DVec3> = corners.iter().map(|corner| corner.as_dvec3()).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, &mut triangles);
        triangles
    }

    /// Sum of the triangles' area vectors and of their absolute areas, twice.
    fn areas(corners: &[Vec3]) -> (DVec3, f64) {
        let triangles = triangles(corners);
        assert_eq!(triangles.len(), corners.len() - 2);
        let vectors = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| corners[i].as_dvec3());
            (b - a).cross(c - a)
        });
        (vectors.clone().sum(), vectors.map(|v| v.length()).sum())
    }

    /// The triangles look up, cover an area of half of this, and none of it twice.
    fn assert_covered(corners: &[Vec3], exact: f64, case: &str) {
        let (sum, total) = areas(corners);
        assert_eq!((sum.z, total), (exact, exact), "{case}");
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

    /// The area that a polygon in the plane z = 0 encloses, twice, by the trapezium rule: exact for small integers.
    fn twice_enclosed(corners: &[Vec3]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        let pairs = corners.iter().map(|p| p.as_dvec3()).zip(next);
        pairs
            .map(|(a, b)| a.x * f64::from(b.y) - f64::from(b.x) * a.y)
            .sum()
    }

    #[test]
    fn polygons_of_any_number_of_corners_have_their_exact_area() {
        for teeth in [1, 2, 127, 128, 129, 5_000] {
            // A bar of height 1 and teeth of width 1 and height 2, one apart: each 2, on a bar of 2 a tooth less the
            // last gap.
            let tooth =
                |i: usize| [[2, 1], [2, 3], [1, 3], [1, 1]].map(|[x, y]| [2 * i + x - 1, y]);
            let top = (0..teeth).rev().flat_map(tooth);
            let all = [[0, 0], [2 * teeth - 1, 0]].into_iter().chain(top);
            let corners: Vec<Vec3> = all
                .map(|[x, y]| Vec3::new(x as f32, y as f32, 0.0))
                .collect();
            let exact = 2.0 * (2 * teeth - 1 + 2 * teeth) as f64;
            for turned in [0, 1, corners.len() / 2, corners.len() - 1] {
                let mut corners = corners.clone();
                corners.rotate_left(turned);
                assert_covered(&corners, exact, &format!("{teeth} teeth, first {turned}"));
            }
        }
    }

    #[test]
    fn holes_that_hang_on_slits_stay_open() {
        // A floor of 4 n x 4 with n square holes of 2 x 2 in a row, each hanging on the lower edge by a slit.
        for holes in [1usize, 2, 3, 200] {
            let at = |x: usize, y: usize| Vec3::new(x as f32, y as f32, 0.0);
            let hole = |i: usize| {
                let x = 4 * i + 1;
                let slit = [at(x, 0), at(x, 1)];
                let around = [at(x, 3), at(x + 2, 3), at(x + 2, 1), at(x, 1), at(x, 0)];
                slit.into_iter().chain(around)
            };
            let wide = 4 * holes;
            let mut corners: Vec<Vec3> = (0..holes).flat_map(hole).collect();
            corners.extend([at(wide, 0), at(wide, 4), at(0, 4), at(0, 0)]);
            let exact = 2.0 * (16 - 4) as f64 * holes as f64;
            assert_eq!(twice_enclosed(&corners), exact);
            for turned in 0..corners.len().min(40) {
                let mut corners = corners.clone();
                corners.rotate_left(turned);
                assert_covered(&corners, exact, &format!("{holes} holes, first {turned}"));
            }
        }
    }

    #[test]
    fn stars_of_any_shape_are_covered_once() {
        // Corners in the order of their angle about the origin, at distances by a hash: simple, and half of them
        // reflex.
        for count in [5usize, 50, 700, 3_000] {
            for seed in 0..20u32 {
                let corner = |i: usize| {
                    let hash = (i as u32 ^ seed << 16).wrapping_mul(0x9e37_79b9) >> 20;
                    let angle = std::f64::consts::TAU * i as f64 / count as f64;
                    let (sin, cos) = angle.sin_cos();
                    let far = 60_000.0 + 100.0 * f64::from(hash);
                    Vec3::new((far * cos).round() as f32, (far * sin).round() as f32, 0.0)
                };
                let corners: Vec<Vec3> = (0..count).map(corner).collect();
                let exact = twice_enclosed(&corners);
                assert_covered(&corners, exact, &format!("{count} corners, seed {seed}"));
            }
        }
    }

    #[test]
    fn degenerate_polygons_give_degenerate_triangles() {
        assert_eq!(areas(&[Vec3::ONE; 6]).1, 0.0);
        assert_eq!(areas(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X]).1, 0.0);
    }
    #[test]
    fn corners_that_are_not_finite_give_triangles_all_the_same() {
        for bad in [f32::NAN, f32::INFINITY, f32::MIN] {
            for at in 0..10 {
                let mut corners: Vec<Vec3> = (0..10)
                    .map(|i| Vec3::new(i as f32, (i % 3) as f32, 0.0))
                    .collect();
                corners[at].x = bad;
                assert_eq!(triangles(&corners).len(), 8, "{bad} at {at}");
            }
        }
    }
}
