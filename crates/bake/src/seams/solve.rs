//! The equations of a page's seams, and what their solution moves.

use super::across::Outer;
use super::border::Chart;
use super::owner::Page;
use super::system::{Equations, LANES, Sums};
use super::{SeamPoint, SeamStats};
use glam::{DVec2, DVec4, Vec4};
use rayon::prelude::*;

/// What a difference of the two sides counts against, in units of the plane. Less would move texels for what nobody
/// sees: at an eighth of it the look-ups of the test's sphere come out farther from the light than before.
const STEP: f64 = 1.0 / 1024.0;

/// A texel's mean is never taken to be known better than this, in units of the plane.
const KNOWN: f64 = 1.0 / 1024.0;

/// Share of the range about a texel by which its best value for a look-up may differ from its mean.
const BEND: f64 = 0.02;

/// How far a gutter texel may leave its neighbours' mean, in ranges about it.
const GUTTER: f64 = 2.0;

/// Standard errors of the two sides within which their difference may be noise.
const NOISE: f64 = 3.0;

/// What the square of a difference beyond noise counts against as well, in units of the plane. Where light changes much
/// from one texel to the next, as at a contact or on charts of two texels, look-ups cannot hold what is on either side,
/// and to make them agree would take it from whole texels. At none, lines are drawn along the bevels of a helmet; at
/// twice this, steps of the test's sphere are nearly seen.
const HELD: f64 = 0.5;

/// How far a texel that is covered may leave its mean, in standard errors: its own, or the root mean square of all that
/// seams read where that is more, since an error that few rays tell may be far too small. Noise beyond it has one texel
/// in two thousand. At 3, steps of the test's sphere are left with 16 rays; at 5, look-ups of a helmet have twice as
/// much more error.
const NOISY: f64 = 3.5;

/// The same in units of the plane, if that is more. A step that asks for more is seen on few texels and stays in part;
/// else whole texels of narrow charts would be wrong. At half of this steps of a town with texels as large as its
/// windows are three times as large.
const FREE: f64 = 0.1;

/// A move of less than this, in units of the plane, is none.
const REST: f64 = 1e-6;

/// Texels that a plane cannot hold are put where it ends and the rest is solved again, so often at most.
const ROUNDS: usize = 3;

/// Places are looked up to so many parts of a texel, so that the weights of a look-up are exact and add up to 1.
const PARTS: f64 = 4096.0;

/// Texels and their weights in a bilinear look-up.
pub(super) type Taps = [(u32, f32); 4];

/// Which texels seams read, and how.
#[derive(Debug)]
pub(crate) struct System {
    size: usize,
    /// The texels that may move, ascending.
    texels: Vec<u32>,
    /// For each point of a seam the difference of its two look-ups, then the look-ups of `tied`, then for each texel
    /// the one that its mean stands for; all by indices into `texels`.
    sums: Sums,
    /// Texels of seam that each point stands for, of those whose other side is on a page that is finished before too.
    lengths: Vec<f64>,
    /// Their numbers.
    tied: Vec<usize>,
    /// Points of which this page is finished before the other, and their look-ups.
    kept: Vec<(usize, Taps)>,
}

/// What is known about the texels of a plane.
pub(crate) struct Known<'a> {
    /// What other pages hold at the points of [`System::tied`], NaN where that is not known.
    pub tied: Vec<f64>,
    /// The values, texel by texel of the page.
    pub values: &'a [f32],
    /// Their standard errors; 0 for a texel that is exact and stays.
    pub std_errs: &'a [f32],
    /// What an open texel has, about.
    pub unit: f64,
    /// The largest value that the plane can have.
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
        let points: Vec<(&SeamPoint, [Taps; 2])> = points
            .par_iter()
            .map(|point| (point, look(point)))
            .filter(|(point, sides)| {
                let mut sides = sides.iter().zip(point.charts);
                sides.all(|(side, chart)| is_own(side, chart) && is_seen(side))
            })
            .collect();
        let (later, earlier): (Vec<_>, Vec<_>) = outer
            .iter()
            .map(|outer| (outer, on_page(outer)))
            .filter(|(outer, side)| is_own(side, outer.chart) && is_seen(side))
            .partition(|(outer, _)| outer.later);
        let sides = points.par_iter().flat_map_iter(|(_, sides)| *sides);
        let sides = sides.chain(later.par_iter().map(|(_, side)| *side));
        let read = texels_of(sides.clone());
        let middle = |texel: &u32| owner(texel).map_or(page.centre(*texel), |owner| owner.middle);
        let own: Vec<Taps> = read.iter().map(|t| taps(middle(t), page.size)).collect();
        let texels = texels_of(sides.chain(own.par_iter().copied()));
        let numbered = |taps: &Taps| {
            taps.map(|(texel, weight)| match texels.binary_search(&texel) {
                Ok(number) => (number as u32, weight),
                Err(_) => (0, 0.0),
            })
        };
        let steps = points.iter().flat_map(|(_, [a, b])| {
            let b = b.map(|(texel, weight)| (texel, -weight));
            [(false, numbered(a)), (true, numbered(&b))]
        });
        let ties = later.iter().map(|(_, side)| (true, numbered(side)));
        let means = texels.iter().enumerate().map(|(number, texel)| {
            let own = read.binary_search(texel).map(|at| numbered(&own[at]));
            let itself = [(number as u32, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
            (true, own.unwrap_or(itself))
        });
        let lengths = points.iter().map(|(point, _)| point.length);
        Self {
            size: page.size as usize,
            sums: Sums::new(texels.len(), steps.chain(ties).chain(means)),
            lengths: lengths
                .chain(later.iter().map(|(outer, _)| outer.length))
                .collect(),
            tied: later.iter().map(|(outer, _)| outer.number).collect(),
            kept: earlier
                .iter()
                .map(|(outer, side)| (outer.number, *side))
                .collect(),
            texels,
        }
    }

    /// Numbers of the points whose other side is on pages that are finished before.
    pub fn tied(&self) -> &[usize] {
        &self.tied
    }

    /// What a finished plane holds at points whose other side is on pages that are finished later.
    pub fn kept(&self, plane: &[f32]) -> Vec<(usize, f32)> {
        let value = |side: &Taps| {
            let of_tap = |&(texel, w): &(u32, f32)| f64::from(w) * f64::from(plane[texel as usize]);
            side.iter().map(of_tap).sum::<f64>() as f32
        };
        let kept = self.kept.iter();
        kept.map(|(number, side)| (*number, value(side))).collect()
    }

    /// Moves the texels of planes whose other texels stay. `coverage` is the page's.
    pub fn solve(&self, planes: &[Known<'_>], coverage: &[f32]) -> Vec<Moved> {
        let groups = planes.par_chunks(LANES);
        let solved = groups.flat_map_iter(|group| self.solve_group(group, coverage));
        solved.collect()
    }

    fn solve_group(&self, group: &[Known<'_>], coverage: &[f32]) -> Vec<Moved> {
        let planes: Vec<Plane> = group
            .par_iter()
            .map(|known| Plane::new(self, known, coverage))
            .collect();
        let counts = |row: usize| {
            let (mut weights, mut lacks) = (Vec4::ZERO, Vec4::ZERO);
            for (lane, plane) in planes.iter().enumerate() {
                let (weight, lack) = plane.counts(row);
                (weights[lane], lacks[lane]) = (weight as f32, lack as f32);
            }
            (weights, lacks)
        };
        let (weights, lacks) = (0..self.sums.count()).into_par_iter().map(counts).unzip();
        let equations = Equations {
            sums: &self.sums,
            weights,
            lacks,
        };
        let mut free = vec![Vec4::ZERO; self.texels.len()];
        let mut moves = free.clone();
        for (lane, plane) in planes.iter().enumerate() {
            let movable = free.iter_mut().enumerate();
            movable
                .filter(|(i, _)| !plane.is_exact(*i))
                .for_each(|(_, free)| free[lane] = 1.0);
        }
        let mut rest = DVec4::ZERO;
        for _ in 0..ROUNDS {
            equations.solve(&mut moves, &free, &mut rest);
            let mut beyond = [false; LANES];
            for (i, (moves, free)) in moves.iter_mut().zip(&mut free).enumerate() {
                for (lane, plane) in planes.iter().enumerate() {
                    let ([least, most], moved) = (plane.room(i), f64::from(moves[lane]));
                    if free[lane] > 0.0 && !(least..=most).contains(&moved) {
                        moves[lane] = moved.clamp(least, most) as f32;
                        (free[lane], beyond[lane]) = (0.0, true);
                    }
                }
            }
            if beyond == [false; LANES] {
                break;
            }
            rest = DVec4::select(beyond.into(), rest, DVec4::INFINITY);
        }
        let lanes = planes.par_iter().enumerate();
        let moved = |(lane, plane): (usize, &Plane<'_>)| plane.moved(|i| moves[i][lane].into());
        lanes.map(moved).collect()
    }
}

/// A plane while its seams are solved. Moves and what they count against are in its units.
struct Plane<'a> {
    system: &'a System,
    known: &'a Known<'a>,
    coverage: &'a [f32],
    about: Vec<About>,
    /// What is not known of the mean of each texel; 0 of a gutter texel, which has no mean.
    doubts: Vec<f32>,
}

impl<'a> Plane<'a> {
    fn new(system: &'a System, known: &'a Known<'a>, coverage: &'a [f32]) -> Self {
        let texels = system.texels.par_iter().map(|&texel| texel as usize);
        let about = texels.map(|texel| About::of(texel, known.values, coverage, system.size));
        let mut plane = Self {
            system,
            known,
            coverage,
            about: about.collect(),
            doubts: Vec::new(),
        };
        let doubt = |i: usize| match plane.covered(i) > 0.0 {
            true => {
                let squares = plane.std_err(i).powi(2) + (BEND * plane.range(i)).powi(2);
                (squares + KNOWN.powi(2)).sqrt() as f32
            }
            false => 0.0,
        };
        plane.doubts = (0..plane.about.len()).into_par_iter().map(doubt).collect();
        plane
    }

    fn value(&self, i: u32) -> f64 {
        f64::from(self.about[i as usize].value) / self.known.unit
    }

    fn range(&self, i: usize) -> f64 {
        f64::from(self.about[i].high - self.about[i].low) / self.known.unit
    }

    fn covered(&self, i: usize) -> f64 {
        self.coverage[self.system.texels[i] as usize].into()
    }

    /// The standard error of a texel; 0 of a gutter texel.
    fn std_err(&self, i: usize) -> f64 {
        let std_err = self.known.std_errs[self.system.texels[i] as usize];
        match self.covered(i) > 0.0 {
            true => f64::from(std_err) / self.known.unit,
            false => 0.0,
        }
    }

    /// True for a texel that stays.
    fn is_exact(&self, i: usize) -> bool {
        self.covered(i) > 0.0 && self.std_err(i) == 0.0
    }

    /// How far a texel may move down and up, so that the plane can hold it.
    fn room(&self, i: usize) -> [f64; 2] {
        let About { value, high, .. } = self.about[i];
        let most = self.known.most.max(high.into());
        [0.0, most].map(|end| (end - f64::from(value)) / self.known.unit)
    }

    /// What the square of what a sum lacks counts, and what it lacks.
    fn counts(&self, row: usize) -> (f64, f64) {
        let taps = self.system.sums.taps(row);
        let lack = self.other(row) - self.sum(row, |i| self.value(i));
        let lengths = &self.system.lengths;
        if let Some(i) = row.checked_sub(lengths.len()) {
            return match self.covered(i) {
                0.0 => ((GUTTER * (self.range(i) + KNOWN)).powi(-2), 0.0),
                covered => (covered / f64::from(self.doubts[i]).powi(2), lack),
            };
        }
        if lack.is_nan() {
            return (0.0, 0.0);
        }
        let variance = |&(i, w): &(u32, f32)| f64::from(w * self.doubts[i as usize]).powi(2);
        let noise = NOISE * taps.iter().map(variance).sum::<f64>().sqrt();
        let against = STEP + HELD * (lack.abs() - noise).max(0.0).powi(2);
        (lengths[row] / against.powi(2), lack)
    }

    fn sum(&self, row: usize, value: impl Fn(u32) -> f64) -> f64 {
        let taps = self.system.sums.taps(row).iter();
        taps.map(|&(i, w)| f64::from(w) * value(i)).sum()
    }

    /// What a sum should be: at a point nothing, which is no difference, or what another page holds there, else the
    /// value of its texel.
    fn other(&self, row: usize) -> f64 {
        let points = self.system.lengths.len();
        match row.checked_sub(points) {
            Some(texel) => self.value(texel as u32),
            None => match row.checked_sub(points - self.system.tied.len()) {
                Some(tie) => self.known.tied[tie] / self.known.unit,
                None => 0.0,
            },
        }
    }

    /// Where its texels end, none of those that are covered farther away than it may go.
    fn moved(&self, moves: impl Fn(usize) -> f64) -> Moved {
        let texels = 0..self.about.len();
        let std_errs = texels.clone().map(|i| self.std_err(i));
        let (count, squares) = std_errs.fold((0u32, 0.0), |(count, sum), std_err| {
            (count + u32::from(std_err > 0.0), sum + std_err.powi(2))
        });
        let common = (squares / f64::from(count.max(1))).sqrt();
        let end = |i: usize| {
            let far = match self.covered(i) > 0.0 {
                true => f64::max(NOISY * self.std_err(i).max(common), FREE),
                false => f64::INFINITY,
            };
            // What is at rest stays to the last bit, and does not take up what rounding leaves.
            match moves(i).clamp(-far, far) {
                moved if moved.abs() < REST => self.about[i].value,
                moved => ((self.value(i as u32) + moved).max(0.0) * self.known.unit) as f32,
            }
        };
        let values: Vec<f32> = texels.map(end).collect();
        let (squares_before, max_before) = self.differences(|i| self.about[i as usize].value);
        let (squares_after, max_after) = self.differences(|i| values[i as usize]);
        let own = self.about.iter().zip(&values).enumerate();
        let own = own.filter(|&(i, _)| self.covered(i) > 0.0);
        let squares = own.map(|(_, (about, value))| f64::from(value - about.value).powi(2));
        let squares_moved = squares.sum();
        let known = self.known.tied.iter().filter(|value| !value.is_nan());
        let steps = self.system.lengths.len() - self.system.tied.len();
        Moved {
            stats: SeamStats {
                points: (steps + known.count()) as u64,
                squares_before,
                squares_after,
                max_before,
                max_after,
                squares_moved,
            },
            values: self.system.texels.iter().copied().zip(values).collect(),
        }
    }

    /// Sum of squares and largest of the differences of the two sides.
    fn differences(&self, value: impl Fn(u32) -> f32) -> (f64, f64) {
        let unit = self.known.unit;
        let difference = |row: usize| {
            let found = self.sum(row, |i| value(i).into());
            (found - self.other(row) * unit).abs()
        };
        let known = (0..self.system.lengths.len()).map(difference);
        let known = known.filter(|difference| !difference.is_nan());
        known.fold((0.0, 0.0), |(sum, most), difference| {
            (sum + difference * difference, difference.max(most))
        })
    }
}

/// A texel and its neighbours in a plane.
struct About {
    /// Its value, or the mean of its covered neighbours where it has none.
    value: f32,
    /// The least and the largest value of itself and its covered neighbours.
    low: f32,
    high: f32,
}

impl About {
    fn of(texel: usize, values: &[f32], coverage: &[f32], size: usize) -> Self {
        let (x, y) = (texel % size, texel / size);
        let mut about = Self {
            value: values[texel],
            low: f32::INFINITY,
            high: f32::NEG_INFINITY,
        };
        let own = coverage[texel] > 0.0;
        for radius in 1..=2 {
            let (mut sum, mut count) = (0.0, 0);
            for v in y.saturating_sub(radius)..(y + radius + 1).min(size) {
                for u in x.saturating_sub(radius)..(x + radius + 1).min(size) {
                    let other = v * size + u;
                    if coverage[other] > 0.0 {
                        let value = values[other];
                        (sum, count) = (sum + f64::from(value), count + 1);
                        (about.low, about.high) = (about.low.min(value), about.high.max(value));
                    }
                }
            }
            if count > 0 {
                if !own {
                    about.value = (sum / f64::from(count)) as f32;
                }
                return about;
            }
        }
        (about.low, about.high) = (about.value, about.value);
        about
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

/// The four texels of a bilinear look-up at a place in texels of the page, whose edge is repeated outside. Texels that
/// count nothing have the weight 0.
pub(super) fn taps(p: DVec2, size: u32) -> Taps {
    let p = ((p - 0.5) * PARTS).round() / PARTS;
    let low = p.floor();
    let f = (p - low).as_vec2();
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
