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

use charts::{Chart, charts};
use choose::{CHANNELS, choose};
pub(crate) use field::Field;
use plane::Plane;
use rayon::prelude::*;
use stated::{Squares, Stated};

/// Charts of fewer texels keep their plain values: too few to tell noise from detail.
const FEWEST: usize = 4;

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
}

/// A texel's new values and standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Denoised {
    pub texel: u32,
    pub values: [f32; CHANNELS],
    pub std_err: f32,
}

/// The charts of a page, ready for the terms to be denoised.
pub(crate) struct Denoiser {
    size: usize,
    charts: Vec<Chart>,
}

impl Denoiser {
    /// Finds the charts of a page.
    pub fn new(field: &Field<'_>) -> Self {
        let mut charts = charts(field);
        charts.retain(|chart| chart.texels.len() >= FEWEST);
        Self {
            size: field.size,
            charts,
        }
    }

    /// The texels of the term that change.
    pub fn denoise(&self, term: &Term<'_>) -> Vec<Denoised> {
        let charts = self.charts.par_iter();
        let chosen: Vec<Vec<Chosen>> = charts.map(|chart| self.chart(chart, term)).collect();
        // In the order of the charts, whatever the number of threads.
        let stated = Stated::of(
            chosen
                .iter()
                .flatten()
                .filter_map(|texel| texel.squares.as_ref()),
        );
        let denoised = |texel: &Chosen| Denoised {
            std_err: match &texel.squares {
                Some(squares) => stated.std_err(squares),
                None => texel.denoised.std_err,
            },
            ..texel.denoised
        };
        chosen.iter().flatten().map(denoised).collect()
    }

    fn chart(&self, chart: &Chart, term: &Term<'_>) -> Vec<Chosen> {
        let local = |texel: u32| {
            let (x, y) = (texel as usize % self.size, texel as usize / self.size);
            (y - chart.at[1]) * chart.size[0] + x - chart.at[0]
        };
        let channels = term.values.len();
        let half = |texel: usize| {
            let halves = term.halves.iter().map(|half| half[texel]);
            halves.sum::<f32>() / channels as f32
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
        let mut mask = Plane::new(chart.size);
        let mut data = vec![Plane::new(chart.size); channels + 1];
        for &texel in &chart.texels {
            let (i, texel) = (local(texel), texel as usize);
            mask.values[i] = 1.0;
            for (plane, values) in data.iter_mut().zip(&term.values) {
                plane.values[i] = values[texel];
            }
            data[channels].values[i] = half(texel);
        }
        // Light may be as sharp as the sun's.
        if term.largest.is_finite() {
            strays::share(&mask, &mut data);
        }
        let mut near = Plane::new(chart.size);
        let Some(chosen) = choose(&mask, &data, &mut near) else {
            return Vec::new();
        };
        // A chart may fill its page, and what follows needs room of its own.
        drop((mask, data));
        let inexact = |texel: &&u32| term.std_err[**texel as usize] > 0.0;
        let texels = chart.texels.iter().filter(inexact);
        texels
            .map(|&texel| {
                let i = local(texel);
                let mut values = [0.0; CHANNELS];
                for (value, plane) in values.iter_mut().zip(&term.values) {
                    *value = plane[texel as usize];
                }
                let plain = values[..channels].iter().sum::<f32>() / channels as f32;
                let std_err = term.std_err[texel as usize];
                let mut denoised = Denoised {
                    texel,
                    values,
                    std_err,
                };
                if chosen[i].plain == 0.0 {
                    // All rays about it agree; the more they are, the less can have slipped between them.
                    denoised.std_err *= (POOLED / near.values[i]).min(1.0);
                    return Chosen {
                        denoised,
                        squares: None,
                    };
                }
                for (channel, value) in denoised.values[..channels].iter_mut().enumerate() {
                    *value = chosen[i].value(channel).clamp(0.0, term.largest);
                }
                let half = half(texel as usize);
                Chosen {
                    denoised,
                    squares: Some(chosen[i].squares(plain, half, channels)),
                }
            })
            .collect()
    }
}

/// A texel whose value is chosen; `None` where all rays about it agree, and its error is known.
struct Chosen {
    denoised: Denoised,
    squares: Option<Squares>,
}

#[cfg(test)]
mod tests;
