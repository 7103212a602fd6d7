//! Pictures through a camera, by the built program.

use crate::support::{load_image, run, run_well, save_image, scene};
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use std::fs;
use std::path::Path;

/// A small picture of the courtyard into `name`, with more arguments.
fn courtyard(folder: &Path, name: &str, more: &[&str]) -> Vec<u8> {
    let path = folder.join(name);
    let mut arguments = vec![
        "render".to_owned(),
        scene("courtyard.obj").display().to_string(),
    ];
    arguments.extend(["-o".to_owned(), path.display().to_string()]);
    let common = "--eye 5.5,3.8,9.5 --look=-0.6,1.2,-2 --size 48x27 --samples 2 --quiet";
    arguments.extend(common.split(' ').map(str::to_owned));
    arguments.extend(more.iter().map(|word| (*word).to_owned()));
    run_well(arguments);
    fs::read(path).expect("the picture is there")
}

/// Pixels of a picture.
fn pixels(path: &Path) -> Vec<[f32; 3]> {
    load_image(path).pixels
}

#[test]
fn a_picture_has_the_same_bytes_at_any_thread_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = courtyard(folder.path(), "one.exr", &["--rays", "8", "--threads", "1"]);
    let two = courtyard(folder.path(), "two.exr", &["--rays", "8", "--threads", "2"]);
    assert!(one == two);
    let other = courtyard(folder.path(), "seed.exr", &["--rays", "8", "--seed", "1"]);
    assert!(one != other);
}

#[test]
fn a_picture_from_a_bake_agrees_with_the_integrated_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let bake = at("bake").display().to_string();
    run_well([
        "bake",
        &scene("courtyard.obj").display().to_string(),
        "-o",
        &bake,
        "--size",
        "512",
        "--rays",
        "64",
        "--quiet",
    ]);
    for model in ["traditional", "lambert"] {
        let [baked, integrated] = ["a.exr", "b.exr"].map(&at);
        let sun = ["--sun", "1,2,1,2", "--model", model];
        courtyard(
            folder.path(),
            "a.exr",
            &[&sun[..], &["--bake", &bake]].concat(),
        );
        courtyard(
            folder.path(),
            "b.exr",
            &[&sun[..], &["--rays", "64"]].concat(),
        );
        let (baked, integrated) = (pixels(&baked), pixels(&integrated));
        let sum = |pixels: &[[f32; 3]]| pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
        let square = |a: &[f32; 3], b: &[f32; 3]| f64::from(a[1] - b[1]).powi(2);
        let pairs = baked.iter().zip(&integrated);
        let rms = (pairs.map(|(a, b)| square(a, b)).sum::<f64>() / baked.len() as f64).sqrt();
        let ratio = sum(&baked) / sum(&integrated);
        // A texel of this bake is about a pixel wide, so contact shadows blur; light is neither lost nor made.
        assert!((ratio - 1.0).abs() < 0.005, "{model}: mean ratio {ratio}");
        assert!(rms < 0.03, "{model}: rms {rms}");
    }
}

#[test]
fn a_lambertian_moon_darkens_toward_its_rim_and_a_wall_does_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.exr");
    let shot_with = |name: &str, view: &str, common: &str| {
        let mut arguments = vec!["render".to_owned(), scene(name).display().to_string()];
        arguments.extend(["-o".to_owned(), path.display().to_string()]);
        let words = view.split(' ').chain(common.split(' '));
        arguments.extend(words.map(str::to_owned));
        run_well(arguments);
        pixels(&path)
    };
    let shot = |name: &str, view: &str| {
        shot_with(
            name,
            view,
            "--quiet --samples 1 --rays 0 --background 0,0,0",
        )
    };
    // Irradiance pi from the eye, 1000 radii away; the picture is 2.5 radii high.
    let fov = (2.0 * (1.25f64 / 1000.0).atan()).to_degrees();
    let light = "--size 101x101 --sun 0,0,1,3.141592653589793";
    let moon = shot(
        "ball.obj",
        &format!("--eye 0,0,1000 --fov-deg {fov} {light}"),
    );
    for (i, pixel) in moon.iter().enumerate() {
        let place = |k: usize| 2.5 * ((k as f64 + 0.5) / 101.0 - 0.5);
        let r = place(i % 101).hypot(place(i / 101));
        let found = f64::from(pixel[0]);
        if r < 0.95 {
            // Facets of 2.8 degrees move a point by 3e-4 of the radius, and at r = 0.95 the slope is 3.
            let exact = (1.0 - r * r).sqrt();
            assert!((found - exact).abs() < 3e-3, "r {r}: {found} for {exact}");
        } else if r > 1.01 {
            assert_eq!(found, 0.0, "r {r}");
        }
    }
    // Dust is as bright at the rim as in the middle; the facing ratio is Lambert's globe without a light.
    let dust = shot(
        "ball.obj",
        &format!("--model lommel-seeliger --eye 0,0,1000 --fov-deg {fov} {light}"),
    );
    let facing = shot(
        "ball.obj",
        &format!("--model facing-ratio --eye 0,0,1000 --fov-deg {fov} --size 101x101"),
    );
    for (i, pixel) in dust.iter().enumerate() {
        let place = |k: usize| 2.5 * ((k as f64 + 0.5) / 101.0 - 0.5);
        let r = place(i % 101).hypot(place(i / 101));
        // The eye is 1000 radii away, which turns its direction from the light's by r/1000.
        let exact = if r < 0.95 { 1.0 } else { 0.0 };
        if !(0.95..=1.01).contains(&r) {
            let found = f64::from(pixel[0]);
            assert!((found - exact).abs() < 2e-3, "r {r}: {found} for {exact}");
            let facing = f64::from(facing[i][0] - moon[i][0]);
            assert!(facing.abs() < 2e-3, "r {r}: {facing}");
        }
    }
    // A globe in front of an open sky of 1: the closed form at each angle, and in the mean closer than the noise of one
    // pixel.
    let grey = format!(
        "--model lommel-seeliger --albedo 0.1,0.1,0.1 --rays 256 --size 31x31 --eye 0,0,1000 --fov-deg {fov}"
    );
    let open = shot_with("ball.obj", &grey, "--quiet --samples 1 --background 0,0,0");
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, pixel) in open.iter().enumerate() {
        let place = |k: usize| 2.5 * ((k as f64 + 0.5) / 31.0 - 0.5);
        let r = place(i % 31).hypot(place(i / 31));
        if r < 0.9 {
            let exact = 0.1 * ambient::lunar::lommel_seeliger_open((1.0 - r * r).sqrt());
            let ratio = f64::from(pixel[0]) / exact;
            assert!((ratio - 1.0).abs() < 0.04, "r {r}: {ratio} of {exact}");
            sum += ratio;
            count += 1.0;
        }
    }
    assert!((sum / count - 1.0_f64).abs() < 0.005, "{}", sum / count);
    let light = "--look 0,0,0 --size 9x9 --sun 0,0.8660254037844386,0.5,3.141592653589793";
    for eye in ["0,0,5", "4,3,2", "-30,1,4"] {
        let wall = shot("wall_lit.obj", &format!("--eye={eye} {light} --fov-deg 10"));
        let same = |pixel: &[f32; 3]| pixel.iter().all(|v| (v - 0.5).abs() < 1e-6);
        assert!(wall.iter().all(same), "{eye}: {wall:?}");
    }
}

#[test]
fn a_scene_is_laid_over_a_plate_as_its_alpha_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let ball = scene("ball.obj").display().to_string();
    let view =
        "--quiet --size 31x21 --samples 4 --rays 4 --albedo 0.25,0.5,0.75 --eye 0,0,4 --look 0,0,0";
    let shot = |name: &str, more: &str| {
        let words = ["render", &ball, "-o", &at(name)];
        let more = view.split(' ').chain(more.split_whitespace());
        run_well(words.into_iter().chain(more));
        pixels(Path::new(&at(name)))
    };
    let object = shot("object.exr", "--alpha");
    let alpha: Vec<f32> = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(at("object.exr"))
        .expect("an EXR")
        .layer_data
        .channel_data
        .list
        .iter()
        .find(|channel| channel.name.to_string() == "A")
        .expect("a channel A")
        .sample_data
        .values_as_f32()
        .collect();
    assert!(alpha.contains(&1.0) && alpha.contains(&0.0));
    assert!(alpha.iter().any(|a| *a > 0.1 && *a < 0.9), "an edge");
    // A plate with a value of its own in each pixel.
    let plate = environment::Image {
        width: 31,
        height: 21,
        pixels: (0..31 * 21).map(|k| [k as f32 / 651.0, 0.5, 2.0]).collect(),
    };
    save_image(at("plate.exr"), &plate);
    let laid = shot("laid.exr", &format!("--backdrop {}", at("plate.exr")));
    for (k, found) in laid.iter().enumerate() {
        for c in 0..3 {
            let exact = object[k][c] + (1.0 - alpha[k]) * plate.pixels[k][c];
            assert!((found[c] - exact).abs() < 1e-6, "{k}: {found:?}");
        }
    }
    // The same by tables: D of a sky of 1, before the plate and with its alpha as a PNG.
    let sky = environment::Image::filled(8, 4, [1.0; 3]);
    save_image(at("sky.exr"), &sky);
    let tables = format!(
        "--maps {0},{0} --specular 0,0,0 --environment {0} --quiet --size 31x21 --samples 4 --albedo 0.25,0.5,0.75 \
         --eye 0,0,4 --look 0,0,0",
        at("sky.exr")
    );
    let frame = |name: &str, more: &str| {
        let words = ["render", &ball, "-o", &at(name)];
        run_well(
            words
                .into_iter()
                .chain(tables.split(' '))
                .chain(more.split_whitespace()),
        );
    };
    frame("tables.exr", &format!("--backdrop {}", at("plate.exr")));
    for (k, found) in pixels(Path::new(&at("tables.exr"))).iter().enumerate() {
        for (c, albedo) in [0.25, 0.5, 0.75].into_iter().enumerate() {
            let exact = alpha[k] * albedo + (1.0 - alpha[k]) * plate.pixels[k][c];
            assert!(
                (found[c] - exact).abs() < 2e-6,
                "{k}: {found:?} for {exact}"
            );
        }
    }
    frame("tables.png", "--alpha");
    let png = image::open(at("tables.png")).expect("a PNG").into_rgba8();
    for (k, pixel) in png.pixels().enumerate() {
        assert_eq!(pixel.0[3], (255.0 * alpha[k]).round() as u8, "{k}");
        // The colour is that of the object alone: 0.5 is 188 in sRGB.
        assert!(
            alpha[k] == 0.0 || pixel.0[1].abs_diff(188) <= 1,
            "{k}: {pixel:?}"
        );
    }
    let small = [
        "render",
        &ball,
        "-o",
        &at("x.exr"),
        "--size",
        "9x9",
        "--backdrop",
    ];
    let output = run(small.into_iter().chain([at("plate.exr").as_str()]));
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        line.contains("--size 31x21") && line.trim().lines().count() == 1,
        "{line}"
    );
}

#[test]
fn a_wrong_request_is_one_line_and_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let plane = scene("plane.obj").display().to_string();
    let cases: [(&[&str], i32, &str); 5] = [
        (&["-o", &path("x.jpg")], 1, ".exr or .png"),
        (
            &["-o", &path("x.png"), "--look", "1,1,1", "--eye", "1,1,1"],
            1,
            "--eye",
        ),
        (
            &["-o", &path("x.png"), "--bake", &path("none")],
            1,
            "plane.glb",
        ),
        (&["-o", &path("x.png"), "--size", "0x9"], 2, "16384"),
        (
            &["-o", &path("x.png"), "--sun", "0,0,0,1"],
            2,
            "no direction",
        ),
    ];
    for (more, status, word) in cases {
        let output = run([&["render", &plane][..], more].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{more:?}: {errors}");
        assert!(errors.contains(word), "{more:?}: {errors}");
        assert!(status == 2 || errors.lines().count() == 1, "{errors}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("it is there").count(), 0);
}
