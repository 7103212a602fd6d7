//! An OpenEXR file as engines expect it: channels R, G and B alone, half floats, ZIP.

use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::meta::attribute::{LineOrder, Text};
use exr::meta::header::LayerAttributes;
use half::f16;
use std::io::Cursor;

/// The bytes of the file. The header names its writer and no more, so that they depend on the pixels alone.
pub fn encode([width, height]: [u32; 2], pixels: &[[f32; 3]]) -> Vec<u8> {
    let channels = [("B", 2), ("G", 1), ("R", 0)].map(|(name, c): (_, usize)| {
        let values = pixels.iter().map(|p| f16::from_f32(p[c]));
        AnyChannel::new(name, FlatSamples::F16(values.collect()))
    });
    let attributes = LayerAttributes {
        software_name: Some(Text::from("ambake")),
        ..LayerAttributes::default()
    };
    let encoding = Encoding {
        compression: exr::compression::Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        (width as usize, height as usize),
        attributes,
        encoding,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_unbuffered(&mut bytes)
        .expect("a picture of three channels, in memory");
    bytes.into_inner()
}
