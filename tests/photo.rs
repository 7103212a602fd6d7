//! Photographs to maps, by the built program: mirrored balls and exposure brackets.

use crate::support::{exr_layer, files, load_image, run, run_well, save_image, scene};
use environment::{FACES, Image, Projection};
use image::{ImageBuffer, Rgb};
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

type Direction = [f64; 3];

/// Surroundings with a bright lamp: smooth, of known value in every direction.
fn sky([x, y, z]: Direction) -> [f32; 3] {
    let lamp = 50.0 * (20.0 * (0.6 * x + 0.8 * y - 1.0)).exp();
    [1.0 + 0.5 * x, 1.5 + y * z, 1.0 + 0.7 * z].map(|v| (v + lamp) as f32)
}

fn dot(a: Direction, b: Direction) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

/// Right, up and toward the camera, for a camera in the direction `toward`.
fn frame([x, y, z]: Direction) -> [Direction; 3] {
    let flat = x.hypot(z);
    [
        [z / flat, 0.0, -x / flat],
        [-x * y / flat, flat, -y * z / flat],
        [x, y, z],
    ]
}

/// A photograph of a mirrored ball of reflectance 0.5, 0.6, 0.7 at (`middle`, radius), seen from `toward` at `d` radii,
/// in front of gray.
fn photograph(d: f64, toward: Direction, circle: [f64; 3], side: usize) -> Image {
    const PARTS: usize = 4;
    let frame = frame(toward);
    let tangent = (d * d - 1.0).sqrt();
    let shown = |x: f64, y: f64| {
        let (right, up) = ((x - circle[0]) / circle[2], (circle[1] - y) / circle[2]);
        // The ray from (0, 0, d) through a picture in which the outline has radius 1.
        let ray = [right / tangent, up / tangent, -1.0];
        let length = dot(ray, ray).sqrt();
        let ray = ray.map(|v| v / length);
        let half = d * ray[2];
        let rest = half * half - d * d + 1.0;
        if rest < 0.0 {
            return [0.2; 3];
        }
        let s = -half - rest.sqrt();
        let normal = [s * ray[0], s * ray[1], d + s * ray[2]];
        let off = 2.0 * dot(normal, ray);
        let mirror: Direction = std::array::from_fn(|c| ray[c] - off * normal[c]);
        let world = std::array::from_fn(|c| (0..3).map(|k| mirror[k] * frame[k][c]).sum());
        let [r, g, b] = sky(world);
        [0.5 * r, 0.6 * g, 0.7 * b]
    };
    let mut image = Image::filled(side, side, [0.0; 3]);
    for (index, pixel) in image.pixels.iter_mut().enumerate() {
        for part in 0..PARTS * PARTS {
            let place = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / PARTS as f64;
            let color = shown(
                place(index % side, part % PARTS),
                place(index / side, part / PARTS),
            );
            *pixel = std::array::from_fn(|c| pixel[c] + color[c] / (PARTS * PARTS) as f32);
        }
    }
    image
}

/// The mean of `sky` over the solid angle of a texel.
fn mean(projection: Projection, size: (usize, usize), texel: usize) -> [f64; 3] {
    const PARTS: usize = 8;
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for part in 0..PARTS * PARTS {
        let place = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / PARTS as f64;
        let x = place(texel % size.0, part % PARTS);
        let y = place(texel / size.0, part / PARTS);
        let weight = projection.density(size, x, y);
        let value = sky(projection.direction(size, x, y).expect("a direction"));
        weights += weight;
        sum = std::array::from_fn(|c| sum[c] + weight * f64::from(value[c]));
    }
    sum.map(|v| v / weights)
}

fn save(path: &Path, image: &Image) {
    save_image(path, image);
}

/// The channel `confidence` of a file.
fn confidence(path: &Path) -> Vec<f32> {
    let mut channels = exr_layer(path).channel_data.list.into_iter();
    let found = channels.find(|c| c.name.to_string() == "confidence");
    found
        .expect("a channel")
        .sample_data
        .values_as_f32()
        .collect()
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_ball_comes_back_as_its_surroundings_but_for_the_blind_cone() {
    let folder = tempfile::tempdir().expect("a folder");
    let (photo, out) = (
        folder.path().join("ball.exr"),
        folder.path().join("map.exr"),
    );
    for (d, blind) in [(4.0f64, 14.4775), (20.0, 2.8660)] {
        let toward = [0.6, 0.0, 0.8];
        save(&photo, &photograph(d, toward, [310.4, 290.7, 251.3], 600));
        let distance = d.to_string();
        let text = run_well([
            "map".as_ref(),
            "ball".as_ref(),
            photo.as_os_str(),
            "-o".as_ref(),
            out.as_os_str(),
            "--distance".as_ref(),
            distance.as_ref(),
            "--toward=0.6,0,0.8".as_ref(),
            "--reflectance=0.5,0.6,0.7".as_ref(),
            "--size=256x128".as_ref(),
            "--json".as_ref(),
        ]);
        let summary = json(&text);
        let ball = &summary["balls"][0];
        let found: Vec<f64> = (0..3)
            .map(|k| ball["circle"][k].as_f64().expect("it is found"))
            .collect();
        println!("d = {d}: {ball}");
        for (found, truth) in found.iter().zip([310.4, 290.7, 251.3]) {
            assert!((found - truth).abs() < 0.2, "{found} for {truth}");
        }
        let angle = ball["blind_half_angle_deg"].as_f64().expect("a number");
        assert!((angle - blind).abs() < 1e-3, "{angle}");
        let image = load_image(&out);
        let confidence = confidence(&out);
        let (mut worst, mut masked) = (0.0f64, 0);
        for (index, pixel) in image.pixels.iter().enumerate() {
            let place = ((index % 256) as f64 + 0.5, (index / 256) as f64 + 0.5);
            let direction = Projection::Polar
                .direction((256, 128), place.0, place.1)
                .expect("a direction");
            let from_camera = dot(direction, toward).clamp(-1.0, 1.0).acos();
            // A texel's diagonal is 2 degrees; only whole texels are masked.
            let beyond = (from_camera - (PI - blind.to_radians())).to_degrees();
            if confidence[index] == 0.0 {
                masked += 1;
                assert!(beyond > -1.0, "texel {index} is masked at {beyond}");
            }
            assert!(
                beyond < 1.0 || confidence[index] == 0.0,
                "texel {index} at {beyond}"
            );
            // The outermost pixels, mixed with the background, are replaced by their neighbours.
            if beyond < -20.0 {
                let truth = mean(Projection::Polar, (256, 128), index);
                let error = |c: usize| (f64::from(pixel[c]) / truth[c] - 1.0).abs();
                worst = worst.max((0..3).map(error).fold(0.0, f64::max));
            }
        }
        println!("d = {d}: worst texel {worst:.4}, {masked} masked");
        assert_eq!(summary["masked_texels"], masked);
        assert!(masked > 0);
        // Bends of the lamp between pixels of the photograph.
        assert!(worst < 0.01, "d = {d}: {worst}");
    }
}

#[test]
fn two_balls_a_quarter_turn_apart_leave_no_direction_unseen() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let circle = [200.0, 200.0, 180.0];
    save(
        at("a.exr").as_ref(),
        &photograph(6.0, [1.0, 0.0, 0.0], circle, 400),
    );
    save(
        at("b.exr").as_ref(),
        &photograph(6.0, [0.0, 0.0, 1.0], circle, 400),
    );
    let text = run_well([
        "map",
        "ball",
        &at("a.exr"),
        &at("b.exr"),
        "-o",
        &at("cube.exr"),
        "--to",
        "cube",
        "--size",
        "64x64",
        "--circle=200,200,180",
        "--circle=200,200,180",
        "--toward=1,0,0",
        "--toward=0,0,1",
        "--distance=6",
        "--reflectance=0.5,0.6,0.7",
        "--json",
    ]);
    let summary = json(&text);
    assert_eq!(summary["masked_texels"], 0);
    assert_eq!(summary["files"].as_array().map(Vec::len), Some(6));
    let mut worst = 0.0f64;
    for (face, name) in ["px", "nx", "py", "ny", "pz", "nz"].into_iter().enumerate() {
        let path = at(&format!("cube_{name}.exr"));
        assert!(confidence(path.as_ref()).iter().all(|c| *c > 0.0));
        let image = load_image(&path);
        for (index, pixel) in image.pixels.iter().enumerate() {
            let truth = mean(Projection::Cube, (64, 384), face * 64 * 64 + index);
            let error = |c: usize| (f64::from(pixel[c]) / truth[c] - 1.0).abs();
            worst = worst.max((0..3).map(error).fold(0.0, f64::max));
        }
    }
    println!("worst texel {worst:.4}");
    assert!(worst < 0.01, "{worst}");
}

/// A photograph of patches of 16 pixels, of radiance 8, 16, … 1024 by columns, with a time in its EXIF block.
fn exif_jpeg(path: &Path, time: [u32; 2]) {
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

#[test]
fn unusable_photographs_are_one_line_and_leave_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let gray = |width: u32, name: &str| {
        let picture: ImageBuffer<Rgb<u8>, Vec<u8>> =
            ImageBuffer::from_fn(width, 30, |x, y| Rgb([(9 * x + y) as u8; 3]));
        picture.save(at(name)).expect("it is written");
    };
    exif_jpeg(at("timeless.jpg").as_ref(), [1, 0]);
    gray(40, "a.png");
    gray(40, "b.png");
    gray(50, "wide.png");
    fs::write(at("text.png"), "no picture").expect("it is written");
    save(at("plain.exr").as_ref(), &Image::filled(64, 64, [1.0; 3]));
    let before = files(folder.path());
    let [a, b, wide, text, plain, out] = [
        "a.png",
        "b.png",
        "wide.png",
        "text.png",
        "plain.exr",
        "out.exr",
    ]
    .map(at);
    let merge = |more: &[&str]| {
        [&["map", "merge", "-o", &out, "--response=linear", &a], more]
            .concat()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    let ball = |more: &[&str]| {
        [&["map", "ball", "-o", &out], more]
            .concat()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    let pair = at("timeless.jpg");
    let timeless = ["map", "merge", "-o", &out, &pair, &pair].map(str::to_owned);
    let cases = [
        (
            merge(&[&wide, "--times=1,2"]),
            "bracket 2 is 50 x 30 pixels",
        ),
        (merge(&[&b]), "has no EXIF exposure time; give the times"),
        (merge(&[&b, "--times=1,0"]), "bracket 2 has a time of 0 s"),
        (merge(&[&b, "--times=-1,2"]), "bracket 1 has a time of -1 s"),
        (
            merge(&[&b, "--times=2,2"]),
            "two brackets have the time 2 s",
        ),
        (merge(&[&b, "--times=1,2,3"]), "--times has 3 values for 2"),
        (
            timeless.to_vec(),
            "bracket 1 has a time of inf s; give one above 0 by --times",
        ),
        (merge(&["--times=1"]), "one photograph is no series"),
        (merge(&[&text, "--times=1,2"]), "text.png"),
        (merge(&[&at("none.png"), "--times=1,2"]), "none.png"),
        (
            ball(&[&plain, "--circle=32,32,40"]),
            "leaves its 64 x 64 pixels",
        ),
        (ball(&[&plain, "--circle=32,32,0"]), "correct --circle"),
        (
            ball(&[&plain, "--circle=32,32,30", "--distance=1"]),
            "give a --distance above 1",
        ),
        (
            ball(&[&plain, "--circle=32,32,30", "--distance=-3"]),
            "give a --distance above 1",
        ),
        (
            ball(&[&plain, "--circle=32,32,30", "--toward=0,1,0"]),
            "not straight up or down",
        ),
        (
            ball(&[&plain, "--circle=32,32,30", "--reflectance=0"]),
            "give values above 0",
        ),
        (ball(&[&plain]), "no ball is found"),
        (ball(&[&plain, &plain]), "--toward for each"),
        (ball(&[&text]), "text.png"),
    ];
    for (arguments, words) in cases {
        let output = run(&arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
        assert!(errors.contains(words), "{arguments:?}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
    }
    assert_eq!(files(folder.path()), before);
}

#[test]
fn a_scene_is_laid_over_a_photograph_in_the_tones_of_its_film() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    // A film that records the 1.6th root of exposure, and a photograph of every level.
    let exposure = |level: u32| (f64::from(level) / 255.0).powf(1.6);
    let lines = (0..256).map(|k| format!("{k} {0:e} {0:e} {0:e}\n", exposure(k)));
    fs::write(at("film.txt"), lines.collect::<String>()).expect("a file");
    let level = |x: u32, y: u32| ((x + 64 * y) % 256) as u8;
    let plate: ImageBuffer<Rgb<u8>, Vec<u8>> =
        ImageBuffer::from_fn(64, 64, |x, y| Rgb([level(x, y), 255 - level(x, y), 128]));
    plate.save(at("plate.png")).expect("it is written");
    // An open plane under a white sky has the radiance of its albedo in all of its pixels.
    let plane = scene("plane.obj").display().to_string();
    let [film, plate_file, out] = ["film.txt", "plate.png", "out.png"].map(at);
    let words = "--eye 0,8,0 --look 0,0,0 --up 0,0,-1 --size 64x64 --samples 1 --rays 1 --model lambert --albedo 0.3,0.2,0.1";
    let asked = ["render", &plane, "-o", &out, "--backdrop", &plate_file];
    let asked: Vec<&str> = asked.into_iter().chain(words.split(' ')).collect();
    run_well([&asked[..], &["--response", &film]].concat());
    let picture = image::open(&out).expect("a picture").to_rgb8();
    // The level nearest to an exposure.
    let recorded = |e: f64| (255.0 * e.powf(1.0 / 1.6)).round() as u8;
    let own = [0.3, 0.2, 0.1].map(recorded);
    let (mut behind, mut before) = (0, 0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let of_plate = pixel == plate.get_pixel(x, y);
        // Between levels the curve is linear: a level up or down.
        let of_plane = (0..3).all(|c| pixel[c].abs_diff(own[c]) <= 1);
        assert!(of_plate || of_plane, "{x}, {y}: {pixel:?} for {own:?}");
        behind += u32::from(of_plate);
        before += u32::from(of_plane);
    }
    assert!(behind > 1000 && before > 500, "{behind} {before}");
    let output = run([&asked[..], &["--response", &at("none.txt")]].concat());
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && line.contains("none.txt"),
        "{line}"
    );
}
