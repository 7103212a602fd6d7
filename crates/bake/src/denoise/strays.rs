//! Rays that two halves have in common by chance.
//!
//! Two rays of a texel that meet something small and bright, one in each half, look like detail: both halves agree. One
//! such texel would keep the 11 x 11 texels about it from being smoothed, for it speaks against every fit of theirs.
//! But light on a surface runs on: no single texel has twice the light of all eight about it. What it has above them is
//! therefore shared by all texels about it.

use super::plane::Sheet;
use super::surface::Surface;

/// Texels to each side that share it.
const RADIUS: usize = 5;

/// How often a texel has the light of any beside it, at least.
const TIMES: f32 = 2.0;

/// Variances of the plain value by which it stands out, at least: noise of less is smoothed as it is.
const STANDS_OUT: f32 = 25.0;

/// Shares what strays brought.
pub(super) fn share(surface: &mut Surface) {
    let Surface {
        mask,
        data,
        leading,
        ..
    } = surface;
    let (mask, leading, channels) = (&*mask, *leading, data.planes - 1);
    let mean = |data: &Sheet, at| mean(data, leading, at);
    let (width, height) = (mask.width, mask.height());
    let mut strays = Vec::new();
    for y in 1..height.saturating_sub(1) {
        for x in 1..width - 1 {
            let own = mean(data, [x, y]);
            let is_below = |at: [usize; 2]| mask.at(0, at) > 0.0 && own > TIMES * mean(data, at);
            // Most fail at once.
            if !is_below([x - 1, y]) || !is_below([x + 1, y]) || mask.at(0, [x, y]) == 0.0 {
                continue;
            }
            let mut beside = [y - 1, y + 1]
                .into_iter()
                .flat_map(|y| [x - 1, x, x + 1].map(|x| [x, y]));
            if beside.all(is_below) {
                strays.push([x, y]);
            }
        }
    }
    for i in strays {
        let about = window(mask, i, RADIUS);
        let squares = about.iter().map(|&j| data.at(channels, j).powi(2));
        let plain = squares.sum::<f32>() / about.len() as f32;
        // What is bright may lie near, beyond an edge of its shadow; those beside are as dark as it should be.
        let beside = window(mask, i, 1);
        let over = |texels: &[[usize; 2]], of: &dyn Fn([usize; 2]) -> f32| {
            texels.iter().map(|&j| of(j)).sum::<f32>() / texels.len() as f32
        };
        let mean = |i: [usize; 2]| mean(data, i);
        let more = mean(i) - over(&beside, &mean);
        // A texel of twice the value has twice the variance.
        let brighter = mean(i) / over(&about, &mean).max(f32::MIN_POSITIVE);
        if more * more <= STANDS_OUT * plain * brighter.max(1.0) {
            continue;
        }
        for plane in 0..=channels {
            let value = over(&beside, &|j| data.at(plane, j));
            let share = (data.at(plane, i) - value) / (about.len() + 1) as f32;
            data.row_mut(plane, i[1])[i[0]] = value + share;
            about
                .iter()
                .for_each(|&[x, y]| data.row_mut(plane, y)[x] += share);
        }
    }
}

/// The texels of the chart about one, so many to each side at most.
fn window(mask: &Sheet, i @ [x, y]: [usize; 2], radius: usize) -> Vec<[usize; 2]> {
    let rows = y.saturating_sub(radius)..(y + radius + 1).min(mask.height());
    let all = rows.flat_map(|y| {
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(mask.width);
        columns.map(move |x| [x, y])
    });
    all.filter(|&j| j != i && mask.at(0, j) > 0.0).collect()
}

/// The mean of so many first channels of a texel's mean.
fn mean(data: &Sheet, leading: usize, at: [usize; 2]) -> f32 {
    (0..leading)
        .map(|channel| data.at(channel, at))
        .sum::<f32>()
        / leading as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_holds_the_texels_of_the_chart_about_one_and_ends_with_the_plane() {
        let mut mask = Sheet::new([7, 6], 1);
        mask.values.fill(1.0);
        let all = |[x, y]: [std::ops::Range<usize>; 2], own: [usize; 2]| -> Vec<[usize; 2]> {
            let rows = y.flat_map(|y| x.clone().map(move |x| [x, y]));
            rows.filter(|&i| i != own).collect()
        };
        assert_eq!(window(&mask, [3, 3], 1), all([2..5, 2..5], [3, 3]));
        assert_eq!(window(&mask, [3, 3], 2), all([1..6, 1..6], [3, 3]));
        assert_eq!(window(&mask, [0, 0], 2), all([0..3, 0..3], [0, 0]));
        assert_eq!(window(&mask, [6, 5], 1), all([5..7, 4..6], [6, 5]));
        mask.row_mut(0, 2)[3] = 0.0;
        assert_eq!(window(&mask, [3, 3], 1).len(), 7);
    }
}
