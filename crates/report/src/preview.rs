//! 8-bit previews of layers, each saying in its own chunks how its numbers are stored.

use crate::{Error, Layer, Page};
use png::{BitDepth, ColorType, Encoder, ScaledFloat, SrgbRenderingIntent};

/// How a value becomes a byte.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encoding {
    /// `round(255 v)`, clamped; the file says gamma 1.
    Linear,
    /// `round(255 v / scale)`, clamped; the file says gamma 1 and names the scale.
    Scaled(f32),
    /// `round(255 (v + 1) / 2)`, clamped: unit vectors; the file says gamma 1.
    Signed,
    /// The sRGB curve, clamped; the file carries the sRGB chunk.
    Srgb,
}

impl Encoding {
    /// The encoding for previews of `layer`; `None` where 8 bits show nothing useful (positions, indices, exponents).
    pub fn of(layer: &Layer) -> Option<Encoding> {
        match layer.name.as_str() {
            "coverage" | "visibility" | "diffuse" | "specular" | "error" | "validity" => {
                Some(Encoding::Linear)
            }
            "traditional" | "lambert" | "phong" => Some(Encoding::Srgb),
            "normal" | "geometric" | "bent" => Some(Encoding::Signed),
            "rays" => {
                let most = layer
                    .channels
                    .iter()
                    .flat_map(|c| &c.values)
                    .fold(0.0f32, |a, &b| a.max(b));
                Some(Encoding::Scaled(if most > 0.0 { most } else { 1.0 }))
            }
            _ => None,
        }
    }

    /// The byte for `value`. NaN becomes 0.
    pub fn byte(self, value: f32) -> u8 {
        let v = f64::from(value);
        let unit = match self {
            Encoding::Linear => v,
            Encoding::Scaled(scale) => v / f64::from(scale),
            Encoding::Signed => (v + 1.0) / 2.0,
            Encoding::Srgb if v <= 0.003_130_8 => 12.92 * v,
            Encoding::Srgb => 1.055 * v.powf(1.0 / 2.4) - 0.055,
        };
        // `as` saturates and takes NaN to 0.
        (unit * 255.0).round() as u8
    }

    /// What the file says about itself.
    fn description(self) -> String {
        match self {
            Encoding::Linear => "linear, byte = round(255 value)".into(),
            Encoding::Scaled(scale) => format!("linear, byte = round(255 value / {scale})"),
            Encoding::Signed => "linear, byte = round(255 (value + 1) / 2)".into(),
            Encoding::Srgb => "sRGB".into(),
        }
    }
}

/// The preview of `layer` as a PNG file: grey for one channel, RGB for three. The bytes are a function of the arguments.
///
/// # Panics
/// Where the layer has neither one nor three channels of `size * size` values.
pub fn preview_png(size: u32, layer: &Layer, encoding: Encoding) -> Vec<u8> {
    let texels = size as usize * size as usize;
    for channel in &layer.channels {
        assert_eq!(
            channel.values.len(),
            texels,
            "layer {} of a page of {size} texels",
            layer.name
        );
    }
    let (color, pixels) = match layer.channels.as_slice() {
        [grey] => (
            ColorType::Grayscale,
            grey.values
                .iter()
                .map(|&v| encoding.byte(v))
                .collect::<Vec<u8>>(),
        ),
        [r, g, b] => {
            let texel =
                |i: usize| [r.values[i], g.values[i], b.values[i]].map(|v| encoding.byte(v));
            (ColorType::Rgb, (0..texels).flat_map(texel).collect())
        }
        other => panic!("layer {} has {} channels", layer.name, other.len()),
    };
    let title = format!("{}: {}", layer.name, encoding.description());
    encode([size, size], color, &pixels, Some((encoding, &title)))
}

/// The diffuse term as the picture for glTF's `occlusionTexture`: RGB, 8-bit, linear, red = green = blue.
///
/// It carries no colour-space chunk, which glTF readers must ignore and validators warn about.
///
/// # Errors
/// [`Error::MissingLayer`] without a `diffuse` layer.
pub fn occlusion_png(page: &Page) -> Result<Vec<u8>, Error> {
    let diffuse = page.values("diffuse").ok_or_else(|| Error::MissingLayer {
        layer: "diffuse".into(),
    })?;
    let pixels: Vec<u8> = diffuse
        .iter()
        .flat_map(|&v| [Encoding::Linear.byte(v); 3])
        .collect();
    Ok(encode([page.size; 2], ColorType::Rgb, &pixels, None))
}

/// A PNG file in memory.
pub(crate) fn encode(
    [width, height]: [u32; 2],
    color: ColorType,
    pixels: &[u8],
    about: Option<(Encoding, &str)>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    if let Some((encoding, text)) = about {
        match encoding {
            Encoding::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
            _ => encoder.set_source_gamma(ScaledFloat::from_scaled(100_000)),
        }
        let keep = "our own words are Latin-1 and the keyword is short";
        encoder
            .add_text_chunk("Description".into(), text.into())
            .expect(keep);
    }
    let why = "a PNG in memory with matching sizes";
    let mut writer = encoder.write_header().expect(why);
    writer.write_image_data(pixels).expect(why);
    writer.finish().expect(why);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_rounded_and_clamped() {
        let linear: Vec<u8> = [-1.0, 0.0, 0.5 / 255.0, 1.49 / 255.0, 0.5, 1.0, 7.0]
            .map(|v| Encoding::Linear.byte(v))
            .into();
        assert_eq!(linear, [0, 0, 1, 1, 128, 255, 255]);
        // 0.2140 is the linear value of mid grey; 0.18 is photography's grey card.
        assert_eq!(
            [0.0, 0.214_041_14, 0.18, 1.0].map(|v| Encoding::Srgb.byte(v)),
            [0, 128, 118, 255]
        );
        assert_eq!(
            [-1.0, 0.0, 1.0].map(|v| Encoding::Signed.byte(v)),
            [0, 128, 255]
        );
        assert_eq!(Encoding::Scaled(64.0).byte(64.0), 255);
    }

    #[test]
    fn a_preview_says_how_it_is_stored() {
        let values = vec![0.0, 0.25, 0.5, 1.0];
        let linear = preview_png(
            2,
            &Layer::scalar("diffuse", values.clone()),
            Encoding::Linear,
        );
        let reader = png::Decoder::new(std::io::Cursor::new(&linear))
            .read_info()
            .unwrap();
        let info = reader.info();
        assert_eq!(info.gamma().unwrap().into_scaled(), 100_000);
        assert_eq!(
            info.uncompressed_latin1_text[0].text,
            "diffuse: linear, byte = round(255 value)"
        );
        assert_eq!((info.color_type, info.srgb), (ColorType::Grayscale, None));

        let layer = Layer::triple(
            "phong",
            ["R", "G", "B"],
            [values.clone(), values.clone(), values],
        );
        let encoding = Encoding::of(&layer).unwrap();
        let bytes = preview_png(2, &layer, encoding);
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        assert_eq!(
            reader.info().srgb,
            Some(SrgbRenderingIntent::RelativeColorimetric)
        );
        let mut pixels = vec![0; 12];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(
            pixels,
            [0, 0, 0, 137, 137, 137, 188, 188, 188, 255, 255, 255]
        );
        assert_eq!(bytes, preview_png(2, &layer, encoding));
    }
}
