//! The equations of a page's seams, and what their solution moves.

use super::across::Outer;
use super::border::Chart;
use super::owner::Page;
use super::system::{Rows, conjugate_gradients};
use super::{SeamPoint, SeamStats};
use glam::DVec2;
use rayon::prelude::*;

/// What a difference of the two sides counts against, in units of the plane. Less would move texels for what nobody sees: at an eighth of
/// it the look-ups of the test's sphere come out farther from the light than before.
const STEP: f64 = 1.0 / 1024.0;

/// A texel's mean is never taken to be known better than this, in units of the plane.
const KNOWN: f64 = 1.0 / 1024.0;

/// Share of the range about a texel by which its best value for a look-up may differ from its mean.
const BEND: f64 = 0.02;

/// How far a gutter texel may leave its neighbours' mean, in ranges about it.
const GUTTER: f64 = 2.0;

/// Standard errors of the two sides within which their difference may be noise.
const NOISE: f64 = 3.0;

/// What the square of a difference beyond noise counts against as well, in units of the plane. Where light changes much from one texel to the
/// next, as at a contact or on charts of two texels, look-ups cannot hold what is on either side, and to make them agree would take it from
/// whole texels. At none, lines are drawn along the bevels of a helmet; at twice this, steps of the test's sphere are nearly seen.
const HELD: f64 = 0.5;

/// How far a texel that is covered may leave its mean, in standard errors: its own, or the root mean square of all that seams read where
/// that is more, since an error that few rays tell may be far too small. Noise beyond it has one texel in two thousand. At 3, steps of the
/// test's sphere are left with 16 rays; at 5, look-ups of a helmet have twice as much more error.
const NOISY: f64 = 3.5;

/// The same in units of the plane, if that is more. A step that asks for more is seen on few texels and stays in part; else whole texels of narrow charts would be wrong. At half of this
/// steps of a town with texels as large as its windows are three times as large.
const FREE: f64 = 0.1;

/// A move of less than this, in units of the plane, is none.
const REST: f64 = 1e-6;

/// Texels that a plane cannot hold are put where it ends and the rest is solved again, so often at most.
const ROUNDS: usize = 3;

/// Texels and their weights in a bilinear look-up.
type Taps = [(u32, f64); 4];

/// Which texels seams read, and how.
#[derive(Debug)]
pub(crate) struct System {
    size: usize,
    /// The texels that may move, ascending.
    texels: Vec<u32>,
    /// For each point of a seam, its two look-ups, the second negative; indices into `texels`.
    steps: Vec<[(u32, f64); 8]>,
    /// Square root of each point's length.
    lengths: Vec<f64>,
    /// Points whose other side is on a page that is finished before, and those of which this page is finished before the other.
    ties: Vec<Tie>,
    kept: Vec<(usize, Taps)>,
    /// For each texel, the look-up that its mean stands for.
    means: Vec<Taps>,
}

/// A look-up that is to find what another page holds.
#[derive(Debug)]
struct Tie {
    /// Number of the point.
    number: usize,
    /// Indices into the texels of the system.
    taps: Taps,
    /// Square root of its length.
    length: f64,
}

/// What is known about the texels of a plane.
pub(crate) struct Known<'a> {
    /// What other pages hold at the points of [`System::tied`], NaN where that is not known.
    pub tied: &'a [f64],
    /// The values, texel by texel of the page.
    pub values: &'a [f32],
    /// Their standard errors; 0 for a texel that is exact and stays.
    pub std_errs: &'a [f32],
    /// What an open texel has, about.
    pub unit: f64,
    /// The largest value that the plane can have; infinite where there is none.
    pub most: f64,
}

/// Where texels of a plane move.
pub(crate) struct Moved {
    /// Texel and value.
    pub values: Vec<(u32, f32)>,
    /// Differences before and after.
    pub stats: SeamStats,
}

impl System {
    pub(super) fn new(points: &[SeamPoint], outer: &[Outer], page: &Page<'_>) -> Self {
        let look = |point: &SeamPoint| point.sides.map(|p| taps(p, page.size));
        let on_page = |outer: &Outer| taps(outer.side, page.size);
        let single = outer.par_iter().map(on_page);
        let all = texels_of(points.par_iter().flat_map_iter(look).chain(single));
        let owners = page.owners(&all);
        let owner = |texel: &u32| all.binary_search(texel).ok().and_then(|at| owners[at]);
        let is_own = |side: &Taps, chart: Chart| {
            let read = side.iter().filter(|tap| tap.1 != 0.0);
            let mut owners = read.map(|tap| owner(&tap.0));
            owners.all(|owner| owner.is_none_or(|owner| owner.chart == Some(chart)))
        };
        let is_seen = |side: &Taps| {
            let read = side.iter().filter(|tap| tap.1 != 0.0);
            let mut covered = read.filter(|tap| owner(&tap.0).is_some()).peekable();
            let seen = |texel: u32| page.validity.is_none_or(|v| v[texel as usize] > 0.0);
            covered.peek().is_none() || covered.any(|tap| seen(tap.0))
        };
        let points: Vec<&SeamPoint> = points
            .par_iter()
            .filter(|point| {
                let mut sides = look(point).into_iter().zip(point.charts);
                sides.all(|(side, chart)| is_own(&side, chart) && is_seen(&side))
            })
            .collect();
        let looked_up: Vec<[Taps; 2]> = points.par_iter().map(|point| look(point)).collect();
        let (later, earlier): (Vec<_>, Vec<_>) = outer
            .iter()
            .map(|outer| (outer, on_page(outer)))
            .filter(|(outer, side)| is_own(side, outer.chart) && is_seen(side))
            .partition(|(outer, _)| outer.later);
        let tied = later.par_iter().map(|(_, side)| *side);
        let read = texels_of(looked_up.par_iter().flatten().copied().chain(tied.clone()));
        let own: Vec<Taps> = read
            .iter()
            .map(|texel| {
                taps(
                    owner(texel).map_or(page.centre(*texel), |o| o.middle),
                    page.size,
                )
            })
            .collect();
        let within = looked_up.par_iter().flatten().chain(&own);
        let texels = texels_of(within.copied().chain(tied));
        let numbered = |(texel, weight): (u32, f64)| match texels.binary_search(&texel) {
            Ok(number) if weight != 0.0 => (number as u32, weight),
            _ => (0, 0.0),
        };
        let means =
            texels
                .iter()
                .enumerate()
                .map(|(number, texel)| match read.binary_search(texel) {
                    Ok(at) => own[at].map(numbered),
                    Err(_) => [(number as u32, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
                });
        let steps = looked_up.par_iter().map(|[a, b]| {
            let side = |k: usize| match k {
                0..4 => a[k],
                _ => (b[k - 4].0, -b[k - 4].1),
            };
            std::array::from_fn(|k| numbered(side(k)))
        });
        Self {
            size: page.size as usize,
            steps: steps.collect(),
            lengths: points.iter().map(|point| point.length.sqrt()).collect(),
            ties: later
                .iter()
                .map(|(outer, side)| Tie {
                    number: outer.number,
                    taps: side.map(numbered),
                    length: outer.length.sqrt(),
                })
                .collect(),
            kept: earlier
                .iter()
                .map(|(outer, side)| (outer.number, *side))
                .collect(),
            means: means.collect(),
            texels,
        }
    }

    /// Numbers of the points whose other side is on pages that are finished before.
    pub fn tied(&self) -> Vec<usize> {
        self.ties.iter().map(|tie| tie.number).collect()
    }

    /// What a finished plane holds at points whose other side is on pages that are finished later.
    pub fn kept(&self, plane: &[f32]) -> Vec<(usize, f32)> {
        let value = |side: &Taps| {
            let of_tap = |&(texel, w): &(u32, f64)| w * f64::from(plane[texel as usize]);
            side.iter().map(of_tap).sum::<f64>() as f32
        };
        let kept = self.kept.iter();
        kept.map(|(number, side)| (*number, value(side))).collect()
    }

    /// Moves the texels of a plane whose other texels stay. `coverage` is the page's.
    pub fn solve(&self, known: &Known<'_>, coverage: &[f32]) -> Moved {
        let about: Vec<About> = self
            .texels
            .par_iter()
            .map(|&texel| About::of(texel as usize, known.values, coverage, self.size))
            .collect();
        let covered = |i: usize| coverage[self.texels[i] as usize] > 0.0;
        let std_err = |i: usize| f64::from(known.std_errs[self.texels[i] as usize]);
        let mut fixed: Vec<bool> = (0..about.len())
            .map(|i| covered(i) && std_err(i) == 0.0)
            .collect();
        let doubts = self.doubts(known, coverage, &about);
        let rows = self.rows(known, coverage, &about, &doubts);
        let start: Vec<f64> = about.iter().map(|about| about.value).collect();
        let mut moved = start.clone();
        for _ in 0..ROUNDS {
            moved = conjugate_gradients(&rows, &moved, &fixed);
            let mut beyond = false;
            for (i, about) in about.iter().enumerate() {
                let most = known.most.max(about.high);
                if !fixed[i] && !(0.0..=most).contains(&moved[i]) {
                    (moved[i], fixed[i], beyond) = (moved[i].clamp(0.0, most), true, true);
                }
            }
            if !beyond {
                break;
            }
        }
        let noisy = (0..about.len()).filter(|&i| covered(i) && std_err(i) > 0.0);
        let (count, squares) = noisy.fold((0u32, 0.0), |(count, sum), i| {
            (count + 1, sum + std_err(i).powi(2))
        });
        let common = (squares / f64::from(count.max(1))).sqrt();
        for (i, (moved, start)) in moved.iter_mut().zip(&start).enumerate() {
            if covered(i) {
                let far = f64::max(NOISY * std_err(i).max(common), FREE * known.unit);
                *moved = moved.clamp(start - far, start + far);
            }
        }
        // What is at rest stays to the last bit, and does not take up what rounding leaves.
        for (moved, start) in moved.iter_mut().zip(&start) {
            if (*moved - start).abs() < REST * known.unit {
                *moved = *start;
            }
        }
        let (squares_before, max_before) = self.differences(&start, known.tied);
        let (squares_after, max_after) = self.differences(&moved, known.tied);
        let tied = known.tied.iter().filter(|value| !value.is_nan()).count();
        let values = self.texels.iter().zip(moved);
        Moved {
            values: values
                .map(|(&texel, value)| (texel, value as f32))
                .collect(),
            stats: SeamStats {
                points: (self.steps.len() + tied) as u64,
                squares_before,
                squares_after,
                max_before,
                max_after,
            },
        }
    }

    /// Sum of squares and largest of the differences of the two sides.
    fn differences(&self, values: &[f64], tied: &[f64]) -> (f64, f64) {
        let mut found = (0.0, 0.0f64);
        let look = |taps: &[(u32, f64)]| -> f64 {
            taps.iter().map(|&(i, w)| w * values[i as usize]).sum()
        };
        let steps = self.steps.iter().map(|step| look(step));
        let ties = self
            .ties
            .iter()
            .zip(tied)
            .map(|(tie, other)| look(&tie.taps) - other);
        for difference in steps.chain(ties.filter(|difference| !difference.is_nan())) {
            found = (
                found.0 + difference * difference,
                found.1.max(difference.abs()),
            );
        }
        found
    }

    /// What is not known of the mean of each texel; none of a gutter texel, which has no mean.
    fn doubts(&self, known: &Known<'_>, coverage: &[f32], about: &[About]) -> Vec<f64> {
        let floor = KNOWN * known.unit;
        let doubt = |(&texel, about): (&u32, &About)| match coverage[texel as usize] > 0.0 {
            true => {
                let std_err = f64::from(known.std_errs[texel as usize]);
                (std_err.powi(2) + (BEND * about.range()).powi(2) + floor.powi(2)).sqrt()
            }
            false => 0.0,
        };
        self.texels.iter().zip(about).map(doubt).collect()
    }

    /// All equations of a plane, each divided by what it counts against.
    fn rows(&self, known: &Known<'_>, coverage: &[f32], about: &[About], doubts: &[f64]) -> Rows {
        let mut rows = Rows::new(self.texels.len());
        let floor = KNOWN * known.unit;
        let step = |taps: &[(u32, f64)], other: f64| {
            let value = |&(i, w): &(u32, f64)| w * about[i as usize].value;
            let variance = |&(i, w): &(u32, f64)| (w * doubts[i as usize]).powi(2);
            let noise = NOISE * taps.iter().map(variance).sum::<f64>().sqrt();
            let difference = (taps.iter().map(value).sum::<f64>() - other).abs();
            STEP * known.unit + HELD * (difference - noise).max(0.0).powi(2) / known.unit
        };
        for (taps, length) in self.steps.iter().zip(&self.lengths) {
            rows.push(taps, length / step(taps, 0.0), 0.0);
        }
        for (tie, other) in self.ties.iter().zip(known.tied) {
            if !other.is_nan() {
                rows.push(&tie.taps, tie.length / step(&tie.taps, *other), *other);
            }
        }
        for (i, &texel) in self.texels.iter().enumerate() {
            let covered = f64::from(coverage[texel as usize]);
            if covered > 0.0 {
                rows.push(&self.means[i], covered.sqrt() / doubts[i], about[i].value);
            } else {
                let own = [(i as u32, 1.0)];
                let weight = 1.0 / (GUTTER * (about[i].range() + floor));
                rows.push(&own, weight, about[i].value);
            }
        }
        rows.transpose();
        rows
    }
}

/// A texel and its neighbours in a plane.
struct About {
    /// Its value, or the mean of its covered neighbours where it has none.
    value: f64,
    /// The least and the largest value of itself and its covered neighbours.
    low: f64,
    high: f64,
}

impl About {
    fn of(texel: usize, values: &[f32], coverage: &[f32], size: usize) -> Self {
        let (x, y) = (texel % size, texel / size);
        let mut about = Self {
            value: f64::from(values[texel]),
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        };
        let own = coverage[texel] > 0.0;
        for radius in 1..=2 {
            let (mut sum, mut count) = (0.0, 0);
            for v in y.saturating_sub(radius)..(y + radius + 1).min(size) {
                for u in x.saturating_sub(radius)..(x + radius + 1).min(size) {
                    let other = v * size + u;
                    if coverage[other] > 0.0 {
                        let value = f64::from(values[other]);
                        (sum, count) = (sum + value, count + 1);
                        (about.low, about.high) = (about.low.min(value), about.high.max(value));
                    }
                }
            }
            if count > 0 {
                if !own {
                    about.value = sum / f64::from(count);
                }
                return about;
            }
        }
        (about.low, about.high) = (about.value, about.value);
        about
    }

    fn range(&self) -> f64 {
        self.high - self.low
    }
}

/// The texels that look-ups read, ascending.
fn texels_of(looked_up: impl ParallelIterator<Item = Taps>) -> Vec<u32> {
    let read = looked_up.flatten_iter().filter(|tap| tap.1 != 0.0);
    let mut texels: Vec<u32> = read.map(|tap| tap.0).collect();
    texels.par_sort_unstable();
    texels.dedup();
    texels
}

/// The four texels of a bilinear look-up at a place in texels of the page, whose edge is repeated outside. Texels that count nothing
/// have the weight 0.
pub(super) fn taps(p: DVec2, size: u32) -> Taps {
    let low = (p - 0.5).floor();
    let f = p - 0.5 - low;
    let texel = |dx: f64, dy: f64| {
        let last = f64::from(size - 1);
        let at = (low + DVec2::new(dx, dy)).clamp(DVec2::ZERO, DVec2::splat(last));
        at.y as u32 * size + at.x as u32
    };
    [
        (texel(0.0, 0.0), (1.0 - f.x) * (1.0 - f.y)),
        (texel(1.0, 0.0), f.x * (1.0 - f.y)),
        (texel(0.0, 1.0), (1.0 - f.x) * f.y),
        (texel(1.0, 1.0), f.x * f.y),
    ]
}
