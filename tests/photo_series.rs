//! Series of photographs: merged by their times, and the curve of a film.

use crate::photo::{confidence, json};
use crate::support::{load_image, run, run_well};
use environment::FACES;
use image::{ImageBuffer, Rgb};
use std::fs;
use std::path::Path;

/// A photograph of patches of 16 pixels, of radiance 8, 16, … 1024 by columns, with a time in its EXIF block.
pub fn exif_jpeg(path: &Path, time: [u32; 2]) {
    exif_shot(path, time, None);
}

/// The same with an aperture and a sensitivity, beside f/2 and ISO 100.
fn exif_shot(path: &Path, [over, under]: [u32; 2], lens: Option<(u32, u16)>) {
    let mut time = f64::from(over) / f64::from(under.max(1));
    if let Some((f_number, iso)) = lens {
        time *= f64::from(iso) / 100.0 * (2.0 / f64::from(f_number)).powi(2);
    }
    let level = |x: u32| (f64::from(8 << (x / 16)) * time).min(255.0) as u8;
    let picture: ImageBuffer<Rgb<u8>, Vec<u8>> =
        ImageBuffer::from_fn(128, 16, |x, _| Rgb([level(x); 3]));
    let mut jpeg = std::io::Cursor::new(Vec::new());
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 100)
        .encode_image(&picture)
        .expect("it is encoded");
    // TIFF: one directory with a pointer to EXIF's, which has ExposureTime as a rational after it.
    let mut tiff = b"II*\0\x08\0\0\0".to_vec();
    let entry = |tag: u16, kind: u16, value: u32| {
        let mut bytes = [tag.to_le_bytes(), kind.to_le_bytes()].concat();
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
        bytes
    };
    tiff.extend(1u16.to_le_bytes());
    tiff.extend(entry(0x8769, 4, 26));
    tiff.extend(0u32.to_le_bytes());
    let fields = if lens.is_some() { 3u16 } else { 1 };
    let after = 32 + 12 * u32::from(fields);
    tiff.extend(fields.to_le_bytes());
    tiff.extend(entry(0x829a, 5, after));
    if let Some((_, iso)) = lens {
        tiff.extend(entry(0x829d, 5, after + 8));
        tiff.extend(entry(0x8827, 3, u32::from(iso)));
    }
    tiff.extend(0u32.to_le_bytes());
    tiff.extend([over, under].iter().flat_map(|v| v.to_le_bytes()));
    if let Some((f_number, _)) = lens {
        tiff.extend([f_number, 1].iter().flat_map(|v| v.to_le_bytes()));
    }
    let block = [b"Exif\0\0".as_slice(), &tiff].concat();
    let jpeg = jpeg.into_inner();
    let length = (block.len() as u16 + 2).to_be_bytes();
    let bytes = [&jpeg[..2], &[0xff, 0xe1], &length, &block, &jpeg[2..]].concat();
    fs::write(path, bytes).expect("it is written");
}

#[test]
fn jpegs_merge_by_the_times_in_their_exif_blocks() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let times = [[2, 1], [1, 2], [1, 8]];
    for (k, time) in times.into_iter().enumerate() {
        exif_jpeg(at(&format!("{k}.jpg")).as_ref(), time);
    }
    let text = run_well([
        "map",
        "merge",
        &at("0.jpg"),
        &at("1.jpg"),
        &at("2.jpg"),
        "-o",
        &at("out.exr"),
        "--response",
        "linear",
        "--json",
    ]);
    let summary = json(&text);
    assert_eq!(summary["times"], serde_json::json!([2.0, 0.5, 0.125]));
    // The brightest level of the last is 1024 / 8 = 128.
    assert_eq!(summary["saturated_pixels"], 0);
    let image = load_image(at("out.exr"));
    for k in 0..8 {
        let truth = f64::from(8 << k) / 255.0;
        let error = f64::from(image.at(16 * k + 8, 8)[1]) / truth - 1.0;
        // Levels that are whole numbers come back whole from flat blocks.
        assert!(error.abs() < 1e-6, "patch {k}: {error}");
    }
}

#[test]
fn a_series_may_be_bracketed_by_time_f_stop_and_iso() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    // Two stops each: by the shutter, by the aperture, by the sensitivity.
    let shots = [([1, 2], (2, 400)), ([1, 2], (2, 100)), ([1, 2], (4, 100))];
    for (k, (time, lens)) in shots.into_iter().enumerate() {
        exif_shot(at(&format!("{k}.jpg")).as_ref(), time, Some(lens));
    }
    let names = ["0.jpg", "1.jpg", "2.jpg"].map(at);
    let out = at("out.exr");
    let words = ["map", "merge", &names[0], &names[1], &names[2], "-o", &out];
    let text = run_well(words.into_iter().chain(["--response", "linear", "--json"]));
    assert_eq!(
        json(&text)["times"],
        serde_json::json!([0.5, 0.125, 0.03125])
    );
    let image = load_image(&out);
    // Radiance by the exposure of the first: 4 times what its EXIF time alone would say.
    for k in 0..8 {
        let truth = 4.0 * f64::from(8 << k) / 255.0;
        let found = f64::from(image.at(16 * k + 8, 8)[1]);
        // What f/4 shows of the darkest patches is a fraction of a level; the longest exposure weighs most.
        let worst = if k < 3 { 0.05 } else { 0.01 };
        assert!(
            (found / truth - 1.0).abs() < worst,
            "patch {k}: {found} for {truth}"
        );
    }
    exif_jpeg(at("2.jpg").as_ref(), [1, 4]);
    let output = run(words);
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        line.contains("2.jpg") && line.contains("no FNumber") && line.trim().lines().count() == 1,
        "{line}"
    );
}

#[test]
fn sixteen_bits_merge_with_shifts_and_saturated_pixels_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let hash = |x: i64, y: i64| {
        let mut z = ((x as u64) << 20 ^ y as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (z >> 40) as f64 / (1 << 24) as f64
    };
    // Blocks of 8 pixels from 0.01 to 1, and a lamp of 100.
    let scene = |x: i64, y: i64| match (x, y) {
        (60..70, 40..50) => 100.0,
        _ => 100f64.powf(hash(x.div_euclid(8), y.div_euclid(8)) - 1.0),
    };
    let shifts = [[4, -3], [0, 0], [-7, 6]];
    for (k, ([dx, dy], time)) in shifts.iter().zip([1.0, 0.25, 0.0625]).enumerate() {
        let picture: ImageBuffer<Rgb<u16>, Vec<u16>> = ImageBuffer::from_fn(160, 120, |x, y| {
            let radiance = scene(i64::from(x) - dx, i64::from(y) - dy);
            Rgb([(65535.0 * (radiance * time).min(1.0)).round() as u16; 3])
        });
        picture
            .save(at(&format!("{k}.png")))
            .expect("it is written");
    }
    let merge = |more: &[&str]| {
        let [a, b, c, out] = ["0.png", "1.png", "2.png", "out.exr"].map(at);
        let common = [
            "map",
            "merge",
            &a,
            &b,
            &c,
            "-o",
            &out,
            "--times",
            "1,0.25,0.0625",
            "--response=linear",
        ];
        run_well([&common, more].concat())
    };
    let summary = json(&merge(&["--align", "--json"]));
    assert_eq!(summary["shifts"], serde_json::json!(shifts));
    assert_eq!(summary["saturated_pixels"], 100);
    let image = load_image(at("out.exr"));
    let confidence = confidence(at("out.exr").as_ref());
    for (index, pixel) in image.pixels.iter().enumerate() {
        let (x, y) = ((index % 160) as i64, (index / 160) as i64);
        let radiance = scene(x, y);
        let found = f64::from(pixel[0]);
        if radiance == 100.0 {
            assert_eq!((found, confidence[index]), (16.0, 0.0));
        } else {
            assert_eq!(confidence[index], 1.0, "({x}, {y})");
            // Half a step of 65535 at 0.01 / 16.
            assert!(
                (found / radiance - 1.0).abs() < 0.013,
                "({x}, {y}): {found} for {radiance}"
            );
        }
    }
    let text = merge(&["--align"]);
    assert!(
        text.contains("2.png: 0.0625 s, shifted by -7,6 pixels"),
        "{text}"
    );
    assert!(text.contains("100 of 19200 pixels are saturated"), "{text}");
}

#[test]
fn a_curve_found_from_a_series_develops_single_photographs() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    // A film that records the 1.6th root of exposure.
    let radiance = |x: u32, y: u32| 0.02 * 40f64.powf(f64::from(x + 64 * y) / 4096.0);
    let shoot = |name: &str, time: f64| {
        let level = |e: f64| (255.0 * e.min(1.0).powf(1.0 / 1.6)).round() as u8;
        let picture: ImageBuffer<Rgb<u8>, Vec<u8>> =
            ImageBuffer::from_fn(64, 64, |x, y| Rgb([level(radiance(x, y) * time); 3]));
        picture.save(at(name)).expect("it is written");
    };
    for (k, time) in [4.0, 1.0, 0.25].into_iter().enumerate() {
        shoot(&format!("{k}.png"), time);
    }
    let [a, b, c, out, film] = ["0.png", "1.png", "2.png", "out.exr", "film.txt"].map(at);
    let series = ["map", "merge", &a, &b, &c, "--times=4,1,0.25", "-o", &out];
    let text = run_well([&series[..], &["--save-response", &film]].concat());
    assert!(text.contains("film.txt"), "{text}");
    let found = load_image(&out);
    run_well([&series[..], &["--response", &film]].concat());
    let again = load_image(&out);
    for (a, b) in found.pixels.iter().zip(&again.pixels) {
        assert!((a[1] / b[1] - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
    // Six single photographs of one exposure.
    for face in FACES {
        shoot(&format!("six_{face}.png"), 1.0);
    }
    let six = [
        "map",
        "mosaic",
        &at("six.png"),
        "--gains=off",
        "--to=cube",
        "-o",
        &at("sky.exr"),
    ]
    .map(str::to_owned);
    let spread = |words: &[String]| {
        run_well(words);
        let image = load_image(at("sky_pz.exr"));
        let ratios: Vec<f64> = (0..4096_u32)
            .filter(|k| (8..56).contains(&(k % 64)))
            .map(|k| f64::from(image.pixels[k as usize][0]) / radiance(k % 64, k / 64))
            .collect();
        let [least, most] =
            [f64::min, f64::max].map(|of| ratios.iter().copied().reduce(of).expect("pixels"));
        most / least
    };
    let by_film = spread(&[&six[..], &["--response".to_owned(), film.clone()]].concat());
    // Half a level of 22, the darkest, is 3.6 % of its exposure, up or down.
    assert!(by_film < 1.09, "{by_film}");
    assert!(spread(&six) > 1.3);
    fs::write(&film, "0 0 0 0\n1 2 3\n").expect("a file");
    let output = run([&series[..], &["--response", &film]].concat());
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        line.contains("film.txt") && line.contains("line 2"),
        "{line}"
    );
}
