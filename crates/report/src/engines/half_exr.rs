//! An OpenEXR file as engines expect it: channels R, G and B alone, half floats, ZIP.

use crate::exr_write::plain_exr;
use exr::image::{AnyChannel, FlatSamples};
use half::f16;

/// The bytes of the file, which depend on the pixels alone.
pub fn encode([width, height]: [u32; 2], pixels: &[[f32; 3]]) -> Vec<u8> {
    let channels = [("B", 2), ("G", 1), ("R", 0)].map(|(name, c): (_, usize)| {
        let values = pixels.iter().map(|p| f16::from_f32(p[c]));
        AnyChannel::new(name, FlatSamples::F16(values.collect()))
    });
    plain_exr((width as usize, height as usize), channels)
}
