//! Illumination maps of scenes, by the built program.

use crate::support::{backends, load_image, run, run_well, scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Captures the scene of a lamp and a screen into `name`, with more arguments.
fn capture(folder: &Path, name: &str, more: &str) -> Vec<u8> {
    let input = scene("lamp.obj").display().to_string();
    let output = folder.join(name).display().to_string();
    let words = ["map", "capture", &input, "-o", &output, "--quiet"];
    run_well(words.into_iter().chain(more.split_whitespace()));
    fs::read(output).unwrap_or_default()
}

#[test]
fn the_diffuse_map_of_a_captured_lamp_is_its_form_factor() {
    for backend in backends() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name).display().to_string();
        let arguments = format!("--at 0,0,0 --sky 0,0,0 --face 64 --backend {backend}");
        capture(folder.path(), "i.exr", &format!("{arguments} --to strip"));
        capture(folder.path(), "p.exr", &arguments);
        // A unit square at distance 1 on the axis. The strip holds it in whole texels; in the polar map its sides of
        // four lengths may each be off by half a cell, 1/6 of a texel.
        let root = 1.25f64.sqrt();
        let factor = 4.0 / std::f64::consts::PI * 0.5 / root * (0.5 / root).atan();
        for (map, bound) in [
            ("i.exr", 1e-6),
            ("p.exr", 4.0 / 6.0 * std::f64::consts::TAU / 256.0),
        ] {
            let (input, output) = (at(map), at("d.exr"));
            let request = "--to strip --size 6x1 --quiet";
            let words = ["map", "diffuse", &input, "-o", &output];
            run_well(words.into_iter().chain(request.split(' ')));
            let d = load_image(&output);
            for (channel, radiance) in [2.0, 3.0, 5.0].into_iter().enumerate() {
                // The face +y, its middle.
                let ratio = f64::from(d.pixels[2][channel]) / radiance / factor;
                println!("{backend} {map}: D / exact = {ratio}");
                assert!((ratio - 1.0).abs() < bound, "{backend} {map}: {ratio}");
            }
            assert_eq!(d.pixels[3], [0.0; 3], "{backend} {map}");
        }
    }
}

#[test]
fn a_capture_has_the_same_bytes_at_any_thread_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let take = |name: &str, more: &str| {
        let arguments = "--at 0.1,0.2,0.3 --face 16 --point 1,0.2,3,4";
        capture(folder.path(), name, &format!("{arguments} {more}"))
    };
    let one = take("1.exr", "--threads 1");
    assert!(!one.is_empty());
    assert!(one == take("2.exr", "--threads 2"));
    assert!(one == take("7.exr", "--threads 7"));
}

#[test]
fn a_point_light_adds_the_same_energy_to_any_map_and_none_from_behind_a_screen() {
    let folder = tempfile::tempdir().expect("a folder");
    let integral = |more: &str| {
        capture(folder.path(), "i.exr", more);
        let path = folder.path().join("i.exr").display().to_string();
        let text = run_well(["map", "stats", &path, "--json"]);
        let json: Value = serde_json::from_str(&text).expect("JSON");
        json["integral"][1].as_f64().expect("a number")
    };
    let dark = "--at 6,-1.5,0 --sky 0,0,0 --hide lamp";
    for size in ["36x18", "256x128"] {
        let lit = format!("{dark} --size {size} --point 6,-3.5,0,8");
        assert!((integral(&lit) - 2.0).abs() < 1e-5, "{size}");
        let hidden = format!("{dark} --size {size} --point 6,1.5,0,8");
        assert_eq!(integral(&hidden), 0.0, "{size}");
        let raw = format!("{lit} --point-source raw");
        assert!(integral(&raw) < 0.2, "{size}");
    }
}

#[test]
fn a_wrong_capture_is_one_line_and_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let plane = scene("plane.obj").display().to_string();
    let output = folder.path().join("i.exr").display().to_string();
    for (more, status, word) in [
        ("--at 0,nan,0", 2, "finite"),
        ("--at 0,0", 2, "three numbers"),
        ("--at 0,1,0 --point 0,2,0,-1", 2, "0 or above"),
        ("--at 0,1,0 --face 4 --point 0,1,0,1", 1, "captured"),
        ("--at 0,1,0 --hide moon", 1, "no object `moon`"),
        ("--at 0,1,0 --size 30x20", 1, "twice as wide"),
        ("--at 0,1,0 -o i.png", 1, ".hdr"),
    ] {
        let words = ["map", "capture", &plane];
        let own = ["-o", &output];
        let own = if more.contains("-o ") {
            &own[..0]
        } else {
            &own
        };
        let output = run(words.iter().chain(own).copied().chain(more.split(' ')));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{more}: {errors}");
        assert!(errors.contains(word), "{more}: {errors}");
        assert!(status == 2 || errors.lines().count() == 1, "{errors}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("it is there").count(), 0);
    // Under a black sky without lamps the map is black, which is worth a word.
    let words = ["map", "capture", &plane, "-o", &output, "--face", "4"];
    let words = words
        .into_iter()
        .chain(["--at", "0,-1,0", "--sky", "0,0,0"]);
    let warned = run(words);
    assert_eq!(warned.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&warned.stderr).contains("warning: nothing shines"));
    let map = load_image(&output);
    assert!(map.pixels.iter().all(|pixel| *pixel == [0.0; 3]));
}

#[test]
fn a_lamp_of_an_obj_scene_still_shines_in_a_picture_from_its_bake() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let lamp = scene("lamp.obj").display().to_string();
    run_well([
        "bake",
        &lamp,
        "-o",
        &at("bake"),
        "--size",
        "64",
        "--rays",
        "1",
        "--quiet",
    ]);
    let view = "--eye 0,0,0 --look 0,1,0 --up 0,0,1 --fov-deg 40 --size 4x4 --quiet";
    let words = ["render", &lamp, "--bake", &at("bake"), "-o", &at("x.exr")];
    run_well(words.into_iter().chain(view.split(' ')));
    let picture = load_image(at("x.exr"));
    assert!(picture.pixels.iter().all(|pixel| *pixel == [2.0, 3.0, 5.0]));
}
