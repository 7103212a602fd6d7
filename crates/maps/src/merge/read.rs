//! Reads the photographs of a series with their exposure times.

use super::Bracket;
use crate::{Error, painted};
use exif::{In, Reader, Tag, Value};
use std::io::Cursor;
use std::path::Path;

/// The photograph in a PNG or JPEG file. `time` in seconds wins over the file's EXIF exposure time.
///
/// # Errors
/// [`Error::Read`] for a file that is absent, damaged or of another kind, and where no time is given and EXIF has none.
pub fn read_bracket(path: &Path, time: Option<f64>) -> Result<Bracket, Error> {
    let fail = |reason: String| Error::Read {
        path: path.to_owned(),
        reason: reason.replace('\n', " "),
    };
    let bytes = std::fs::read(path).map_err(|e| fail(e.to_string()))?;
    let (width, height, values) = painted::decode_values(&bytes).map_err(fail)?;
    let time = time.or_else(|| exposure_time(&bytes));
    let time = time.ok_or_else(|| {
        fail("it has no EXIF exposure time; give the times of all brackets by --times".into())
    })?;
    Ok(Bracket {
        width,
        height,
        values,
        time,
        shift: [0, 0],
    })
}

/// Seconds of exposure by EXIF's ExposureTime.
fn exposure_time(bytes: &[u8]) -> Option<f64> {
    let exif = Reader::new()
        .read_from_container(&mut Cursor::new(bytes))
        .ok()?;
    match &exif.get_field(Tag::ExposureTime, In::PRIMARY)?.value {
        Value::Rational(times) => times.first().map(|t| t.to_f64()),
        _ => None,
    }
}
