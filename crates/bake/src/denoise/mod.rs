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
mod state;
mod stated;
mod steep;
mod strays;
mod surface;

use crate::seams::SeamPoint;
use beyond::{Beyond, Borders};
use charts::{Area, Band, Chart, Charts, Run, charts};
use choose::{Chosen, choose};
use features::Features;
pub(crate) use field::Field;
use plane::{Sheet, TASK};
use rayon::prelude::*;
use stated::{Predicted, Seen, Squares, Stated};
use std::ops::Range;
use steep::steepness;
use surface::{FEATURES, Surface, SurfaceTerm};

/// Charts of fewer texels keep their plain values: too few to tell noise from detail.
const FEWEST: usize = 4;

/// Texels of a chart that are fitted at a time, each of which takes some 100 to 230 bytes meanwhile. Most charts have
/// fewer.
const AT_A_TIME: usize = 1 << 21;

/// Texels of a page, times the terms that are denoised together, at most.
const TOGETHER: usize = 1 << 23;

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
    /// One line a channel.
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

    /// So many terms are denoised together at most: what is known of the texels of a page is held for all of them.
    pub fn together(&self) -> usize {
        (TOGETHER / (self.size * self.size)).max(1)
    }

    /// What changes of each term, in parts that share no texel.
    pub fn denoise(&self, terms: &[Term<'_>]) -> Vec<Vec<Denoised>> {
        let tasks = self.tasks();
        let tasks = tasks.par_iter().with_max_len(1);
        let found = tasks.map(|charts| {
            let charts = charts
                .clone()
                .filter(|chart| self.charts.charts[*chart].texels >= FEWEST);
            charts
                .flat_map(|chart| self.chart(chart as u32, terms))
                .collect()
        });
        let found: Vec<Vec<(usize, Part)>> = found.collect();
        let mut parts: Vec<Vec<Part>> = terms.iter().map(|_| Vec::new()).collect();
        for (term, part) in found.into_iter().flatten() {
            parts[term].push(part);
        }
        parts.into_iter().map(told).collect()
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

    /// What becomes of a chart: of the terms by number the parts of its bands.
    fn chart(&self, number: u32, terms: &[Term<'_>]) -> Vec<(usize, Part)> {
        let chart = &self.charts.charts[number as usize];
        let differ = |crosses: bool| -> Vec<usize> {
            let of = (0..terms.len()).filter(|&k| terms[k].crosses == crosses);
            of.filter(|&k| terms[k].differs(chart)).collect()
        };
        let goes_on = |of: Vec<usize>| {
            let crosses = terms[*of.first()?].crosses;
            let numbers = &self.charts.number;
            Some((self.borders.beyond(number, chart, numbers, crosses), of))
        };
        let groups = match [true, false].map(|crosses| goes_on(differ(crosses))) {
            [Some((beyond, mut of)), Some((other, more))] if beyond == other => {
                of.extend(more);
                vec![(beyond, of)]
            }
            groups => groups.into_iter().flatten().collect(),
        };
        let each = groups.into_iter();
        each.flat_map(|(beyond, of)| self.chart_with(number, &beyond, &of, terms))
            .collect()
    }

    /// The same of the terms `of` that go on alike.
    fn chart_with(
        &self,
        number: u32,
        beyond: &[Beyond],
        of: &[usize],
        terms: &[Term<'_>],
    ) -> Vec<(usize, Part)> {
        let chart = &self.charts.charts[number as usize];
        let area = chart
            .area
            .with(beyond.iter().map(|beyond| beyond.place))
            .in_lanes();
        let of_surface = |surface: Surface, band: &Band| -> Vec<(usize, Part)> {
            let chosen = choose(&surface, agreed);
            let chosen = chosen.into_iter().zip(&surface.terms);
            let chosen = chosen.filter_map(|(chosen, of)| {
                let chosen = chosen?;
                let steep = steepness(&surface.mask, &chosen.0, Chosen::VALUES);
                Some((of.number, chosen, steep))
            });
            let chosen: Vec<(usize, Chosen, Sheet)> = chosen.collect();
            // A band may fill its page, and what follows needs room of its own.
            drop(surface);
            let parts = chosen.into_iter().map(|(number, chosen, steep)| {
                let term = &terms[number];
                let mut part = Part::new(term.values.len());
                for run in chart.runs_of(&area, &band.rows, self.size) {
                    let place = area.local(run.first, &band.about, self.size);
                    part.push(term, run, [&chosen.0, &steep], place);
                }
                (number, part)
            });
            parts.collect()
        };
        let parts = |band: &Band| -> Vec<(usize, Part)> {
            let surfaces = self.surfaces(number, &area, beyond, band, (of, terms));
            let surfaces = surfaces.into_iter();
            surfaces
                .flat_map(|surface| of_surface(surface, band))
                .collect()
        };
        let bands = area.bands(self.at_a_time / of.len());
        // No more at a time than there are threads: one that waits for others takes up what else there is.
        let together = bands.chunks(rayon::current_num_threads());
        let found = together.flat_map(|bands| bands.par_iter().map(parts).collect::<Vec<_>>());
        found.flatten().collect()
    }

    /// A band of a chart and what it goes on in, for the terms `of`: one surface for those that have the same texels.
    fn surfaces(
        &self,
        number: u32,
        area: &Area,
        beyond: &[Beyond],
        band: &Band,
        (of, terms): (&[usize], &[Term<'_>]),
    ) -> Vec<Surface> {
        let chart = &self.charts.charts[number as usize];
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
        let is_bent = self.features.are_of(number);
        let each = of.iter();
        let each = each.map(|&k| surface_of(k, &terms[k], size, &runs, is_bent));
        let mut surfaces = Surface::joined(each.collect());
        for surface in surfaces.iter_mut().filter(|_| is_bent) {
            surface.features = Some(self.features_of(size, &runs));
        }
        surfaces
    }

    /// The features of runs of texels at their places.
    fn features_of(&self, size: [usize; 2], runs: &[([usize; 2], Run)]) -> Sheet {
        let mut sheet = Sheet::new(size, FEATURES);
        for ([x, y], run) in runs {
            for feature in 0..FEATURES {
                let row = sheet.row_mut(feature, *y)[*x..].iter_mut();
                for (value, texel) in row.zip(run.texels()) {
                    *value = self.features.at(texel, feature);
                }
            }
        }
        sheet
    }
}

/// Runs of texels of a term at their places, without features.
fn surface_of(
    number: usize,
    term: &Term<'_>,
    size: [usize; 2],
    runs: &[([usize; 2], Run)],
    is_bent: bool,
) -> Surface {
    let channels = term.values.len();
    let set = |sheet: &mut Sheet, plane: usize, of: &[f32]| {
        for ([x, y], run) in runs {
            sheet.row_mut(plane, *y)[*x..][..run.count as usize].copy_from_slice(&of[run.texels()]);
        }
    };
    let mut mask = Sheet::new(size, 1);
    let mut errors = mask.clone();
    set(&mut errors, 0, term.std_err);
    let mut data = Sheet::new(size, channels + 1);
    for (channel, values) in term.values.iter().enumerate() {
        set(&mut data, channel, values);
    }
    if let [half] = term.halves[..] {
        set(&mut data, channels, half);
    }
    for ([x, y], run) in runs {
        let shares = &mut mask.row_mut(0, *y)[*x..][..run.count as usize];
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
        if channels > 1 {
            let halves = data.row_mut(channels, *y)[*x..]
                .iter_mut()
                .zip(run.texels());
            halves.for_each(|(half, texel)| *half = term.half(texel));
        }
    }
    if term.is_smooth {
        strays::share(&mask, &mut data);
    }
    // Fits of a bent chart follow what changes with its normals.
    if term.is_smooth && !is_bent {
        lines::set_apart(&mut mask, &mut data, &errors);
    }
    let terms = vec![SurfaceTerm {
        number,
        first: 0,
        channels,
        largest: term.largest,
        errors,
    }];
    Surface {
        mask,
        features: None,
        data,
        terms,
    }
}

/// What becomes of the texels of a term: its parts, once the page has told their standard errors.
fn told(parts: Vec<Part>) -> Vec<Denoised> {
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

impl Term<'_> {
    /// Whether a chart is not known exactly and its halves do not agree by chance: a chart may have all its light of one or two texels
    /// that see any, the others being mended from them. Two rays of theirs, one in each half, then look as if all were
    /// known.
    fn differs(&self, chart: &Chart) -> bool {
        let (mut differs, mut errors, mut is_known) = (0.0, 0.0, true);
        for texel in chart.all() {
            is_known &= self.std_err[texel] == 0.0;
            let half = f64::from(self.half(texel));
            if half != 0.0 {
                differs += half * half;
                errors += f64::from(self.std_err[texel]).powi(2);
            }
        }
        !is_known && differs >= BY_CHANCE * errors
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
        let channels = term.values.len();
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
        for (channel, values) in self.chosen.values.iter_mut().enumerate() {
            let chosen = line(Chosen::VALUES + channel).iter().zip(plain);
            values.extend(chosen.zip(run.texels()).map(
                |((value, plain), texel)| match term.std_err[texel] > 0.0 && *plain > 0.0 {
                    true => value.clamp(0.0, term.largest),
                    false => term.values[channel][texel],
                },
            ));
        }
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
