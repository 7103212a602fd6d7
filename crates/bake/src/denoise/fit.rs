//! Smooth surfaces through the texels of a chart: polynomials over overlapping windows, blended.
//!
//! Corners stand `stride` texels apart. About each of them a polynomial is fitted to the texels of a window of `2 *
//! stride` x `2 * stride`, by least squares with the weights of a tent, (1 - |u|)(1 - |v|). A texel's value is the mean
//! of its four corners' polynomials with the same weights. These add up to 1 at every texel, so there are no seams
//! between windows; and since the residuals of each fit add up to 0 under its weights, those of the blend add up to 0
//! over the chart: smoothing moves no chart's mean.
//!
//! Where a chart bends, the functions of a fit are those of the place and the *features* of its texels
//! ([`super::features`]), linearly.
//!
//! All that a fit needs are *moments*: sums over the cells between corners of t^i q^j, by the place in the cell, 0..1
//! across and down. Those of a cell follow from those of its four quarters, so texels are summed once for all strides.

// Indices are those of the mathematics.
#![allow(clippy::needless_range_loop)]

use super::lanes::{LANES, Lanes};
use super::plane::{Sheet, rows};

/// Functions of the place: 1, u and v, which linear fits have, and u², uv and v².
const PLACES: usize = 6;
const LINEAR: usize = 3;
/// Features of a texel on a bent surface, which are functions beside those of the place.
pub(super) const FEATURES: usize = 4;

/// Exponents of u and v of each function of the place.
const POWERS: [[usize; 2]; PLACES] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// A function of the place, or a feature, whose part that the functions before it do not explain is below this share of
/// its sum of squares is left out.
const DEPENDENT: f32 = 1e-3;
const DEPENDENT_FEATURE: f32 = 1e-4;

/// Tents that a window holds for each function at least: so many that it has as many texels as functions, by the
/// variance of a mean with the weights of a tent. Full windows have that.
const TENT: f32 = 4.0 / 9.0;

/// Powers across and down of which a cell has the moments: of the mask, of a plane, and of the product of two.
const MASK: usize = 6;
const PLANE: usize = 4;
const PRODUCT: usize = 2;

/// The least stride.
const LEAST: usize = 2;

const BINOMIAL: [[f32; MASK]; MASK] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0, 0.0],
    [1.0, 5.0, 10.0, 10.0, 5.0, 1.0],
];

/// Powers of the middles of two halves of a cell.
const NEAR: [f32; MASK] = powers(0.25);
const FAR: [f32; MASK] = powers(0.75);
const HALF: [f32; MASK] = powers(0.5);

const fn powers(of: f32) -> [f32; MASK] {
    let mut powers = [1.0; MASK];
    let mut i = 1;
    while i < MASK {
        powers[i] = powers[i - 1] * of;
        i += 1;
    }
    powers
}

/// A chart, or a band of one, ready to be fitted.
#[derive(Debug)]
pub(super) struct Surface {
    /// 1 where it has texels; of those that something seals in part, what is left.
    pub mask: Sheet,
    /// What fits may follow beside the place: [`FEATURES`] planes or none.
    pub features: Option<Sheet>,
    /// The channels of the mean of two halves of the rays, then the mean channel of half their difference.
    pub data: Sheet,
    /// Standard errors of the plain values.
    pub errors: Sheet,
}

impl Surface {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.mask.width, self.mask.height()]
    }
}

/// Fits over a surface, from the least stride to wider ones.
pub(super) struct Fitter<'a> {
    surface: &'a Surface,
    stride: usize,
    /// The moments of all cells of the last stride; none of the least, whose cells are summed when they are needed.
    cells: Vec<f32>,
}

/// How a row of cells is laid out: moment by moment, each with a cell without texels at both ends.
#[derive(Clone, Copy)]
struct Layout {
    features: usize,
    planes: usize,
    cells: usize,
    /// Numbers of a moment's row.
    room: usize,
}

impl Layout {
    fn of(surface: &Surface, stride: usize) -> Self {
        let cells = surface.mask.width.div_ceil(stride);
        Self {
            features: surface.features.as_ref().map_or(0, |sheet| sheet.planes),
            planes: surface.data.planes,
            cells,
            room: (cells + 2).next_multiple_of(LANES) + LANES,
        }
    }

    /// The first moment of a feature's or a plane's.
    #[inline(always)]
    fn line(&self, line: usize) -> usize {
        MASK * MASK + line * PLANE * PLANE
    }

    /// The first moment of the product of a line with a feature not after it.
    #[inline(always)]
    fn product(&self, line: usize, feature: usize) -> usize {
        let before = match line.checked_sub(self.features) {
            None => line * (line + 1) / 2,
            Some(plane) => self.features * (self.features + 1) / 2 + plane * self.features,
        };
        self.line(self.features + self.planes) + (before + feature) * PRODUCT * PRODUCT
    }

    fn moments(&self) -> usize {
        self.product(self.features + self.planes, 0)
    }

    /// Numbers of a row of cells.
    fn row(&self) -> usize {
        self.moments() * self.room
    }

    /// Lanes of a moment from the cell before cell `at` on.
    #[inline(always)]
    fn load(&self, row: &[f32], moment: usize, at: usize) -> Lanes {
        Lanes::load(row, moment * self.room + at)
    }

    #[inline(always)]
    fn store(&self, row: &mut [f32], moment: usize, cell: usize, lanes: Lanes) {
        lanes.store(row, moment * self.room + 1 + cell);
    }
}

impl<'a> Fitter<'a> {
    pub fn new(surface: &'a Surface) -> Self {
        Self {
            surface,
            stride: LEAST,
            cells: Vec::new(),
        }
    }

    /// Fits windows of `stride`, which is at least the last one, by quadratic and linear polynomials, where each is
    /// wanted.
    pub fn fit(&mut self, stride: usize, out: [(bool, &mut Sheet); 2]) {
        while self.stride < stride {
            self.widen();
        }
        match self.surface.features {
            None => self.fit_by::<PLACES>(out),
            Some(_) => self.fit_by::<{ PLACES + FEATURES }>(out),
        }
    }

    /// Goes on to cells of twice the size.
    fn widen(&mut self) {
        let [_, height] = self.surface.size();
        let stride = 2 * self.stride;
        let [fine, layout] = [self.stride, stride].map(|stride| Layout::of(self.surface, stride));
        let count = height.div_ceil(stride);
        let mut cells = vec![0.0; count * layout.row()];
        rows(
            count,
            1,
            [&mut cells],
            #[inline(always)]
            |first, [cells]| {
                let mut room = [0; 2].map(|_| vec![0.0; fine.row()]);
                for (row, out) in cells.chunks_exact_mut(layout.row()).enumerate() {
                    for (k, room) in room.iter_mut().enumerate() {
                        self.sum_texels(&fine, 2 * (first + row) + k, room);
                    }
                    let quarters = self.cells([0, 1].map(|k| Some(2 * (first + row) + k)), &room);
                    merge(&fine, &layout, quarters, out);
                }
            },
        );
        (self.stride, self.cells) = (stride, cells);
    }

    /// The moments of two rows of cells, where they are not in `room`; there is none beyond the last.
    #[inline(always)]
    fn cells<'b>(&'b self, rows: [Option<usize>; 2], room: &'b [Vec<f32>; 2]) -> [&'b [f32]; 2] {
        let [mut above, mut below] = [&room[0][..], &room[1][..]];
        if self.stride > LEAST {
            let length = above.len();
            let stored = |row: usize| self.cells.get(row * length..(row + 1) * length);
            (above, below) = (
                rows[0].and_then(stored).unwrap_or(above),
                rows[1].and_then(stored).unwrap_or(below),
            );
        }
        [above, below]
    }

    /// Sums the texels of a row of cells of the least stride; nothing of wider ones, which are stored.
    #[inline(always)]
    fn sum_texels(&self, layout: &Layout, row: usize, out: &mut [f32]) {
        if self.stride > LEAST {
            return;
        }
        let height = self.surface.mask.height();
        let texels = |sheet: &Sheet, plane: usize, at: usize| -> Quarters {
            let below = match LEAST * row + 1 {
                y if y < height => sheet.row(plane, y),
                _ => &[],
            };
            let above = match LEAST * row {
                y if y < height => sheet.row(plane, y),
                _ => &[],
            };
            [
                Lanes::load_pairs(above, LEAST * at),
                Lanes::load_pairs(below, LEAST * at),
            ]
        };
        for at in (0..layout.cells).step_by(LANES) {
            let mask = texels(&self.surface.mask, 0, at);
            sum::<MASK>(layout, mask, 0, at, out);
            let mut features = [mask; FEATURES];
            for line in 0..layout.features + layout.planes {
                let (own, known) = match (&self.surface.features, line.checked_sub(layout.features))
                {
                    (Some(sheet), None) => {
                        features[line] = texels(sheet, line, at);
                        (times(features[line], mask), line + 1)
                    }
                    (_, plane) => {
                        let plane = texels(&self.surface.data, plane.unwrap_or(0), at);
                        (plane, layout.features)
                    }
                };
                sum::<PLANE>(layout, own, layout.line(line), at, out);
                for (number, feature) in features.iter().enumerate().take(known) {
                    let product = times(own, *feature);
                    sum::<PRODUCT>(layout, product, layout.product(line, number), at, out);
                }
            }
        }
    }

    fn fit_by<const N: usize>(&self, out: [(bool, &mut Sheet); 2]) {
        let [width, height] = self.surface.size();
        let stride = self.stride;
        let layout = Layout::of(self.surface, stride);
        let planes = layout.planes;
        let wanted = out.each_ref().map(|(is_wanted, _)| *is_wanted);
        let out = out.map(|(is_wanted, sheet)| match is_wanted {
            true => &mut sheet.values[..],
            false => &mut [],
        });
        rows(
            height,
            stride,
            out,
            #[inline(always)]
            |first, mut out| {
                let of_row = planes * width;
                let count = out.iter().map(|out| out.len()).max().unwrap_or(0) / of_row;
                let mut room = [0; 2].map(|_| vec![0.0; layout.row()]);
                let corners = 2 * planes * N * layout.room;
                let [mut upper, mut lower] = [0, 1].map(|_| vec![0.0; corners]);
                let mut line = Line::<N>::new(&layout, width);
                // The cells above the first row, those of it, and so on; from the second on the corners above them,
                // then texels.
                for step in 0..count.div_ceil(stride) + 2 {
                    let row = first / stride + step;
                    room.swap(0, 1);
                    match row.checked_sub(1) {
                        Some(row) => self.sum_texels(&layout, row, &mut room[1]),
                        None => room[1].fill(0.0),
                    }
                    if step == 0 {
                        continue;
                    }
                    std::mem::swap(&mut upper, &mut lower);
                    let cells = self.cells([row.checked_sub(2), Some(row - 1)], &room);
                    solve_row::<N>(&layout, cells, wanted, &mut lower);
                    let Some(start) = step.checked_sub(2).map(|cell| cell * stride) else {
                        continue;
                    };
                    for y in start..(start + stride).min(count) {
                        let q = (y - start) as f32 + 0.5;
                        for (degree, out) in out.iter_mut().enumerate() {
                            let out = out.get_mut(y * of_row..(y + 1) * of_row);
                            let lines = out.into_iter().flat_map(|out| out.chunks_mut(width));
                            for (plane, values) in lines.enumerate() {
                                let at = (degree * planes + plane) * N * layout.room;
                                let corners =
                                    [&upper, &lower].map(|row| &row[at..at + N * layout.room]);
                                line.blend(&layout, degree, corners, q / stride as f32);
                                line.write(self.surface, first + y, stride, values);
                            }
                        }
                    }
                }
            },
        );
    }
}

/// Numbers of the four quarters of cells: down, then across.
type Quarters = [[Lanes; 2]; 2];

#[inline(always)]
fn times(mut a: Quarters, b: Quarters) -> Quarters {
    for j in 0..2 {
        for i in 0..2 {
            a[j][i] = a[j][i] * b[j][i];
        }
    }
    a
}

/// The moments of N powers of cells whose quarters are single texels.
#[inline(always)]
fn sum<const N: usize>(layout: &Layout, of: Quarters, moment: usize, at: usize, out: &mut [f32]) {
    for j in 0..N {
        let left = of[0][0] * NEAR[j] + of[1][0] * FAR[j];
        let right = of[0][1] * NEAR[j] + of[1][1] * FAR[j];
        for i in 0..N {
            let sum = left * NEAR[i] + right * FAR[i];
            layout.store(out, moment + j * N + i, at, sum);
        }
    }
}

/// The moments of a row of cells from those of two rows of their quarters.
#[inline(always)]
fn merge(fine: &Layout, layout: &Layout, quarters: [&[f32]; 2], out: &mut [f32]) {
    let lines = layout.features + layout.planes;
    for at in (0..layout.cells).step_by(LANES) {
        merge_line::<MASK>(fine, layout, quarters, 0, at, out);
        for line in 0..lines {
            merge_line::<PLANE>(fine, layout, quarters, layout.line(line), at, out);
        }
        let products = layout.product(0, 0)..layout.moments();
        for moment in products.step_by(PRODUCT * PRODUCT) {
            merge_line::<PRODUCT>(fine, layout, quarters, moment, at, out);
        }
    }
}

#[inline(always)]
fn merge_line<const N: usize>(
    fine: &Layout,
    layout: &Layout,
    quarters: [&[f32]; 2],
    moment: usize,
    at: usize,
    out: &mut [f32],
) {
    // A place of a quarter is half as far from its beginning, and the second begins in the middle.
    let mut halves = [[[Lanes::ZERO; N]; N]; 2];
    for (quarters, halves) in quarters.into_iter().zip(&mut halves) {
        for (j, half) in halves.iter_mut().enumerate() {
            let mut pairs = [[Lanes::ZERO; N]; 2];
            for i in 0..N {
                let row = &quarters[(moment + j * N + i) * fine.room..][..fine.room];
                let [left, right] = Lanes::load_pairs(row, 1 + 2 * at);
                (pairs[0][i], pairs[1][i]) = (left, right);
            }
            for (i, half) in half.iter_mut().enumerate() {
                *half = joined(i, pairs[0][i], &pairs[1]);
            }
        }
    }
    for i in 0..N {
        let mut below = [Lanes::ZERO; N];
        for (below, half) in below.iter_mut().zip(&halves[1]) {
            *below = half[i];
        }
        for j in 0..N {
            let sum = joined(j, halves[0][j][i], &below);
            layout.store(out, moment + j * N + i, at, sum);
        }
    }
}

#[inline(always)]
fn joined(power: usize, first: Lanes, second: &[Lanes]) -> Lanes {
    let mut sum = first;
    for (second, times) in second.iter().zip(BINOMIAL[power]).take(power + 1) {
        sum += *second * times;
    }
    sum * HALF[power]
}

/// The fits of a row of corners between two rows of cells: of each degree and plane the coefficients, each of all
/// corners.
#[inline(always)]
fn solve_row<const N: usize>(
    layout: &Layout,
    cells: [&[f32]; 2],
    wanted: [bool; 2],
    out: &mut [f32],
) {
    let features = N - PLACES;
    for at in (0..layout.cells + 1).step_by(LANES) {
        let mass = windows::<MASK, 5>(layout, cells, 0, at);
        let of_line = |line: usize| windows::<PLANE, 3>(layout, cells, layout.line(line), at);
        let product = |line: usize, feature: usize| {
            windows::<PRODUCT, 1>(layout, cells, layout.product(line, feature), at)[0][0]
        };
        // Products of functions: features stand between those that are linear in the place and those that are
        // quadratic.
        let place = |number: usize| match number < LINEAR {
            true => number,
            false => number + features,
        };
        let mut gram = [[Lanes::ZERO; N]; N];
        for (i, [a, b]) in POWERS.into_iter().enumerate() {
            for (j, [c, d]) in POWERS.into_iter().enumerate().take(i + 1) {
                gram[place(i)][place(j)] = mass[b + d][a + c];
            }
        }
        for feature in 0..features {
            let sums = of_line(feature);
            for (number, [a, b]) in POWERS.into_iter().enumerate() {
                let (i, j) = (LINEAR + feature, place(number));
                gram[i.max(j)][i.min(j)] = sums[b][a];
            }
            for other in 0..=feature {
                gram[LINEAR + feature][LINEAR + other] = product(feature, other);
            }
        }
        let lower = Lower::of(gram, mass[0][0]);
        for plane in 0..layout.planes {
            let sums = of_line(features + plane);
            let mut of = [Lanes::ZERO; N];
            for (number, [a, b]) in POWERS.into_iter().enumerate() {
                of[place(number)] = sums[b][a];
            }
            for feature in 0..features {
                of[LINEAR + feature] = product(features + plane, feature);
            }
            let z = lower.forward(of);
            for degree in (0..2).filter(|degree| wanted[*degree]) {
                let functions = N - degree * (PLACES - LINEAR);
                let of = lower.back(&z, functions);
                for (number, lanes) in of.into_iter().enumerate().take(functions) {
                    let row = (degree * layout.planes + plane) * N + number;
                    lanes.store(out, row * layout.room + at);
                }
            }
        }
    }
}

/// Sums of tent u^a v^b over the windows of corners, for a + b < A, of the moments of N = A + 1 powers that begin with
/// `moment`.
#[inline(always)]
fn windows<const N: usize, const A: usize>(
    layout: &Layout,
    cells: [&[f32]; 2],
    moment: usize,
    at: usize,
) -> [[Lanes; A]; A] {
    // From the cells on the left and on the right, then from those above and below: u = t - 1, tent = t, and u = t,
    // tent = 1 - t.
    let mut sides = [[[Lanes::ZERO; A]; N]; 2];
    for (side, cells) in sides.iter_mut().zip(cells) {
        for (j, side) in side.iter_mut().enumerate() {
            let mut both = [[Lanes::ZERO; N]; 2];
            for i in 0..N {
                let moment = moment + j * N + i;
                both[0][i] = layout.load(cells, moment, at);
                both[1][i] = layout.load(cells, moment, at + 1);
            }
            for (a, side) in side.iter_mut().enumerate().take(N - j) {
                *side = about(a, &both[0], &both[1]);
            }
        }
    }
    let mut windows = [[Lanes::ZERO; A]; A];
    for a in 0..A {
        let mut both = [[Lanes::ZERO; N]; 2];
        for j in 0..N {
            (both[0][j], both[1][j]) = (sides[0][j][a], sides[1][j][a]);
        }
        for (b, windows) in windows.iter_mut().enumerate().take(A - a) {
            windows[a] = about(b, &both[0], &both[1]);
        }
    }
    windows
}

#[inline(always)]
fn about(power: usize, before: &[Lanes], after: &[Lanes]) -> Lanes {
    let mut sum = after[power] - after[power + 1];
    for k in 0..=power {
        let sign = if (power - k).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        sum += before[k + 1] * (sign * BINOMIAL[power][k]);
    }
    sum
}

/// The lower triangle of Cholesky's method over the functions of windows that are kept. That of fewer functions is its
/// leading part.
struct Lower<const N: usize> {
    rows: [[Lanes; N]; N],
    /// 1 over the diagonal; 0 where the function is left out.
    inverse: [Lanes; N],
}

impl<const N: usize> Lower<N> {
    #[inline(always)]
    fn of(gram: [[Lanes; N]; N], mass: Lanes) -> Self {
        let (mut rows, mut inverse) = (gram, [Lanes::ZERO; N]);
        for i in 0..N {
            let own = gram[i][i];
            let mut left = own;
            for j in 0..i {
                let mut rest = rows[i][j];
                for k in 0..j {
                    rest = rest - rows[i][k] * rows[j][k];
                }
                rows[i][j] = rest * inverse[j];
                left = left - rows[i][j] * rows[i][j];
            }
            let is_feature = (LINEAR..LINEAR + N - PLACES).contains(&i);
            let dependent = if is_feature {
                DEPENDENT_FEATURE
            } else {
                DEPENDENT
            };
            let least = if i < LINEAR {
                0.0
            } else {
                TENT * (i + 1) as f32
            };
            for lane in 0..LANES {
                let left = left.0[lane];
                let is_kept = (left > dependent * own.0[lane]) & (mass.0[lane] > least);
                let root = 1.0 / left.sqrt();
                inverse[i].0[lane] = if is_kept { root } else { 0.0 };
            }
        }
        Self { rows, inverse }
    }

    #[inline(always)]
    fn forward(&self, of: [Lanes; N]) -> [Lanes; N] {
        let mut z = of;
        for i in 0..N {
            for k in 0..i {
                z[i] = z[i] - self.rows[i][k] * z[k];
            }
            z[i] = z[i] * self.inverse[i];
        }
        z
    }

    /// The coefficients of the first functions.
    #[inline(always)]
    fn back(&self, z: &[Lanes; N], functions: usize) -> [Lanes; N] {
        let mut c = *z;
        for i in (0..functions).rev() {
            for k in i + 1..functions {
                c[i] = c[i] - self.rows[k][i] * c[k];
            }
            c[i] = c[i] * self.inverse[i];
        }
        c
    }
}

/// A row of a blend: the polynomials of corners at one place down, and those of the cells between them across.
struct Line<const N: usize> {
    /// Numbers of a coefficient's row.
    room: usize,
    /// By corners: the coefficients of 1, u, u² and of the features.
    corners: Vec<f32>,
    /// By cells: those of 1, t, t², t³, then of 1 and t of each feature.
    cells: Vec<f32>,
    /// A row of texels.
    texels: Vec<f32>,
}

/// Coefficients of the place of a corner along a row, and of a cell.
const ALONG: usize = 3;
const BETWEEN: usize = 4;

impl<const N: usize> Line<N> {
    fn new(layout: &Layout, width: usize) -> Self {
        Self {
            room: layout.room,
            corners: vec![0.0; (ALONG + FEATURES) * layout.room],
            cells: vec![0.0; (BETWEEN + 2 * FEATURES) * layout.room],
            texels: vec![0.0; width],
        }
    }

    /// Blends the fits of two rows of corners at the place `q` down between them, 0..1.
    #[inline(always)]
    fn blend(&mut self, layout: &Layout, degree: usize, corners: [&[f32]; 2], q: f32) {
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
    fn write(&mut self, surface: &Surface, y: usize, stride: usize, out: &mut [f32]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: usize = 96;
    const STRIDES: [usize; 5] = [2, 4, 8, 16, 32];

    /// A surface with these numbers by column and row, and features where they are asked for.
    fn surface(
        is_bent: bool,
        mask: impl Fn([usize; 2]) -> f32,
        value: impl Fn([usize; 2]) -> f32,
    ) -> Surface {
        let sheet = |planes: usize, of: &dyn Fn(usize, [usize; 2]) -> f32| {
            let mut sheet = Sheet::new([EDGE; 2], planes);
            for y in 0..EDGE {
                for plane in 0..planes {
                    let row = sheet.row_mut(plane, y).iter_mut().enumerate();
                    row.for_each(|(x, value)| *value = mask([x, y]) * of(plane, [x, y]));
                }
            }
            sheet
        };
        Surface {
            mask: sheet(1, &|_, _| 1.0),
            features: is_bent.then(|| sheet(FEATURES, &|plane, at| feature(plane, at))),
            data: sheet(2, &|plane, at| value(at) * (1 - 3 * plane as i32) as f32),
            errors: sheet(1, &|_, _| 0.0),
        }
    }

    fn feature(plane: usize, [x, y]: [usize; 2]) -> f32 {
        let (x, y) = (x as f32, y as f32);
        [
            (0.7 * x).sin(),
            (0.9 * y).cos(),
            (0.4 * x + 0.8 * y).sin(),
            (1.1 * x - y).cos(),
        ][plane]
    }

    /// Fits of one degree for each stride, with the largest difference from the data one stride or more inside of
    /// the square.
    fn fits(surface: &Surface, degree: usize) -> Vec<(usize, Sheet, f32)> {
        let mut fitter = Fitter::new(surface);
        let fit = |stride: usize| {
            let mut out = [0; 2].map(|_| Sheet::new([EDGE; 2], 2));
            let [quadratic, linear] = out.each_mut();
            fitter.fit(stride, [(degree == 0, quadratic), (degree == 1, linear)]);
            let [quadratic, linear] = out;
            let out = if degree == 0 { quadratic } else { linear };
            let inside = stride..EDGE - stride;
            let all = inside
                .clone()
                .flat_map(|y| inside.clone().map(move |x| [x, y]));
            let off =
                all.flat_map(|at| [0, 1].map(|k| (out.at(k, at) - surface.data.at(k, at)).abs()));
            let off = off.fold(0.0, f32::max);
            (stride, out, off)
        };
        STRIDES.map(fit).into()
    }

    #[test]
    fn polynomials_and_features_are_their_own_fits_at_every_stride() {
        let place = |[x, y]: [usize; 2]| [x, y].map(|v| v as f32 / EDGE as f32);
        let plane = move |at: [usize; 2]| {
            let [u, v] = place(at);
            0.2 + 0.5 * u - 0.3 * v
        };
        let curved = move |at: [usize; 2]| {
            let [u, v] = place(at);
            plane(at) + 0.4 * u * u - 0.6 * u * v + 0.3 * v * v
        };
        let bent = move |at: [usize; 2]| {
            let features: f32 = (0..FEATURES)
                .map(|k| 0.1 * (k + 1) as f32 * feature(k, at))
                .sum();
            plane(at) + features
        };
        for (name, degree, surface) in [
            ("a quadratic", 0, surface(false, |_| 1.0, curved)),
            ("a plane", 1, surface(false, |_| 1.0, plane)),
            ("features", 1, surface(true, |_| 1.0, bent)),
        ] {
            for (stride, _, off) in fits(&surface, degree) {
                // Four texels, or sixteen, are fewer than what features need.
                let is_known = name != "features" || stride > 4;
                assert!(
                    !is_known || off < 2e-4,
                    "{name} by {off} at stride {stride}"
                );
            }
        }
    }

    #[test]
    fn no_fit_moves_the_sum_of_what_it_is_fitted_to() {
        // A chart with a hole and a ragged border, and numbers without any order.
        let mask = |[x, y]: [usize; 2]| {
            let [a, b] = [x, y].map(|v| v as f32 - 40.0);
            let is_in = a.hypot(b) < 38.0 + 4.0 * (0.3 * b).sin() && (a - 9.0).hypot(b - 5.0) > 7.0;
            f32::from(u8::from(is_in))
        };
        let value = |[x, y]: [usize; 2]| ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
        for is_bent in [false, true] {
            let surface = surface(is_bent, mask, value);
            let sum = |sheet: &Sheet| -> f64 {
                let rows = (0..EDGE).flat_map(|y| sheet.row(0, y));
                rows.map(|value| f64::from(*value)).sum()
            };
            let truth = sum(&surface.data);
            for degree in [0, 1] {
                for (stride, out, _) in fits(&surface, degree) {
                    // Rounding of some thousand numbers, in equations whose pivots are a thousandth of their
                    // diagonal at least.
                    let moved = sum(&out) / truth - 1.0;
                    assert!(
                        moved.abs() < 2e-4,
                        "by {moved}, stride {stride}, degree {degree}"
                    );
                }
            }
        }
    }
}
