//! Denoising: an integrated term smoothed over the texels of a surface where that lowers its error.
//!
//! Each chart is fitted by polynomials over windows of several sizes ([`fit`]), and each texel takes the mean of these fits and of
//! its plain value, weighted by estimates of their errors ([`choose`]) that need no model of the noise: two independent halves of
//! its rays are fitted alike. Fits move no mean of what is fitted together: a chart and what it goes on in ([`beyond`]). The standard errors that come back include the bias that is estimated; what
//! texels predict of it is held against what the halves show of the whole page ([`stated`]).

mod beyond;
mod charts;
mod choose;
mod features;
mod field;
mod fit;
pub(crate) mod oidn;
mod plane;
mod stated;
mod strays;

use crate::seams::SeamPoint;
use beyond::Borders;
use charts::{Band, Chart, Charts, charts};
use choose::{STRIDES, Surface, Texel, Whole, choose};
use features::Features;
pub(crate) use field::Field;
use fit::FEATURES;
use plane::{Plane, TASK};
use rayon::prelude::*;
use stated::{Predicted, Seen, Stated};

/// Charts of fewer texels keep their plain values: too few to tell noise from detail.
const FEWEST: usize = 4;

/// Strides of the fits that foresee what is left of a tile's errors.
const OF_TILE: &[usize] = &[4, 16];

/// Texels of a chart that are fitted at a time, each of which takes some 100 bytes meanwhile. Most charts have fewer.
const AT_A_TIME: usize = 1 << 21;

/// Where halves of a chart differ less than by this share of the standard errors of its texels, in squares, they agree by chance.
const BY_CHANCE: f64 = 1.0 / 400.0;

/// Texels over which the standard error of a plain value pools its replicates.
const POOLED: f32 = 25.0;

/// One term of a page: planes of as many texels.
#[derive(Debug)]
pub(crate) struct Term<'a> {
    /// One plane a channel, at most three.
    pub values: Vec<&'a [f32]>,
    /// Half of the difference between two independent halves of the rays, channel by channel.
    pub halves: Vec<&'a [f32]>,
    /// Standard error of the mean of the channels; 0 where the value is exact.
    pub std_err: &'a [f32],
    /// The largest value that there is; the least is 0.
    pub largest: f32,
    /// It is a mean over the hemisphere, which no single texel has much more of than all about it.
    pub is_smooth: bool,
    /// It does not depend on materials, so that it goes on from one object to the next.
    pub crosses: bool,
}

/// New values and standard errors of some texels of a term.
#[derive(Debug, Default)]
pub(crate) struct Denoised {
    texels: Vec<u32>,
    /// One line a channel; none where the values stay.
    values: Vec<Vec<f32>>,
    std_err: Vec<f32>,
}

impl Denoised {
    /// Writes the values of a channel into its plane.
    pub fn set_values(&self, channel: usize, plane: &mut [f32]) {
        let values = self.values.iter().skip(channel).take(1).flatten();
        for (&texel, &value) in self.texels.iter().zip(values) {
            plane[texel as usize] = value;
        }
    }

    /// Writes the standard errors into their plane.
    pub fn set_errors(&self, plane: &mut [f32]) {
        for (&texel, &std_err) in self.texels.iter().zip(&self.std_err) {
            plane[texel as usize] = std_err;
        }
    }
}

/// The charts of a page, ready for the terms to be denoised.
pub(crate) struct Denoiser<'a> {
    size: usize,
    charts: Charts,
    features: Features,
    borders: Borders<'a>,
    strides: &'static [usize],
    at_a_time: usize,
}

impl<'a> Denoiser<'a> {
    /// Finds the charts of a page, and where they go on in each other: at the points of `seams`.
    pub fn new(field: &Field<'_>, seams: &'a [SeamPoint]) -> Self {
        let charts = charts(field);
        Self {
            size: field.size,
            features: Features::new(field, &charts, AT_A_TIME),
            borders: Borders::new(seams, &charts, field),
            charts,
            strides: STRIDES,
            at_a_time: AT_A_TIME,
        }
    }

    /// Finds the charts of a tile alone, to foresee with few fits what errors the page will state. One thread does it.
    pub fn of_tile(field: &Field<'_>) -> Self {
        Self {
            strides: OF_TILE,
            ..Self::new(field, &[])
        }
    }

    /// What changes of the term, in parts that share no texel.
    pub fn denoise(&self, term: &Term<'_>) -> Vec<Denoised> {
        let charts = self.charts.charts.par_iter().with_max_len(1);
        let charts = charts.with_min_len(at_least(self.size)).enumerate();
        let charts = charts.filter(|(_, chart)| chart.texels.len() >= FEWEST);
        let parts = charts.map(|(number, chart)| self.chart(number as u32, chart, term));
        let parts: Vec<Vec<Part>> = parts.collect();
        // In the order of the charts, whatever the number of threads.
        let seen = parts.iter().flatten().map(|part| &part.seen);
        let stated = Stated::of(seen);
        let parts = parts.into_iter().flatten();
        let finished = parts.map(|part| {
            let predicted = part.predicted.into_iter();
            let chosen = Denoised {
                // In place: what is known of a whole page's texels is held once.
                std_err: predicted.map(|texel| stated.std_err(&texel)).collect(),
                ..part.chosen
            };
            [part.agreeing, chosen]
        });
        finished.flatten().collect()
    }

    fn chart(&self, number: u32, chart: &Chart, term: &Term<'_>) -> Vec<Part> {
        let half = |texel: usize| {
            let halves = term.halves.iter().map(|half| half[texel]);
            halves.sum::<f32>() / term.halves.len() as f32
        };
        // A chart may have all its light of one or two texels that see any, the others being mended from them. Two rays of theirs, one in each
        // half, then look as if all were known.
        let (mut differs, mut errors) = (0.0, 0.0);
        for &texel in &chart.texels {
            let half = f64::from(half(texel as usize));
            if half != 0.0 {
                differs += half * half;
                errors += f64::from(term.std_err[texel as usize]).powi(2);
            }
        }
        if differs < BY_CHANCE * errors {
            return Vec::new();
        }
        let charts = &self.charts.number;
        let beyond = self.borders.beyond(number, chart, charts, term.crosses);
        let area = chart.area.with(beyond.iter().map(|beyond| beyond.place));
        let features = &self.features;
        let plane = |band: &Band, of: &dyn Fn(usize) -> f32| {
            let mut plane = Plane::new([area.size[0], band.about.len()]);
            for &texel in chart.texels_of(&area, &band.about, self.size) {
                plane.values[area.local(texel, &band.about, self.size)] = of(texel as usize);
            }
            let before = |row: usize| {
                beyond.partition_point(|beyond| ((beyond.place[1] - area.at[1]) as usize) < row)
            };
            for beyond in &beyond[before(band.about.start)..before(band.about.end)] {
                plane.values[area.local_at(beyond.place, &band.about)] = of(beyond.texel as usize);
            }
            plane
        };
        let surface = |band: &Band| {
            let plane = |of: &dyn Fn(usize) -> f32| plane(band, of);
            let mask = plane(&|_| 1.0);
            let feature = |k: usize| plane(&|texel| features.at(texel, k));
            let is_bent = features.are_of(number);
            let features: Vec<Plane> = (0..FEATURES).filter(|_| is_bent).map(feature).collect();
            let values = term.values.iter();
            let mut data: Vec<Plane> = values.map(|values| plane(&|texel| values[texel])).collect();
            data.push(plane(&half));
            if term.is_smooth {
                strays::share(&mask, &mut data);
            }
            Surface {
                mask,
                features,
                data,
            }
        };
        let bands = area.bands(self.at_a_time);
        // No more at a time than there are threads: one that waits for others takes up what else there is.
        let together = || bands.chunks(rayon::current_num_threads());
        let whole = (bands.len() > 1).then(|| {
            let of = |band: &Band| Whole::of(&surface(band), &band.inner());
            let wholes = together().flat_map(|bands| bands.par_iter().map(of).collect::<Vec<_>>());
            wholes.reduce(Whole::plus)
        });
        let whole = whole.flatten();
        let part = |band: &Band| {
            let mut near = Plane::new([area.size[0], band.about.len()]);
            let surface = surface(band);
            let errors = plane(band, &|texel| term.std_err[texel]);
            let dark = |i: usize, near: f32| agreed(errors.values[i], near);
            let chosen = choose(&surface, self.strides, whole.as_ref(), &mut near, dark)?;
            // A band may fill its page, and what follows needs room of its own.
            drop(surface);
            let mut part = Part::new(term.values.len());
            for &texel in chart.texels_of(&area, &band.rows, self.size) {
                let i = area.local(texel, &band.about, self.size);
                part.push(
                    term,
                    texel,
                    half(texel as usize),
                    &chosen[i],
                    near.values[i],
                );
            }
            Some(part)
        };
        let parts =
            together().flat_map(|bands| bands.par_iter().filter_map(part).collect::<Vec<_>>());
        parts.collect()
    }
}

/// What becomes of the texels of a band, before the page has told their standard errors.
struct Part {
    /// Texels about which all rays agree, with their errors.
    agreeing: Denoised,
    /// The others, without errors, and what these follow from.
    chosen: Denoised,
    predicted: Vec<Predicted>,
    seen: Seen,
}

impl Part {
    fn new(channels: usize) -> Self {
        let new = || Denoised {
            values: vec![Vec::new(); channels],
            ..Denoised::default()
        };
        Self {
            agreeing: new(),
            chosen: new(),
            predicted: Vec::new(),
            seen: Seen::default(),
        }
    }

    /// Adds a texel for which this was chosen, `near` so many of its chart about it; one that is exact stays as it is.
    fn push(&mut self, term: &Term<'_>, texel: u32, half: f32, chosen: &Texel, near: f32) {
        let std_err = term.std_err[texel as usize];
        if std_err <= 0.0 {
            return;
        }
        let channels = term.values.len();
        let part = match chosen.agrees {
            true => &mut self.agreeing,
            false => &mut self.chosen,
        };
        part.texels.push(texel);
        for (channel, line) in part.values.iter_mut().enumerate() {
            line.push(match chosen.plain > 0.0 {
                true => chosen.value(channel).clamp(0.0, term.largest),
                false => term.values[channel][texel as usize],
            });
        }
        if chosen.agrees {
            part.std_err.push(agreed(std_err, near));
            return;
        }
        let before = term.values.iter().map(|values| values[texel as usize]);
        let squares = chosen.squares(before.sum::<f32>() / channels as f32, half, channels);
        self.predicted.push(squares.predicted);
        self.seen.count(&squares);
    }
}

/// Charts of a page of this edge that one task takes at least: all where there is little to do.
fn at_least(size: usize) -> usize {
    if size * size <= TASK { usize::MAX } else { 1 }
}

/// The standard error where all rays agree, of so many texels in place of those that it stands for: the more they are, the less can have
/// slipped between them.
fn agreed(std_err: f32, near: f32) -> f32 {
    std_err * (POOLED / near).min(1.0)
}

#[cfg(test)]
mod tests;
