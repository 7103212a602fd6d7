//! Smooth surfaces through the texels of a chart: polynomials over overlapping windows, blended.
//!
//! Corners stand `stride` texels apart. About each of them a polynomial is fitted to the texels of a window of `2 * stride` x
//! `2 * stride`, by least squares with the weights of a tent, (1 - |u|)(1 - |v|). A texel's value is the mean of its four corners'
//! polynomials with the same weights. These add up to 1 at every texel, so there are no seams between windows; and since the residuals
//! of each fit add up to 0 under its weights, those of the blend add up to 0 over the chart: smoothing moves no chart's mean.

use super::plane::{Plane, TASK};
use rayon::prelude::*;

/// Functions of a quadratic: 1, u, v, u², uv, v². The first three are the linear ones.
const TERMS: usize = 6;
const LINEAR: usize = 3;

/// Exponents of u and v of each function.
const POWERS: [[usize; 2]; TERMS] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// A function whose part that the ones before it do not explain is below this share of its sum of squares is left out.
const DEPENDENT: f32 = 1e-3;

/// Corners whose polynomials are held at a time: some 24 MB.
const CORNERS: usize = 1 << 19;

/// Fits of several planes alike: quadratics first, linear ones second.
pub(super) type Fits = [Vec<Plane>; 2];

/// A corner's polynomials of one plane: the quadratic and the linear one.
type Corner = [[f32; TERMS]; 2];

/// Fits windows of `stride` to the planes of `data` where `mask` is 1, into `out`.
pub(super) fn fit(mask: &Plane, data: &[Plane], stride: usize, out: &mut Fits) {
    let (width, height) = (mask.width, mask.height());
    let across = width.div_ceil(stride) + 1;
    let down = height.div_ceil(stride) + 1;
    let rows = TASK.div_ceil(across * stride * stride);
    let powers: Vec<[f32; 6]> = (0..stride)
        .map(|i| {
            let t = (i as f32 + 0.5) / stride as f32;
            [
                1.0,
                t,
                t * t,
                t * t * t,
                (t * t) * (t * t),
                (t * t) * (t * t * t),
            ]
        })
        .collect();
    // Row after row of corners, the planes of each side by side; so many rows of cells at a time that corners need little room.
    let band = (CORNERS / (across * data.len())).max(1);
    for first in (0..down - 1).step_by(band) {
        let last = (first + band).min(down - 1);
        let corners: Vec<Corner> = (first..last + 1)
            .into_par_iter()
            .with_min_len(rows)
            .flat_map_iter(|row| corner_row(mask, data, &powers, row))
            .collect();
        let texels = first * stride * width..(last * stride).min(height) * width;
        for (degree, planes) in out.iter_mut().enumerate() {
            for (index, plane) in planes.iter_mut().enumerate() {
                let of = |row: usize, cell: usize, j: usize, i: usize| {
                    let corner = (row + j) * across + cell + i;
                    &corners[corner * data.len() + index][degree]
                };
                let lines = plane.values[texels.clone()].par_chunks_mut(width);
                let lines = lines.enumerate().with_min_len(TASK.div_ceil(width));
                lines.for_each(|(line, values)| {
                    let q = powers[line % stride][1];
                    let mask = &mask.values[texels.start + line * width..][..width];
                    let cells = values.chunks_mut(stride).zip(mask.chunks(stride));
                    for (cell, (values, mask)) in cells.enumerate() {
                        let of = |j, i| of(line / stride, cell, j, i);
                        let c = blend([[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]], q);
                        for ((value, mask), [_, t, ..]) in values.iter_mut().zip(mask).zip(&powers)
                        {
                            *value = mask * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
                        }
                    }
                });
            }
        }
    }
}

/// The blend of four corners' polynomials along a row of their cell, as a cubic of the column, 0..1; `q`: the row, 0..1.
fn blend(corners: [[&[f32; TERMS]; 2]; 2], q: f32) -> [f32; 4] {
    let mut side = [[0.0; 3]; 2];
    for (j, (tent, v)) in [(1.0 - q, q), (q, q - 1.0)].into_iter().enumerate() {
        for (i, sum) in side.iter_mut().enumerate() {
            let c = corners[j][i];
            sum[0] += tent * (c[0] + v * (c[2] + v * c[5]));
            sum[1] += tent * (c[1] + v * c[4]);
            sum[2] += tent * c[3];
        }
    }
    // (1 - t) a(t) + t b(t - 1)
    let [a, b] = side;
    let b = [b[0] - b[1] + b[2], b[1] - 2.0 * b[2], b[2]];
    [a[0], a[1] - a[0] + b[0], a[2] - a[1] + b[1], b[2] - a[2]]
}

/// The fits of one row of corners.
fn corner_row(mask: &Plane, data: &[Plane], powers: &[[f32; 6]], row: usize) -> Vec<Corner> {
    let (width, height, stride) = (mask.width, mask.height(), powers.len());
    let across = width.div_ceil(stride) + 1;
    // Sums of tent u^a v^b over each window: of the mask for a + b <= 4, of the planes for a + b <= 2.
    let mut masses = vec![[[0.0; 5]; 5]; across];
    let mut sums = vec![[[0.0; 3]; 3]; across * data.len()];
    let first = (row * stride).saturating_sub(stride);
    for y in first..(row * stride + stride).min(height) {
        let v = (y as f32 + 0.5) / stride as f32 - row as f32;
        let tent = 1.0 - v.abs();
        let vs: [f32; 5] = [
            tent,
            tent * v,
            tent * v * v,
            tent * v * v * v,
            tent * v * v * v * v,
        ];
        for (cell, x) in (0..width).step_by(stride).enumerate() {
            let at = y * width + x..y * width + (x + stride).min(width);
            let moments = row_moments::<6>(&mask.values[at.clone()], powers);
            if moments[0] == 0.0 {
                continue;
            }
            add(&mut masses[cell], left(&moments), &vs);
            add(&mut masses[cell + 1], right(&moments), &vs);
            for (index, plane) in data.iter().enumerate() {
                let moments = row_moments::<4>(&plane.values[at.clone()], powers);
                let sum = cell * data.len() + index;
                add(&mut sums[sum], left(&moments), &vs);
                add(&mut sums[sum + data.len()], right(&moments), &vs);
            }
        }
    }
    let both = masses.iter().zip(sums.chunks(data.len()));
    both.flat_map(|(mass, sums)| {
        let lower = Lower::of(mass);
        sums.iter().map(move |sums| lower.solve(sums))
    })
    .collect()
}

/// Sums of t^a times the numbers of a row of a cell.
fn row_moments<const N: usize>(line: &[f32], powers: &[[f32; 6]]) -> [f32; N] {
    let mut sums = [0.0; N];
    for (value, powers) in line.iter().zip(powers) {
        for (sum, power) in sums.iter_mut().zip(powers) {
            *sum += value * power;
        }
    }
    sums
}

/// Moments of u^a with the tent of the corner on the left: u = t, tent = 1 - t.
fn left<const M: usize, const N: usize>(m: &[f32; M]) -> [f32; N] {
    std::array::from_fn(|a| m[a] - m[a + 1])
}

/// Moments of u^a with the tent of the corner on the right: u = t - 1, tent = t.
fn right<const M: usize, const N: usize>(m: &[f32; M]) -> [f32; N] {
    const BINOMIAL: [[f32; 5]; 5] = [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, -2.0, 1.0, 0.0, 0.0],
        [-1.0, 3.0, -3.0, 1.0, 0.0],
        [1.0, -4.0, 6.0, -4.0, 1.0],
    ];
    std::array::from_fn(|a| (0..=a).map(|k| BINOMIAL[a][k] * m[k + 1]).sum())
}

/// Adds the moments of a row, times v^b, to those of a window.
fn add<const N: usize>(window: &mut [[f32; N]; N], row: [f32; N], vs: &[f32; 5]) {
    for (b, line) in window.iter_mut().enumerate() {
        for (sum, moment) in line.iter_mut().zip(&row[..N - b]) {
            *sum += vs[b] * moment;
        }
    }
}

/// The lower triangle of Cholesky's method over the functions of a window that are kept. The linear fit's is its leading part.
struct Lower {
    rows: [[f32; TERMS]; TERMS],
    /// 1 over the diagonal; 0 where the function is left out.
    inverse: [f32; TERMS],
}

impl Lower {
    fn of(mass: &[[f32; 5]; 5]) -> Self {
        let (mut rows, mut inverse) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
        for i in 0..TERMS {
            let gram = |j: usize| mass[POWERS[i][1] + POWERS[j][1]][POWERS[i][0] + POWERS[j][0]];
            let mut left = gram(i);
            for j in 0..i {
                let dot: f32 = (0..j).map(|k| rows[i][k] * rows[j][k]).sum();
                rows[i][j] = (gram(j) - dot) * inverse[j];
                left -= rows[i][j] * rows[i][j];
            }
            if left > DEPENDENT * gram(i) {
                rows[i][i] = left.sqrt();
                inverse[i] = 1.0 / rows[i][i];
            }
        }
        Self { rows, inverse }
    }

    /// The coefficients of the quadratic and of the linear fit.
    fn solve(&self, sums: &[[f32; 3]; 3]) -> Corner {
        let mut z = [0.0; TERMS];
        for i in 0..TERMS {
            let dot: f32 = (0..i).map(|k| self.rows[i][k] * z[k]).sum();
            z[i] = (sums[POWERS[i][1]][POWERS[i][0]] - dot) * self.inverse[i];
        }
        [TERMS, LINEAR].map(|terms| {
            let mut c = [0.0; TERMS];
            for i in (0..terms).rev() {
                let dot: f32 = (i + 1..terms).map(|k| self.rows[k][i] * c[k]).sum();
                c[i] = (z[i] - dot) * self.inverse[i];
            }
            c
        })
    }
}
