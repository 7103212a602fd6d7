//! What is known of the texels of a row while candidates are tried, and how these are weighed.

use super::lanes::{larger, smaller};
use super::plane::Sheet;
use super::surface::SurfaceTerm;

/// Planes of what is known of texels while candidates are tried: sums over the candidates by their weights, of the
/// weights, of variances and of halves; variance and squared bias of the last candidate; and sums of the channels by
/// the weights.
pub(super) const WEIGHTS: usize = 0;
pub(super) const VARIANCES: usize = 1;
pub(super) const HALVES: usize = 2;
pub(super) const VARIANCE: usize = 3;
pub(super) const VALUES: usize = 5;

/// A row of a sheet: its first planes, then the rest.
pub(super) struct Planes<'a, const N: usize>(pub [&'a mut [f32]; N], pub &'a mut [f32]);

#[inline(always)]
pub(super) fn planes<const N: usize>(row: &mut [f32], width: usize) -> Planes<'_, N> {
    let (first, rest) = row.split_at_mut(N * width);
    let mut planes = [0; N].map(|_| <&mut [f32]>::default());
    for (plane, row) in planes.iter_mut().zip(first.chunks_exact_mut(width)) {
        *plane = row;
    }
    Planes(planes, rest)
}

impl Planes<'_, VALUES> {
    /// Counts a candidate by its errors, in units of `unit`; they become its weights. Errors below 1e-5 of it weigh
    /// alike, and so do those beyond 1e5.
    #[inline(always)]
    pub fn count(
        &mut self,
        errors: &mut [f32],
        unit: f32,
        variances: &[f32],
        (term, of, y): (&SurfaceTerm, &Sheet, usize),
    ) {
        let Self([weights, all_variances, halves, ..], values) = self;
        for error in &mut *errors {
            let inverse = 1.0 / smaller(larger(*error / unit, 1e-5), 1e5);
            let square = inverse * inverse;
            *error = square * square * square;
        }
        for (sum, weight) in weights.iter_mut().zip(&*errors) {
            *sum += weight;
        }
        add(all_variances, errors, variances);
        add(halves, errors, of.row(term.halves(), y));
        for (channel, values) in values.chunks_exact_mut(of.width).enumerate() {
            add(values, errors, of.row(term.first + channel, y));
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], weights: &[f32], numbers: &[f32]) {
    for ((sum, weight), number) in sums.iter_mut().zip(weights).zip(numbers) {
        *sum += weight * number;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::lanes::LANES;

    #[test]
    fn candidates_weigh_by_the_sixth_power_of_their_error() {
        // Errors are squared already as risks: 2 against 1 is a sixty-fourth. The unit does not matter; errors that are
        // hardly any weigh alike.
        let share = 1.0 / 64.0;
        let expected = (3.0 + 7.0 * share) / (1.0 + share);
        for (errors, unit, expected) in [
            ([1.0, 2.0], 1.0, expected),
            ([100.0, 200.0], 100.0, expected),
            ([0.0, 1e-6], 1.0, 5.0),
        ] {
            let mut state = Sheet::new([LANES, 1], VALUES + 1);
            let term = SurfaceTerm {
                number: 0,
                first: 0,
                channels: 1,
                largest: 1.0,
                errors: Sheet::default(),
            };
            for (error, value) in errors.into_iter().zip([3.0, 7.0]) {
                let mut fit = Sheet::new([LANES, 1], 2);
                fit.row_mut(0, 0).fill(value);
                let mut state = planes::<VALUES>(&mut state.values, LANES);
                let (mut errors, variances) = ([error; LANES], [0.0; LANES]);
                state.count(&mut errors, unit, &variances, (&term, &fit, 0));
            }
            for x in 0..LANES {
                let value = state.row(VALUES, 0)[x] / state.row(WEIGHTS, 0)[x];
                assert!((value - expected).abs() < 1e-6, "{value} of {expected}");
            }
        }
    }
}
