//! Sums of harmonics over the rays of sixteen lanes, from which a texel's term follows for any view.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::step::Step;
use crate::survey::Texel;
use ambient::any_view::{self, Basis, COUNT, Coefficients};
use ambient::lanes::{LANES, Wide};
use std::sync::LazyLock;

/// Sums of one replicate by harmonic: over open rays and over all, each by its weight as a uniform direction.
#[derive(Clone)]
pub(crate) struct Moments {
    open: [f64; COUNT],
    all: [f64; COUNT],
    points: f64,
    /// By what the weights are corrected: an open share that other rays found.
    pub slope: f64,
}

/// What the lanes of a gang gather, up to an order.
pub(super) struct LaneMoments {
    order: usize,
    /// Tangent and bitangent of each lane's texel.
    axes: [[Wide; 3]; 2],
    sums: Box<[[[f64; LANES]; COUNT]; 2]>,
    block: Box<[[Wide; COUNT]; 2]>,
}

static BASIS: LazyLock<Basis<f32>> = LazyLock::new(|| Basis::new().single());

impl LaneMoments {
    pub fn new(order: usize) -> Self {
        Self {
            order,
            axes: [[[0.0; LANES]; 3]; 2],
            sums: Box::new([[[0.0; LANES]; COUNT]; 2]),
            block: Box::new([[[0.0; LANES]; COUNT]; 2]),
        }
    }

    /// Forgets what was gathered.
    pub fn clear(&mut self) {
        *self.sums = [[[0.0; LANES]; COUNT]; 2];
    }

    /// Gives a lane its texel. All its directions count in the frame of the texel's mean normal, which is the one that
    /// is written.
    pub fn set(&mut self, lane: usize, texel: &Texel) {
        let frame = any_view::frame(texel.normal);
        for (axis, of) in self.axes.iter_mut().zip([frame.tangent, frame.bitangent]) {
            for (plane, value) in axis.iter_mut().zip(of.to_array()) {
                plane[lane] = value as f32;
            }
        }
    }

    #[inline(always)]
    pub fn add(&mut self, step: &Step, open: u32) {
        let basis = &*BASIS;
        let [mut x, mut y, mut square, mut is_open] = [[0.0; LANES]; 4];
        for l in 0..LANES {
            let along = |axis: &[Wide; 3]| {
                axis[0][l] * step.directions[0][l]
                    + axis[1][l] * step.directions[1][l]
                    + axis[2][l] * step.directions[2][l]
            };
            (x[l], y[l]) = (along(&self.axes[0]), along(&self.axes[1]));
            square[l] = (1.0 - x[l] * x[l] - y[l] * y[l]).max(0.0);
            is_open[l] = (open >> l & 1) as f32;
        }
        // Weight times Re and Im of (x + iy)^m.
        let mut powers = [step.weights[1], [0.0; LANES]];
        for m in 0..=self.order {
            for l in (m..=self.order).step_by(2) {
                let mut q = [0.0; LANES];
                for &c in basis.polynomials[any_view::pair(l, m)][..=(l - m) / 2]
                    .iter()
                    .rev()
                {
                    for lane in 0..LANES {
                        q[lane] = q[lane] * square[lane] + c;
                    }
                }
                for (power, sign) in powers.iter().zip([1, -1]).take(if m > 0 { 2 } else { 1 }) {
                    let at = any_view::index(l, sign * m as isize);
                    let [open, all] = &mut *self.block;
                    for lane in 0..LANES {
                        let value = q[lane] * power[lane];
                        all[at][lane] += value;
                        open[at][lane] += value * is_open[lane];
                    }
                }
            }
            for l in 0..LANES {
                let (c, s) = (powers[0][l], powers[1][l]);
                powers[0][l] = c * x[l] - s * y[l];
                powers[1][l] = c * y[l] + s * x[l];
            }
        }
    }

    /// Takes the sums of a block.
    pub fn absorb(&mut self) {
        let count = any_view::count(self.order);
        for (sums, block) in self.sums.iter_mut().zip(self.block.iter_mut()) {
            for (sums, block) in sums.iter_mut().zip(block).take(count) {
                for l in 0..LANES {
                    sums[l] += f64::from(block[l]);
                }
                *block = [0.0; LANES];
            }
        }
    }

    /// Adds what a lane gathered from so many points to its replicate.
    pub fn collect(&self, lane: usize, points: u64, moments: &mut Moments) {
        moments.points += points as f64;
        let into = [&mut moments.open, &mut moments.all];
        for (into, sums) in into.into_iter().zip(&*self.sums) {
            for (sum, lanes) in into.iter_mut().zip(sums) {
                *sum += lanes[lane];
            }
        }
    }
}

impl Default for Moments {
    fn default() -> Self {
        Self {
            open: [0.0; COUNT],
            all: [0.0; COUNT],
            points: 0.0,
            slope: 0.0,
        }
    }
}

/// The coefficients of a texel from its replicates, and their variances.
///
/// With β the slope, `c = Σ w (V - β) y / n`, and β more for y(0, 0): what rays that all agree have drawn unevenly does
/// not count, so that an open texel is exactly (1, 0, …) and a closed one 0.
pub(crate) fn coefficients(replicates: &[Moments]) -> (Coefficients, [f64; COUNT]) {
    let used = || replicates.iter().filter(|own| own.points > 0.0);
    let drawn: Vec<[f64; COUNT]> = used()
        .map(|own| {
            let of = |at: usize| (own.open[at] - own.slope * own.all[at]) / own.points;
            let mut values: [f64; COUNT] = std::array::from_fn(of);
            values[0] += own.slope;
            values
        })
        .collect();
    let points: f64 = used().map(|own| own.points).sum();
    let mut values = [0.0; COUNT];
    for (own, drawn) in used().zip(&drawn) {
        for (value, of_own) in values.iter_mut().zip(drawn) {
            *value += of_own * (own.points / points);
        }
    }
    let variances = std::array::from_fn(|at| {
        let values: Vec<f64> = drawn.iter().map(|values| values[at]).collect();
        super::super::estimate::variance_of_mean(&values)
    });
    (Coefficients(values), variances)
}
