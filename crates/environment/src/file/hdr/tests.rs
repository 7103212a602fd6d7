//! Codec tests on files written by hand and on real ones.

use super::{decode, encode};
use crate::{Image, Labels};

const HEAD: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";

fn file(header: &str, pixels: &[u8]) -> Vec<u8> {
    [header.as_bytes(), pixels].concat()
}

/// A picture whose pixels all differ, exactly stored by RGBE.
fn numbered(width: usize, height: usize) -> Image {
    let mut image = Image::filled(width, height, [0.0; 3]);
    for (at, pixel) in image.pixels.iter_mut().enumerate() {
        *pixel = [128.0, at as f32, (at % 3) as f32];
    }
    image
}

#[test]
fn values_come_back_rounded_to_the_nearest_mantissa() {
    let mut image = Image::filled(512, 64, [0.0; 3]);
    for (at, pixel) in image.pixels.iter_mut().enumerate() {
        let size = 2f32.powi((at % 200) as i32 - 100);
        *pixel = [size * (1.0 + (at as f32 * 0.618).fract()), size * 0.37, 0.0];
    }
    let back = decode(&encode(&image, &Labels::new()).unwrap())
        .unwrap()
        .image;
    for (ours, theirs) in image.pixels.iter().zip(&back.pixels) {
        let largest = ours[0].max(ours[1]);
        for c in 0..3 {
            // Half a step of a mantissa of 8 bits that is at least 127.5.
            let error = (ours[c] - theirs[c]).abs();
            assert!(error <= largest / 255.0, "{ours:?} {theirs:?}");
        }
    }
    assert_eq!(
        decode(&encode(&back, &Labels::new()).unwrap())
            .unwrap()
            .image,
        back
    );
}

#[test]
fn powers_of_two_and_values_next_to_them_are_exact_or_nearest() {
    for value in [1.0f32, 0.5, 3.0, 1e-30, 1.6e38, 255.0, 255.4, 255.6, 0.0] {
        let image = Image::filled(1, 1, [value; 3]);
        let back = decode(&encode(&image, &Labels::new()).unwrap()).unwrap();
        let got = back.image.pixels[0][0];
        assert!((got - value).abs() <= value / 256.0, "{value} became {got}");
    }
    let one = encode(&Image::filled(1, 1, [1.0; 3]), &Labels::new()).unwrap();
    assert_eq!(one[one.len() - 4..], [128, 128, 128, 129]);
}

#[test]
fn what_rgbe_cannot_hold_is_refused() {
    for bad in [-1.0, 2e38] {
        let reason = encode(&Image::filled(9, 1, [bad; 3]), &Labels::new()).unwrap_err();
        assert!(
            reason.contains("(0, 0)") && reason.contains(".exr"),
            "{reason}"
        );
    }
}

#[test]
fn every_order_of_scanlines_gives_the_same_picture() {
    let image = numbered(3, 2);
    let bytes = encode(&image, &Labels::new()).unwrap();
    let stored: Vec<[u8; 4]> = bytes[bytes.len() - 24..]
        .chunks_exact(4)
        .map(|p| [p[0], p[1], p[2], p[3]])
        .collect();
    for order in [
        "-Y +X", "-Y -X", "+Y +X", "+Y -X", "+X -Y", "-X -Y", "+X +Y", "-X +Y",
    ] {
        let (slow, fast) = order.split_once(' ').unwrap();
        let range = |axis: &str| -> Vec<usize> {
            match axis {
                "+X" => (0..3).collect(),
                "-X" => (0..3).rev().collect(),
                "-Y" => (0..2).collect(),
                _ => (0..2).rev().collect(),
            }
        };
        let mut pixels = Vec::new();
        for a in range(slow) {
            for b in range(fast) {
                let (x, y) = if slow.ends_with('X') { (a, b) } else { (b, a) };
                pixels.extend(stored[y * 3 + x]);
            }
        }
        let size = |axis: &str| if axis.ends_with('X') { 3 } else { 2 };
        let text = format!("{HEAD}\n{slow} {} {fast} {}\n", size(slow), size(fast));
        assert_eq!(
            decode(&file(&text, &pixels)).unwrap().image,
            image,
            "{order}"
        );
    }
}

#[test]
fn old_runs_repeat_the_last_pixel_in_base_256() {
    let text = format!("{HEAD}\n-Y 1 +X 300\n");
    // One pixel, then 43 + 1 · 256 repetitions.
    let bytes = file(&text, &[128, 64, 0, 129, 1, 1, 1, 43, 1, 1, 1, 1]);
    assert_eq!(
        decode(&bytes).unwrap().image.pixels,
        vec![[1.0, 0.5, 0.0]; 300]
    );
}

#[test]
fn exposure_and_colour_correction_are_divided_out() {
    let text =
        format!("{HEAD}EXPOSURE=2\nEXPOSURE= 4\nCOLORCORR= 1 2 4\nVIEW= -vtv\n\n-Y 1 +X 1\n");
    let read = decode(&file(&text, &[128, 128, 128, 129])).unwrap();
    assert_eq!(read.image.pixels, [[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0]]);
    assert_eq!(read.labels["VIEW"], "-vtv");
}

#[test]
fn xyz_of_equal_energy_is_white() {
    let text = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
    let [r, g, b] = decode(&file(text, &[128, 128, 128, 129]))
        .unwrap()
        .image
        .pixels[0];
    for v in [r, g, b] {
        assert!((v - 1.0).abs() < 1e-7, "{r} {g} {b}");
    }
}

#[test]
fn broken_files_are_named() {
    let good = encode(&numbered(20, 4), &Labels::new()).unwrap();
    for length in [1, 12, 40, good.len() - 1] {
        let reason = decode(&good[..length]).unwrap_err();
        assert!(
            reason.contains("damaged") || reason.contains("no Radiance"),
            "{reason}"
        );
    }
    for (text, word) in [
        ("no picture\n\n-Y 1 +X 1\n", "#?"),
        ("#?RADIANCE\n\n-Y 1 +X 1\n", "FORMAT"),
        ("#?RADIANCE\nFORMAT=ascii\n\n-Y 1 +X 1\n", "ascii"),
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0\n\n-Y 1 +X 1\n",
            "EXPOSURE",
        ),
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nGAMMA=2.2\n\n-Y 1 +X 1\n",
            "GAMMA",
        ),
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +Y 1\n",
            "resolution",
        ),
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 1\n",
            "0 pixels",
        ),
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 99999\n",
            "at most",
        ),
    ] {
        let reason = decode(&file(text, &[0; 8])).unwrap_err();
        assert!(reason.contains(word), "{text}: {reason}");
    }
}

#[test]
fn no_flipped_byte_panics() {
    let good = encode(&numbered(20, 4), &Labels::new()).unwrap();
    for at in 0..good.len() {
        for flip in [1, 0x80, 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            let _ = decode(&bytes);
        }
    }
}

/// The header that Photoshop writes.
const PHOTOSHOP: &str = "#?RADIANCE\n# Made with Adobe Photoshop\nGAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\n\
    FORMAT=32-bit_rle_rgbe\n\n";

/// One channel of a scanline in pieces of at most `longest` values: a run where all are equal, else the values.
fn pieces(values: &[u8], longest: usize) -> Vec<u8> {
    let piece = |part: &[u8]| {
        let length = part.len() as u8;
        if part.iter().all(|value| *value == part[0]) {
            vec![128 + length, part[0]]
        } else {
            [&[length], part].concat()
        }
    };
    values.chunks(longest).flat_map(piece).collect()
}

#[test]
fn a_file_as_photoshop_writes_it_gives_its_values_and_survives_a_round_trip() {
    let (width, height) = (300usize, 40usize);
    // Even stretches and uneven ones, black among them, over 60 powers of two; the largest mantissa is at least 128.
    let pixel = |x: usize, y: usize| -> [u8; 4] {
        match (x / 50) % 3 {
            0 => [0, 0, 0, 0],
            1 => [200, 7, 0, 100 + y as u8],
            _ => [
                (x * 7 + y) as u8,
                128 + (x % 128) as u8,
                (x * x) as u8,
                90 + (x % 60) as u8,
            ],
        }
    };
    let mut bytes = file(PHOTOSHOP, format!("-Y {height} +X {width}\n").as_bytes());
    for y in 0..height {
        bytes.extend([2, 2, (width >> 8) as u8, width as u8]);
        for channel in 0..4 {
            let values: Vec<u8> = (0..width).map(|x| pixel(x, y)[channel]).collect();
            // 127 is the longest run, 128 the most single values; 50 meets the ends of stretches.
            bytes.extend(pieces(&values, [50, 127, 3][y % 3]));
        }
    }
    let read = decode(&bytes).unwrap();
    assert_eq!(read.labels["PRIMARIES"], "0 0 0 0 0 0 0 0");
    assert_eq!((read.image.width, read.image.height), (width, height));
    for (at, value) in read.image.pixels.iter().enumerate() {
        let [r, g, b, e] = pixel(at % width, at / width);
        let unit = 2f32.powi(i32::from(e) - 136);
        let exact = [r, g, b].map(|m| f32::from(m) * unit);
        assert_eq!(*value, exact, "pixel {at}");
    }
    let again = decode(&encode(&read.image, &Labels::new()).unwrap());
    assert_eq!(again.unwrap().image, read.image);
}

#[path = "../../../../../tests/skip.rs"]
mod skip;

#[test]
fn real_files_survive_a_round_trip() {
    let Some(folder) = skip::model("hdr") else {
        return;
    };
    for entry in std::fs::read_dir(folder).unwrap() {
        let bytes = std::fs::read(entry.unwrap().path()).unwrap();
        let image = decode(&bytes).unwrap().image;
        assert_eq!((image.width, image.height), (1024, 512));
        let back = decode(&encode(&image, &Labels::new()).unwrap())
            .unwrap()
            .image;
        assert_eq!(image, back);
    }
}

#[test]
fn a_byte_order_mark_before_the_text_is_read_past() {
    let plain = file(
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n",
        &[128, 64, 32, 129],
    );
    let marked = [&b"\xef\xbb\xbf"[..], &plain].concat();
    // 2^(129 - 136) = 1/128.
    let expected = [1.0f32, 0.5, 0.25];
    let read = |bytes: &[u8]| decode(bytes).unwrap().image.pixels;
    assert_eq!(read(&marked), read(&plain));
    for (c, exact) in read(&marked)[0].into_iter().zip(expected) {
        // Readers add half a step of 1/128 or none.
        assert!((c - exact).abs() <= 1.0 / 128.0, "{c} {exact}");
    }
}
