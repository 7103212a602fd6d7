//! From rings of data to spherical harmonics: I_lm = ∫ I Y*_lm dω.
//!
//! Not a quadrature but the adjoint of synthesis: the sum over texels is taken as it is, so nothing aliases. Rings are
//! real FFTs; rows θ and π-θ are folded by parity; orders m run in parallel, each with sums in a fixed order.

use super::legendre::{Legendre, diagonal};
use ambient::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Coefficients I_lm for m >= 0: real and imaginary parts of red, green, blue.
pub(super) struct Series {
    pub order: usize,
    /// `[m][l - m]`
    pub values: Vec<Vec<[f64; 6]>>,
}

/// Rings of equal spacing that carry data.
pub(super) struct Rings<'a> {
    pub height: usize,
    pub width: usize,
    /// Red, green and blue of a row.
    pub row: &'a (dyn Fn(usize, &mut [Vec<f64>; 3]) + Sync),
    /// Data are areas: the functions are integrated over texels with this many nodes a row. 0: data are points with
    /// weights.
    pub nodes: usize,
}

/// Gauss-Legendre nodes that integrate functions of this many radians to 1e-9.
pub(super) fn nodes(radians: f64) -> usize {
    2 + (radians * 0.6).ceil() as usize
}

/// Rows that are transformed together.
const BLOCK: usize = 16;

pub(super) fn analyse_rings(rings: &Rings, order: usize) -> Series {
    let blocks: Vec<usize> = (0..rings.height).step_by(BLOCK).collect();
    // `[block][m][component][row]`
    let rows: Vec<Vec<f64>> = blocks
        .into_par_iter()
        .map(|start| transform(rings, order, start))
        .collect();
    let half = rings.height.div_ceil(2);
    let fold = Fold::of(rings, half);
    let first = diagonal(order);
    let column = |m: usize| {
        // Sums and differences of the two rows of a pair.
        let mut folded = [vec![[0.0; 6]; half], vec![[0.0; 6]; half]];
        for (j, opposite) in (0..half).map(|j| (j, rings.height - 1 - j)) {
            for component in 0..6 {
                let at = |j: usize| {
                    let count = (rings.height - j / BLOCK * BLOCK).min(BLOCK);
                    rows[j / BLOCK][(m * 6 + component) * count + j % BLOCK]
                };
                let (a, b) = if opposite == j {
                    (at(j), 0.0)
                } else {
                    (at(j), at(opposite))
                };
                folded[0][j][component] = a + b;
                folded[1][j][component] = if opposite == j { 0.0 } else { a - b };
            }
        }
        fold.sums(m, order, first[m], &folded)
    };
    Series {
        order,
        values: (0..=order).into_par_iter().map(column).collect(),
    }
}

/// Fourier coefficients of some rows.
fn transform(rings: &Rings, order: usize, start: usize) -> Vec<f64> {
    let width = rings.width;
    let fft = fourier::forward(width);
    let mut scratch = fft.make_scratch_vec();
    let mut bins = fft.make_output_vec();
    let mut channels = std::array::from_fn(|_| vec![0.0; width]);
    let count = (rings.height - start).min(BLOCK);
    let mut values = vec![0.0; (order + 1) * 6 * count];
    // ∫ e^{-imφ} over a texel about the middle of the first one, which lies at φ = π/width - π.
    let factors: Vec<(f64, f64)> = (0..=order)
        .map(|m| {
            let m = m as f64;
            let half = m * PI / width as f64;
            let size = match rings.nodes {
                0 => 1.0,
                _ if m == 0.0 => TAU / width as f64,
                _ => 2.0 / m * half.sin(),
            };
            let (sin, cos) = (m * (PI - PI / width as f64)).sin_cos();
            (size * cos, size * sin)
        })
        .collect();
    for j in 0..count {
        (rings.row)(start + j, &mut channels);
        for (c, channel) in channels.iter_mut().enumerate() {
            fft.process_with_scratch(channel, &mut bins, &mut scratch)
                .expect("the lengths are the plan's own");
            for (m, (re, im)) in factors.iter().enumerate() {
                // Beyond the highest frequency of the row its spectrum repeats.
                let k = m % width;
                let bin = if k < bins.len() {
                    bins[k]
                } else {
                    bins[width - k].conj()
                };
                let at = |part: usize| (m * 6 + 2 * c + part) * count + j;
                values[at(0)] = bin.re * re - bin.im * im;
                values[at(1)] = bin.re * im + bin.im * re;
            }
        }
    }
    values
}

/// Nodes of the rows of the upper half.
struct Fold {
    /// `[node][row]`
    cos: Vec<Vec<f64>>,
    sin: Vec<Vec<f64>>,
    weight: Vec<Vec<f64>>,
}

impl Fold {
    fn of(rings: &Rings, half: usize) -> Fold {
        let step = PI / rings.height as f64;
        let rule = match rings.nodes {
            0 => vec![(0.0, 1.0)],
            count => gauss_legendre(count),
        };
        let angle = |node: f64, j: usize| (j as f64 + 0.5 + 0.5 * node) * step;
        let each = |f: &dyn Fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
            let row = |(x, w): &(f64, f64)| (0..half).map(|j| f(angle(*x, j), *w)).collect();
            rule.iter().map(row).collect()
        };
        let area = rings.nodes > 0;
        Fold {
            cos: each(&|angle, _| angle.cos()),
            sin: each(&|angle, _| angle.sin()),
            weight: each(&|angle, w| {
                if area {
                    0.5 * step * w * angle.sin()
                } else {
                    1.0
                }
            }),
        }
    }

    /// Σ over rows of data times P̄_lm, for l from m to `order`.
    fn sums(
        &self,
        m: usize,
        order: usize,
        first: f64,
        folded: &[Vec<[f64; 6]>; 2],
    ) -> Vec<[f64; 6]> {
        let half = folded[0].len();
        let nodes = self.cos.iter().zip(&self.sin);
        let mut nodes: Vec<Legendre> = nodes
            .map(|(cos, sin)| Legendre::new(m, first, cos, sin))
            .collect();
        let mut row = vec![0.0; half];
        let mut values = Vec::with_capacity(order + 1 - m);
        for l in m..=order {
            row.fill(0.0);
            for (node, weight) in nodes.iter_mut().zip(&self.weight) {
                for ((sum, p), w) in row.iter_mut().zip(&node.current).zip(weight) {
                    *sum += p * w;
                }
                node.step();
            }
            let mut sum = [0.0; 6];
            for (p, data) in row.iter().zip(&folded[(l - m) % 2]) {
                for (s, d) in sum.iter_mut().zip(data) {
                    *s += p * d;
                }
            }
            values.push(sum);
        }
        values
    }
}
