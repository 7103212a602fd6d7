//! Comparing the models of a bake, and two pages.

use super::SMALL;
use crate::support::{Page, bake, files, page_path, run_well, scene};
use serde_json::Value;

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
