//! A map as small areas at their middles, and direct sums over them.

use super::{Request, picture};
use ambient::quadrature::gauss_legendre;
use environment::{Direction, IlluminationMap, Image, Projection};
use rayon::prelude::*;

/// Areas with their flux, I dω.
#[derive(Default)]
pub(super) struct Points {
    pub directions: Vec<Direction>,
    pub flux: Vec<[f64; 3]>,
    /// Side of a square of the area's solid angle, radians. Points for smooth functions have none.
    pub sides: Vec<f64>,
}

impl Points {
    /// `count` by `count` Gauss-Legendre nodes in every texel; their solid angles add up to the texel's own. Texels
    /// that are black or show nothing are left out.
    pub(super) fn of(map: &IlluminationMap, count: usize) -> Points {
        let size = map.size();
        let of_tile = |tile: usize| {
            let across = size.0.div_ceil(TILE);
            let (left, top) = (tile % across * TILE, tile / across * TILE);
            let mut points = Points::default();
            let rows = top..(top + TILE).min(size.1);
            let row = |j| (left..(left + TILE).min(size.0)).map(move |i| (i, j));
            points.add_texels(map, count, rows.flat_map(row));
            points
        };
        let tiles = size.0.div_ceil(TILE) * size.1.div_ceil(TILE);
        let tiles: Vec<Points> = (0..tiles).into_par_iter().map(of_tile).collect();
        let mut all = Points::default();
        for tile in tiles {
            all.directions.extend(tile.directions);
            all.flux.extend(tile.flux);
            all.sides.extend(tile.sides);
        }
        all
    }

    /// Adds `count` by `count` nodes of each texel.
    pub(super) fn add_texels(
        &mut self,
        map: &IlluminationMap,
        count: usize,
        texels: impl Iterator<Item = (usize, usize)>,
    ) {
        let rules = [
            gauss_legendre(count),
            gauss_legendre(Projection::fine(count)),
        ];
        texels.for_each(|(i, j)| self.add(map, &rules, i, j));
    }

    /// Adds the nodes of one texel.
    fn add(&mut self, map: &IlluminationMap, rules: &[Vec<(f64, f64)>; 2], i: usize, j: usize) {
        let (size, projection) = (map.size(), map.projection());
        let pixel = map.image().at(i, j);
        let omega = projection.solid_angle(size, i, j);
        if pixel == [0.0; 3] || omega == 0.0 {
            return;
        }
        let mut nodes = projection.nodes(size, (i, j), &rules[0], &rules[1]);
        if nodes.is_empty() {
            // A sliver: the place on the rim next to its middle.
            let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
            nodes.push((projection.nearest_direction(size, x, y), 1.0));
        }
        let total: f64 = nodes.iter().map(|(_, weight)| weight).sum();
        for (direction, weight) in nodes {
            let omega = omega * weight / total;
            self.directions.push(direction);
            self.flux.push(pixel.map(|v| f64::from(v) * omega));
            self.sides.push(omega.sqrt());
        }
    }
}

/// Side of a square of texels whose points follow each other.
const TILE: usize = 8;

/// Points that follow each other, with their sums: seen as one where the horizon does not cut them.
struct Cluster {
    range: std::ops::Range<usize>,
    axis: Direction,
    /// Sine of the angle of a cone about the axis that holds them with a margin; 1 where that is not acute.
    sine: f64,
    flux: [f64; 3],
    /// Σ flux · direction, by channel.
    vector: [[f64; 3]; 3],
}

impl Cluster {
    fn of(points: &Points, range: std::ops::Range<usize>) -> Cluster {
        let mut sum = [0.0; 3];
        let (mut flux, mut vector) = ([0.0; 3], [[0.0; 3]; 3]);
        for at in range.clone() {
            let (l, f) = (points.directions[at], points.flux[at]);
            sum = std::array::from_fn(|k| sum[k] + l[k]);
            flux = std::array::from_fn(|c| flux[c] + f[c]);
            vector = std::array::from_fn(|c| std::array::from_fn(|k| vector[c][k] + f[c] * l[k]));
        }
        let length = dot(sum, sum).sqrt();
        let axis = sum.map(|v| v / length.max(f64::MIN_POSITIVE));
        let cosines = points.directions[range.clone()]
            .iter()
            .map(|l| dot(axis, *l));
        let least = cosines.fold(1.0, f64::min);
        let widest = points.sides[range.clone()]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b));
        let sine = if least > 0.0 {
            (1.0 - least * least).sqrt() + widest
        } else {
            1.0
        };
        Cluster {
            range,
            axis,
            sine,
            flux,
            vector,
        }
    }
}

fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Points of a cluster.
const CLUSTER: usize = 256;

/// Σ flux · x^power over the hemisphere of each direction of the result.
pub(super) fn integrate(map: &IlluminationMap, request: &Request, power: u32, scale: f64) -> Image {
    // The horizon cuts areas as if they were squares along it: two millions of them leave some 1e-7.
    let (width, height) = map.size();
    let points = Points::of(
        map,
        (2e6 / (width * height) as f64).sqrt().ceil().max(2.0) as usize,
    );
    let count = points.directions.len();
    let ranges: Vec<_> = (0..count)
        .step_by(CLUSTER)
        .map(|start| start..(start + CLUSTER).min(count))
        .collect();
    let clusters: Vec<Cluster> = ranges
        .into_par_iter()
        .map(|range| Cluster::of(&points, range))
        .collect();
    picture(request, |n| {
        let mut sum = [0.0; 3];
        for cluster in &clusters {
            let height = dot(n, cluster.axis);
            if height <= -cluster.sine {
                continue;
            }
            let value: [f64; 3] = if height < cluster.sine {
                cluster.range.clone().fold([0.0; 3], |sum, at| {
                    let flux = points.flux[at];
                    let value = above(dot(n, points.directions[at]), points.sides[at], power);
                    std::array::from_fn(|c| sum[c] + value * flux[c])
                })
            } else if power == 0 {
                cluster.flux
            } else {
                cluster.vector.map(|v| dot(n, v))
            };
            sum = std::array::from_fn(|c| sum[c] + value[c]);
        }
        sum.map(|v| v * scale)
    })
}

/// Mean of x^power above the horizon over a square along it with its middle at `x`.
fn above(x: f64, side: f64, power: u32) -> f64 {
    let part = (x / side + 0.5).clamp(0.0, 1.0);
    if power == 0 {
        part
    } else if part < 1.0 {
        0.5 * side * part * part
    } else {
        x
    }
}
