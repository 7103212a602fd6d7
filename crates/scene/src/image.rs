//! Decodes image files to 8-bit RGBA.

use image::{ImageError, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Why an image gives no pixels.
pub(crate) enum Failure {
    /// A format that is not read here (KTX2, AVIF, …): the texture is left out with a warning.
    Unsupported(String),
    /// The bytes are broken: the load stops.
    Broken(String),
    /// A sound image of more pixels than are read: the load stops with [`TOO_LARGE`].
    TooLarge,
}

/// What is said of [`Failure::TooLarge`].
pub(crate) const TOO_LARGE: &str = "the image is wider or higher than 65,536 pixels or takes more than 1 GiB decoded; scale it down";

/// Width, height and RGBA pixels.
pub(crate) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 4]>,
    /// The file has an alpha channel of its own.
    pub has_alpha: bool,
}

/// Decodes PNG, JPEG, WebP, BMP (by content) and TGA (by the ending of `name`, for it has no signature).
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, Failure> {
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
        Err(_) if name.to_ascii_lowercase().ends_with(".tga") => {
            reader.set_format(ImageFormat::Tga)
        }
        Err(_) => {
            return Err(Failure::Broken(
                "neither PNG, JPEG, WebP, BMP nor TGA".into(),
            ));
        }
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(1 << 16);
    limits.max_image_height = Some(1 << 16);
    limits.max_alloc = Some(1 << 30);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| match e {
        ImageError::Limits(_) => Failure::TooLarge,
        other => Failure::Broken(other.to_string().replace('\n', " ")),
    })?;
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
