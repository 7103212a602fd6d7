//! 8-bit previews of layers, each saying in its own chunks how its numbers are stored.

use layers::{Layer, Preview};
use png::{BitDepth, ColorType, Compression, Encoder, ScaledFloat, SrgbRenderingIntent};
use std::sync::LazyLock;

/// The least value that becomes each byte above 0 on the sRGB curve: a search among them costs less than the curve's
/// power.
static SRGB_STEPS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|step| {
        let reaches = |bits| usize::from(Encoding::Srgb.byte(f32::from_bits(bits))) > step;
        // Bits of positive numbers are in the order of the numbers, and 1 becomes 255.
        let (mut low, mut high) = (0, 1f32.to_bits());
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            match reaches(middle) {
                true => high = middle,
                false => low = middle,
            }
        }
        f32::from_bits(high)
    })
});

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
    /// The encoding of a layer's preview, as the table of layers says; `None` where there is none. `values` are all of
    /// the layer's.
    ///
    /// ```
    /// use ambake_report::Encoding;
    /// use layers::Layer;
    ///
    /// let encoding = Encoding::of(Layer::Diffuse, &[0.25, 0.5]).unwrap();
    /// assert_eq!((encoding, encoding.byte(0.5)), (Encoding::Linear, 128));
    /// ```
    pub fn of(layer: Layer, values: &[f32]) -> Option<Encoding> {
        Some(match layer.preview() {
            Preview::Linear => Encoding::Linear,
            Preview::Signed => Encoding::Signed,
            Preview::Srgb => Encoding::Srgb,
            Preview::OfLargest => {
                let most = values.iter().fold(0.0f32, |a, &b| a.max(b));
                Encoding::Scaled(if most > 0.0 { most } else { 1.0 })
            }
            Preview::None => return None,
        })
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

/// The preview of `layer` as a PNG file: grey for one channel, RGB for three; `None` where the layer has none. The
/// bytes are a function of the arguments.
///
/// * `values`: planes of `size * size` values, one after another, one for each of the layer's channels.
///
/// # Panics
/// Where there are more or fewer values.
pub fn preview_png(size: u32, layer: Layer, values: &[f32]) -> Option<Vec<u8>> {
    let texels = size as usize * size as usize;
    let channels = layer.channels().len();
    assert_eq!(
        values.len(),
        channels * texels,
        "layer {} of a page of {size} texels",
        layer.name()
    );
    let encoding = Encoding::of(layer, values)?;
    let color = match channels {
        1 => ColorType::Grayscale,
        _ => ColorType::Rgb,
    };
    let mut pixels = vec![0; channels * texels];
    for (c, plane) in values.chunks(texels.max(1)).enumerate() {
        let bytes = pixels.iter_mut().skip(c).step_by(channels);
        match encoding {
            Encoding::Srgb => {
                let steps = &*SRGB_STEPS;
                let byte = |value: f32| steps.partition_point(|&least| value >= least) as u8;
                bytes.zip(plane).for_each(|(to, &value)| *to = byte(value));
            }
            _ => bytes
                .zip(plane)
                .for_each(|(to, &value)| *to = encoding.byte(value)),
        }
    }
    let title = format!("{}: {}", layer.name(), encoding.description());
    // Grey ones get a tenth larger by it, coloured ones twice as large.
    let how = match channels {
        1 => Compression::Fast,
        _ => Compression::Balanced,
    };
    Some(packed(
        [size; 2],
        color,
        &pixels,
        Some((encoding, &title)),
        how,
    ))
}

/// The diffuse term as the picture for glTF's `occlusionTexture`: RGB, 8-bit, linear, red = green = blue.
///
/// It carries no colour-space chunk, which glTF readers must ignore and validators warn about.
///
/// * `diffuse`: `size * size` values.
pub fn occlusion_png(size: u32, diffuse: &[f32]) -> Vec<u8> {
    let pixels: Vec<u8> = diffuse
        .iter()
        .flat_map(|&v| [Encoding::Linear.byte(v); 3])
        .collect();
    encode([size; 2], ColorType::Rgb, &pixels, None)
}

/// A PNG file in memory.
pub(crate) fn encode(
    size: [u32; 2],
    color: ColorType,
    pixels: &[u8],
    about: Option<(Encoding, &str)>,
) -> Vec<u8> {
    packed(size, color, pixels, about, Compression::Balanced)
}

/// As [`encode`], packed so.
fn packed(
    [width, height]: [u32; 2],
    color: ColorType,
    pixels: &[u8],
    about: Option<(Encoding, &str)>,
    compression: Compression,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
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

/// Width and bytes of a PNG.
#[cfg(test)]
pub(crate) fn decoded(png: &[u8]) -> (usize, Vec<u8>) {
    let decoder = png::Decoder::new(std::io::Cursor::new(png));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (reader.info().width as usize, pixels)
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
    fn previews_on_the_srgb_curve_are_rounded_to_the_nearest_byte() {
        let steps = SRGB_STEPS.iter().flat_map(|step| {
            let bits = step.to_bits();
            [bits - 1, bits, bits + 1].map(f32::from_bits)
        });
        let odd = [-1.0, 0.0, 0.5, 1.0, 7.0, f32::MAX, 1e-30];
        let mut values: Vec<f32> = steps.chain(odd).collect();
        values.resize(32 * 32 * 3, 0.25);
        let bytes = preview_png(32, Layer::Phong, &values).unwrap();
        let (_, pixels) = decoded(&bytes);
        assert_eq!(pixels.len(), values.len());
        for (at, &byte) in pixels.iter().enumerate() {
            let value = values[at % 3 * 1024 + at / 3];
            assert_eq!(byte, Encoding::Srgb.byte(value), "{value}");
        }
    }

    #[test]
    fn a_preview_says_how_it_is_stored() {
        let values = vec![0.0, 0.25, 0.5, 1.0];
        let linear = preview_png(2, Layer::Diffuse, &values).unwrap();
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

        let bytes = preview_png(2, Layer::Phong, &values.repeat(3)).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info();
        assert_eq!(
            reader.unwrap().info().srgb,
            Some(SrgbRenderingIntent::RelativeColorimetric)
        );
        assert_eq!(
            decoded(&bytes).1,
            [0, 0, 0, 137, 137, 137, 188, 188, 188, 255, 255, 255]
        );
        assert_eq!(Some(bytes), preview_png(2, Layer::Phong, &values.repeat(3)));
    }

    #[test]
    fn every_layer_but_positions_and_indices_has_a_preview() {
        for layer in Layer::all() {
            let values = vec![0.5; 4 * layer.channels().len()];
            let none =
                matches!(layer, Layer::Position | Layer::Object) || layer.channels().len() > 3;
            assert_eq!(
                preview_png(2, layer, &values).is_none(),
                none,
                "{}",
                layer.name()
            );
        }
    }
}
