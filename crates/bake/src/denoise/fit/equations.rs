//! The fits of a row of corners: the normal equations of their windows, solved by Cholesky's method.

use super::moments::{BINOMIAL, MASK, MomentRows, PLANE, PRODUCT};
use crate::denoise::lanes::{LANES, Lanes};

/// Functions of the place: 1, u and v, which linear fits have, and u², uv and v².
pub(super) const PLACES: usize = 6;
const LINEAR: usize = 3;

/// Exponents of u and v of each function of the place.
const POWERS: [[usize; 2]; PLACES] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// A function of the place, or a feature, whose part that the functions before it do not explain is below this share of
/// its sum of squares is left out.
const DEPENDENT: f32 = 1e-3;
const DEPENDENT_FEATURE: f32 = 1e-4;

/// Tents that a window holds for each function at least: so many that it has as many texels as functions, by the
/// variance of a mean with the weights of a tent. Full windows have that.
const TENT: f32 = 4.0 / 9.0;

/// The fits of a row of corners between two rows of cells: of each degree and plane the coefficients, each of all
/// corners.
#[inline(always)]
pub(super) fn solve_row<const N: usize>(
    layout: &MomentRows,
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
    layout: &MomentRows,
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
