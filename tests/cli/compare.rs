//! Comparing the models of a bake, and two pages.

use super::SMALL;
use crate::support::{Page, bake, files, page_path, run, run_well, scene};
use exr::prelude::{Image, SpecificChannels, WritableImage};
use serde_json::Value;
use std::path::Path;

#[test]
fn compare_tells_numbers_and_places() {
    let (folder, page) = bake(&scene("courtyard.obj"), &SMALL);
    let text = run_well(["compare".as_ref(), folder.path().as_os_str()]).to_lowercase();
    for word in ["lambert", "phong", "rmse"] {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
    let json = run_well([
        "compare".as_ref(),
        folder.path().as_os_str(),
        "--json".as_ref(),
    ]);
    let json: Value = serde_json::from_str(&json).expect("compare --json is JSON");
    let mut found = Vec::new();
    each_number(&json, &mut |key, number| {
        if key == "rmse" {
            found.push(number);
        }
    });
    for model in ["lambert", "phong"] {
        let rmse = weighted_rmse(&page, "traditional", model);
        assert!(
            found.iter().any(|n| (n / rmse - 1.0).abs() < 1e-5),
            "{model}: no rmse of {rmse} in {json}"
        );
    }
    let pictures = files(folder.path())
        .into_iter()
        .filter(|name| name.contains("difference") && name.ends_with(".png"));
    assert!(pictures.count() >= 2, "{:?}", files(folder.path()));
}

#[test]
fn pictures_of_differences_do_not_take_the_place_of_previews() {
    let arguments = [
        "--size",
        "16",
        "--rays",
        "4",
        "--layers",
        "difference.phong",
    ];
    let (folder, _page) = bake(&scene("wall_long.obj"), &arguments);
    let preview = folder.path().join("wall_long.0.difference.phong.png");
    let before = std::fs::read(&preview).expect("a preview");
    run_well(["compare".as_ref(), folder.path().as_os_str()]);
    assert_eq!(std::fs::read(&preview).expect("a preview"), before);
    let picture = folder
        .path()
        .join("wall_long.0.difference.traditional-phong.png");
    assert!(picture.is_file());
}

/// Root mean square difference of two models, weighted by coverage, channels averaged.
fn weighted_rmse(page: &Page, a: &str, b: &str) -> f64 {
    let (mut squares, mut weight) = (0.0, 0.0);
    for (i, &coverage) in page.plane("coverage").iter().enumerate() {
        weight += f64::from(coverage);
        for suffix in ["R", "G", "B"] {
            let value = |model: &str| f64::from(page.plane(&format!("{model}.{suffix}"))[i]);
            squares += f64::from(coverage) * (value(a) - value(b)).powi(2) / 3.0;
        }
    }
    (squares / weight).sqrt()
}

#[test]
fn compare_of_a_page_with_itself_is_nought() {
    let (folder, _page) = bake(&scene("wall_long.obj"), &["--size", "16", "--rays", "16"]);
    let path = page_path(folder.path(), &scene("wall_long.obj"), 0);
    let json = run_well([
        "compare".as_ref(),
        path.as_os_str(),
        path.as_os_str(),
        "--json".as_ref(),
    ]);
    let json: Value = serde_json::from_str(&json).expect("compare --json is JSON");
    let mut seen = 0;
    each_number(&json, &mut |key, number| {
        if ["rmse", "maximum", "mean_signed"].contains(&key) {
            seen += 1;
            assert_eq!(number, 0.0, "{key} in {json}");
        }
    });
    assert!(seen > 0, "{json}");
}

#[test]
fn compare_refuses_pages_of_different_scenes() {
    let few = ["--size", "16", "--rays", "4"];
    let (wall, _) = bake(&scene("wall_long.obj"), &few);
    let (plane, _) = bake(&scene("plane.obj"), &few);
    let wall_page = page_path(wall.path(), &scene("wall_long.obj"), 0);
    let plane_page = page_path(plane.path(), &scene("plane.obj"), 0);
    refuses(&wall_page, &plane_page, "different scenes");

    // The same scene with other options is what the verb is for.
    let (again, _) = bake(&scene("wall_long.obj"), &["--size", "16", "--rays", "16"]);
    let again = page_path(again.path(), &scene("wall_long.obj"), 0);
    run_well(["compare".as_ref(), wall_page.as_os_str(), again.as_os_str()]);

    // A file of another program states no scene.
    let foreign = plane.path().join("foreign.exr");
    let channels = SpecificChannels::build()
        .with_channel("diffuse")
        .with_pixel_fn(|_| (0.5f32,));
    let image = Image::from_channels((16, 16), channels);
    image
        .write()
        .to_file(&foreign)
        .expect("the file is written");
    for (a, b) in [(&wall_page, &foreign), (&foreign, &plane_page)] {
        let text = run_well(["compare".as_ref(), a.as_os_str(), b.as_os_str()]);
        assert!(text.contains("diffuse"), "{text}");
    }
}

#[test]
fn compare_refuses_two_pages_of_one_bake() {
    let path = scene("closed_box.obj");
    let words: Vec<&str> = "--size 64 --rays 4 --uv unwrap --density 12"
        .split(' ')
        .collect();
    let (folder, _) = bake(&path, &words);
    let [first, second] = [0, 1].map(|number| page_path(folder.path(), &path, number));
    refuses(&first, &second, "of one bake");
}

/// `compare` of two files ends with status 1 and one line that names both and says `why`, and writes nothing.
fn refuses(a: &Path, b: &Path, why: &str) {
    let out = tempfile::tempdir().expect("a temporary directory");
    let words = [
        "compare".as_ref(),
        a.as_os_str(),
        b.as_os_str(),
        "-o".as_ref(),
        out.path().as_os_str(),
    ];
    let output = run(words);
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{line}");
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    for word in [&a.display().to_string(), &b.display().to_string(), why] {
        assert!(line.contains(word), "no {word} in {line}");
    }
    assert!(
        output.stdout.is_empty() && files(out.path()).is_empty(),
        "{:?}",
        files(out.path())
    );
}

/// Calls `found` with every number of a document and the key it stands under.
fn each_number(value: &Value, found: &mut dyn FnMut(&str, f64)) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| each_number(item, found)),
        Value::Object(fields) => fields.iter().for_each(|(key, item)| match item.as_f64() {
            Some(number) => found(key, number),
            None => each_number(item, found),
        }),
        _ => {}
    }
}
