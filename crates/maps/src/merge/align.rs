//! Whole-pixel shifts between brackets, by threshold bitmaps.
//!
//! G. Ward, "Fast, Robust Image Registration for Compositing High Dynamic Range Photographs from Handheld Exposures"
//! (2003): a picture cut at its median looks the same at any exposure, and a pyramid of such bitmaps gives a shift bit
//! by bit. Here the cut is the percentile nearest the median at which both pictures are neither black nor saturated, so
//! that exposures far from a middle one align too, and every bracket is compared with its neighbour in exposure.

use super::{Bracket, SATURATED};
use rayon::prelude::*;

/// Levels about the cut that noise may carry over it; they do not count (Ward's 4 of 255).
const NOISE: f64 = 4.0;

/// Lowest level of a cut.
const DARKEST: f64 = 12.0;

/// Shortest side of a picture of the pyramid.
const SMALLEST: usize = 32;

/// Largest shift that is tried in the smallest picture: a sixth of its shorter side or more.
const REACH: i32 = 10;

/// Sets the shift of every bracket to that of its content against the one of middle exposure, which stays.
///
/// Returns for each whether it was found: where no percentile is well exposed in a bracket and its neighbour, it takes
/// its neighbour's.
pub fn align(brackets: &mut [Bracket]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..brackets.len()).collect();
    order.sort_by(|a, b| brackets[*a].time.total_cmp(&brackets[*b].time));
    let pyramids: Vec<Vec<Gray>> = brackets.par_iter().map(pyramid).collect();
    let mut found = vec![true; brackets.len()];
    let middle = order.len() / 2;
    if let Some(reference) = order.get(middle) {
        brackets[*reference].shift = [0, 0];
    }
    let outward = (1..=middle).map(|k| (middle - k + 1, middle - k));
    let inward = (middle + 1..order.len()).map(|k| (k - 1, k));
    for (fixed, moved) in outward.chain(inward) {
        let (fixed, moved) = (order[fixed], order[moved]);
        let step = shift(&pyramids[fixed], &pyramids[moved]);
        found[moved] = step.is_some();
        let [x, y] = brackets[fixed].shift;
        let [dx, dy] = step.unwrap_or([0, 0]);
        brackets[moved].shift = [x + dx, y + dy];
    }
    found
}

/// Mean of the three channels, 0..=255.
struct Gray {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

fn pyramid(bracket: &Bracket) -> Vec<Gray> {
    let mean = |p: &[u16; 3]| p.iter().map(|v| f32::from(*v)).sum::<f32>() / (3.0 * 257.0);
    let mut levels = vec![Gray {
        width: bracket.width,
        height: bracket.height,
        values: bracket.values.iter().map(mean).collect(),
    }];
    loop {
        let last = &levels[levels.len() - 1];
        let (width, height) = (last.width / 2, last.height / 2);
        if width.min(height) < SMALLEST {
            return levels;
        }
        let at = |x: usize, y: usize| last.values[y * last.width + x];
        let mean = |i: usize| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        let values = (0..width * height).map(mean).collect();
        levels.push(Gray {
            width,
            height,
            values,
        });
    }
}

/// Where pixel (0, 0) of the first picture lies in the second; `None` where they have no well exposed percentile in
/// common.
fn shift(first: &[Gray], second: &[Gray]) -> Option<[i32; 2]> {
    let [a, b] = [&first[0], &second[0]].map(|gray| {
        let mut sorted = gray.values.clone();
        sorted.sort_by(f32::total_cmp);
        sorted
    });
    let exposed = |v: f32| (DARKEST..SATURATED - 2.0 * NOISE).contains(&f64::from(v));
    let cuts = (0..=98).map(|k| {
        if k % 2 == 0 {
            50 - k / 2
        } else {
            50 + k / 2 + 1
        }
    });
    let cut = cuts
        .map(|percent| (a.len() - 1) * percent as usize / 100)
        .find(|at| exposed(a[*at]) && exposed(b[*at]))?;
    let cuts = [a[cut], b[cut]];
    let mut best = [0, 0];
    for level in (0..first.len()).rev() {
        let [a, b] =
            [(&first[level], cuts[0]), (&second[level], cuts[1])].map(|(g, c)| bitmap(g, c));
        let reach = if level + 1 == first.len() { REACH } else { 1 };
        let start = best.map(|v| 2 * v);
        let steps = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
        let mut steps: Vec<[i32; 2]> = steps.collect();
        steps.sort_by_key(|[x, y]| (x * x + y * y, *y, *x));
        let mut lowest = f64::INFINITY;
        for [x, y] in steps {
            let tried = [start[0] + x, start[1] + y];
            let error = difference(&first[level], &a, &b, tried);
            if error < lowest {
                (lowest, best) = (error, tried);
            }
        }
    }
    Some(best)
}

/// 1 below the cut, 2 above it, 0 within the noise.
fn bitmap(gray: &Gray, cut: f32) -> Vec<u8> {
    let side = |v: &f32| match v - cut {
        d if f64::from(d) > NOISE => 2,
        d if f64::from(d) < -NOISE => 1,
        _ => 0,
    };
    gray.values.iter().map(side).collect()
}

/// Part of the pixels on which two bitmaps disagree, of those that count in both; 1 where too few do.
fn difference(size: &Gray, a: &[u8], b: &[u8], [dx, dy]: [i32; 2]) -> f64 {
    let (w, h) = (size.width as i32, size.height as i32);
    let (left, right) = ((-dx).max(0), (w - dx).min(w));
    let (top, bottom) = ((-dy).max(0), (h - dy).min(h));
    if left >= right || top >= bottom {
        return 1.0;
    }
    let row = |y: i32| {
        let from = |y: i32, x: i32| (y * w + x) as usize;
        let a = &a[from(y, left)..from(y, left) + (right - left) as usize];
        let b = &b[from(y + dy, left + dx)..from(y + dy, left + dx) + (right - left) as usize];
        let pairs = a.iter().zip(b);
        pairs.fold([0u32; 2], |[differ, count], (a, b)| {
            let both = *a != 0 && *b != 0;
            [differ + u32::from(a ^ b == 3), count + u32::from(both)]
        })
    };
    let add = |p: [u64; 2], q: [u64; 2]| [p[0] + q[0], p[1] + q[1]];
    let rows = (top..bottom).into_par_iter().map(row);
    let [differ, count] = rows.map(|r| r.map(u64::from)).reduce(|| [0; 2], add);
    if count * 64 < (w as u64) * (h as u64) {
        return 1.0;
    }
    differ as f64 / count as f64
}
