//! The fits of corners blended into texels, row by row.

use super::equations::PLACES;
use super::moments::MomentRows;
use crate::denoise::lanes::{LANES, Lanes};
use crate::denoise::surface::{FEATURES, Surface};

/// Coefficients of the place of a corner along a row, and of a cell.
const ALONG: usize = 3;
const BETWEEN: usize = 4;

/// A row of a blend: the polynomials of corners at one place down, and those of the cells between them across.
pub(super) struct Line<const N: usize> {
    /// Numbers of a coefficient's row.
    room: usize,
    /// By corners: the coefficients of 1, u, u² and of the features.
    corners: Vec<f32>,
    /// By cells: those of 1, t, t², t³, then of 1 and t of each feature.
    cells: Vec<f32>,
    /// A row of texels.
    texels: Vec<f32>,
}

impl<const N: usize> Line<N> {
    pub fn new(layout: &MomentRows, width: usize) -> Self {
        Self {
            room: layout.room,
            corners: vec![0.0; (ALONG + FEATURES) * layout.room],
            cells: vec![0.0; (BETWEEN + 2 * FEATURES) * layout.room],
            texels: vec![0.0; width],
        }
    }

    /// Blends the fits of two rows of corners at the place `q` down between them, 0..1.
    #[inline(always)]
    pub fn blend(&mut self, layout: &MomentRows, degree: usize, corners: [&[f32]; 2], q: f32) {
        let (room, features) = (self.room, N - PLACES);
        for at in (0..layout.cells + 1).step_by(LANES) {
            let mut sums = [Lanes::ZERO; ALONG + FEATURES];
            for (row, [tent, v]) in corners.into_iter().zip([[1.0 - q, q], [q, q - 1.0]]) {
                let c = |number: usize| Lanes::load(row, number * room + at);
                let mut along = [c(0) + c(2) * v, c(1), Lanes::ZERO];
                if degree == 0 {
                    let [uu, uv, vv] = [c(N - 3), c(N - 2), c(N - 1)];
                    along = [along[0] + vv * (v * v), along[1] + uv * v, uu];
                }
                for (number, sum) in sums.iter_mut().enumerate().take(ALONG + features) {
                    let own = if number < ALONG {
                        along[number]
                    } else {
                        c(number)
                    };
                    *sum += own * tent;
                }
            }
            for (number, sum) in sums.into_iter().enumerate().take(ALONG + features) {
                sum.store(&mut self.corners, number * room + at);
            }
        }
        for at in (0..layout.cells).step_by(LANES) {
            // (1 - t) a(t) + t b(t - 1)
            let load = |number: usize, k: usize| Lanes::load(&self.corners, number * room + at + k);
            let a = [load(0, 0), load(1, 0), load(2, 0)];
            let b = [load(0, 1), load(1, 1), load(2, 1)];
            let b = [b[0] - b[1] + b[2], b[1] - b[2] * 2.0, b[2]];
            let cubic = [a[0], a[1] - a[0] + b[0], a[2] - a[1] + b[1], b[2] - a[2]];
            for (number, lanes) in cubic.into_iter().enumerate() {
                lanes.store(&mut self.cells, number * room + at);
            }
            for feature in 0..features {
                let [left, right] = [load(ALONG + feature, 0), load(ALONG + feature, 1)];
                let row = (BETWEEN + 2 * feature) * room + at;
                left.store(&mut self.cells, row);
                (right - left).store(&mut self.cells, row + room);
            }
        }
    }

    /// What was blended, at the texels of row `y` of the surface.
    #[inline(always)]
    pub fn write(&mut self, surface: &Surface, y: usize, stride: usize, out: &mut [f32]) {
        let row = |number: usize| &self.cells[number * self.room..][..self.room];
        expand::<BETWEEN>([row(0), row(1), row(2), row(3)], stride, out);
        for feature in 0..N - PLACES {
            let first = BETWEEN + 2 * feature;
            let of = [row(first), row(first + 1)];
            expand::<2>(of, stride, &mut self.texels);
            let features = surface.features.iter().map(|sheet| sheet.row(feature, y));
            for features in features {
                for ((out, feature), more) in out.iter_mut().zip(features).zip(&self.texels) {
                    *out += feature * more;
                }
            }
        }
        for (out, mask) in out.iter_mut().zip(surface.mask.row(0, y)) {
            *out *= mask;
        }
    }
}

/// Polynomials of cells at the texels of a row.
#[inline(always)]
fn expand<const T: usize>(of: [&[f32]; T], stride: usize, out: &mut [f32]) {
    match stride {
        2 => expand_short::<T, 2>(of, out),
        4 => expand_short::<T, 4>(of, out),
        _ => {
            for (cell, out) in out.chunks_mut(stride).enumerate() {
                let of = column(&of, cell);
                for (k, out) in out.iter_mut().enumerate() {
                    *out = polynomial(of, (k as f32 + 0.5) / stride as f32);
                }
            }
        }
    }
}

/// The same of cells of S texels, of which vectors take several.
#[inline(always)]
fn expand_short<const T: usize, const S: usize>(of: [&[f32]; T], out: &mut [f32]) {
    let mut cut = of;
    for row in &mut cut {
        *row = &row[..out.len() / S];
    }
    for (cell, out) in out.chunks_exact_mut(S).enumerate() {
        let of = column(&cut, cell);
        for (k, out) in out.iter_mut().enumerate() {
            *out = polynomial(of, (k as f32 + 0.5) / S as f32);
        }
    }
}

#[inline(always)]
fn column<const T: usize>(of: &[&[f32]; T], cell: usize) -> [f32; T] {
    let mut column = [0.0; T];
    for (number, row) in column.iter_mut().zip(of) {
        *number = row[cell];
    }
    column
}

#[inline(always)]
fn polynomial<const T: usize>(of: [f32; T], t: f32) -> f32 {
    let mut sum = of[T - 1];
    for k in (0..T - 1).rev() {
        sum = of[k] + t * sum;
    }
    sum
}
