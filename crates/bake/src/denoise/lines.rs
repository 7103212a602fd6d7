//! Lines of texels that no fit follows: a slit of light below a door, the dark foot of a skirting board.
//!
//! They are a texel or two wide and far from what is beside them. A window that holds part of one misses it wherever
//! else it is, so a line would keep all within eleven texels from being smoothed. It is set apart, as if the chart ended
//! at it: its texels keep their plain values, and those about it are fitted without them.

use super::plane::Sheet;

/// Edge of the squares of texels that are held against a texel.
const EDGE: usize = 5;

/// How often a texel has the light of all squares of its chart that it is part of, or they have its, at least.
const TIMES: f32 = 2.0;

/// Standard errors of plain values by which they differ, at least.
const STANDS_OUT: f32 = 5.0;

/// Takes the texels of lines out of a surface.
pub(super) fn set_apart(mask: &mut Sheet, data: &mut Sheet, errors: &Sheet) {
    let (width, height) = (mask.width, mask.height());
    if width.min(height) < EDGE {
        return;
    }
    let channels = data.planes - 1;
    let sum = |at| {
        (0..channels)
            .map(|channel| data.at(channel, at))
            .sum::<f32>()
    };
    let value = |at| sum(at) / (channels as f32 * mask.at(0, at));
    let is_far = |own: f32, other: f32, error: f32| {
        let (low, high) = if own < other {
            (own, other)
        } else {
            (other, own)
        };
        high > TIMES * low && high - low > STANDS_OUT * error
    };
    let middle = EDGE / 2;
    let mut suspects = Vec::new();
    for y in 0..height {
        for x in (0..width).filter(|&x| mask.at(0, [x, y]) > 0.0) {
            let own = value([x, y]);
            for at in [[x + middle, y], [x, y + middle]] {
                if at[0] < width && at[1] < height && mask.at(0, at) > 0.0 {
                    let error = errors.at(0, at).max(errors.at(0, [x, y]));
                    if is_far(own, value(at), error) {
                        suspects.extend([[x, y], at]);
                    }
                }
            }
        }
    }
    suspects.sort_unstable();
    suspects.dedup();
    // None where the chart does not fill it.
    let square = |[left, top]: [usize; 2]| {
        let texels = || (0..EDGE * EDGE).map(move |k| [left + k % EDGE, top + k / EDGE]);
        let is_full = texels().all(|at| mask.at(0, at) > 0.0);
        is_full.then(|| texels().map(value).sum::<f32>() / (EDGE * EDGE) as f32)
    };
    suspects.retain(|&[x, y]| {
        let (own, error) = (value([x, y]), errors.at(0, [x, y]));
        let from = |at: usize, size: usize| at.saturating_sub(EDGE - 1)..=at.min(size - EDGE);
        let places = from(y, height).flat_map(|top| from(x, width).map(move |left| [left, top]));
        let mut squares = places.filter_map(square).peekable();
        let is_above = squares.peek().is_some_and(|square| own > *square);
        squares.peek().is_some()
            && squares.all(|square| (own > square) == is_above && is_far(own, square, error))
    });
    for [x, y] in suspects {
        mask.row_mut(0, y)[x] = 0.0;
        (0..=channels).for_each(|plane| data.row_mut(plane, y)[x] = 0.0);
    }
}
