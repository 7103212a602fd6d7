//! How much what was chosen changes from one texel to the next.

use super::plane::{Sheet, rows};
use std::ops::Range;

/// For each texel of a surface, the mean square of what the mean channel differs by from the texels beside it and
/// above and below; 0 where there are none. The `channels` are planes of `sheet`.
pub(super) fn steepness(mask: &Sheet, sheet: &Sheet, channels: Range<usize>) -> Sheet {
    let (width, height) = (mask.width, mask.height());
    let mut steep = Sheet::new([width, height], 1);
    rows(
        height,
        1,
        [&mut steep.values],
        #[inline(always)]
        |from, [steep]| {
            let mut means = [0; 3].map(|_| vec![0.0; width]);
            let mut counts = vec![0.0; width];
            for (row, steep) in steep.chunks_exact_mut(width).enumerate() {
                let y = from + row;
                let [own, above, below] = means.each_mut();
                let own_mask = mask.row(0, y);
                mean(sheet, &channels, y, own);
                counts.fill(f32::MIN_POSITIVE);
                let (next, before) = (1..width, 0..width - 1);
                for (at, other) in [(&next, &before), (&before, &next)] {
                    let (sums, counts) = (&mut steep[at.clone()], &mut counts[at.clone()]);
                    add(
                        &own[at.clone()],
                        &own[other.clone()],
                        &own_mask[other.clone()],
                        sums,
                        counts,
                    );
                }
                if y > 0 {
                    mean(sheet, &channels, y - 1, above);
                    add(own, above, mask.row(0, y - 1), steep, &mut counts);
                }
                if y + 1 < height {
                    mean(sheet, &channels, y + 1, below);
                    add(own, below, mask.row(0, y + 1), steep, &mut counts);
                }
                for (sum, count) in steep.iter_mut().zip(&counts) {
                    *sum /= count;
                }
            }
        },
    );
    steep
}

/// The mean channel of a row.
#[inline(always)]
fn mean(sheet: &Sheet, channels: &Range<usize>, y: usize, out: &mut [f32]) {
    let share = 1.0 / channels.len() as f32;
    out.fill(0.0);
    for plane in channels.clone() {
        for (out, value) in out.iter_mut().zip(sheet.row(plane, y)) {
            *out += share * value;
        }
    }
}

/// Adds the squares of what texels differ by from others, where these are of the surface.
#[inline(always)]
fn add(own: &[f32], others: &[f32], mask: &[f32], sums: &mut [f32], counts: &mut [f32]) {
    let texels = own.iter().zip(others).zip(mask);
    for (((own, other), mask), (sum, count)) in texels.zip(sums.iter_mut().zip(counts)) {
        let is_one = if *mask > 0.0 { 1.0 } else { 0.0 };
        *sum += is_one * (other - own) * (other - own);
        *count += is_one;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steepness_is_the_mean_square_of_the_steps_to_texels_of_the_surface() {
        // Two channels, whose mean is x + 3 y, behind a plane that does not count; one texel is not of the surface.
        let mut mask = Sheet::new([4, 3], 1);
        mask.values.fill(1.0);
        mask.row_mut(0, 1)[2] = 0.0;
        let mut sheet = Sheet::new([4, 3], 3);
        for (x, y) in (0..4).flat_map(|x| (0..3).map(move |y| (x, y))) {
            let mean = if (x, y) == (2, 1) {
                99.0
            } else {
                (x + 3 * y) as f32
            };
            for (plane, value) in [7.0 * mean, mean - 1.0, mean + 1.0].into_iter().enumerate() {
                sheet.row_mut(plane, y)[x] = value;
            }
        }
        let steep = steepness(&mask, &sheet, 1..3);
        // A corner, a border, the texel left of the one that is left out, and the one above that.
        for (at, steps) in [
            ([0, 0], 5.0),
            ([1, 0], 11.0 / 3.0),
            ([1, 1], 19.0 / 3.0),
            ([2, 0], 1.0),
        ] {
            assert_eq!(steep.at(0, at), steps, "{at:?}");
        }
        let alone = steepness(&Sheet::new([4, 3], 1), &sheet, 1..3);
        assert!(alone.values.iter().all(|step| *step == 0.0));
    }
}
