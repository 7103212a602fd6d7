//! Nodes in a texel for sums over its part of the sphere, exact to rounding for smooth functions.
//!
//! A texel may be cut: by the rim of a disc, where solid angle by area ends abruptly or has no bound, or by the fold of
//! an octahedron. On a line of a disc x = √(1-y²) sin t makes directions and solid angles smooth in t up to the rim;
//! lines end where the rim leaves the texel, as a root, which y = middle + half sin u smooths.

use super::{Direction, Projection, disc};
use std::f64::consts::FRAC_PI_2;

/// Least nodes on a line of a texel that is cut.
const CUT: usize = 10;

impl Projection {
    /// Directions in a texel with their solid angles up to a common factor. `rule` are nodes and weights on -1..1,
    /// `fine` those for a texel that is cut.
    pub fn nodes(
        self,
        size: (usize, usize),
        (i, j): (usize, usize),
        rule: &[(f64, f64)],
        fine: &[(f64, f64)],
    ) -> Vec<(Direction, f64)> {
        let corner = [i as f64, j as f64];
        match self {
            Projection::Ortho | Projection::Ball | Projection::Angular => {
                on_disc(self, size, (i, j), rule, fine)
            }
            Projection::Octahedral if !self.smooth(size, corner, [1.0; 2]) => {
                let right = 2 * i >= size.0;
                let low = 2 * j >= size.1;
                folded(self, size, corner, right == low, fine)
            }
            _ => {
                let places = rule.iter().flat_map(|(y, wy)| {
                    let place = move |(x, wx): &(f64, f64)| (0.5 + 0.5 * x, 0.5 + 0.5 * y, wx * wy);
                    rule.iter().map(place)
                });
                let node = |(x, y, weight): (f64, f64, f64)| {
                    let (x, y) = (corner[0] + x, corner[1] + y);
                    let direction = self.direction(size, x, y)?;
                    Some((direction, weight * self.density(size, x, y)))
                };
                places.filter_map(node).collect()
            }
        }
    }

    /// Nodes a line of a cut texel needs where others need `count`.
    pub fn fine(count: usize) -> usize {
        count.max(CUT)
    }
}

/// Two triangles on both sides of a diagonal: a square of nodes squeezed to a corner each.
fn folded(
    projection: Projection,
    size: (usize, usize),
    [left, top]: [f64; 2],
    rising: bool,
    rule: &[(f64, f64)],
) -> Vec<(Direction, f64)> {
    let mut nodes = Vec::with_capacity(2 * rule.len() * rule.len());
    for (a, wa) in rule {
        for (b, wb) in rule {
            let (a, b) = (0.5 + 0.5 * a, 0.5 + 0.5 * b);
            // Towards the corner at the top left by 1 - a, and its mirror image at the other end.
            let (x, y) = (a * b, a * (1.0 - b));
            for (x, y) in [(x, y), (1.0 - x, 1.0 - y)] {
                let x = if rising { x } else { 1.0 - x };
                let (x, y) = (left + x, top + y);
                if let Some(direction) = projection.direction(size, x, y) {
                    let weight = wa * wb * a * projection.density(size, x, y);
                    nodes.push((direction, weight));
                }
            }
        }
    }
    nodes
}

fn on_disc(
    projection: Projection,
    size: (usize, usize),
    (i, j): (usize, usize),
    rule: &[(f64, f64)],
    fine: &[(f64, f64)],
) -> Vec<(Direction, f64)> {
    let side = size.1 as f64;
    let edge = |k: usize| 2.0 * k as f64 / side - 1.0;
    let (k, front) = (i % size.1, i < size.1);
    let (x0, x1) = (edge(k), edge(k + 1));
    // Downward, as texels are counted; up is the other sign.
    let (y0, y1) = (edge(j), edge(j + 1));
    let outside = |x: f64, y: f64| x * x + y * y > 1.0;
    let cut = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)]
        .into_iter()
        .any(|(x, y)| outside(x, y));
    let rule = if cut { fine } else { rule };
    let mut ends = vec![y0, y1];
    if cut {
        for x in [x0, x1] {
            let y = (1.0 - x * x).max(0.0).sqrt();
            ends.extend([y, -y].into_iter().filter(|y| y0 < *y && *y < y1));
        }
        ends.sort_by(f64::total_cmp);
    }
    let mut nodes = Vec::new();
    for piece in ends.windows(2) {
        let (middle, half) = (0.5 * (piece[0] + piece[1]), 0.5 * (piece[1] - piece[0]));
        for (u, wu) in rule {
            let (shift, slope) = match cut {
                true => (FRAC_PI_2 * u).sin_cos(),
                false => (*u, 1.0),
            };
            let down = middle + half * shift;
            let across = (1.0 - down * down).max(0.0).sqrt();
            let angle = |x: f64| (x / across).clamp(-1.0, 1.0).asin();
            let (from, to) = (angle(x0), angle(x1));
            if to <= from {
                continue;
            }
            for (t, wt) in rule {
                let (sin, cos) = (from + (0.5 + 0.5 * t) * (to - from)).sin_cos();
                let (x, y, z) = (across * sin, -down, across * cos);
                let line = wu * wt * half * slope * (to - from);
                let node = match projection {
                    Projection::Ortho => Some(([x, y, if front { z } else { -z }], line)),
                    Projection::Ball => disc::ball(x, y).map(|d| (d, line * z)),
                    _ => disc::angular(x, y).map(|d| (d, line * z * disc::angular_density(x, y))),
                };
                nodes.extend(node);
            }
        }
    }
    nodes
}
