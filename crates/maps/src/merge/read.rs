//! Reads the photographs of a series with their exposures.

use super::Bracket;
use environment::{Error, contents, recorded};
use exif::{Exif, In, Reader, Tag, Value};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// What a camera says of one exposure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Shot {
    /// Seconds.
    time: Option<f64>,
    /// Focal length by the diameter of the opening.
    f_number: Option<f64>,
    /// Sensitivity by ISO 12232.
    iso: Option<f64>,
}

/// One of them.
type Field = fn(&Shot) -> Option<f64>;

/// The photographs in PNG or JPEG files. `times` in seconds, one for each file, win over what EXIF says.
///
/// Without them an exposure is EXIF's ExposureTime, in seconds at the aperture and the sensitivity of the first: light
/// grows with `ISO / FNumber²`, so a series may be bracketed by any of the three.
///
/// # Errors
/// [`Error::Read`] for a file that is absent, damaged or of another kind; without times where EXIF has none, or where
/// some photographs name an aperture or a sensitivity and others do not.
pub fn read_brackets(paths: &[PathBuf], times: &[f64]) -> Result<Vec<Bracket>, Error> {
    let mut brackets = vec![];
    let mut shots = vec![];
    for (index, path) in paths.iter().enumerate() {
        let bytes = contents(path)?;
        let (width, height, values) = recorded(path, &bytes)?;
        let shot = match times.get(index) {
            Some(time) => Shot {
                time: Some(*time),
                ..Shot::default()
            },
            None => shot(&bytes),
        };
        let time = shot.time.ok_or_else(|| {
            let lacks = "it has no EXIF exposure time; give the times of all brackets by --times";
            fail(path, lacks)
        })?;
        shots.push(shot);
        brackets.push(Bracket {
            width,
            height,
            values,
            time,
            shift: [0, 0],
        });
    }
    let fields: [(&str, Field, i32); 2] = [
        ("FNumber", |shot| shot.f_number, -2),
        ("ISO sensitivity", |shot| shot.iso, 1),
    ];
    for (name, of, power) in fields {
        let Some(whole) = shots.iter().find_map(of) else {
            continue;
        };
        for ((shot, bracket), path) in shots.iter().zip(&mut brackets).zip(paths) {
            let value = of(shot).ok_or_else(|| {
                fail(
                    path,
                    &format!(
                        "its EXIF block has no {name}, that of another photograph has; \
                         give exposures by --times"
                    ),
                )
            })?;
            let first = of(&shots[0]).unwrap_or(whole);
            bracket.time *= (value / first).powi(power);
        }
    }
    Ok(brackets)
}

fn fail(path: &Path, reason: &str) -> Error {
    Error::Read {
        path: path.to_owned(),
        reason: reason.replace('\n', " "),
    }
}

/// What the EXIF block of a file says; lenses without contacts are named as f/0 and count as unknown.
fn shot(bytes: &[u8]) -> Shot {
    let Ok(exif) = Reader::new().read_from_container(&mut Cursor::new(bytes)) else {
        return Shot::default();
    };
    let sound = |tag| number(&exif, tag).filter(|value| value.is_finite() && *value > 0.0);
    Shot {
        time: number(&exif, Tag::ExposureTime),
        f_number: sound(Tag::FNumber),
        iso: sound(Tag::PhotographicSensitivity),
    }
}

fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(values) => values.first().map(|value| value.to_f64()),
        value => value.get_uint(0).map(f64::from),
    }
}
