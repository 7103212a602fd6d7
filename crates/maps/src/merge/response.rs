//! Response curves of a camera: given, or found from the brackets by least squares.
//!
//! P. Debevec, J. Malik, "Recovering High Dynamic Range Radiance Maps from Photographs" (1997), equation 3, and
//! M. Robertson, S. Borman, R. Stevenson, "Dynamic Range Improvement Through Multiple Exposures" (1999), equation 6.
//! Both objectives are quadratic in the radiances too, so these are eliminated one by one: every pixel adds a matrix of
//! rank (brackets - 1) to 256 normal equations, and one solve gives the minimum that alternation only approaches.

use super::{Bracket, Model, SATURATED, solve::cholesky};
use crate::Error;

/// Levels at which a curve is held; 16-bit values lie between them.
pub const LEVELS: usize = 256;

/// Most pixels that enter a fit; larger pictures are thinned evenly.
const FIT_PIXELS: usize = 1 << 16;

/// Degree of a fitted curve as a polynomial of the level (T. Mitsunaga, S. Nayar, "Radiometric Self Calibration", 1999).
///
/// Evenly spaced times leave every wave in log exposure with their spacing as its period unobserved (M. Grossberg,
/// S. Nayar, "What Can Be Known about the Radiometric Response from Images?", 2002); free levels would take it up.
const DEGREE: usize = 6;

/// Exposure (radiance times time) by recorded level, 0..=255, of one channel. Grows strictly.
#[derive(Debug, Clone, PartialEq)]
pub struct Response(pub Vec<f64>);

impl Response {
    /// The curve value = exposure, 1 at the top.
    pub fn linear() -> Response {
        Response((0..LEVELS).map(|z| z as f64 / 255.0).collect())
    }

    /// The curve of IEC 61966-2-1, 1 at the top.
    pub fn srgb() -> Response {
        Response((0..LEVELS).map(|z| srgb(z as f64 / 255.0)).collect())
    }

    /// Exposure and its slope by level, at a level 0..=255.
    pub fn at(&self, level: f64) -> (f64, f64) {
        let below = (level as usize).min(LEVELS - 2);
        let slope = self.0[below + 1] - self.0[below];
        (self.0[below] + (level - below as f64) * slope, slope)
    }

    /// The curve of one channel that explains the brackets best. Only ratios are observable: level 128 is set to its
    /// sRGB value in every channel, so that gray stays gray.
    ///
    /// # Errors
    /// [`Error::Shape`] where the brackets do not tell: fewer than two, or no pixel that two of them show unsaturated.
    pub fn fit(brackets: &[Bracket], channel: usize, model: Model) -> Result<Response, Error> {
        let curve = match model {
            Model::Linear => return Ok(Response::linear()),
            Model::Srgb => return Ok(Response::srgb()),
            Model::Debevec | Model::Robertson => normal_equations(brackets, channel, model),
        };
        let unknown = |why: &str| {
            Error::Shape(format!(
                "the response cannot be found from these brackets: {why}; add exposures or give --response srgb"
            ))
        };
        let mut curve = curve.ok_or_else(|| unknown("no pixel is well exposed in two of them"))?;
        if model == Model::Debevec {
            curve.iter_mut().for_each(|g| *g = g.exp());
        }
        let scale = srgb(128.0 / 255.0) / curve[128];
        curve.iter_mut().for_each(|f| *f *= scale);
        // A flat stretch would claim no noise and drown every other bracket.
        if !curve.windows(2).all(|p| p[1] > p[0]) {
            return Err(unknown(
                "the fitted curve falls; check the times or try debevec",
            ));
        }
        Ok(Response(curve.into_iter().map(|f| f.max(0.0)).collect()))
    }
}

fn srgb(v: f64) -> f64 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// How much a level counts in a fit; nothing at the two ends, where values are clipped.
///
/// The noise of a level is the same everywhere. A logarithm then has a deviation of about 1 / level, whose inverse square
/// is the weight; exposures are weighted alike.
fn trust(level: f64, log: bool) -> f64 {
    let weight = if log { (level / 255.0).powi(2) } else { 1.0 };
    weight * f64::from(u8::from(level > 2.0 && level < SATURATED))
}

/// The minimum of the objective with level 128 fixed at 0 (logarithms, Debevec) or 1 (exposures, Robertson).
fn normal_equations(brackets: &[Bracket], channel: usize, model: Model) -> Option<Vec<f64>> {
    let log = model == Model::Debevec;
    let mut matrix = vec![0.0; LEVELS * LEVELS];
    let mut right = vec![0.0; LEVELS];
    let (width, height) = (brackets[0].width, brackets[0].height);
    let step = ((width * height) as f64 / FIT_PIXELS as f64).max(1.0);
    let mut used = 0usize;
    let mut terms: Vec<(usize, f64, f64)> = Vec::new();
    for index in 0..width * height {
        let pixel = (index as f64 * step) as usize;
        if pixel >= width * height {
            break;
        }
        terms.clear();
        for bracket in brackets {
            let Some(value) = bracket.recorded(pixel, channel) else {
                continue;
            };
            let level = f64::from(value) / 257.0;
            let weight = trust(level, log);
            if weight > 0.0 {
                terms.push((level.round() as usize, weight, bracket.time));
            }
        }
        if terms.len() < 2 {
            continue;
        }
        used += 1;
        // Residual of bracket j: g(z) - ln t - ln x, or f(z) - t x. `a` is the factor of the eliminated unknown.
        let a = |t: f64| if log { 1.0 } else { t };
        let known = |t: f64| if log { t.ln() } else { 0.0 };
        let norm: f64 = terms.iter().map(|(_, w, t)| w * a(*t) * a(*t)).sum();
        let mean: f64 = terms
            .iter()
            .map(|(_, w, t)| w * a(*t) * known(*t))
            .sum::<f64>()
            / norm;
        for &(z, w, t) in &terms {
            matrix[z * LEVELS + z] += w;
            right[z] += w * (known(t) - a(t) * mean);
            for &(y, v, s) in &terms {
                matrix[z * LEVELS + y] -= w * a(t) * v * a(s) / norm;
            }
        }
    }
    if used == 0 {
        return None;
    }
    let start = if log { 0.0 } else { 1.0 };
    let basis: Vec<Vec<f64>> = (1..=DEGREE + usize::from(log)).map(shape).collect();
    let times = |v: &[f64]| -> Vec<f64> {
        let row = |m: &[f64]| m.iter().zip(v).map(|(a, b)| a * b).sum();
        matrix.chunks_exact(LEVELS).map(row).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let known = times(&[start; LEVELS]);
    let rest: Vec<f64> = right.iter().zip(&known).map(|(r, k)| r - k).collect();
    let mut small: Vec<f64> = Vec::new();
    for shape in &basis {
        let image = times(shape);
        small.extend(basis.iter().map(|other| dot(other, &image)));
    }
    let mut factors: Vec<f64> = basis.iter().map(|shape| dot(shape, &rest)).collect();
    let value = |z: usize, factors: &[f64]| {
        start
            + basis
                .iter()
                .zip(factors)
                .map(|(b, c)| b[z] * c)
                .sum::<f64>()
    };
    cholesky(&mut small, &mut factors).then(|| (0..LEVELS).map(|z| value(z, &factors)).collect())
}

/// Chebyshev polynomial k of the level, and a logarithm beyond [`DEGREE`]; 0 at level 128.
fn shape(k: usize) -> Vec<f64> {
    let at = |z: usize| {
        if k > DEGREE {
            (z as f64 + 1.0).ln()
        } else {
            (k as f64 * (z as f64 / 127.5 - 1.0).clamp(-1.0, 1.0).acos()).cos()
        }
    };
    (0..LEVELS).map(|z| at(z) - at(128)).collect()
}
