//! Picture files: which format, strict reading, encoding with labels.

use super::faces::absent_hint;
use super::image_file::{ImageFile, Labels, Reason};
use super::{exr, hdr, painted};
use crate::{Error, Image};
use std::path::Path;

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
/// ```
/// let error = ambake_environment::read("absent.exr".as_ref()).unwrap_err();
/// assert!(error.to_string().starts_with("cannot read absent.exr"));
/// ```
///
/// # Errors
/// [`Error::Read`] for a file that is absent, cut short, damaged, empty or of another kind; [`Error::Pixel`] for a
/// value that is NaN, infinite or negative.
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
    decode(path, &bytes(path)?)
}

/// The bytes of the picture at `path`, whose name says of which kind it is.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if !path.is_dir() {
        decoder(path)?;
    }
    contents(path)
}

/// The bytes of the regular file at `path`.
///
/// # Errors
/// [`Error::Read`].
pub fn contents(path: &Path) -> Result<Vec<u8>, Error> {
    if path.is_dir() {
        return Err(fail(path, "it is a directory; name a picture".into()));
    }
    if path.exists() && !path.is_file() {
        return Err(fail(
            path,
            "it is a pipe or a device; name a picture".into(),
        ));
    }
    let bytes = std::fs::read(path);
    bytes.map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => fail(path, format!("{e}{}", absent_hint(path))),
        _ => fail(path, e.to_string()),
    })
}

/// The picture in the bytes of the file at `path`; its pixels may hold any value.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<ImageFile, Error> {
    if bytes.is_empty() {
        return Err(fail(path, "it is empty".into()));
    }
    decoder(path)?(bytes).map_err(|reason| fail(path, reason))
}

/// Width, height and recorded values of the PNG or JPEG photograph with these bytes, 16 bits a channel; 8-bit values
/// times 257. `path` is named in errors.
///
/// # Errors
/// [`Error::Read`].
pub fn recorded(path: &Path, bytes: &[u8]) -> Result<(usize, usize, Vec<[u16; 3]>), Error> {
    painted::decode_values(bytes).map_err(|reason| fail(path, reason))
}

/// Makes a picture of a file's bytes.
type Decoder = fn(&[u8]) -> Result<ImageFile, Reason>;

/// What reads a file, by its ending.
fn decoder(path: &Path) -> Result<Decoder, Error> {
    match ending(path).as_str() {
        "hdr" | "pic" | "rgbe" | "xyze" => Ok(hdr::decode),
        "exr" => Ok(exr::decode),
        "png" | "jpg" | "jpeg" => Ok(painted::decode),
        _ => Err(fail(
            path,
            "it is not .hdr, .exr, .png or .jpg; convert it".into(),
        )),
    }
}

fn fail(path: &Path, reason: Reason) -> Error {
    Error::Read {
        path: path.to_owned(),
        reason: reason.replace('\n', " "),
    }
}

/// The bytes of a file with this picture. They depend on the arguments alone.
///
/// A label's name is a word of letters and digits; its text is one line.
///
/// ```
/// use ambake_environment::{Format, Image, Labels, encode, read};
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("sky.exr");
/// let image = Image::filled(8, 4, [0.1, 0.2, 0.3]);
/// let labels = Labels::from([("ambakeProjection".into(), "polar".into())]);
/// std::fs::write(&path, encode(&image, Format::of(&path)?, &labels)?)?;
/// let file = read(&path)?;
/// assert_eq!((file.image, file.labels), (image, labels));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error::Encode`] for a value that is NaN or infinite, and for one that RGBE cannot hold: negative, or above 1.7e38.
pub fn encode(image: &Image, format: Format, labels: &Labels) -> Result<Vec<u8>, Error> {
    encode_with(image, None, format, labels)
}

/// Like [`encode`], with another channel, its name and one value a pixel: `confidence`, or `A`. An `.hdr` file has no
/// place for it and leaves it out.
///
/// # Errors
/// As [`encode`].
pub fn encode_with(
    image: &Image,
    extra: Option<(&str, &[f32])>,
    format: Format,
    labels: &Labels,
) -> Result<Vec<u8>, Error> {
    assert_eq!(image.pixels.len(), image.width * image.height);
    if let Some((name, values)) = extra {
        assert_eq!(values.len(), image.pixels.len());
        assert!(values.iter().all(|v| v.is_finite()), "{name} {values:?}");
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
        Format::Exr => exr::encode(image, extra, labels),
    }
    .map_err(Error::Encode)
}

fn ending(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_is_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("sky.hdr");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let error = read(&pipe).unwrap_err().to_string();
        assert!(
            error.contains("sky.hdr") && error.contains("pipe"),
            "{error}"
        );
    }
}
