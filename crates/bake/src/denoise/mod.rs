//! Denoising: an integrated term smoothed over the texels of a surface where that lowers its error.
//!
//! Each chart is fitted by polynomials over windows of several sizes ([`fit`]), and each texel takes the mean of these fits and of
//! its plain value, weighted by estimates of their errors ([`choose`]) that need no model of the noise: two independent halves of
//! its rays are fitted alike. Fits move no chart's mean. The standard errors that come back include the bias that is estimated; what
//! texels predict of it is held against what the halves show of the whole page ([`stated`]).

mod charts;
mod choose;
mod field;
mod fit;
pub(crate) mod oidn;
mod plane;
mod stated;
mod strays;

use charts::{Band, Chart, charts};
use choose::{Texel, Whole, choose};
pub(crate) use field::Field;
use plane::Plane;
use rayon::prelude::*;
use stated::{Predicted, Seen, Stated};

/// Charts of fewer texels keep their plain values: too few to tell noise from detail.
const FEWEST: usize = 4;

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
pub(crate) struct Denoiser {
    size: usize,
    charts: Vec<Chart>,
    at_a_time: usize,
}

impl Denoiser {
    /// Finds the charts of a page.
    pub fn new(field: &Field<'_>) -> Self {
        let mut charts = charts(field);
        charts.retain(|chart| chart.texels.len() >= FEWEST);
        Self {
            size: field.size,
            charts,
            at_a_time: AT_A_TIME,
        }
    }

    /// What changes of the term, in parts that share no texel.
    pub fn denoise(&self, term: &Term<'_>) -> Vec<Denoised> {
        let charts = self.charts.par_iter().with_max_len(1);
        let parts: Vec<Vec<Part>> = charts.map(|chart| self.chart(chart, term)).collect();
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

    fn chart(&self, chart: &Chart, term: &Term<'_>) -> Vec<Part> {
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
        let planes = |band: &Band| {
            let plane = |of: &dyn Fn(usize) -> f32| {
                let mut plane = Plane::new([chart.size[0], band.about.len()]);
                for &texel in chart.texels_of(&band.about, self.size) {
                    plane.values[chart.local(texel, &band.about, self.size)] = of(texel as usize);
                }
                plane
            };
            let mask = plane(&|_| 1.0);
            let values = term.values.iter();
            let mut data: Vec<Plane> = values.map(|values| plane(&|texel| values[texel])).collect();
            data.push(plane(&half));
            if term.is_smooth {
                strays::share(&mask, &mut data);
            }
            (mask, data)
        };
        let bands = chart.bands(self.at_a_time);
        // No more at a time than there are threads: one that waits for others takes up what else there is.
        let together = || bands.chunks(rayon::current_num_threads());
        let whole = (bands.len() > 1).then(|| {
            let of = |band: &Band| {
                let (mask, data) = planes(band);
                Whole::of(&mask, &data[term.values.len()], &band.inner())
            };
            let wholes = together().flat_map(|bands| bands.par_iter().map(of).collect::<Vec<_>>());
            wholes.reduce(Whole::plus)
        });
        let whole = whole.flatten();
        let part = |band: &Band| {
            let mut near = Plane::new([chart.size[0], band.about.len()]);
            let (mask, data) = planes(band);
            let chosen = choose(&mask, &data, whole.as_ref(), &mut near)?;
            // A band may fill its page, and what follows needs room of its own.
            drop((mask, data));
            let mut part = Part::new(term.values.len());
            for &texel in chart.texels_of(&band.rows, self.size) {
                let i = chart.local(texel, &band.about, self.size);
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
    /// Texels about which all rays agree, and whose errors are known.
    agreeing: Denoised,
    /// The others, without errors, and what these follow from.
    chosen: Denoised,
    predicted: Vec<Predicted>,
    seen: Seen,
}

impl Part {
    fn new(channels: usize) -> Self {
        Self {
            agreeing: Denoised::default(),
            chosen: Denoised {
                values: vec![Vec::new(); channels],
                ..Denoised::default()
            },
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
        if chosen.plain == 0.0 {
            // The more they are that agree, the less can have slipped between them.
            self.agreeing.texels.push(texel);
            self.agreeing
                .std_err
                .push(std_err * (POOLED / near).min(1.0));
            return;
        }
        let channels = term.values.len();
        let before = term.values.iter().map(|values| values[texel as usize]);
        let squares = chosen.squares(before.sum::<f32>() / channels as f32, half, channels);
        self.chosen.texels.push(texel);
        for (channel, line) in self.chosen.values.iter_mut().enumerate() {
            line.push(chosen.value(channel).clamp(0.0, term.largest));
        }
        self.predicted.push(squares.predicted);
        self.seen.count(&squares);
    }
}

#[cfg(test)]
mod tests;
