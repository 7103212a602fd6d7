//! Response curves as a text, so that what one series of exposures tells of a film or a camera serves single
//! photographs of it.
//!
//! 256 lines of a level, 0 to 255 in their order, and the exposures of red, green and blue that it stands for; `#`
//! begins a comment. Between levels a curve is linear, so that photographs of 8 bits get the very curve that was found.

use super::Response;
use environment::{Error, Image, contents, recorded};
use std::path::Path;

/// Levels of a text.
const LEVELS: usize = 256;

/// A text of curves is some 20 kB.
const LONGEST: u64 = 1 << 20;

const LINE: &str = "a level, 0 to 255 in their order, and three exposures, \
    finite and each above that of the level before,";

/// The text of the curves of red, green and blue.
pub fn curves_text(curves: &[Response; 3]) -> String {
    let mut text =
        "# exposures of red, green and blue by recorded level; written by ambake map merge\n"
            .to_owned();
    for level in 0..LEVELS {
        let [r, g, b] = curves
            .each_ref()
            .map(|curve| curve.exposure((level * 257) as u16));
        text += &format!("{level} {r:e} {g:e} {b:e}\n");
    }
    text
}

/// The curves of red, green and blue in a text.
///
/// # Errors
/// [`crate::Error::Line`] with the first line that is none, or with the one after the last where levels are missing.
fn parse_curves(text: &str) -> Result<[Response; 3], crate::Error> {
    let mut levels: [Vec<f64>; 3] = Default::default();
    let fail = |line: usize| {
        Err(crate::Error::Line {
            line,
            expected: LINE,
        })
    };
    for (at, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let values: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let next = levels[0].len();
        match values.as_deref() {
            Ok([]) => {}
            Ok([level, rgb @ ..]) if rgb.len() == 3 && *level == next as f64 && next < LEVELS => {
                for (curve, &value) in levels.iter_mut().zip(rgb) {
                    let least = curve.last().copied().unwrap_or(-f64::MIN_POSITIVE);
                    if !value.is_finite() || value <= least {
                        return fail(at + 1);
                    }
                    curve.push(value);
                }
            }
            _ => return fail(at + 1),
        }
    }
    match levels[0].len() == LEVELS {
        true => Ok(levels.map(|levels| Response::of_levels(&levels))),
        false => fail(text.lines().count() + 1),
    }
}

/// The curves in the file at `path`.
///
/// # Errors
/// [`Error::Read`] for a file that is absent or no such text.
pub fn read_curves(path: &Path) -> Result<[Response; 3], Error> {
    let fail = |reason: String| Error::Read {
        path: path.to_owned(),
        reason,
    };
    let about = std::fs::metadata(path).map_err(|e| fail(e.to_string()))?;
    if !about.is_file() || about.len() > LONGEST {
        return Err(fail(
            "it is no file of curves; name one that --save-response wrote".into(),
        ));
    }
    let text = std::fs::read_to_string(path).map_err(|e| fail(e.to_string()))?;
    parse_curves(&text).map_err(|e| fail(e.to_string()))
}

/// The exposures in a single photograph, a PNG or JPEG file. Saturated values stand for the exposure at which the curve
/// ends.
///
/// # Errors
/// [`Error::Read`] for a file that is absent, damaged or of another kind.
pub fn develop(path: &Path, curves: &[Response; 3]) -> Result<Image, Error> {
    let (width, height, values) = recorded(path, &contents(path)?)?;
    let exposure = |rgb: [u16; 3]| {
        std::array::from_fn(|c| curves[c].exposure(rgb[c]).min(f64::from(f32::MAX)) as f32)
    };
    Ok(Image {
        width,
        height,
        pixels: values.into_iter().map(exposure).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_eight_bits_come_back_to_the_last_bit() {
        let curves = [Response::srgb(), Response::linear(), Response::srgb()];
        let back = parse_curves(&curves_text(&curves)).unwrap();
        for (curve, back) in curves.iter().zip(&back) {
            for level in 0..=255_u16 {
                assert_eq!(curve.exposure(257 * level), back.exposure(257 * level));
            }
        }
        // Between levels within the curve's bend.
        for value in 0..=u16::MAX {
            let off = (curves[0].exposure(value) - back[0].exposure(value)).abs();
            assert!(off < 2e-5, "{value}: {off}");
        }
        assert_eq!(parse_curves(&curves_text(&back)).unwrap(), back);
    }

    #[test]
    fn texts_that_are_no_curves_name_their_line() {
        let text = curves_text(&[(); 3].map(|()| Response::srgb()));
        let broken = |from: &str, to: &str| parse_curves(&text.replacen(from, to, 1)).unwrap_err();
        for (error, line) in [
            (broken("\n7 ", "\n8 "), "line 9"),
            (broken("\n9 ", "\n9 NaN "), "line 11"),
            (broken("\n0 0e0", "\n0 -1"), "line 2"),
            (broken("\n12 ", "\n12 inf inf inf #"), "line 14"),
            (broken("\n255 ", "\n#"), "line 258"),
            (parse_curves("").unwrap_err(), "line 1"),
        ] {
            let error = error.to_string();
            assert!(error.starts_with(line), "{error}");
        }
    }

    #[test]
    fn a_single_photograph_is_developed_by_the_curve_of_its_channels() {
        let folder = std::env::temp_dir().join(format!("ambake-develop-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.png");
        image::RgbImage::from_fn(256, 1, |x, _| image::Rgb([x as u8; 3]))
            .save(&path)
            .unwrap();
        let curves = [Response::linear(), Response::srgb(), Response::linear()];
        let image = develop(&path, &curves);
        let absent = develop(&folder.join("b.png"), &curves);
        std::fs::remove_dir_all(&folder).unwrap();
        let image = image.unwrap();
        for (x, pixel) in image.pixels.iter().enumerate() {
            let value = 257 * x as u16;
            let exact = curves.each_ref().map(|curve| curve.exposure(value) as f32);
            assert_eq!(*pixel, exact);
        }
        assert!(absent.unwrap_err().to_string().contains("b.png"));
    }
}
