//! Smooth surfaces through the texels of a chart: polynomials over overlapping windows, blended.
//!
//! Corners stand `stride` texels apart. About each of them a polynomial is fitted to the texels of a window of `2 * stride` x
//! `2 * stride`, by least squares with the weights of a tent, (1 - |u|)(1 - |v|). A texel's value is the mean of its four corners'
//! polynomials with the same weights. These add up to 1 at every texel, so there are no seams between windows; and since the residuals
//! of each fit add up to 0 under its weights, those of the blend add up to 0 over the chart: smoothing moves no chart's mean.
//!
//! Where a chart bends, the functions of a fit are those of the place and the *features* of its texels ([`super::features`]), linearly.

use super::plane::{Plane, TASK};
use rayon::prelude::*;

/// Functions of the place: 1, u and v, which linear fits have, and u², uv and v².
const PLACES: usize = 6;
const LINEAR: usize = 3;
/// Features of a texel on a bent surface, which are functions beside those of the place.
pub(super) const FEATURES: usize = 4;

/// Exponents of u and v of each function of the place.
const POWERS: [[usize; 2]; PLACES] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// A function of the place, or a feature, whose part that the functions before it do not explain is below this share of its sum of squares
/// is left out.
const DEPENDENT: f32 = 1e-3;
const DEPENDENT_FEATURE: f32 = 1e-4;

/// Tents that a window holds for each function at least: so many that it has as many texels as functions, by the variance of a mean with
/// the weights of a tent. Full windows have that.
const TENT: f32 = 4.0 / 9.0;

/// Corners whose fits are held at a time: 9 MB, or 16 with features.
const CORNERS: usize = 1 << 17;

/// Fits of several planes alike, from the most functions to the fewest: quadratic, linear, and where there are features the fits that are
/// linear without them.
pub(super) type Fits = [Vec<Plane>; DEGREES];
pub(super) const DEGREES: usize = 3;

/// How many of the fits there are.
pub(super) fn degrees(features: &[Plane]) -> usize {
    if features.is_empty() { 2 } else { 3 }
}

/// A corner's fits of one plane. Of N functions the first are 1, u and v, then come the features, the last are u², uv and v².
type Corner<const N: usize> = [[f32; N]; DEGREES];

/// Fits windows of `stride` to the planes of `data` where `mask` is 1, into `out`.
///
/// * `features`: one plane each, 0 outside; all of [`FEATURES`] or none.
pub(super) fn fit(mask: &Plane, features: &[Plane], data: &[Plane], stride: usize, out: &mut Fits) {
    match features {
        [] => Fitter::<PLACES>::new(mask, features, data, stride).fit(out),
        _ => Fitter::<{ PLACES + FEATURES }>::new(mask, features, data, stride).fit(out),
    }
}

/// What windows of one stride are fitted to, by N functions.
struct Fitter<'a, const N: usize> {
    mask: &'a Plane,
    features: &'a [Plane],
    data: &'a [Plane],
    stride: usize,
    /// Of the place of each texel across a cell, 0..1.
    powers: Vec<Powers>,
}

/// The powers from 0 to 5 of a number.
type Powers = [f32; 6];

impl<'a, const N: usize> Fitter<'a, N> {
    fn new(mask: &'a Plane, features: &'a [Plane], data: &'a [Plane], stride: usize) -> Self {
        assert_eq!(features.len() + PLACES, N, "functions");
        let power = |i: usize| {
            let t = (i as f32 + 0.5) / stride as f32;
            let square = t * t;
            [
                1.0,
                t,
                square,
                square * t,
                square * square,
                square * square * t,
            ]
        };
        Self {
            mask,
            features,
            data,
            stride,
            powers: (0..stride).map(power).collect(),
        }
    }

    fn across(&self) -> usize {
        self.mask.width.div_ceil(self.stride) + 1
    }

    fn fit(&self, out: &mut Fits) {
        let (width, height, stride) = (self.mask.width, self.mask.height(), self.stride);
        let across = self.across();
        let down = height.div_ceil(stride) + 1;
        let rows = TASK.div_ceil(across * stride * stride);
        let planes = self.data.len();
        // Row after row of corners, the planes of each side by side; so many rows of cells at a time that corners need little room.
        let band = (CORNERS / (across * planes)).max(1);
        for first in (0..down - 1).step_by(band) {
            let last = (first + band).min(down - 1);
            let corners: Vec<Corner<N>> = (first..last + 1)
                .into_par_iter()
                .with_min_len(rows)
                .flat_map_iter(|row| self.corner_row(row))
                .collect();
            let texels = first * stride * width..(last * stride).min(height) * width;
            for (degree, fits) in out.iter_mut().enumerate().take(degrees(self.features)) {
                for (index, plane) in fits.iter_mut().enumerate() {
                    let of = |row: usize, cell: usize, j: usize, i: usize| {
                        let corner = (row + j) * across + cell + i;
                        &corners[corner * planes + index][degree]
                    };
                    let lines = plane.values[texels.clone()].par_chunks_mut(width);
                    let lines = lines.enumerate().with_min_len(TASK.div_ceil(width));
                    lines.for_each(|(line, values)| {
                        let row = texels.start / width + line;
                        let of = |cell, j, i| of(line / stride, cell, j, i);
                        self.line(row, of, values);
                    });
                }
            }
        }
    }

    /// A row of a blend, from the corners `of(cell, down, right)` about it.
    fn line<'b>(
        &self,
        row: usize,
        of: impl Fn(usize, usize, usize) -> &'b [f32; N],
        values: &mut [f32],
    ) {
        let width = self.mask.width;
        let q = self.powers[row % self.stride][1];
        let mask = &self.mask.values[row * width..][..width];
        let cells = values.chunks_mut(self.stride).zip(mask.chunks(self.stride));
        for (cell, (values, mask)) in cells.enumerate() {
            let corners = [
                [of(cell, 0, 0), of(cell, 0, 1)],
                [of(cell, 1, 0), of(cell, 1, 1)],
            ];
            let c = blend(corners, q);
            for ((value, mask), [_, t, ..]) in values.iter_mut().zip(mask).zip(&self.powers) {
                *value = mask * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
            }
            for (f, feature) in self.features.iter().enumerate() {
                let [left, right] = [0, 1].map(|i| {
                    let [above, below] = [0, 1].map(|j| corners[j][i][LINEAR + f]);
                    (1.0 - q) * above + q * below
                });
                let feature = &feature.values[row * width + cell * self.stride..];
                for ((value, feature), [_, t, ..]) in
                    values.iter_mut().zip(feature).zip(&self.powers)
                {
                    *value += feature * (left + t * (right - left));
                }
            }
        }
    }

    /// The fits of one row of corners.
    fn corner_row(&self, row: usize) -> Vec<Corner<N>> {
        let (width, height, stride) = (self.mask.width, self.mask.height(), self.stride);
        let (across, planes, features) = (self.across(), self.data.len(), self.features.len());
        // Sums of tent u^a v^b over each window: of the mask for a + b <= 4, of features and planes for a + b <= 2.
        let mut masses = vec![[[0.0; 5]; 5]; across];
        let mut sums = vec![[[0.0; 3]; 3]; across * (features + planes)];
        // Sums of the tent times features, by themselves and by the planes.
        let mut products = vec![[0.0; FEATURES]; across * (features + planes)];
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
                let moments = row_moments::<6>(&self.mask.values[at.clone()], &self.powers);
                if moments[0] == 0.0 {
                    continue;
                }
                add(&mut masses[cell], left(&moments), &vs);
                add(&mut masses[cell + 1], right(&moments), &vs);
                let lines = self.features.iter().chain(self.data);
                for (index, plane) in lines.enumerate() {
                    let line = &plane.values[at.clone()];
                    let moments = row_moments::<4>(line, &self.powers);
                    let [here, next] =
                        [cell, cell + 1].map(|cell| cell * (features + planes) + index);
                    add(&mut sums[here], left(&moments), &vs);
                    add(&mut sums[next], right(&moments), &vs);
                    // Those after it are found by symmetry.
                    for (f, feature) in self.features.iter().enumerate().take(index + 1) {
                        let (mut all, mut toward) = (0.0, 0.0);
                        for ((a, b), [_, t, ..]) in line
                            .iter()
                            .zip(&feature.values[at.clone()])
                            .zip(&self.powers)
                        {
                            all += a * b;
                            toward += a * b * t;
                        }
                        products[here][f] += tent * (all - toward);
                        products[next][f] += tent * toward;
                    }
                }
            }
        }
        let each = features + planes;
        let corners = masses
            .iter()
            .zip(sums.chunks(each))
            .zip(products.chunks(each));
        corners
            .flat_map(|((mass, sums), products)| {
                let lower = Lower::<N>::of(mass, &sums[..features], &products[..features]);
                let planes = sums[features..].iter().zip(&products[features..]);
                planes.map(move |(sums, products)| lower.solve(sums, products))
            })
            .collect()
    }
}

/// The blend of four corners' polynomials along a row of their cell, as a cubic of the column, 0..1; `q`: the row, 0..1.
fn blend<const N: usize>(corners: [[&[f32; N]; 2]; 2], q: f32) -> [f32; 4] {
    let mut side = [[0.0; 3]; 2];
    for (j, (tent, v)) in [(1.0 - q, q), (q, q - 1.0)].into_iter().enumerate() {
        for (i, sum) in side.iter_mut().enumerate() {
            let c = corners[j][i];
            let square = &c[N - 3..];
            sum[0] += tent * (c[0] + v * (c[2] + v * square[2]));
            sum[1] += tent * (c[1] + v * square[1]);
            sum[2] += tent * square[0];
        }
    }
    // (1 - t) a(t) + t b(t - 1)
    let [a, b] = side;
    let b = [b[0] - b[1] + b[2], b[1] - 2.0 * b[2], b[2]];
    [a[0], a[1] - a[0] + b[0], a[2] - a[1] + b[1], b[2] - a[2]]
}

/// Sums of t^a times the numbers of a row of a cell.
fn row_moments<const M: usize>(line: &[f32], powers: &[Powers]) -> [f32; M] {
    let mut sums = [0.0; M];
    for (value, powers) in line.iter().zip(powers) {
        for (sum, power) in sums.iter_mut().zip(powers) {
            *sum += value * power;
        }
    }
    sums
}

/// Moments of u^a with the tent of the corner on the left: u = t, tent = 1 - t.
fn left<const M: usize, const L: usize>(m: &[f32; M]) -> [f32; L] {
    std::array::from_fn(|a| m[a] - m[a + 1])
}

/// Moments of u^a with the tent of the corner on the right: u = t - 1, tent = t.
fn right<const M: usize, const L: usize>(m: &[f32; M]) -> [f32; L] {
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
fn add<const L: usize>(window: &mut [[f32; L]; L], row: [f32; L], vs: &[f32; 5]) {
    for (b, line) in window.iter_mut().enumerate() {
        for (sum, moment) in line.iter_mut().zip(&row[..L - b]) {
            *sum += vs[b] * moment;
        }
    }
}

/// A function of a fit, by its exponents or by its number among the features.
enum Function {
    Place([usize; 2]),
    Feature(usize),
}

/// Function `number` of N.
fn function<const N: usize>(number: usize) -> Function {
    let features = N - PLACES;
    match number.checked_sub(LINEAR) {
        None => Function::Place(POWERS[number]),
        Some(feature) if feature < features => Function::Feature(feature),
        Some(_) => Function::Place(POWERS[number - features]),
    }
}

/// The lower triangle of Cholesky's method over the functions of a window that are kept. That of fewer functions is its leading part.
struct Lower<const N: usize> {
    rows: [[f32; N]; N],
    /// 1 over the diagonal; 0 where the function is left out.
    inverse: [f32; N],
}

impl<const N: usize> Lower<N> {
    /// * `mass`: moments of the mask.
    /// * `sums`, `products`: of each feature, its moments, and with the features up to itself.
    fn of(mass: &[[f32; 5]; 5], sums: &[[[f32; 3]; 3]], products: &[[f32; FEATURES]]) -> Self {
        let gram = |i: usize, j: usize| match (function::<N>(i), function::<N>(j)) {
            (Function::Place([a, b]), Function::Place([c, d])) => mass[b + d][a + c],
            (Function::Place([a, b]), Function::Feature(f))
            | (Function::Feature(f), Function::Place([a, b])) => sums[f][b][a],
            (Function::Feature(f), Function::Feature(g)) => products[f.max(g)][f.min(g)],
        };
        let (mut rows, mut inverse) = ([[0.0; N]; N], [0.0; N]);
        for i in 0..N {
            let own = gram(i, i);
            let mut left = own;
            for j in 0..i {
                let dot: f32 = (0..j).map(|k| rows[i][k] * rows[j][k]).sum();
                rows[i][j] = (gram(i, j) - dot) * inverse[j];
                left -= rows[i][j] * rows[i][j];
            }
            let dependent = match function::<N>(i) {
                Function::Place(_) => DEPENDENT,
                Function::Feature(_) => DEPENDENT_FEATURE,
            };
            let is_room = i < LINEAR || mass[0][0] > TENT * (i + 1) as f32;
            if left > dependent * own && is_room {
                rows[i][i] = left.sqrt();
                inverse[i] = 1.0 / rows[i][i];
            }
        }
        Self { rows, inverse }
    }

    /// The coefficients of each fit of a plane.
    ///
    /// * `sums`, `products`: its moments, and with the features.
    fn solve(&self, sums: &[[f32; 3]; 3], products: &[f32; FEATURES]) -> Corner<N> {
        let mut z = [0.0; N];
        for i in 0..N {
            let dot: f32 = (0..i).map(|k| self.rows[i][k] * z[k]).sum();
            let sum = match function::<N>(i) {
                Function::Place([a, b]) => sums[b][a],
                Function::Feature(f) => products[f],
            };
            z[i] = (sum - dot) * self.inverse[i];
        }
        let plain = if N > PLACES { LINEAR } else { 0 };
        [N, N - (PLACES - LINEAR), plain].map(|functions| {
            let mut c = [0.0; N];
            for i in (0..functions).rev() {
                let dot: f32 = (i + 1..functions).map(|k| self.rows[k][i] * c[k]).sum();
                c[i] = (z[i] - dot) * self.inverse[i];
            }
            c
        })
    }
}
