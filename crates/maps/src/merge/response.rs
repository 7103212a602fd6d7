//! Response curves of a camera: exposure by recorded value, given or found from the brackets.
//!
//! P. Debevec, J. Malik, "Recovering High Dynamic Range Radiance Maps from Photographs" (1997), minimise over the curve
//! and the radiances x the weighted squares of g(z) - ln x - ln t, with g the logarithmic exposure of level z. M.
//! Robertson, S. Borman, R. Stevenson, "Dynamic Range Improvement Through Multiple Exposures" (1999), minimise those of
//! f(z) - t x. Here either objective is minimised over curves of one form,
//!
//! ln f(z) = a ln z + b ln(256 - z) + a polynomial in arccos(1 - 2z/255),
//!
//! which are positive, hold power laws exactly and bend at both ends as film does. Both papers solve for 256 free
//! levels, Debevec and Malik against a weight on its bends. But evenly spaced times leave every wave in log exposure
//! that has their spacing as its period unobserved (M. Grossberg, S. Nayar, "Determining the Camera Response from
//! Images: What Is Knowable?", 2003); free levels take it up, and a weight on bends flattens the curve instead.
//!
//! The weights follow from one assumption: every level has the same noise. A residual then has the variance of g or f
//! by its slope, squared, so the fit is repeated with the slopes that it found. The radiances of both objectives are
//! linear and eliminated pixel by pixel.

use super::{Bracket, Model, trust, views};
use ambient::solve::cholesky;
use environment::Error;
use rayon::prelude::*;

/// Recorded values.
const VALUES: usize = 1 << 16;

/// Recorded steps in a level.
const STEP: usize = 257;

/// Most pixels that enter a fit; larger pictures are thinned evenly.
const FIT_PIXELS: usize = 1 << 16;

/// Lowest value that enters a fit; below it a curve goes on as a power law. Noise of a level or two turns no such value
/// to black.
const DARKEST: usize = 4 * STEP;

/// Highest value that enters a fit.
const BRIGHTEST: usize = 250 * STEP;

/// Highest degree of the polynomial in a curve.
const DEGREE: usize = 8;

/// Terms of a curve's logarithm.
const TERMS: usize = DEGREE + 2;

/// Most repetitions of a fit with new weights, taken at the recorded values, and as many at the predicted ones.
const ROUNDS: usize = 8;

/// Exposure (radiance times time) by recorded value of one channel; it grows strictly.
#[derive(Debug, Clone, PartialEq)]
pub struct Response(Vec<f64>);

impl Response {
    /// The curve value = exposure, 1 at the top.
    pub fn linear() -> Response {
        Response::by(|v| v)
    }

    /// The curve of IEC 61966-2-1, 1 at the top.
    pub fn srgb() -> Response {
        Response::by(srgb)
    }

    fn by(curve: impl Fn(f64) -> f64) -> Response {
        Response((0..VALUES).map(|v| curve(v as f64 / 65535.0)).collect())
    }

    /// The curve that is linear between the exposures of 256 levels, which grow.
    pub(super) fn of_levels(levels: &[f64]) -> Response {
        let at = |value: usize| {
            let (level, rest) = (value / STEP, value % STEP);
            let low = levels[level];
            let high = levels[(level + 1).min(levels.len() - 1)];
            low + (high - low) * rest as f64 / STEP as f64
        };
        Response((0..VALUES).map(at).collect())
    }

    /// The exposure of a value.
    pub fn exposure(&self, value: u16) -> f64 {
        self.0[usize::from(value)]
    }

    /// The value at which an exposure is recorded: the inverse of [`Response::exposure`], to the nearest value.
    pub fn recorded(&self, exposure: f64) -> u16 {
        let after = self.0.partition_point(|&own| own < exposure);
        let [low, high] = [after.saturating_sub(1), after.min(VALUES - 1)];
        let is_low = exposure - self.0[low] < self.0[high] - exposure;
        (if is_low { low } else { high }) as u16
    }

    /// Exposure by level at a value: over the level about it, which is as fine as a photograph of 8 bits tells.
    pub fn slope(&self, value: u16) -> f64 {
        let low = usize::from(value).saturating_sub(STEP / 2);
        let high = (usize::from(value) + STEP / 2).min(VALUES - 1);
        (self.0[high] - self.0[low]) * STEP as f64 / (high - low) as f64
    }

    /// The value at which an exposure near that of `value` is recorded, by the slope there.
    pub fn predict(&self, value: u16, exposure: f64) -> u16 {
        let off = (exposure - self.exposure(value)) / self.slope(value);
        (f64::from(value) + STEP as f64 * off).clamp(0.0, 65535.0) as u16
    }

    /// The curves of red, green and blue that explain the brackets best. Only ratios are observable: level 128 is set
    /// to its sRGB value in every channel, so that gray stays gray.
    ///
    /// # Errors
    /// [`Error::Shape`] where the brackets do not tell: no pixel is well exposed in two of them, or no curve that grows
    /// explains them.
    pub(super) fn fit(brackets: &[&Bracket], model: Model) -> Result<[Response; 3], Error> {
        match model {
            Model::Linear => return Ok([(); 3].map(|()| Response::linear())),
            Model::Srgb => return Ok([(); 3].map(|()| Response::srgb())),
            Model::Debevec | Model::Robertson => {}
        }
        let terms: Vec<[f64; TERMS]> = (0..VALUES).into_par_iter().map(terms).collect();
        let fit = |channel: usize| {
            let pixels = pixels(brackets, channel);
            if pixels.is_empty() {
                return Err("no pixel is well exposed in two of them");
            }
            // Fewer bends where a curve would fall, as between levels that no pixel has.
            let mut degrees = (0..=DEGREE).rev();
            let curve = degrees.find_map(|degree| solve(&pixels, &terms, degree + 2, model));
            curve.ok_or("no curve that grows explains them, so the times may be wrong")
        };
        let mut curves = [0, 1, 2].map(|_| Err(""));
        curves
            .par_iter_mut()
            .enumerate()
            .for_each(|(channel, curve)| *curve = fit(channel));
        let unknown = |why: &str| {
            Error::Shape(format!(
                "the response cannot be found from these brackets: {why}; add exposures or give --response srgb"
            ))
        };
        let [red, green, blue] = curves.map(|curve| curve.map_err(unknown));
        Ok([red?, green?, blue?])
    }
}

fn srgb(v: f64) -> f64 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// The terms of a curve's logarithm at a value, 0 at level 128: ln z, ln(256 - z), and Chebyshev polynomials of the
/// angle.
fn terms(value: usize) -> [f64; TERMS] {
    let at = |level: f64, k: usize| match k {
        0 => level.max(0.5 / STEP as f64).ln(),
        1 => (256.0 - level).ln(),
        _ => {
            let angle = (1.0 - level / 127.5).clamp(-1.0, 1.0).acos();
            let x = angle / std::f64::consts::FRAC_PI_2 - 1.0;
            ((k - 1) as f64 * x.clamp(-1.0, 1.0).acos()).cos()
        }
    };
    let level = value as f64 / STEP as f64;
    std::array::from_fn(|k| at(level, k) - at(128.0, k))
}

/// What is recorded of each pixel that two brackets show neither black nor saturated.
fn pixels(brackets: &[&Bracket], channel: usize) -> Vec<Vec<(u16, f64)>> {
    let pixels = brackets[0].values.len();
    let count = pixels.min(FIT_PIXELS);
    let view = |k: usize| -> Vec<(u16, f64)> {
        let shown = views(brackets, k * pixels / count, channel);
        shown.filter(|(value, _)| *value > 0).collect()
    };
    (0..count).map(view).filter(|v| v.len() > 1).collect()
}

/// The curve with the first `count` terms; `None` where it is not determined or falls.
fn solve(
    pixels: &[Vec<(u16, f64)>],
    terms: &[[f64; TERMS]],
    count: usize,
    model: Model,
) -> Option<Response> {
    let mut factors = [0.0; TERMS];
    factors[0] = 1.0; // a linear camera
    let mut curve = tabulate(&factors, terms);
    for settled in [false, true] {
        for _ in 0..ROUNDS {
            let (mut matrix, mut step) =
                normal_equations(pixels, terms, count, &curve, model, settled);
            if !cholesky(&mut matrix, &mut step) {
                return None;
            }
            for (factor, step) in factors.iter_mut().zip(&step) {
                *factor += step;
            }
            curve = tabulate(&factors, terms);
            if step.iter().all(|step| step.abs() < 1e-6) {
                break;
            }
        }
    }
    let grows = curve.0.windows(2).all(|p| p[1] > p[0]) && curve.0[VALUES - 1].is_finite();
    let scale = srgb(128.0 / 255.0);
    grows.then(|| Response(curve.0.into_iter().map(|f| f * scale).collect()))
}

/// The curve of these factors, as a power law beyond the values of a fit.
fn tabulate(factors: &[f64; TERMS], terms: &[[f64; TERMS]]) -> Response {
    let log = |v: usize| {
        terms[v]
            .iter()
            .zip(factors)
            .map(|(t, c)| t * c)
            .sum::<f64>()
    };
    let power = |v: usize| {
        let ratio = ((v + STEP / 2) as f64 / (v - STEP / 2) as f64).ln();
        (log(v + STEP / 2) - log(v - STEP / 2)) / ratio
    };
    let (low, high) = (power(DARKEST), power(BRIGHTEST));
    let at = |v: usize| {
        let beyond = |end: usize, power: f64| log(end) + power * (v as f64 / end as f64).ln();
        match v {
            0 => f64::NEG_INFINITY,
            v if v < DARKEST => beyond(DARKEST, low),
            v if v > BRIGHTEST => beyond(BRIGHTEST, high),
            v => log(v),
        }
    };
    Response((0..VALUES).map(|v| at(v).exp()).collect())
}

/// Normal equations of the change of the factors, about a curve.
///
/// The residual of a view is g + φ·δ - ln t - ln x, or f (1 + φ·δ) - t x. Its noise must not choose its own weight and
/// terms, or the fit is biased, so these are taken at the values that the curve predicts from all views of the pixel.
fn normal_equations(
    pixels: &[Vec<(u16, f64)>],
    terms: &[[f64; TERMS]],
    count: usize,
    curve: &Response,
    model: Model,
    settled: bool,
) -> (Vec<f64>, Vec<f64>) {
    let (mut matrix, mut right) = (vec![0.0; count * count], vec![0.0; count]);
    for views in pixels {
        let radiance = radiance(views, curve);
        // Sums over the pixel's views; `x` stands for the factor of the unknown that is eliminated.
        let (mut xx, mut x_known) = (0.0, 0.0);
        let mut x_terms = [0.0; TERMS];
        for &(value, time) in views {
            let about = if settled {
                curve.predict(value, radiance * time)
            } else {
                value
            };
            let exposure = curve.exposure(value);
            let (shape, x, known, noise) = match model {
                Model::Robertson => (curve.exposure(about), time, exposure, slope(curve, about)),
                _ => (
                    1.0,
                    1.0,
                    (exposure / time).ln(),
                    slope(curve, about) / curve.exposure(about),
                ),
            };
            let weight = if (DARKEST..=BRIGHTEST).contains(&usize::from(about)) {
                trust(about) / (noise * noise)
            } else {
                0.0
            };
            if weight == 0.0 {
                continue;
            }
            let row = terms[usize::from(about)];
            for i in 0..count {
                let scaled = weight * shape * row[i];
                x_terms[i] += scaled * x;
                right[i] -= scaled * known;
                for j in i..count {
                    matrix[i * count + j] += scaled * shape * row[j];
                }
            }
            xx += weight * x * x;
            x_known += weight * x * known;
        }
        if xx == 0.0 {
            continue;
        }
        for i in 0..count {
            right[i] += x_terms[i] * x_known / xx;
            for j in i..count {
                matrix[i * count + j] -= x_terms[i] * x_terms[j] / xx;
            }
        }
    }
    (matrix, right)
}

/// The radiance of a pixel by a curve.
fn radiance(views: &[(u16, f64)], curve: &Response) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for &(value, time) in views {
        let weight = trust(value) * (time / slope(curve, value)).powi(2);
        sum += weight * curve.exposure(value) / time;
        weights += weight;
    }
    sum / weights
}

/// The curve's slope, which a fit that has not settled may lose.
fn slope(curve: &Response, value: u16) -> f64 {
    let chord = curve.exposure(value) / (f64::from(value) / STEP as f64);
    curve.slope(value).max(0.05 * chord)
}
