//! Picture files: which format, strict reading, encoding with labels.

use crate::error::Reason;
use crate::{Error, Image, exr_file, hdr, painted};
use std::collections::BTreeMap;
use std::path::Path;

/// Longest side that is read, in pixels.
pub(crate) const MAX_SIDE: usize = 1 << 16;

/// Most pixels that are read: 3 GiB as [`Image`].
pub(crate) const MAX_PIXELS: usize = 1 << 28;

/// Text of a file's header by name: `ambakeProjection`, `ambakeAxes`, `ambakeNormalisation`, …
pub type Labels = BTreeMap<String, String>;

/// A picture with what its header says.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageFile {
    /// The picture.
    pub image: Image,
    /// The header's own text.
    pub labels: Labels,
}

/// A format that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Radiance RGBE: 8 bits a channel with a shared exponent, at most 0.4 % from the value.
    Hdr,
    /// OpenEXR, 32-bit floats, ZIP.
    Exr,
}

impl Format {
    /// The format of a file called `path`, by its ending.
    ///
    /// # Errors
    /// [`Error::Encode`] for another ending than `.hdr` and `.exr`.
    pub fn of(path: &Path) -> Result<Format, Error> {
        match ending(path).as_str() {
            "hdr" => Ok(Format::Hdr),
            "exr" => Ok(Format::Exr),
            _ => Err(Error::Encode(format!(
                "{} ends neither in .hdr nor in .exr; rename it",
                path.display()
            ))),
        }
    }
}

/// The picture in the file at `path`: `.hdr` or `.pic` (Radiance), `.exr`, and painted maps as `.png` or `.jpg`, which
/// are taken as sRGB and made linear (white is 1).
///
/// # Errors
/// [`Error::Read`] for a file that is absent, cut short, damaged, empty or of another kind; [`Error::Pixel`] for a value
/// that is NaN, infinite or negative.
pub fn read(path: &Path) -> Result<ImageFile, Error> {
    let file = read_unchecked(path)?;
    file.image.check(path)?;
    Ok(file)
}

/// Like [`read`], but pixels may hold any value: for statistics.
///
/// # Errors
/// [`Error::Read`].
pub fn read_unchecked(path: &Path) -> Result<ImageFile, Error> {
    let fail = |reason: Reason| Error::Read {
        path: path.to_owned(),
        reason: reason.replace('\n', " "),
    };
    if path.is_dir() {
        return Err(fail("it is a directory; name a picture".into()));
    }
    let decode = match ending(path).as_str() {
        "hdr" | "pic" | "rgbe" | "xyze" => hdr::decode,
        "exr" => exr_file::decode,
        "png" | "jpg" | "jpeg" => painted::decode,
        _ => {
            return Err(fail(
                "it is not .hdr, .exr, .png or .jpg; convert it".into(),
            ));
        }
    };
    let bytes = std::fs::read(path).map_err(|e| fail(e.to_string()))?;
    if bytes.is_empty() {
        return Err(fail("it is empty".into()));
    }
    decode(&bytes).map_err(fail)
}

/// The bytes of a file with this picture. They depend on the arguments alone.
///
/// A label's name is a word of letters and digits; its text is one line.
///
/// # Errors
/// [`Error::Encode`] for a value that is NaN or infinite, and for one that RGBE cannot hold: negative, or above 1.7e38.
pub fn encode(image: &Image, format: Format, labels: &Labels) -> Result<Vec<u8>, Error> {
    encode_with(image, None, format, labels)
}

/// Like [`encode`], with a channel `confidence` of one value a pixel; an `.hdr` file has no place for it and leaves it out.
///
/// # Errors
/// As [`encode`].
pub fn encode_with(
    image: &Image,
    confidence: Option<&[f32]>,
    format: Format,
    labels: &Labels,
) -> Result<Vec<u8>, Error> {
    assert_eq!(image.pixels.len(), image.width * image.height);
    if let Some(values) = confidence {
        assert_eq!(values.len(), image.pixels.len());
        assert!(
            values.iter().all(|v| v.is_finite()),
            "confidence {values:?}"
        );
    }
    if let Some(at) = image
        .pixels
        .iter()
        .position(|p| !p.iter().all(|v| v.is_finite()))
    {
        let (x, y) = (at % image.width, at / image.width);
        let value = image.pixels[at];
        return Err(Error::Encode(format!(
            "pixel ({x}, {y}) is {value:?}; please report this input"
        )));
    }
    match format {
        Format::Hdr => hdr::encode(image, labels),
        Format::Exr => exr_file::encode(image, confidence, labels),
    }
    .map_err(Error::Encode)
}

/// A side length pair that fits in memory.
pub(crate) fn check_size(width: usize, height: usize) -> Result<(), Reason> {
    if width == 0 || height == 0 {
        return Err(format!("it is {width} x {height} pixels"));
    }
    if width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_PIXELS {
        return Err(format!(
            "it is {width} x {height} pixels; at most {MAX_SIDE} a side and {MAX_PIXELS} in all are read"
        ));
    }
    Ok(())
}

fn ending(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default()
}
