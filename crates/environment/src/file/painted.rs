//! Painted maps: 8- and 16-bit pictures, made linear.

use super::image_file::{ImageFile, Labels, MAX_SIDE, Reason, check_size};
use image::codecs::{jpeg::JpegDecoder, png::PngDecoder};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageResult, Limits};
use std::io::Cursor;

/// The picture in a PNG or JPEG file. Its values are sRGB (IEC 61966-2-1); transparency is left out.
pub(super) fn decode(bytes: &[u8]) -> Result<ImageFile, Reason> {
    let (width, height, values) = decode_values(bytes)?;
    let pixels = values.into_iter().map(|p| p.map(linear)).collect();
    Ok(ImageFile {
        image: crate::Image {
            width,
            height,
            pixels,
        },
        labels: Labels::new(),
    })
}

/// Width, height and recorded values of a PNG or JPEG file, 16 bits a channel; 8-bit values times 257.
pub(super) fn decode_values(bytes: &[u8]) -> Result<(usize, usize, Vec<[u16; 3]>), Reason> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(1 << 30);
    let file = Cursor::new(bytes);
    // Each by its own decoder: who asks for any gets those of formats that are not read here, once more in the program.
    let picture = match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => PngDecoder::with_limits(file, limits.clone())
            .and_then(|decoder| decoded(decoder, limits)),
        Ok(ImageFormat::Jpeg) => {
            JpegDecoder::new(file).and_then(|decoder| decoded(decoder, limits))
        }
        _ => return Err("it is neither PNG nor JPEG; export it as one of them".into()),
    };
    let picture = picture.map_err(|e| match e {
        image::ImageError::Limits(_) => {
            format!("it is larger than {MAX_SIDE} pixels a side or 1 GiB decoded; scale it down")
        }
        other => format!("{other}; the file is damaged, export it again"),
    })?;
    let picture = picture.into_rgb16();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    check_size(width, height)?;
    Ok((width, height, picture.pixels().map(|p| p.0).collect()))
}

fn decoded(mut decoder: impl ImageDecoder, mut limits: Limits) -> ImageResult<DynamicImage> {
    limits.reserve(decoder.total_bytes())?;
    decoder.set_limits(limits)?;
    DynamicImage::from_decoder(decoder)
}

/// The linear value of an sRGB value of 16 bits; 8 bits times 257 are the same value.
fn linear(encoded: u16) -> f32 {
    let v = f64::from(encoded) / 65535.0;
    let linear = if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    };
    linear as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_white_and_middle_gray_are_linear() {
        let mut bytes = Vec::new();
        let gray = image::GrayImage::from_raw(4, 1, vec![0, 10, 188, 255]).unwrap();
        gray.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .unwrap();
        let pixels = decode(&bytes).unwrap().image.pixels;
        // 10/255/12.92, and ((188/255 + 0.055) / 1.055)^2.4.
        assert_eq!(pixels[0], [0.0; 3]);
        assert_eq!(pixels[1], [0.003_035_27; 3]);
        assert_eq!(pixels[2], [0.502_886_5; 3]);
        assert_eq!(pixels[3], [1.0; 3]);
    }

    #[test]
    fn a_picture_of_another_format_is_refused_with_what_to_do() {
        let mut bytes = Vec::new();
        image::GrayImage::new(2, 2)
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Bmp)
            .unwrap();
        for other in [&bytes[..], b"none at all"] {
            let Err(reason) = decode(other) else {
                panic!("it is no PNG")
            };
            assert_eq!(
                reason,
                "it is neither PNG nor JPEG; export it as one of them"
            );
        }
    }

    #[test]
    fn a_truncated_picture_is_refused() {
        let mut bytes = Vec::new();
        let noise = image::RgbImage::from_fn(64, 64, |x, y| {
            image::Rgb([(x * 37 + y * 101) as u8, (x * y) as u8, y as u8])
        });
        noise
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .unwrap();
        for length in [8, 40, bytes.len() / 2] {
            let reason = decode(&bytes[..length]).unwrap_err();
            assert!(reason.contains("damaged"), "{length}: {reason}");
        }
    }
}
