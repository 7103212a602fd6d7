//! A map as few points that smooth functions cannot tell from it.
//!
//! Over a tile of texels a function of bounded order is a polynomial in the picture's coordinates. So the tile's areas
//! are moved onto a grid of Gauss-Legendre nodes by the adjoint of interpolation: node (p, q) gets Σ I ∫∫ l_p l_q over
//! texels, times the solid angle by area at the node. Where a tile is cut by a rim or a fold every texel has its own
//! nodes.

use super::points::Points;
use super::rings::nodes;
use ambient::quadrature::gauss_legendre;
use environment::{IlluminationMap, Projection};
use rayon::prelude::*;

/// Longest side of a tile, in texels.
const TILE: usize = 32;

/// Points of a map for functions up to an order.
pub(super) fn points(map: &IlluminationMap, order: usize) -> Points {
    let parts: Vec<Points> = Tile::all(map)
        .par_iter()
        .map(|tile| tile.points(map, order))
        .collect();
    let mut all = Points::default();
    for part in parts {
        all.directions.extend(part.directions);
        all.flux.extend(part.flux);
    }
    all
}

/// A rectangle of texels within one face, quadrant or disc.
struct Tile {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Tile {
    fn all(map: &IlluminationMap) -> Vec<Tile> {
        let (width, height) = map.size();
        let piece = map.projection().piece((width, height));
        let cuts = |length: usize| -> Vec<(usize, usize)> {
            let of_piece = |start: usize| {
                let end = (start + piece).min(length);
                (start..end)
                    .step_by(TILE)
                    .map(move |at| (at, TILE.min(end - at)))
            };
            (0..length).step_by(piece).flat_map(of_piece).collect()
        };
        let columns = cuts(width);
        let row = |(top, height): (usize, usize)| {
            let tile = move |&(left, width): &(usize, usize)| Tile {
                left,
                top,
                width,
                height,
            };
            columns.iter().map(tile).collect::<Vec<_>>()
        };
        cuts(height).into_iter().flat_map(row).collect()
    }

    fn points(&self, map: &IlluminationMap, order: usize) -> Points {
        let (size, projection) = (map.size(), map.projection());
        let mut points = Points::default();
        let texels = || {
            let rows = self.top..self.top + self.height;
            rows.flat_map(|j| (self.left..self.left + self.width).map(move |i| (i, j)))
        };
        let omegas: Vec<f64> = texels()
            .map(|(i, j)| projection.solid_angle(size, i, j))
            .collect();
        let whole: f64 = omegas.iter().sum();
        if whole == 0.0 || texels().all(|(i, j)| map.image().at(i, j) == [0.0; 3]) {
            return points;
        }
        let (corner, sides) = (
            [self.left as f64, self.top as f64],
            [self.width as f64, self.height as f64],
        );
        let smooth = projection.smooth(size, corner, sides);
        let extent = smooth.then(|| extent(projection, size, corner, sides));
        // Interpolation follows r radians from r/2 nodes on; ten more leave 1e-9 of low orders.
        let count = extent.map(|extent| (0.5 * extent * order as f64).ceil() as usize + 10);
        let of_texel = nodes((whole / omegas.len() as f64).sqrt() * order as f64);
        let Some(count) = count.filter(|count| count * count < of_texel * of_texel * omegas.len())
        else {
            texels().for_each(|(i, j)| add_texel(&mut points, map, order, (i, j)));
            return points;
        };
        let across = Moments::of(self.width, count);
        let down = Moments::of(self.height, count);
        // Rows first: `[row][p]`, then `[q][p]`.
        let mut rows = vec![[0.0; 3]; self.height * count];
        for (j, row) in rows.chunks_exact_mut(count).enumerate() {
            for i in 0..self.width {
                let pixel = map.image().at(self.left + i, self.top + j).map(f64::from);
                for (sum, moment) in row.iter_mut().zip(across.of_texel(i)) {
                    *sum = std::array::from_fn(|c| sum[c] + pixel[c] * moment);
                }
            }
        }
        let mut sums = vec![[0.0; 3]; count * count];
        for (q, sums) in sums.chunks_exact_mut(count).enumerate() {
            for (j, row) in rows.chunks_exact(count).enumerate() {
                let moment = down.of_texel(j)[q];
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum = std::array::from_fn(|c| sum[c] + value[c] * moment);
                }
            }
        }
        let place = |start: usize, length: usize, node: f64| {
            start as f64 + 0.5 * (node + 1.0) * length as f64
        };
        let mut area = 0.0;
        for (q, (y, wy)) in down.rule.iter().enumerate() {
            for (p, (x, wx)) in across.rule.iter().enumerate() {
                let (x, y) = (
                    place(self.left, self.width, *x),
                    place(self.top, self.height, *y),
                );
                let density = projection.density(size, x, y);
                let Some(direction) = projection.direction(size, x, y) else {
                    unreachable!("a smooth tile shows directions throughout")
                };
                area += wx * wy * density;
                points.directions.push(direction);
                points.flux.push(sums[q * count + p].map(|v| v * density));
            }
        }
        // Moments add up to the tile's area in texels; its solid angle is known.
        let scale = 4.0 * whole / (area * (self.width * self.height) as f64);
        points
            .flux
            .iter_mut()
            .for_each(|flux| *flux = flux.map(|v| v * scale));
        points
    }
}

/// Adds one texel's own nodes.
fn add_texel(points: &mut Points, map: &IlluminationMap, order: usize, (i, j): (usize, usize)) {
    let extent = extent(map.projection(), map.size(), [i as f64, j as f64], [1.0; 2]);
    points.add_texels(map, nodes(extent * order as f64), std::iter::once((i, j)));
}

/// Largest angle between the ends of a line across a rectangle; outside a disc its rim counts.
fn extent(projection: Projection, size: (usize, usize), corner: [f64; 2], sides: [f64; 2]) -> f64 {
    // A little inside: the border belongs to the next face.
    let ends = [1e-9, 0.5, 1.0 - 1e-9];
    let at = |x: f64, y: f64| {
        let (x, y) = (corner[0] + x * sides[0], corner[1] + y * sides[1]);
        let shown = projection.direction(size, x, y);
        shown.unwrap_or_else(|| projection.nearest_direction(size, x, y))
    };
    let mut extent: f64 = 0.0;
    for fixed in ends {
        for (a, b) in [
            (at(ends[0], fixed), at(ends[2], fixed)),
            (at(fixed, ends[0]), at(fixed, ends[2])),
        ] {
            let chord = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            extent = extent.max(2.0 * (0.5 * chord).min(1.0).asin());
        }
    }
    extent
}

/// Integrals of Lagrange's polynomials over the texels of a line.
struct Moments {
    rule: Vec<(f64, f64)>,
    /// `[texel][node]`, in texels.
    values: Vec<f64>,
}

impl Moments {
    fn of(texels: usize, count: usize) -> Moments {
        let rule = gauss_legendre(count);
        // l_p = w_p Σ_k (2k+1)/2 P_k(x_p) P_k, and (2k+1) ∫ P_k = P_{k+1} - P_{k-1}.
        let legendre = |x: f64| {
            let mut p = vec![1.0, x];
            for k in 1..=count {
                let l = k as f64;
                p.push(((2.0 * l + 1.0) * x * p[k] - l * p[k - 1]) / (l + 1.0));
            }
            p
        };
        let at_nodes: Vec<Vec<f64>> = rule.iter().map(|(x, _)| legendre(*x)).collect();
        let edges: Vec<Vec<f64>> = (0..=texels)
            .map(|i| legendre(2.0 * i as f64 / texels as f64 - 1.0))
            .collect();
        let mut values = Vec::with_capacity(texels * count);
        for edge in edges.windows(2) {
            let integral = |k: usize| {
                let upper = |p: &[f64]| if k == 0 { p[1] } else { p[k + 1] - p[k - 1] };
                upper(&edge[1]) - upper(&edge[0])
            };
            let integrals: Vec<f64> = (0..count).map(integral).collect();
            for (p, (_, weight)) in at_nodes.iter().zip(&rule) {
                let sum: f64 = integrals.iter().zip(p).map(|(a, b)| a * b).sum();
                values.push(0.25 * texels as f64 * weight * sum);
            }
        }
        Moments { rule, values }
    }

    fn of_texel(&self, i: usize) -> &[f64] {
        let count = self.rule.len();
        &self.values[i * count..(i + 1) * count]
    }
}
