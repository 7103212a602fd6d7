//! `ambake fit`: coefficients of a material from pictures that the program rendered of it.

use crate::support::{run, run_well, scene};
use serde_json::Value;
use std::path::Path;

const EYES: [&str; 2] = ["4,3,4", "-3,1.2,5"];

/// Two small pictures of a ball on a plane, of one material.
fn pictures(folder: &Path, material: &[&str]) -> Vec<String> {
    let scene = scene("resting_sphere.obj").display().to_string();
    let render = |(number, eye): (usize, &&str)| {
        let path = folder
            .join(format!("view {number}.exr"))
            .display()
            .to_string();
        let own = [
            "render", &scene, "-o", &path, "--eye", eye, "--look", "0,0.6,0", "--size", "24x18",
        ];
        let how = ["--samples", "1", "--rays", "256", "--seed", "9", "--quiet"];
        run_well([&own[..], &how, material].concat());
        path
    };
    EYES.iter().enumerate().map(render).collect()
}

fn fitted(images: &[String], more: &[&str]) -> Value {
    let scene = scene("resting_sphere.obj").display().to_string();
    let mut words = vec![
        "fit",
        &scene,
        "--eye",
        EYES[0],
        "--eye",
        EYES[1],
        "--look",
        "0,0.6,0",
        "--samples",
        "1",
        "--rays",
        "512",
        "--json",
    ];
    words.extend(more);
    words.extend(images.iter().map(String::as_str));
    serde_json::from_str(&run_well(words)).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn coefficients_come_back_within_what_is_stated() {
    let folder = tempfile::tempdir().expect("a folder");
    let images = pictures(
        folder.path(),
        &[
            "--albedo",
            "0.5,0.3,0.1",
            "--specular",
            "0.3,0.3,0.4",
            "--exponent",
            "12",
        ],
    );
    let fit = fitted(&images, &[]);
    let close = |name: &str, at: Option<usize>, exact: f64, most: f64| {
        let of = |value: &Value| at.map_or_else(|| number(value), |at| number(&value[at]));
        let (found, interval) = (of(&fit[name]), of(&fit[&format!("{name}_interval")]));
        // Twice the interval of 95 of 100: what one of seven misses by chance, and noise of the fit's own rays.
        assert!(
            (found - exact).abs() < 2.0 * interval + 1e-6,
            "{name} {at:?}: {found} ± {interval}, not {exact}"
        );
        assert!(interval < most, "{name}: {interval} says little");
    };
    for (channel, (albedo, specular)) in
        [(0.5, 0.3), (0.3, 0.3), (0.1, 0.4)].into_iter().enumerate()
    {
        close("albedo", Some(channel), albedo, 0.05);
        close("specular", Some(channel), specular, 0.05);
    }
    close("exponent", None, 12.0, 6.0);
    let k_d = number(&fit["kd"][0]) * std::f64::consts::PI;
    assert!((k_d - number(&fit["albedo"][0])).abs() < 1e-12);

    // A brighter exposure of the same changes nothing; pixels that are twice as bright are twice the reflectance.
    let doubled = fitted(&images, &["--exposure", "0.5"]);
    assert!((number(&doubled["albedo"][0]) - 2.0 * number(&fit["albedo"][0])).abs() < 1e-9);
}

#[test]
fn matte_surfaces_have_no_exponent() {
    let folder = tempfile::tempdir().expect("a folder");
    let images = pictures(
        folder.path(),
        &["--albedo", "0.6,0.4,0.2", "--specular", "0,0,0"],
    );
    let fit = fitted(&images, &[]);
    assert!((number(&fit["albedo"][0]) - 0.6).abs() < 0.02, "{fit}");
    assert!(number(&fit["specular"][0]) < 0.02, "{fit}");
}

#[test]
fn what_cannot_be_fitted_is_said_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let images = pictures(folder.path(), &[]);
    let scene = scene("resting_sphere.obj").display().to_string();
    let away = [
        "fit", &scene, &images[0], "--eye", "0,50,0", "--look", "0,100,0", "--up", "1,0,0",
    ];
    let three = [
        "fit", &scene, &images[0], "--eye", "1,1,1", "--eye", "2,2,2",
    ];
    let absent = ["fit", &scene, "absent.exr"];
    for (words, told) in [
        (&away[..], "fewer than 16 pixels show the shape"),
        (&three[..], "--eye is given 2 times for 1 pictures"),
        (&absent[..], "absent.exr"),
    ] {
        let output = run(words);
        let line = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(
            line.contains(told) && line.trim().lines().count() == 1,
            "{line}"
        );
    }
}
