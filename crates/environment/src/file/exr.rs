//! OpenEXR pictures: any flat RGB or luminance part in, one float32 ZIP part out.

use super::image_file::{ImageFile, Labels, Reason, check_size};
use crate::Image;
use exr::block::reader::Reader;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::read::read;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Layer};
use exr::meta::attribute::{AttributeValue, LineOrder, Text};
use exr::meta::header::LayerAttributes;
use std::io::{Cursor, Read, Seek};

/// Deflate cannot shrink data more than this; a header that promises more lies about its file.
const MAX_RATIO: usize = 1032;

/// The first part of an `.exr` file: its channels R, G and B, or Y.
pub(super) fn decode(bytes: &[u8]) -> Result<ImageFile, Reason> {
    let damaged = |e: exr::error::Error| format!("{e}; the file is damaged, export it again");
    let mut source = Cursor::new(bytes);
    let chunks = exr_chunks(&mut source).map_err(damaged)?;
    let Some(header) = chunks.headers().first() else {
        return Err("it holds no picture".into());
    };
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    check_size(width, height)?;
    if header.deep {
        return Err("it is deep; flatten it".into());
    }
    let channels = &header.channels.list;
    if channels
        .iter()
        .any(|c| c.sampling.x() != 1 || c.sampling.y() != 1)
    {
        return Err("it has subsampled channels; write it as RGB".into());
    }
    let shown = header.shared_attributes.display_window;
    if shown.size != header.layer_size || shown.position != header.own_attributes.layer_position {
        return Err("its data window is not its display window; write it without cropping".into());
    }
    let promised = width * height * 2 * channels.len();
    if promised / MAX_RATIO > bytes.len() {
        return Err(format!(
            "its header promises {promised} bytes of pixels, its {} bytes cannot hold them",
            bytes.len()
        ));
    }
    let (mut planes, labels) = exr_planes(chunks).map_err(damaged)?;
    let mut plane = |name: &str| {
        let found = planes.iter_mut().find(|plane| plane.0 == name)?;
        Some(std::mem::take(&mut found.1))
    };
    let pixels = match (plane("R"), plane("G"), plane("B"), plane("Y")) {
        (Some(r), Some(g), Some(b), _) => (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect(),
        (None, None, None, Some(y)) => y.into_iter().map(|v| [v; 3]).collect(),
        _ => return Err("it has neither R, G and B nor Y alone; choose one layer of it".into()),
    };
    Ok(ImageFile {
        image: Image {
            width,
            height,
            pixels,
        },
        labels,
    })
}

/// Channels of an `.exr` file with their names, in the file's order.
pub type Planes = Vec<(String, Vec<f32>)>;

/// What an `.exr` file is read from. A reader for each kind of source would be the same code once more.
pub trait ExrSource: Read + Seek {}

impl<R: Read + Seek> ExrSource for R {}

/// The headers of an `.exr` file, and what reads the rest.
///
/// # Errors
/// The file is damaged, or none.
pub fn exr_chunks(source: &mut dyn ExrSource) -> exr::error::Result<Reader<&mut dyn ExrSource>> {
    exr::block::read(source, false)
}

/// The channels of the first part of an `.exr` file as floats, and its text attributes.
///
/// # Errors
/// The file is damaged.
pub fn exr_planes(chunks: Reader<&mut dyn ExrSource>) -> exr::error::Result<(Planes, Labels)> {
    let file = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_chunks(chunks)?;
    let layer = file.layer_data;
    let attributes = layer.attributes.other.iter().chain(&file.attributes.other);
    let labels = attributes.filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => {
            let text = String::from_utf8_lossy(text.as_slice()).into_owned();
            Some((name.to_string(), text))
        }
        _ => None,
    });
    let labels = labels.collect();
    let planes = layer.channel_data.list.into_iter().map(|channel| {
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            other => other.values_as_f32().collect(),
        };
        (channel.name.to_string(), values)
    });
    Ok((planes.collect(), labels))
}

/// The bytes of an `.exr` file with `labels` as string attributes, and a channel of another name where it is given.
pub(super) fn encode(
    image: &Image,
    extra: Option<(&str, &[f32])>,
    labels: &Labels,
) -> Result<Vec<u8>, Reason> {
    let colors = ["B", "G", "R"].iter().zip([2, 1, 0]).map(|(name, c)| {
        let values = image.pixels.iter().map(|p| p[c]).collect();
        AnyChannel::new(*name, FlatSamples::F32(values))
    });
    let extra =
        extra.map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values.to_vec())));
    let channels = colors.chain(extra);
    let mut attributes = LayerAttributes::default();
    for (name, text) in labels {
        let text = Text::from_slice_unchecked(text.as_bytes());
        let name = Text::from_slice_unchecked(name.as_bytes());
        attributes.other.insert(name, AttributeValue::Text(text));
    }
    let encoding = Encoding {
        compression: exr::compression::Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width, image.height);
    let layer = Layer::new(
        size,
        attributes,
        encoding,
        AnyChannels::sort(channels.collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer)
        .write()
        .to_unbuffered(&mut bytes)
        .map_err(|e| e.to_string())?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Puts the attributes of the header in the order of their names: the exr crate writes them in a random one. The header
/// keeps its length, so the offset table after it stays true.
fn sort_attributes(bytes: &mut [u8]) {
    const PREFIX: usize = 8; // magic number and version
    let header = &bytes[PREFIX..];
    let mut records = Vec::new();
    let mut at = 0;
    while header[at] != 0 {
        let end_of_word =
            |from: usize| from + header[from..].iter().take_while(|b| **b != 0).count() + 1;
        let value = end_of_word(end_of_word(at)) + 4;
        let length: [u8; 4] = std::array::from_fn(|i| header[value - 4 + i]);
        let end = value + u32::from_le_bytes(length) as usize;
        records.push(&header[at..end]);
        at = end;
    }
    records.sort(); // a record begins with its name and a zero byte
    let sorted = records.concat();
    bytes[PREFIX..PREFIX + sorted.len()].copy_from_slice(&sorted);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Image {
        let mut image = Image::filled(33, 17, [0.0; 3]);
        for (at, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [at as f32 * 0.1, 1e30, 1.0 / (at as f32 + 1.0)];
        }
        image
    }

    #[test]
    fn pixels_and_labels_come_back_bit_for_bit_and_bytes_repeat() {
        let labels: Labels = (0..20)
            .map(|i| (format!("ambake{i}"), format!("text {i}, größer")))
            .collect();
        let bytes = encode(&picture(), None, &labels).unwrap();
        let back = decode(&bytes).unwrap();
        assert_eq!(back.image, picture());
        assert_eq!(back.labels, labels);
        for _ in 0..4 {
            assert_eq!(encode(&picture(), None, &labels).unwrap(), bytes);
        }
    }

    #[test]
    fn truncations_are_errors_and_flipped_bytes_never_panic() {
        let bytes = encode(&picture(), None, &Labels::new()).unwrap();
        for length in (0..bytes.len()).step_by(7) {
            assert!(decode(&bytes[..length]).is_err(), "{length}");
        }
        for at in 0..bytes.len().min(600) {
            let mut broken = bytes.clone();
            broken[at] ^= 0xff;
            let _ = decode(&broken);
        }
    }
}
