//! The cosine lobe on polar maps, exact along rows.
//!
//! On a row at polar angle θ the cosine to a normal is A + B cos Δ with Δ the difference of longitude. It is positive
//! for |Δ| < Δ₀ = arccos(-A/B). Running integrals of I, I cos φ and I sin φ along the row give the integral over that
//! arc in constant time, ends inside a texel included: the cost is rows times results, whatever the width.

use super::Request;
use ambient::quadrature::gauss_legendre;
use environment::{IlluminationMap, Image};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rows whose contributions are summed together; the blocks are then added in order.
const BLOCK: usize = 16;

/// ∫ I x^power dω over the hemisphere of each direction, for power 0 or 1, times `scale`.
pub(super) fn integrate(map: &IlluminationMap, request: &Request, power: u32, scale: f64) -> Image {
    let (width, height) = request.size;
    let normals: Vec<Option<Normal>> = (0..width * height)
        .map(|at| {
            let (x, y) = ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
            request
                .projection
                .direction(request.size, x, y)
                .map(Normal::of)
        })
        .collect();
    let rows = map.size().1;
    let rule = nodes(rows, if power == 0 { 8192 } else { 1024 });
    let blocks: Vec<usize> = (0..rows).step_by(BLOCK).collect();
    let partial: Vec<Vec<[f64; 3]>> = blocks
        .into_par_iter()
        .map(|start| {
            let mut sums = vec![[0.0; 3]; normals.len()];
            for j in start..(start + BLOCK).min(rows) {
                let row = Row::of(map, j);
                for (node, weight) in &rule {
                    let step = PI / rows as f64;
                    let (sin, cos) = ((j as f64 + 0.5 + 0.5 * node) * step).sin_cos();
                    row.add(
                        [sin, cos],
                        0.5 * step * weight * sin,
                        power,
                        &normals,
                        &mut sums,
                    );
                }
            }
            sums
        })
        .collect();
    let pixels = (0..normals.len()).map(|at| {
        let sum = partial.iter().fold([0.0; 3], |sum: [f64; 3], part| {
            std::array::from_fn(|c| sum[c] + part[at][c])
        });
        sum.map(|v| (v * scale).max(0.0) as f32)
    });
    Image {
        width,
        height,
        pixels: pixels.collect(),
    }
}

/// Nodes in -1..1 and weights for one of `rows` rows. Where the horizon touches a row the integrand has a kink of power
/// 3/2, or 1/2 for x^0, so small steps do more than high order: two nodes in each step of `all` from pole to pole.
fn nodes(rows: usize, all: usize) -> Vec<(f64, f64)> {
    let steps = all.div_ceil(rows);
    let step = |k: usize| {
        let middle = (2 * k + 1) as f64 / steps as f64 - 1.0;
        let node = move |(x, w): (f64, f64)| (middle + x / steps as f64, w / steps as f64);
        gauss_legendre(2).into_iter().map(node)
    };
    (0..steps).flat_map(step).collect()
}

/// A direction of the result: polar angle and longitude.
struct Normal {
    sin: f64,
    cos: f64,
    /// Longitude, its sine and cosine.
    longitude: [f64; 3],
}

impl Normal {
    fn of([x, y, z]: [f64; 3]) -> Normal {
        let sin = x.hypot(z);
        let longitude = x.atan2(z);
        let (s, c) = longitude.sin_cos();
        Normal {
            sin,
            cos: y,
            longitude: [longitude, s, c],
        }
    }
}

/// Running integrals along one row up to the left edge of every texel.
struct Row {
    width: usize,
    /// ∫ I, ∫ I cos φ, ∫ I sin φ for each channel; one entry more than texels.
    sums: Vec<[[f64; 3]; 3]>,
    pixels: Vec<[f64; 3]>,
    /// Sine and cosine of the left edges.
    edges: Vec<(f64, f64)>,
}

impl Row {
    fn of(map: &IlluminationMap, j: usize) -> Row {
        let width = map.size().0;
        let row = &map.image().pixels[j * width..(j + 1) * width];
        let pixels: Vec<[f64; 3]> = row.iter().map(|p| p.map(f64::from)).collect();
        let step = TAU / width as f64;
        let edges: Vec<(f64, f64)> = (0..=width)
            .map(|i| (i as f64 * step - PI).sin_cos())
            .collect();
        let mut sums = vec![[[0.0; 3]; 3]];
        let mut sum = [[0.0; 3]; 3];
        for (i, pixel) in pixels.iter().enumerate() {
            let (a, b) = (edges[i], edges[i + 1]);
            let moments = [step, b.0 - a.0, a.1 - b.1];
            for (sum, moment) in sum.iter_mut().zip(moments) {
                *sum = std::array::from_fn(|c| sum[c] + pixel[c] * moment);
            }
            sums.push(sum);
        }
        Row {
            width,
            sums,
            pixels,
            edges,
        }
    }

    /// The running integrals at a longitude in -2π..2π, whose sine and cosine are known.
    fn at(&self, longitude: f64, (sin, cos): (f64, f64)) -> [[f64; 3]; 3] {
        let turns = ((longitude + PI) / TAU).floor();
        let place = (longitude + PI - turns * TAU) / TAU * self.width as f64;
        let i = (place as usize).min(self.width - 1);
        let (whole, pixel, edge) = (&self.sums[self.width], self.pixels[i], self.edges[i]);
        let inside = (place - i as f64) * TAU / self.width as f64;
        let moments = [inside, sin - edge.0, edge.1 - cos];
        std::array::from_fn(|k| {
            std::array::from_fn(|c| {
                turns * whole[k][c] + self.sums[i][k][c] + pixel[c] * moments[k]
            })
        })
    }

    /// Adds the row's part at polar angle `[sin, cos]` to every result.
    fn add(
        &self,
        [sin, cos]: [f64; 2],
        weight: f64,
        power: u32,
        normals: &[Option<Normal>],
        sums: &mut [[f64; 3]],
    ) {
        let whole = &self.sums[self.width];
        // Neighbours in a polar result share their polar angle.
        let mut last = (f64::NAN, 0.0, 0.0, 0.0);
        for (normal, sum) in normals.iter().zip(sums) {
            let Some(normal) = normal else { continue };
            let (a, b) = (cos * normal.cos, sin * normal.sin);
            if a <= -b {
                continue;
            }
            let (constant, linear) = if power == 0 { (1.0, 0.0) } else { (a, b) };
            let [longitude, s, c] = normal.longitude;
            let turned = [linear * c, linear * s];
            let value: [f64; 3] = if a >= b {
                std::array::from_fn(|k| {
                    constant * whole[0][k] + turned[0] * whole[1][k] + turned[1] * whole[2][k]
                })
            } else {
                if last.0 != normal.cos {
                    let ratio = -a / b;
                    last = (
                        normal.cos,
                        ratio.acos(),
                        ratio,
                        (1.0 - ratio * ratio).sqrt(),
                    );
                }
                let (_, half, ch, sh) = last;
                let right = self.at(longitude + half, (s * ch + c * sh, c * ch - s * sh));
                let left = self.at(longitude - half, (s * ch - c * sh, c * ch + s * sh));
                std::array::from_fn(|k| {
                    let part = |m: usize| right[m][k] - left[m][k];
                    constant * part(0) + turned[0] * part(1) + turned[1] * part(2)
                })
            };
            *sum = std::array::from_fn(|k| sum[k] + weight * value[k]);
        }
    }
}
