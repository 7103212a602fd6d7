//! Rays that two halves have in common by chance.
//!
//! Two rays of a texel that meet something small and bright, one in each half, look like detail: both halves agree. One such texel would
//! keep the 11 x 11 texels about it from being smoothed, for it speaks against every fit of theirs. But light on a surface runs on: no
//! single texel has twice the light of all eight about it. What it has above them is therefore shared by all texels about it.

use super::plane::Plane;

/// Texels to each side that share it.
const RADIUS: usize = 5;

/// How often a texel has the light of any beside it, at least.
const TIMES: f32 = 2.0;

/// Variances of the plain value by which it stands out, at least: noise of less is smoothed as it is.
const STANDS_OUT: f32 = 25.0;

/// Shares what strays brought. `data`: the channels of the mean, then the half difference.
pub(super) fn share(mask: &Plane, data: &mut [Plane]) {
    let channels = data.len() - 1;
    let (width, height) = (mask.width, mask.height());
    if width < 3 || height < 3 {
        return;
    }
    let mut strays = Vec::new();
    for y in 1..height - 1 {
        for i in (1..width - 1).map(|x| y * width + x) {
            let own = mean(data, i);
            let is_below = |j: usize| mask.values[j] > 0.0 && own > TIMES * mean(data, j);
            let rows = [i - width, i, i + width];
            let mut about = rows.into_iter().flat_map(|j| [j - 1, j, j + 1]);
            if mask.values[i] > 0.0 && about.all(|j| j == i || is_below(j)) {
                strays.push(i);
            }
        }
    }
    for i in strays {
        let about = window(mask, i, RADIUS);
        let squares = about.iter().map(|&j| data[channels].values[j].powi(2));
        let plain = squares.sum::<f32>() / about.len() as f32;
        // What is bright may lie near, beyond an edge of its shadow; those beside are as dark as it should be.
        let beside = window(mask, i, 1);
        let over = |texels: &[usize], of: &dyn Fn(usize) -> f32| {
            texels.iter().map(|&j| of(j)).sum::<f32>() / texels.len() as f32
        };
        let mean = |i: usize| mean(data, i);
        let more = mean(i) - over(&beside, &mean);
        // A texel of twice the value has twice the variance.
        let brighter = mean(i) / over(&about, &mean).max(f32::MIN_POSITIVE);
        if more * more <= STANDS_OUT * plain * brighter.max(1.0) {
            continue;
        }
        for plane in data.iter_mut() {
            let value = over(&beside, &|j| plane.values[j]);
            let more = plane.values[i] - value;
            plane.values[i] = value;
            let share = more / (about.len() + 1) as f32;
            plane.values[i] += share;
            about.iter().for_each(|&j| plane.values[j] += share);
        }
    }
}

/// The texels of the chart about one, so many to each side at most.
fn window(mask: &Plane, i: usize, radius: usize) -> Vec<usize> {
    let (x, y) = (i % mask.width, i / mask.width);
    let rows = y.saturating_sub(radius)..(y + radius + 1).min(mask.height());
    let all = rows.flat_map(|y| {
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(mask.width);
        columns.map(move |x| y * mask.width + x)
    });
    all.filter(|&j| j != i && mask.values[j] > 0.0).collect()
}

/// The mean channel of a texel's mean.
fn mean(data: &[Plane], i: usize) -> f32 {
    let channels = &data[..data.len() - 1];
    channels.iter().map(|p| p.values[i]).sum::<f32>() / channels.len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_holds_the_texels_of_the_chart_about_one_and_ends_with_the_plane() {
        let mut mask = Plane::new([7, 6]);
        mask.values.fill(1.0);
        let all = |[x, y]: [std::ops::Range<usize>; 2], own: usize| -> Vec<usize> {
            let rows = y.flat_map(|y| x.clone().map(move |x| 7 * y + x));
            rows.filter(|&i| i != own).collect()
        };
        assert_eq!(window(&mask, 7 * 3 + 3, 1), all([2..5, 2..5], 24));
        assert_eq!(window(&mask, 7 * 3 + 3, 2), all([1..6, 1..6], 24));
        assert_eq!(window(&mask, 0, 2), all([0..3, 0..3], 0));
        assert_eq!(window(&mask, 7 * 5 + 6, 1), all([5..7, 4..6], 41));
        mask.values[7 * 2 + 3] = 0.0;
        assert_eq!(window(&mask, 24, 1).len(), 7);
    }
}
