//! Denoising: an integrated term smoothed over the texels of a surface where that lowers its error.
//!
//! Each chart is fitted by polynomials over windows of several sizes ([`fit`]), and each texel takes the mean of these
//! fits and of its plain value, weighted by estimates of their errors ([`choose`]) that need no model of the noise: two
//! independent halves of its rays are fitted alike. Fits move no mean of what is fitted together: a chart and what it
//! goes on in ([`beyond`]). The standard errors that come back include the bias that is estimated; what texels predict
//! of it is held against what the halves show of the whole page ([`stated`]).

mod beyond;
mod charts;
mod choose;
mod features;
mod field;
mod fit;
mod lanes;
mod lines;
pub(crate) mod oidn;
mod plane;
mod stated;
mod steep;
mod strays;
mod surface;

use crate::seams::SeamPoint;
use beyond::{Beyond, Borders};
use charts::{Area, Band, Charts, Run, charts};
use choose::{Chosen, choose};
use features::Features;
pub(crate) use field::Field;
use plane::{Sheet, TASK};
use rayon::prelude::*;
use stated::{Predicted, Seen, Squares, Stated};
use std::ops::Range;
use steep::steepness;
use surface::{FEATURES, Surface};

/// Charts of fewer texels keep their plain values: too few to tell noise from detail.
const FEWEST: usize = 4;

/// Texels of a chart that are fitted at a time, each of which takes some 100 to 230 bytes meanwhile. Most charts have
/// fewer.
const AT_A_TIME: usize = 1 << 21;

/// Where halves of a chart differ less than by this share of the standard errors of its texels, in squares, they agree
/// by chance.
const BY_CHANCE: f64 = 1.0 / 400.0;

/// Texels over which the standard error of a plain value pools its replicates.
const POOLED: f32 = 25.0;

/// One term of a page: planes of as many texels.
#[derive(Debug)]
pub(crate) struct Term<'a> {
    /// One plane a channel, at most three.
    pub values: Vec<&'a [f32]>,
    /// What the same rays say besides: smoothed as the values are, which alone decide how.
    pub riders: Vec<&'a [f32]>,
    /// Half of the difference between two independent halves of the rays, channel by channel.
    pub halves: Vec<&'a [f32]>,
    /// Standard error of the mean of the channels; 0 where the value is exact.
    pub std_err: &'a [f32],
    /// Share of what can be seen of a texel that something seals: the term is 0 there, and fits leave it out.
    /// `None` where nothing is.
    pub sealed: Option<&'a [f32]>,
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
    runs: Vec<Run>,
    /// One line a channel, those of riders last.
    values: Vec<Vec<f32>>,
    /// None where the errors stay.
    std_err: Vec<f32>,
}

impl Denoised {
    /// Writes the values of a channel into its plane.
    pub fn set_values(&self, channel: usize, plane: &mut [f32]) {
        self.set(&self.values[channel], plane);
    }

    /// Writes the standard errors into their plane.
    pub fn set_errors(&self, plane: &mut [f32]) {
        self.set(&self.std_err, plane);
    }

    fn set(&self, mut line: &[f32], plane: &mut [f32]) {
        for run in self.runs.iter().filter(|_| !line.is_empty()) {
            let (own, rest) = line.split_at(run.count as usize);
            plane[run.texels()].copy_from_slice(own);
            line = rest;
        }
    }
}

/// The charts of a page, ready for the terms to be denoised.
pub(crate) struct Denoiser<'a> {
    size: usize,
    charts: Charts,
    features: Features,
    borders: Borders<'a>,
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
            at_a_time: AT_A_TIME,
        }
    }

    /// What changes of the term, in parts that share no texel.
    pub fn denoise(&self, term: &Term<'_>) -> Vec<Denoised> {
        let tasks = self.tasks();
        let tasks = tasks.par_iter().with_max_len(1);
        let parts = tasks.map(|charts| {
            let charts = charts
                .clone()
                .filter(|chart| self.charts.charts[*chart].texels >= FEWEST);
            charts
                .flat_map(|chart| self.chart(chart as u32, term))
                .collect()
        });
        let parts: Vec<Vec<Part>> = parts.collect();
        let parts: Vec<Part> = parts.into_iter().flatten().collect();
        // In the order of the charts, whatever the number of threads.
        let mut stated = Stated::of(parts.iter().map(|part| &part.seen));
        let shown = parts.par_iter().map(|part| stated.shown(&part.texels));
        stated.sort(&shown.collect::<Vec<_>>());
        let finished = parts.into_iter().map(|part| {
            let texels = part.texels.into_iter();
            Denoised {
                // In place: what is known of a whole page's texels is held once.
                std_err: texels.map(|texel| stated.std_err(&texel)).collect(),
                ..part.chosen
            }
        });
        finished.collect()
    }

    /// Charts that one task takes: several where they are small.
    fn tasks(&self) -> Vec<Range<usize>> {
        let mut tasks = Vec::new();
        let (mut first, mut texels) = (0, 0);
        for (number, chart) in self.charts.charts.iter().enumerate() {
            texels += chart.texels;
            if texels >= TASK || number + 1 == self.charts.charts.len() {
                tasks.push(first..number + 1);
                (first, texels) = (number + 1, 0);
            }
        }
        tasks
    }

    fn chart(&self, number: u32, term: &Term<'_>) -> Vec<Part> {
        let chart = &self.charts.charts[number as usize];
        // A chart may have all its light of one or two texels that see any, the others being mended from them. Two rays
        // of theirs, one in each half, then look as if all were known.
        let (mut differs, mut errors) = (0.0, 0.0);
        for texel in chart.all() {
            let half = f64::from(term.half(texel));
            if half != 0.0 {
                differs += half * half;
                errors += f64::from(term.std_err[texel]).powi(2);
            }
        }
        if differs < BY_CHANCE * errors {
            return Vec::new();
        }
        let beyond = self
            .borders
            .beyond(number, chart, &self.charts.number, term.crosses);
        let area = chart
            .area
            .with(beyond.iter().map(|beyond| beyond.place))
            .in_lanes();
        let part = |band: &Band| {
            let surface = self.surface(number, &area, &beyond, band, term);
            let chosen = choose(&surface, term.largest, agreed)?;
            let leading = Chosen::VALUES..Chosen::VALUES + surface.leading;
            let steep = steepness(&surface.mask, &chosen.0, leading);
            // A band may fill its page, and what follows needs room of its own.
            drop(surface);
            let mut part = Part::new(term.planes().count());
            for run in chart.runs_of(&area, &band.rows, self.size) {
                let place = area.local(run.first, &band.about, self.size);
                part.push(term, run, [&chosen.0, &steep], place);
            }
            Some(part)
        };
        let bands = area.bands(self.at_a_time);
        // No more at a time than there are threads: one that waits for others takes up what else there is.
        let together = bands.chunks(rayon::current_num_threads());
        let parts =
            together.flat_map(|bands| bands.par_iter().filter_map(part).collect::<Vec<_>>());
        parts.collect()
    }

    /// A band of a chart and what it goes on in.
    fn surface(
        &self,
        number: u32,
        area: &Area,
        beyond: &[Beyond],
        band: &Band,
        term: &Term<'_>,
    ) -> Surface {
        let chart = &self.charts.charts[number as usize];
        let channels = term.planes().count();
        let size = [area.size[0], band.about.len()];
        let of_others = |row: usize| {
            beyond.partition_point(|beyond| ((beyond.place[1] - area.at[1]) as usize) < row)
        };
        let own = chart.runs_of(area, &band.about, self.size).iter();
        let own = own.map(|run| (area.local(run.first, &band.about, self.size), *run));
        let others = beyond[of_others(band.about.start)..of_others(band.about.end)].iter();
        let others = others.map(|beyond| {
            let run = Run {
                first: beyond.texel,
                count: 1,
            };
            (area.local_at(beyond.place, &band.about), run)
        });
        let runs: Vec<([usize; 2], Run)> = own.chain(others).collect();
        let set = |sheet: &mut Sheet, plane: usize, of: &[f32]| {
            for ([x, y], run) in &runs {
                sheet.row_mut(plane, *y)[*x..][..run.count as usize]
                    .copy_from_slice(&of[run.texels()]);
            }
        };
        let mut mask = Sheet::new(size, 1);
        let mut errors = mask.clone();
        set(&mut errors, 0, term.std_err);
        let mut data = Sheet::new(size, channels + 1);
        for (channel, values) in term.planes().enumerate() {
            set(&mut data, channel, values);
        }
        if let [half] = term.halves[..] {
            set(&mut data, channels, half);
        }
        let mut features = self
            .features
            .are_of(number)
            .then(|| Sheet::new(size, FEATURES));
        for ([x, y], run) in &runs {
            let count = run.count as usize;
            let shares = &mut mask.row_mut(0, *y)[*x..][..count];
            match term.sealed {
                None => shares.fill(1.0),
                Some(sealed) => {
                    let open = sealed[run.texels()].iter().map(|sealed| 1.0 - sealed);
                    shares
                        .iter_mut()
                        .zip(open)
                        .for_each(|(share, open)| *share = open);
                }
            }
            if term.halves.len() > 1 {
                let halves = data.row_mut(channels, *y)[*x..]
                    .iter_mut()
                    .zip(run.texels());
                halves.for_each(|(half, texel)| *half = term.half(texel));
            }
            if let Some(sheet) = &mut features {
                for feature in 0..FEATURES {
                    let row = sheet.row_mut(feature, *y)[*x..]
                        .iter_mut()
                        .zip(run.texels());
                    row.for_each(|(value, texel)| *value = self.features.at(texel, feature));
                }
            }
        }
        let mut surface = Surface {
            mask,
            features,
            data,
            leading: term.values.len(),
            errors,
        };
        if term.is_smooth {
            strays::share(&mut surface);
        }
        // Fits of a bent chart follow what changes with its normals.
        if term.is_smooth && surface.features.is_none() {
            lines::set_apart(&mut surface);
        }
        surface
    }
}

impl<'a> Term<'a> {
    /// The planes that are smoothed.
    fn planes(&self) -> impl Iterator<Item = &'a [f32]> {
        self.values.iter().chain(&self.riders).copied()
    }

    /// The mean channel of half the difference of a texel's halves.
    fn half(&self, texel: usize) -> f32 {
        let halves = self.halves.iter().map(|half| half[texel]);
        halves.sum::<f32>() / self.halves.len() as f32
    }
}

/// What becomes of the texels of a band, before the page has told their standard errors.
struct Part {
    /// Without errors, and what these follow from.
    chosen: Denoised,
    texels: Vec<Squares>,
    seen: Seen,
}

impl Part {
    fn new(channels: usize) -> Self {
        Self {
            chosen: Denoised {
                values: vec![Vec::new(); channels],
                ..Denoised::default()
            },
            texels: Vec::new(),
            seen: Seen::default(),
        }
    }

    /// Adds texels from a place on, of what was chosen and of how steep that is; those that are exact or were set apart
    /// stay as they are.
    fn push(
        &mut self,
        term: &Term<'_>,
        run: &Run,
        [chosen, steep]: [&Sheet; 2],
        [x, y]: [usize; 2],
    ) {
        self.chosen.runs.push(*run);
        let line = |plane: usize| &chosen.row(plane, y)[x..];
        let steep = &steep.row(0, y)[x..];
        let [plain, variance, near_bias, halves, near] = [
            Chosen::PLAIN,
            Chosen::VARIANCE,
            Chosen::NEAR_BIAS,
            Chosen::HALF,
            Chosen::NEAR,
        ]
        .map(line);
        let lines = self.chosen.values.iter_mut().zip(term.planes());
        for (channel, (values, before)) in lines.enumerate() {
            let chosen = line(Chosen::VALUES + channel).iter().zip(plain);
            values.extend(chosen.zip(run.texels()).map(
                |((value, plain), texel)| match term.std_err[texel] > 0.0 && *plain > 0.0 {
                    true => value.clamp(0.0, term.largest),
                    false => before[texel],
                },
            ));
        }
        let channels = term.values.len();
        for (k, texel) in run.texels().enumerate() {
            let std_err = term.std_err[texel];
            if std_err <= 0.0 || plain[k] == 0.0 {
                let known = if std_err > 0.0 {
                    agreed(std_err, near[k])
                } else {
                    std_err
                };
                self.texels.push(Squares::known(known * known));
                continue;
            }
            let chosen = (0..channels).map(|channel| line(Chosen::VALUES + channel)[k]);
            let before = term.values.iter().map(|values| values[texel]);
            let moved = (chosen.sum::<f32>() - before.sum::<f32>()) / channels as f32;
            let (left, half) = (halves[k], halves[k] - term.half(texel));
            let predicted = Predicted {
                plain: plain[k],
                variance: variance[k],
                near_bias: near_bias[k],
            };
            let texel = Squares {
                predicted,
                seen_variance: left * left,
                seen_bias: moved * moved - half * half,
                steep: steep[k],
            };
            self.seen.count(&texel);
            self.texels.push(texel);
        }
    }
}

/// Charts of a page of this edge that one task takes at least: all where there is little to do.
fn at_least(size: usize) -> usize {
    if size * size <= TASK { usize::MAX } else { 1 }
}

/// The standard error where all rays agree, of so many texels in place of those that it stands for: the more they are,
/// the less can have slipped between them.
fn agreed(std_err: f32, near: f32) -> f32 {
    std_err * (POOLED / near).min(1.0)
}

#[cfg(test)]
mod tests;
