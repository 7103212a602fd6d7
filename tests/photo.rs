//! Photographs to maps, by the built program: mirrored balls and exposure brackets.

use crate::photo_series::exif_jpeg;
use crate::support::{exr_layer, files, load_image, run, run_well, save_image, scene};
use environment::{Image, Projection};
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
pub fn confidence(path: &Path) -> Vec<f32> {
    let mut channels = exr_layer(path).channel_data.list.into_iter();
    let found = channels.find(|c| c.name.to_string() == "confidence");
    found
        .expect("a channel")
        .sample_data
        .values_as_f32()
        .collect()
}

pub fn json(text: &str) -> Value {
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
    let words = "--eye 0,8,0 --look 0,0,0 --up 0,0,-1 --size 64x64 --samples 1 --rays 1 --model lambert \
        --albedo 0.3,0.2,0.1";
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
