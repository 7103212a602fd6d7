//! A picture of any width and height as an 8-bit file.

use crate::preview::{Encoding, encode};
use png::ColorType;

/// Linear RGB `pixels`, rows of `width` from the top, as an 8-bit sRGB PNG; values outside 0..=1 are clamped. The bytes
/// are a function of the arguments.
///
/// # Panics
/// Where `pixels` are not whole rows.
pub fn picture_png(width: usize, pixels: &[[f32; 3]]) -> Vec<u8> {
    let height = pixels.len() / width.max(1);
    assert_eq!(pixels.len(), width * height, "a picture {width} wide");
    let bytes: Vec<u8> = pixels
        .iter()
        .flatten()
        .map(|&value| Encoding::Srgb.byte(value))
        .collect();
    encode(
        [width as u32, height as u32],
        ColorType::Rgb,
        &bytes,
        Some((Encoding::Srgb, "sRGB")),
    )
}

/// Like [`picture_png`] with a matte: colours are divided by their alpha, as the format asks.
///
/// # Panics
/// Where `pixels` are not whole rows, or there are not as many alphas.
pub fn matte_png(width: usize, pixels: &[[f32; 3]], alpha: &[f32]) -> Vec<u8> {
    let height = pixels.len() / width.max(1);
    assert_eq!(pixels.len(), width * height, "a picture {width} wide");
    assert_eq!(pixels.len(), alpha.len());
    let pixel = |(rgb, alpha): (&[f32; 3], &f32)| {
        let own = rgb.map(|v| if *alpha > 0.0 { v / alpha } else { 0.0 });
        let [r, g, b] = own.map(|v| Encoding::Srgb.byte(v));
        [r, g, b, Encoding::Linear.byte(*alpha)]
    };
    let bytes: Vec<u8> = pixels.iter().zip(alpha).flat_map(pixel).collect();
    let size = [width as u32, height as u32];
    encode(
        size,
        ColorType::Rgba,
        &bytes,
        Some((Encoding::Srgb, "sRGB")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_its_width_and_height() {
        let png = picture_png(3, &[[0.5, 1.0, 2.0]; 6]);
        assert_eq!(&png[16..24], &[0, 0, 0, 3, 0, 0, 0, 2]);
    }

    #[test]
    fn a_matte_has_colours_without_their_alpha_and_black_where_there_is_none() {
        let png = matte_png(3, &[[0.5, 0.25, 0.0], [7.0; 3], [1.0; 3]], &[0.5, 0.0, 1.0]);
        // Half of linear light is 188 in sRGB.
        assert_eq!(
            crate::preview::decoded(&png).1,
            [255, 188, 0, 128, 0, 0, 0, 0, 255, 255, 255, 255]
        );
    }
}
