//! A picture of any width and height as an 8-bit file.

use crate::preview::{Encoding, encode};
use png::ColorType;

/// Linear RGB `pixels`, rows of `width` from the top, as an 8-bit sRGB PNG; values outside 0..=1 are clamped. The bytes are
/// a function of the arguments.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_its_width_and_height() {
        let png = picture_png(3, &[[0.5, 1.0, 2.0]; 6]);
        assert_eq!(&png[16..24], &[0, 0, 0, 3, 0, 0, 0, 2]);
    }
}
