//! Exposure brackets to one picture of radiance.
//!
//! A bracket is a photograph of 8 or 16 bits with its exposure time. The response curve turns its values into exposures;
//! exposure by time is radiance, and the brackets are averaged by the inverse of their variance. Rounding to 8 bits and
//! the chroma subsampling of JPEG are in the photograph: the first costs half a level, the second smears colour over two
//! pixels; neither is undone.

mod align;
mod read;
mod response;
mod solve;
#[cfg(test)]
mod tests;

pub use align::align;
pub use read::read_bracket;
pub use response::Response;
pub(crate) use solve::cholesky;

use crate::{Error, Image};

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
    /// Pixels with a channel that every bracket saturates: they hold the bound of the shortest exposure.
    pub saturated: Vec<bool>,
    /// The curves of red, green and blue.
    pub responses: [Response; 3],
}

/// The radiance that the brackets show.
///
/// The recorded level is taken to have the same noise everywhere (rounding and read noise), so that a bracket's radiance
/// f(z)/t has a deviation of f'(z)/t; its weight is the inverse square. Saturated values do not count. Where all are
/// saturated the pixel keeps the shortest exposure's value, a lower bound, and is flagged.
///
/// # Errors
/// [`Error::Shape`] for fewer than two brackets, different sizes, a time that is not above 0 or given twice, or brackets
/// that do not determine the curve that is to be fitted.
pub fn merge(brackets: &[Bracket], model: Model) -> Result<Merged, Error> {
    check(brackets)?;
    let fit = |channel| Response::fit(brackets, channel, model);
    let responses = [fit(0)?, fit(1)?, fit(2)?];
    let (width, height) = (brackets[0].width, brackets[0].height);
    let mut saturated = vec![false; width * height];
    let mut image = Image::filled(width, height, [0.0; 3]);
    for (pixel, flag) in saturated.iter_mut().enumerate() {
        for (channel, response) in responses.iter().enumerate() {
            let (value, bound) = radiance(brackets, response, pixel, channel);
            image.pixels[pixel][channel] = value.min(f64::from(f32::MAX)) as f32;
            *flag |= bound;
        }
    }
    Ok(Merged {
        image,
        saturated,
        responses,
    })
}

/// One channel of a pixel, and whether it is only a lower bound.
fn radiance(
    brackets: &[Bracket],
    response: &Response,
    pixel: usize,
    channel: usize,
) -> (f64, bool) {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mut bound = (f64::INFINITY, 0.0);
    let mut clipped = false;
    for bracket in brackets {
        let Some(value) = bracket.recorded(pixel, channel) else {
            continue;
        };
        let level = f64::from(value) / 257.0;
        let (exposure, slope) = response.at(level);
        if bracket.time < bound.0 {
            bound = (bracket.time, exposure / bracket.time);
            clipped = level >= SATURATED;
        }
        if level < SATURATED && slope > 0.0 {
            // Noise lifts some values of a pixel over the end and not others; near it a value counts little.
            let weight = (bracket.time / slope).powi(2) * ((SATURATED - level) / 32.0).min(1.0);
            sum += weight * exposure / bracket.time;
            weights += weight;
        }
    }
    if weights > 0.0 {
        (sum / weights, false)
    } else {
        (bound.1, clipped)
    }
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
