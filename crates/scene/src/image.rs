//! Decodes image files to 8-bit RGBA, within bounds for a picture and for all pictures of a scene.

use image::{ImageError, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Bytes that a decoded picture may take.
const MOST_OF_ONE: u64 = 1 << 30;
/// Bytes that all decoded pictures of a scene may take, however short their files are.
const MOST_OF_ALL: u64 = 4 << 30;
/// Bytes that they may take in addition for each byte of their files. Textures in use have 3 to 60, plain areas some
/// hundreds.
const MOST_PER_BYTE: u64 = 64;

/// Why an image gives no pixels.
pub(crate) enum Failure {
    /// A format that is not read here (KTX2, AVIF, …): the texture is left out with a warning.
    Unsupported(String),
    /// The bytes are broken: the texture is left out with a warning.
    Broken(String),
    /// A sound image of more pixels than are read: the load stops with [`TOO_LARGE`].
    TooLarge,
}

/// What is said of [`Failure::TooLarge`].
pub(crate) const TOO_LARGE: &str = "the image is wider or higher than 65,536 pixels or takes more than 1 GiB decoded; \
    scale it down";

/// Width, height and RGBA pixels.
pub(crate) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 4]>,
    /// The file has an alpha channel of its own.
    pub has_alpha: bool,
}

/// What decides a picture: the hash of its file, and whether the name makes a TGA of what has no signature.
pub(crate) type Content = (blake3::Hash, bool);

/// What [`decode`] makes of a file, without decoding it: equal for the same picture under several names.
pub(crate) fn content(bytes: &[u8], name: &str) -> Content {
    (blake3::hash(bytes), is_tga(name))
}

/// What the decoded pictures of a scene take together, counted before they are decoded.
pub(crate) struct Budget {
    allowed: u64,
    taken: u64,
}

impl Budget {
    /// For the pictures of a scene; `allowed` bytes, beyond what their files' own bytes allow.
    pub fn of(allowed: u64) -> Self {
        Self { allowed, taken: 0 }
    }

    /// Counts a picture by the size that its header declares. One that is broken or too large by itself is for
    /// [`decode`] to tell of.
    ///
    /// # Errors
    /// A sentence, where it is one too many.
    pub fn take(&mut self, bytes: &[u8], name: &str) -> Result<(), String> {
        let size = reader(bytes, name)
            .ok()
            .and_then(|reader| reader.into_dimensions().ok());
        let Some((width, height)) = size else {
            return Ok(());
        };
        let pixels = size_of_pixels(width, height);
        if pixels > MOST_OF_ONE {
            return Ok(());
        }
        let own = MOST_PER_BYTE.saturating_mul(bytes.len() as u64);
        self.allowed = self.allowed.saturating_add(own);
        self.taken = self.taken.saturating_add(pixels);
        match self.taken > self.allowed {
            true => Err(format!(
                "with this image of {width} x {height} pixels the decoded pictures of the scene take {} MiB, and {} \
                 are allowed for files of their length; scale pictures down or leave some out",
                self.taken.div_ceil(1 << 20),
                self.allowed >> 20
            )),
            false => Ok(()),
        }
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::of(MOST_OF_ALL)
    }
}

/// Bytes of RGBA pixels.
fn size_of_pixels(width: u32, height: u32) -> u64 {
    4 * u64::from(width) * u64::from(height)
}

fn is_tga(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(".tga")
}

/// Knows PNG, JPEG, WebP, BMP (by content) and TGA (by the ending of `name`, for it has no signature).
fn reader<'a>(bytes: &'a [u8], name: &str) -> Result<ImageReader<Cursor<&'a [u8]>>, Failure> {
    if bytes.is_empty() {
        return Err(Failure::Broken("the image is empty".into()));
    }
    if bytes.starts_with(&[0xab, b'K', b'T', b'X']) {
        return Err(Failure::Unsupported("KTX".into()));
    }
    let mut reader = ImageReader::new(Cursor::new(bytes));
    match image::guess_format(bytes) {
        Ok(
            format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Bmp),
        ) => reader.set_format(format),
        Ok(other) => return Err(Failure::Unsupported(format!("{other:?}"))),
        Err(_) if is_tga(name) => reader.set_format(ImageFormat::Tga),
        Err(_) => {
            return Err(Failure::Broken(
                "neither PNG, JPEG, WebP, BMP nor TGA".into(),
            ));
        }
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(1 << 16);
    limits.max_image_height = Some(1 << 16);
    limits.max_alloc = Some(MOST_OF_ONE);
    reader.limits(limits);
    Ok(reader)
}

/// Decodes PNG, JPEG, WebP, BMP (by content) and TGA (by the ending of `name`).
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, Failure> {
    decode_within(bytes, name, MOST_OF_ONE)
}

/// As [`decode`], for a picture of at most `most` bytes.
fn decode_within(bytes: &[u8], name: &str, most: u64) -> Result<Pixels, Failure> {
    let failed = |e| match e {
        ImageError::Limits(_) => Failure::TooLarge,
        other => Failure::Broken(other.to_string().replace('\n', " ")),
    };
    // The decoder's own limit is for the file's colours: of grey ones four times as much becomes of it.
    let (width, height) = reader(bytes, name)?.into_dimensions().map_err(failed)?;
    if size_of_pixels(width, height) > most {
        return Err(Failure::TooLarge);
    }
    let image = reader(bytes, name)?.decode().map_err(failed)?;
    let has_alpha = image.color().has_alpha();
    let image = image.into_rgba8();
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 {
        return Err(Failure::Broken(format!(
            "the image is {width} x {height} pixels"
        )));
    }
    let pixels = image
        .as_raw()
        .chunks_exact(4)
        .map(|p| [p[0], p[1], p[2], p[3]])
        .collect();
    Ok(Pixels {
        width,
        height,
        pixels,
        has_alpha,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of one grey.
    fn grey(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let image = image::GrayImage::new(width, height);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn pictures_count_with_their_pixels_and_allow_for_their_bytes() {
        let bytes = grey(300, 200);
        let (own, allowed) = (4 * 300 * 200, MOST_PER_BYTE * bytes.len() as u64);
        assert!(own > allowed, "{own} {allowed}");
        for count in [1u64, 3] {
            let free = count * (own - allowed);
            for (free, fits) in [(free, true), (free - 1, false)] {
                let mut budget = Budget::of(free);
                let takes = (0..count).map(|_| budget.take(&bytes, "a.png"));
                let takes: Vec<_> = takes.collect();
                assert!(takes[..takes.len() - 1].iter().all(Result::is_ok));
                assert_eq!(takes[takes.len() - 1].is_ok(), fits, "{count} {free}");
            }
        }
        // What is no picture is not counted, and allows for nothing.
        let mut budget = Budget::of(0);
        assert!(budget.take(&[7; 5000], "a.png").is_ok());
        let problem = budget.take(&bytes, "a.png").unwrap_err();
        assert!(problem.contains("300 x 200 pixels"), "{problem}");
        assert!(!problem.contains(['\n', '\u{1b}']), "{problem}");
    }

    #[test]
    fn a_grey_picture_is_judged_by_the_colours_that_become_of_it() {
        let bytes = grey(300, 200);
        let most = 4 * 300 * 200;
        assert!(decode_within(&bytes, "a.png", most).is_ok());
        let refused = decode_within(&bytes, "a.png", most - 1);
        assert!(matches!(refused, Err(Failure::TooLarge)));
    }
}
