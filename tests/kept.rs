//! What an update may not keep: one change each that reaches other texels by a way of its own, and the bytes of a whole
//! bake.

use crate::support::scene;
use crate::update::compare_files;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// An authored glTF file, changed, in `folder` with the picture that it names.
fn gltf(folder: &Path, name: &str, change: impl Fn(&mut Value)) -> PathBuf {
    fs::create_dir_all(folder).expect("a folder");
    let text = fs::read_to_string(scene(name)).expect("an authored file");
    let mut json: Value = serde_json::from_str(&text).expect("JSON");
    change(&mut json);
    let path = folder.join(name);
    fs::write(&path, json.to_string()).expect("a file");
    let picture = scene(name).with_extension("png");
    if picture.exists() {
        fs::copy(picture, path.with_extension("png")).expect("copied");
    }
    path
}

/// Two versions of an authored file in folders of their own, compared; the share of the texels that were baked again.
fn share(name: &str, change: impl Fn(&Path, &mut Value), more: &[&str]) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    let old = gltf(&a, name, |_| {});
    let new = gltf(&b, name, |json| change(&b, json));
    // The picture that a change made stands in place of the authored one.
    if let Ok(made) = fs::read(b.join("made.png")) {
        fs::write(new.with_extension("png"), made).expect("a file");
        fs::remove_file(b.join("made.png")).expect("it is there");
    }
    let said = compare_files(folder.path(), [&old, &new], more);
    assert_eq!(said["reason"], Value::Null, "{said}");
    said["share"].as_f64().expect("a share")
}

const NEAR: &[&str] = &["--size", "96", "--rays", "8", "--max-distance", "0.5"];

#[test]
fn one_of_two_copies_of_a_sheet_that_moves_is_seen_by_the_floor_below_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let twice = |name: &str, shift: f32| {
        gltf(&folder.path().join(name), "masked_card.gltf", |json| {
            let nodes = json["nodes"].as_array_mut().expect("a list");
            nodes.push(json!({"mesh": 1, "translation": [shift, 0.5, 0]}));
            json["scenes"][0]["nodes"] = json!([0, 1, 2]);
        })
    };
    let small = ["--size", "64", "--rays", "16"];
    let (old, new) = (twice("a", 0.0), twice("b", 0.5));
    let said = compare_files(folder.path(), [&old, &new], &small);
    assert_eq!(said["reason"], Value::Null, "{said}");
    assert!(said["share"].as_f64() > Some(0.0), "{said}");
}

#[test]
fn what_no_longer_casts_a_shadow_is_missed_by_the_floor_below_it() {
    let ghost = |_: &Path, json: &mut Value| {
        json["nodes"][1]["extras"] = json!({"ambake": {"cast": false}});
    };
    let share = share("masked_card.gltf", ghost, &["--size", "64", "--rays", "16"]);
    assert!(share > 0.0, "{share}");
}

#[test]
fn holes_in_a_picture_let_light_through_to_what_lies_below() {
    let opened = |folder: &Path, _: &mut Value| {
        let picture = image::open(scene("masked_card.png")).expect("a picture");
        let mut picture = picture.into_rgba8();
        let left = picture.width() / 2;
        for (x, _, pixel) in picture.enumerate_pixels_mut() {
            pixel.0[3] = if x < left { 0 } else { pixel.0[3] };
        }
        picture.save(folder.join("made.png")).expect("a picture");
    };
    let share = share(
        "masked_card.gltf",
        opened,
        &["--size", "64", "--rays", "16"],
    );
    assert!(share > 0.0, "{share}");
}

/// Writes squares that look up, each with the shading normal of its corners, as an OBJ file; the last one moves by
/// `step`.
fn squares(folder: &Path, normal: &str, step: f32) -> PathBuf {
    fs::create_dir_all(folder).expect("a folder");
    let mut text = format!("{normal}\n");
    let mut first = 1;
    let mut square = |[x, y, z]: [f32; 3], name: &str, with_normals: bool| {
        text += &format!("o {name}\n");
        for [dx, dz] in [[0, 0], [0, 1], [1, 1], [1, 0]] {
            text += &format!("v {} {y} {}\n", x + dx as f32, z + dz as f32);
        }
        let corner = |k: usize| match with_normals {
            true => format!("{}//{}", first + k, k + 1),
            false => (first + k).to_string(),
        };
        let corners: Vec<String> = (0..4).map(corner).collect();
        text += &format!("f {}\n", corners.join(" "));
        first += 4;
    };
    square([0.0, 0.0, 0.0], "near", true);
    square([6.0, 0.0, 0.0], "far", true);
    square([0.1, -0.3 + step, 0.1], "below", false);
    let path = folder.join("squares.obj");
    fs::write(&path, text).expect("a file");
    path
}

#[test]
fn surfaces_look_to_the_side_that_is_lit_alone() {
    let small = [
        "--size",
        "64",
        "--rays",
        "16",
        "--max-distance",
        "1",
        "--under",
        "0",
    ];
    for (case, normals, baked) in [
        // The normals of the corners in the order of the file. The far one sees nothing of what moves.
        ("against its winding", ["0 -1 0"; 4], 0.5..0.9),
        (
            "bent through its plane",
            ["0.8 0.6 0", "0.8 0.6 0", "0.8 -0.6 0", "0.8 -0.6 0"],
            0.2..0.5,
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let lines = normals.map(|normal| format!("vn {normal}")).join("\n");
        let [old, new] = [("a", 0.0), ("b", 0.1)]
            .map(|(name, step)| squares(&folder.path().join(name), &lines, step));
        let said = compare_files(folder.path(), [&old, &new], &small);
        let share = said["share"].as_f64().expect("a share");
        assert!(baked.contains(&share), "{case}: {said}");
    }
}

#[test]
fn with_a_target_what_moves_elsewhere_decides_how_many_rays_a_tile_takes() {
    let until = [
        "--size=96",
        "--target-error=0.02",
        "--max-rays=256",
        "--max-distance=0.5",
    ];
    let moved = |_: &Path, json: &mut Value| json["nodes"][1]["scale"] = json!([1, 0.05, 1]);
    share("instances.gltf", moved, &until);
}

#[test]
fn objects_that_are_counted_anew_are_so_in_the_layer_of_their_numbers() {
    let first = |_: &Path, json: &mut Value| {
        let nodes = json["scenes"][0]["nodes"].as_array_mut().expect("a list");
        nodes.rotate_right(1);
    };
    let numbered = [NEAR, &["--layers", "object"]].concat();
    share("instances.gltf", first, &numbered);
}
