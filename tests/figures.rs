//! The papers' figures and the notes on Lambertian surfaces, by the built program.

use crate::support::{files, model, run, run_well, scene};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

/// Fig. 3 of a scene in `DIR/NAME`, small, with more arguments.
fn fig3(scene: &Path, folder: &Path, name: &str, more: &str) -> std::path::PathBuf {
    let output = folder.join(name);
    let mut arguments = vec!["render".to_owned(), scene.display().to_string()];
    arguments.extend(["-o".to_owned(), output.display().to_string()]);
    let common = "--figure fig3 --size 64x36 --samples 2";
    arguments.extend(common.split(' ').chain(more.split(' ')).map(str::to_owned));
    run_well(arguments);
    output
}

/// Pixels of a picture.
fn pixels(path: &Path) -> Vec<[f32; 3]> {
    environment::read_unchecked(path)
        .expect("an EXR")
        .image
        .pixels
}

/// Mean of the green pixels that keep a rule, and its standard error.
fn mean(pixels: &[[f32; 3]]) -> (f64, f64) {
    let count = pixels.len() as f64;
    let mean = pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / count;
    let square: f64 = pixels
        .iter()
        .map(|p| (f64::from(p[1]) - mean).powi(2))
        .sum();
    (mean, (square / (count - 1.0) / count).sqrt())
}

#[test]
fn fig3_holds_five_models_and_their_signed_differences() {
    let folder = tempfile::tempdir().expect("a folder");
    let view = "--eye=-60,23,-68 --look=-2,3,-2 --fov-deg 30 --rays 8";
    let airliner = scene("airliner.obj");
    let one = fig3(
        &airliner,
        folder.path(),
        "one",
        &format!("{view} --threads 1"),
    );
    let two = fig3(
        &airliner,
        folder.path(),
        "two",
        &format!("{view} --threads 2"),
    );
    let names = files(&one);
    assert_eq!(names.len(), 19, "{names:?}");
    for name in &names {
        let same = fs::read(one.join(name)).ok() == fs::read(two.join(name)).ok();
        assert!(same, "{name} depends on the threads");
    }
    let picture = |name: &str| pixels(&one.join(format!("fig3_{name}.exr")));
    let [a, b, c] = ["traditional", "lambert", "phong"].map(picture);
    let [ba, cb] = ["lambert-traditional", "phong-lambert"].map(picture);
    for at in 0..a.len() {
        for k in 0..3 {
            assert_eq!(ba[at][k], b[at][k] - a[at][k]);
            assert_eq!(cb[at][k], c[at][k] - b[at][k]);
            assert!(cb[at][k] >= 0.0, "the specular term is {}", cb[at][k]);
        }
    }
    // Under the body it is darker than the traditional model says, on top of it brighter.
    let range = ba
        .iter()
        .map(|p| p[1])
        .fold((0.0f32, 0.0f32), |(low, high), v| (low.min(v), high.max(v)));
    assert!(range.0 < -0.05 && range.1 > 0.05, "{range:?}");
    let table = fs::read_to_string(one.join("fig3.csv")).expect("a table");
    assert_eq!(table.lines().count(), 10, "{table}");
}

#[test]
fn fig3_of_a_groove_shows_the_known_difference_of_the_models() {
    let folder = tempfile::tempdir().expect("a folder");
    // From within, so that a face fills the picture.
    let view = "--eye 2,2,0 --look 2,0,0.01 --fov-deg 30 --rays 64";
    let output = fig3(&scene("groove_60.obj"), folder.path(), "groove", view);
    for (name, exact) in [
        ("traditional", 1.0 / 3.0),
        ("lambert", 0.25),
        ("lambert-traditional", 0.25 - 1.0 / 3.0),
    ] {
        let (value, error) = mean(&pixels(&output.join(format!("fig3_{name}.exr"))));
        println!("{name}: {value} ± {error} for {exact}");
        // The groove ends after 4096 units.
        assert!(
            (value - exact).abs() < 5.0 * error + 4e-4,
            "{name}: {value} ± {error}"
        );
    }
    let specular = pixels(&output.join("fig3_phong-lambert.exr"));
    assert!(specular.iter().all(|pixel| *pixel == [0.0; 3]));
}

#[test]
fn fig3_frames_a_real_airliner() {
    let Some(boeing) = model("boeing_787/scene.gltf") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let output = fig3(
        &boeing,
        folder.path(),
        "boeing",
        "--rays 1 --background 0,0,0",
    );
    let lit: Vec<_> = pixels(&output.join("fig3_phong.exr"))
        .into_iter()
        .enumerate()
        .filter(|(_, pixel)| pixel[0] > 0.0)
        .map(|(at, _)| (at % 64, at / 64))
        .collect();
    let inside = |&(x, y): &(usize, usize)| (1..63).contains(&x) && (1..35).contains(&y);
    assert!(lit.iter().all(inside));
    assert!(lit.len() > 64 * 36 / 10, "{} pixels", lit.len());
}

#[test]
fn an_unknown_figure_and_two_directories_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let plane = scene("plane.obj").display().to_string();
    let to = folder.path().join("x").display().to_string();
    let refused = |more: &[&str], status: i32, word: &str| {
        let output = run([&["render", &plane, "-o", &to], more].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{errors}");
        assert!(errors.contains(word), "{errors}");
    };
    refused(&["--figure", "fig2"], 2, "fig3");
    refused(&["--figure", "fig3", "-o", "y"], 1, "one -o DIR");
    assert!(files(folder.path()).is_empty());
}

/// A folder with a luminous square of radiance 3, side 1, in the plane z = 0.
fn plate() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let square = "v -0.5 -0.5 0\nv 0.5 -0.5 0\nv 0.5 0.5 0\nv -0.5 0.5 0\nf 1 2 3 4\n";
    let text = format!("mtllib plate.mtl\nusemtl lamp\n{square}");
    fs::write(folder.path().join("plate.obj"), text).expect("written");
    fs::write(folder.path().join("plate.mtl"), "newmtl lamp\nKe 3 3 3\n").expect("written");
    folder
}

/// A picture of the plate from `distance` away, `angle` off its normal, `side` pixels square, a field of view of 1/40
/// sr and less.
fn plate_from(folder: &Path, distance: f64, angle: f64, fov: f64, side: usize) -> Vec<[f32; 3]> {
    let at = |name: &str| folder.join(name).display().to_string();
    let eye = format!("{},0,{}", distance * angle.sin(), distance * angle.cos());
    let (size, degrees) = (format!("{side}x{side}"), fov.to_degrees().to_string());
    let (input, output) = (at("plate.obj"), at("x.exr"));
    let words = [
        "render", &input, "-o", &output, "--eye", &eye, "--look", "0,0,0",
    ];
    let more = [
        "--size",
        &size,
        "--fov-deg",
        &degrees,
        "--samples",
        "1",
        "--rays",
        "0",
    ];
    let dark = ["--sky", "0,0,0", "--quiet"];
    run_well(words.into_iter().chain(more).chain(dark));
    pixels(Path::new(&output))
}

#[test]
fn a_lambertian_plate_is_as_bright_from_every_side_and_its_picture_shrinks_by_the_cosine() {
    let folder = plate();
    let (distance, side) = (1000.0, 400);
    // The picture is 1.25 units high at the plate.
    let fov = 2.0 * f64::atan(0.625 / distance);
    let pixel = 1.25 / side as f64;
    for degrees in [0.0, 20.0, 45.0, 60.0, 75.0, 85.0] {
        let angle = f64::to_radians(degrees);
        let picture = plate_from(folder.path(), distance, angle, fov, side);
        let lit = picture.iter().filter(|p| **p == [3.0; 3]).count();
        let dark = picture.iter().filter(|p| **p == [0.0; 3]).count();
        assert_eq!(lit + dark, side * side, "one radiance, {degrees} degrees");
        // Foreshortened in one direction; each of four sides is known to half a pixel, and from near it looks larger by
        // at most half its depth over the distance.
        let area = lit as f64 * pixel * pixel;
        let exact = angle.cos();
        let bound = pixel * (1.0 + angle.cos()) + 1.0 / distance;
        println!("{degrees}: {area} for {exact}");
        assert!(
            (area - exact).abs() <= bound,
            "{degrees}: {area} for {exact}"
        );
    }
}

#[test]
fn the_flux_of_a_lambertian_patch_through_a_detector_follows_the_cosine() {
    let folder = plate();
    let (distance, side) = (100.0, 200);
    let fov = 2.0 * f64::atan(0.625 / distance);
    let slope = (0.5 * fov).tan();
    for degrees in [0.0, 30.0, 60.0, 80.0] {
        let angle = f64::to_radians(degrees);
        let picture = plate_from(folder.path(), distance, angle, fov, side);
        // Irradiance of a detector that faces the patch: radiance times projected solid angle of each pixel.
        let cell = (2.0 * slope / side as f64).powi(2);
        let irradiance: f64 = (0..side * side)
            .map(|at| {
                let place = |k: usize| (2.0 * (k as f64 + 0.5) / side as f64 - 1.0) * slope;
                let square = place(at % side).powi(2) + place(at / side).powi(2);
                f64::from(picture[at][0]) * cell / (1.0 + square).powi(2)
            })
            .sum();
        // Per steradian that the detector fills: L A cos.
        let found = irradiance * distance * distance;
        println!("{degrees}: {found} for {}", 3.0 * angle.cos());
        let rim = 1.25 / side as f64 * (1.0 + angle.cos()) + 1.0 / distance;
        assert!(
            (found - 3.0 * angle.cos()).abs() <= 3.0 * rim,
            "{degrees}: {found}"
        );
    }
}

#[test]
fn a_lambertian_full_moon_is_two_thirds_of_a_flat_disc() {
    // Lit from the eye with irradiance pi, the globe is as bright as a white disc in its middle alone: sqrt(1 - r^2).
    // The full moon sends about as much from its rim as from its middle, so it looks like the flat disc, and 1 would
    // stand below in place of 2/3.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("moon.exr");
    let (ball, output) = (scene("ball.obj"), path.display().to_string());
    let fov = (2.0 * (1.25f64 / 1000.0).atan()).to_degrees().to_string();
    let words = [
        "render",
        &ball.display().to_string(),
        "-o",
        &output,
        "--fov-deg",
        &fov,
    ];
    let light = format!("--sun 0,0,1,{PI} --rays 0 --background 0,0,0 --quiet");
    let view = "--eye 0,0,1000 --size 401x401 --samples 2";
    run_well(
        words
            .into_iter()
            .chain(light.split(' '))
            .chain(view.split(' ')),
    );
    let moon = pixels(&path);
    let pixel = 2.5 / 401.0;
    let whole: f64 = moon.iter().map(|p| f64::from(p[0])).sum();
    let ratio = whole * pixel * pixel / PI / f64::from(moon[200 * 401 + 200][0]);
    println!("mean over the disc / middle = {ratio}");
    // Facets take 4e-4 of the area; at the rim half a sample of radiance sqrt(pixel) may be missed.
    let bound = 4e-4 + 0.5 * pixel * pixel.sqrt();
    assert!((ratio - 2.0 / 3.0).abs() < bound, "{ratio}");
}
