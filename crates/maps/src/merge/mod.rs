//! Exposure brackets to one picture of radiance.
//!
//! A bracket is a photograph of 8 or 16 bits with its exposure time. The response curve turns its values into
//! exposures; exposure by time is radiance, and the brackets are averaged by the inverse of their variance. Before
//! that, [`align`] may find how they are shifted. Rounding to 8 bits and the chroma subsampling of JPEG are in the
//! photograph: the first costs half a level, the second smears colour over two pixels; neither is undone.

mod align;
mod curves;
mod read;
mod response;
#[cfg(test)]
mod tests;

pub use align::align;
pub use curves::{curves_text, develop, read_curves};
pub use read::read_brackets;
pub use response::Response;

use environment::{Error, Image};
use rayon::prelude::*;

/// Recorded levels of one channel that count as saturated, on the scale 0..=255.
const SATURATED: f64 = 252.0;

/// How the response curve comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Least squares of logarithms.
    Debevec,
    /// Least squares of exposures.
    Robertson,
    /// Values are exposures.
    Linear,
    /// Values are sRGB.
    Srgb,
}

/// One photograph of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Bracket {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels, red, green, blue, 0..=65535; 8-bit values times 257.
    pub values: Vec<[u16; 3]>,
    /// Exposure time in seconds, above 0.
    pub time: f64,
    /// Where pixel (0, 0) of the merged picture lies in this one, columns and rows; [`align`] finds it.
    pub shift: [i32; 2],
}

impl Bracket {
    /// What was recorded for a pixel of the merged picture, 0..=65535; `None` outside this photograph.
    fn recorded(&self, pixel: usize, channel: usize) -> Option<u16> {
        let at = |i: usize, shift: i32, side: usize| {
            let place = i as i64 + i64::from(shift);
            (0..side as i64).contains(&place).then_some(place as usize)
        };
        let x = at(pixel % self.width, self.shift[0], self.width)?;
        let y = at(pixel / self.width, self.shift[1], self.height)?;
        Some(self.values[y * self.width + x][channel])
    }
}

/// The merged picture and what could not be known.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// Radiance up to one constant factor, finite and at least 0.
    pub image: Image,
    /// Pixels with a channel that no bracket shows between black and saturated: they hold the lower bound of the
    /// shortest saturated exposure.
    pub saturated: Vec<bool>,
    /// The curves of red, green and blue.
    pub responses: [Response; 3],
}

/// The radiance that the brackets show.
///
/// Every recorded level is taken to have the same noise (rounding and read noise), so that a bracket's radiance f(z)/t
/// has a deviation of f'(z)/t; its weight is the inverse square. The noise of a value must not choose its own weight,
/// or the mean is biased: the weight is taken at the value that a first estimate predicts. Saturated values do not
/// count. Where every bracket is saturated, or black beside a saturated one, the pixel holds a lower bound and is
/// flagged.
///
/// ```
/// use ambake_maps::merge::{Bracket, Model, merge};
/// let bracket = |time: f64, value: u16| Bracket {
///     width: 1,
///     height: 1,
///     values: vec![[value; 3]],
///     time,
///     shift: [0, 0],
/// };
/// // The same radiance for one second and for four; values are proportional to exposure.
/// let merged = merge(&[bracket(1.0, 10_000), bracket(4.0, 40_000)], Model::Linear)?;
/// let radiance = f64::from(merged.image.pixels[0][0]);
/// assert!((radiance / (10_000.0 / 65_535.0) - 1.0).abs() < 1e-6, "{radiance}");
/// # Ok::<(), environment::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for fewer than two brackets, different sizes, a time that is not above 0 or given twice, or
/// brackets that do not determine the curve that is to be fitted.
pub fn merge(brackets: &[Bracket], model: Model) -> Result<Merged, Error> {
    let brackets = sorted(brackets)?;
    let responses = Response::fit(&brackets, model)?;
    Ok(by(&brackets, responses))
}

/// The radiance that the brackets show by curves that are known, as [`merge`].
///
/// # Errors
/// As [`merge`], but for the curve.
pub fn merge_by(brackets: &[Bracket], responses: [Response; 3]) -> Result<Merged, Error> {
    Ok(by(&sorted(brackets)?, responses))
}

/// The brackets, the shortest first.
fn sorted(brackets: &[Bracket]) -> Result<Vec<&Bracket>, Error> {
    check(brackets)?;
    let mut brackets: Vec<&Bracket> = brackets.iter().collect();
    brackets.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(brackets)
}

fn by(brackets: &[&Bracket], responses: [Response; 3]) -> Merged {
    let (width, height) = (brackets[0].width, brackets[0].height);
    let pixel = |pixel: usize| {
        let channels = [0, 1, 2].map(|c| radiance(brackets, &responses[c], pixel, c));
        let value = channels.map(|(value, _)| value.min(f64::from(f32::MAX)) as f32);
        (value, channels.iter().any(|(_, bound)| *bound))
    };
    let (pixels, saturated) = (0..width * height).into_par_iter().map(pixel).unzip();
    Merged {
        image: Image {
            width,
            height,
            pixels,
        },
        saturated,
        responses,
    }
}

/// How much a recorded value counts: less toward saturation, where noise lifts some values over the end and not others.
fn trust(value: u16) -> f64 {
    let level = f64::from(value) / 257.0;
    ((SATURATED - level) / 32.0).clamp(0.0, 1.0)
}

/// What the brackets, the shortest first, recorded for a channel of a pixel, with their times.
///
/// Saturated values are left out, and with the first of them all longer exposures: what is less there is noise.
fn views(brackets: &[&Bracket], pixel: usize, channel: usize) -> impl Iterator<Item = (u16, f64)> {
    let view = move |b: &&Bracket| Some((b.recorded(pixel, channel)?, b.time));
    let views = brackets.iter().filter_map(view);
    views.take_while(|(value, _)| trust(*value) > 0.0)
}

/// One channel of a pixel, and whether it is only a lower bound.
fn radiance(
    brackets: &[&Bracket],
    response: &Response,
    pixel: usize,
    channel: usize,
) -> (f64, bool) {
    let mean = |predicted: &dyn Fn(u16, f64) -> u16| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (value, time) in views(brackets, pixel, channel) {
            let about = predicted(value, time);
            let weight = trust(about) * (time / response.slope(about)).powi(2);
            sum += weight * response.exposure(value) / time;
            weights += weight;
        }
        (weights > 0.0).then(|| sum / weights)
    };
    if views(brackets, pixel, channel).all(|(value, _)| value == 0) {
        let view = |b: &&Bracket| Some((b.recorded(pixel, channel)?, b.time));
        let clipped = brackets
            .iter()
            .filter_map(view)
            .find(|(value, _)| trust(*value) == 0.0);
        return match clipped {
            Some((value, time)) => (response.exposure(value) / time, true),
            None => (0.0, false),
        };
    }
    let first = mean(&|value, _| value).unwrap_or(0.0);
    let again = mean(&|value, time| response.predict(value, first * time));
    (again.unwrap_or(first), false)
}

fn check(brackets: &[Bracket]) -> Result<(), Error> {
    let shape = |text: String| Err(Error::Shape(text));
    let [first, _, ..] = brackets else {
        let count = brackets.len();
        return shape(format!(
            "{count} brackets are no series; name at least two with different times"
        ));
    };
    for (index, b) in brackets.iter().enumerate() {
        assert_eq!(b.values.len(), b.width * b.height);
        if (b.width, b.height) != (first.width, first.height) {
            return shape(format!(
                "bracket {} is {} x {} pixels but the first is {} x {}; crop them alike",
                index + 1,
                b.width,
                b.height,
                first.width,
                first.height
            ));
        }
        if !b.time.is_finite() || b.time <= 0.0 {
            let (index, time) = (index + 1, b.time);
            return shape(format!(
                "bracket {index} has a time of {time} s; give one above 0 by --times"
            ));
        }
    }
    let twin = |b: &&Bracket| brackets.iter().filter(|o| o.time == b.time).count() > 1;
    if let Some(twin) = brackets.iter().find(twin) {
        return shape(format!(
            "two brackets have the time {} s; give every exposure its own time, and name it once",
            twin.time
        ));
    }
    Ok(())
}
