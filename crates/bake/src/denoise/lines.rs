//! Lines of texels that no fit follows: a slit of light below a door, the dark foot of a skirting board.
//!
//! They are a texel or two wide and far from what is beside them. A window that holds part of one misses it wherever
//! else it is, so a line would keep all within eleven texels from being smoothed. It is set apart, as if the chart ended
//! at it: its texels keep their plain values, and those about it are fitted without them.
//!
//! Single texels are no line, however far they are from all about them: `strays.rs` shares what came there by chance.

use super::surface::Surface;
use std::collections::BTreeMap;

/// Edge of the squares of texels that are held against a texel.
const EDGE: usize = 5;

/// How often a texel has the light of all squares of its chart that it is part of, or they have its, at least.
const TIMES: f32 = 2.0;

/// Standard errors of plain values by which they differ, at least.
const STANDS_OUT: f32 = 5.0;

/// Texels that touch are a line where they reach at least so far along rows or columns.
const LONG: usize = 5;

/// Takes the texels of lines out of a surface.
pub(super) fn set_apart(surface: &mut Surface) {
    let Surface {
        mask,
        data,
        leading,
        errors,
        ..
    } = surface;
    let (width, height) = (mask.width, mask.height());
    if width.min(height) < EDGE {
        return;
    }
    let (leading, channels) = (*leading, data.planes - 1);
    let sum = |at| {
        (0..leading)
            .map(|channel| data.at(channel, at))
            .sum::<f32>()
    };
    let value = |at| sum(at) / (leading as f32 * mask.at(0, at));
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
    let stands_out = |[x, y]: [usize; 2]| {
        let (own, error) = (value([x, y]), errors.at(0, [x, y]));
        let from = |at: usize, size: usize| at.saturating_sub(EDGE - 1)..=at.min(size - EDGE);
        let places = from(y, height).flat_map(|top| from(x, width).map(move |left| [left, top]));
        let mut squares = places.filter_map(square).peekable();
        let is_above = squares.peek().is_some_and(|square| own > *square);
        let stands_out = squares.peek().is_some()
            && squares.all(|square| (own > square) == is_above && is_far(own, square, error));
        stands_out.then_some(([x, y], is_above))
    };
    let standing = suspects.into_iter().filter_map(stands_out).collect();
    for [x, y] in in_lines(standing) {
        mask.row_mut(0, y)[x] = 0.0;
        (0..=channels).for_each(|plane| data.row_mut(plane, y)[x] = 0.0);
    }
}

/// Those of some texels, each brighter or darker than what is about it, that are parts of lines.
fn in_lines(mut left: BTreeMap<[usize; 2], bool>) -> Vec<[usize; 2]> {
    let mut found = Vec::new();
    while let Some((first, is_above)) = left.pop_first() {
        let start = found.len();
        found.push(first);
        let mut next = start;
        while let Some(&[x, y]) = found.get(next) {
            next += 1;
            let rows = y.saturating_sub(1)..=y + 1;
            for at in rows.flat_map(|y| (x.saturating_sub(1)..=x + 1).map(move |x| [x, y])) {
                if left.get(&at) == Some(&is_above) {
                    left.remove(&at);
                    found.push(at);
                }
            }
        }
        let reach = |axis: usize| {
            let places = || found[start..].iter().map(|at| at[axis]);
            places()
                .max()
                .zip(places().min())
                .map_or(0, |(high, low)| high - low + 1)
        };
        if reach(0).max(reach(1)) < LONG {
            found.truncate(start);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_that_touch_and_reach_far_are_lines_and_others_are_not() {
        let row: Vec<[usize; 2]> = (3..8).map(|x| [x, 4]).collect();
        let slope: Vec<[usize; 2]> = (0..6).map(|k| [20 + k, k]).collect();
        let blot = [[30, 9], [31, 9], [30, 10], [32, 10], [31, 11]];
        let short = [[40, 2], [40, 3], [40, 4], [40, 5]];
        let all = [&row[..], &slope, &blot, &short].concat();
        let lines = |is_above: &dyn Fn([usize; 2]) -> bool| {
            let mut found = in_lines(all.iter().map(|&at| (at, is_above(at))).collect());
            found.sort_unstable();
            found
        };
        assert_eq!(lines(&|_| true), [&row[..], &slope].concat());
        // A bright texel in a dark row parts it.
        assert_eq!(lines(&|at| at == [5, 4]), slope);
    }
}
