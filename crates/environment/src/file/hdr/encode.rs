//! Writes RGBE, run-length coded.

use crate::Image;
use crate::file::image_file::{Labels, Reason};

/// The bytes of a `.hdr` file with `labels` in its header.
pub(crate) fn encode(image: &Image, labels: &Labels) -> Result<Vec<u8>, Reason> {
    let mut bytes = b"#?RADIANCE\n".to_vec();
    for (name, text) in labels {
        bytes.extend(format!("{name}={}\n", text.replace(['\n', '\r'], " ")).bytes());
    }
    bytes.extend(b"FORMAT=32-bit_rle_rgbe\n\n");
    bytes.extend(format!("-Y {} +X {}\n", image.height, image.width).bytes());
    let mut line = Vec::with_capacity(image.width);
    for (y, row) in image.pixels.chunks_exact(image.width).enumerate() {
        line.clear();
        for (x, pixel) in row.iter().enumerate() {
            let rgbe = rgbe(*pixel).ok_or_else(|| {
                format!("pixel ({x}, {y}) is {pixel:?}, which RGBE cannot hold; write .exr")
            })?;
            line.push(rgbe);
        }
        write_scanline(&line, &mut bytes);
    }
    Ok(bytes)
}

/// The nearest pixel of four bytes; `None` for a negative or too large value.
fn rgbe(pixel: [f32; 3]) -> Option<[u8; 4]> {
    let pixel = pixel.map(f64::from);
    let largest = pixel.into_iter().fold(0.0, f64::max);
    if pixel.iter().any(|v| *v < 0.0) {
        return None;
    }
    // The smallest power of two under which the largest mantissa still rounds to at most 255.
    let mut exponent = largest.log2().floor() as i32 + 1;
    if largest == 0.0 || exponent < -127 {
        return Some([0; 4]);
    }
    if (largest * 2f64.powi(8 - exponent)).round() > 255.0 {
        exponent += 1;
    }
    if exponent > 127 {
        return None;
    }
    let [r, g, b] = pixel.map(|v| (v * 2f64.powi(8 - exponent)).round() as u8);
    Some([r, g, b, (exponent + 128) as u8])
}

fn write_scanline(line: &[[u8; 4]], bytes: &mut Vec<u8>) {
    let length = line.len();
    if !(8..1 << 15).contains(&length) {
        bytes.extend(line.iter().flatten());
        return;
    }
    bytes.extend([2, 2, (length >> 8) as u8, length as u8]);
    for channel in 0..4 {
        let values: Vec<u8> = line.iter().map(|pixel| pixel[channel]).collect();
        let run_at = |at: usize| {
            let same = values[at..].iter().take(127);
            same.take_while(|v| **v == values[at]).count()
        };
        let mut at = 0;
        while at < length {
            let run = run_at(at);
            if run >= 4 {
                bytes.extend([128 + run as u8, values[at]]);
                at += run;
                continue;
            }
            let mut end = at + 1;
            while end < length && end - at < 128 && run_at(end) < 4 {
                end += 1;
            }
            bytes.push((end - at) as u8);
            bytes.extend(&values[at..end]);
            at = end;
        }
    }
}
