//! Surfaces that go on from page to page, and pages that are too small.

use crate::support::{bake, page_path, report, run_well, scene};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Two halves of one floor, too large for one page together, with a box over where they meet.
fn halves(folder: &Path) -> PathBuf {
    let text = "\
        v -4 0 -2\nv -4 0 2\nv 0 0 2\nv 0 0 -2\nv 4 0 2\nv 4 0 -2\n\
        v -1 0.5 -1\nv -1 0.5 1\nv 1 0.5 1\nv 1 0.5 -1\n\
        o left half\nf 1 2 3 4\no right %\nf 4 3 5 6\no lid\nf 7 8 9 10\n";
    let path = folder.join("halves.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

/// Points of seams, and the steps there before and after: root mean square and largest.
fn steps(folder: &Path) -> (u64, [f64; 2], [f64; 2]) {
    let seams = &report(folder)["seams"];
    let step = |name: &str| seams[name].as_f64().unwrap_or(0.0);
    let points = seams["points"].as_u64().unwrap_or(0);
    let both = |when: &str| ["rms", "max"].map(|what| step(&format!("{what}_{when}")));
    (points, both("before"), both("after"))
}

#[test]
fn a_floor_on_two_pages_shows_no_step_between_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = halves(folder.path());
    let options = [
        "--size=64",
        "--density=12",
        "--rays=256",
        "--exclude=lid",
        "--only=diffuse",
    ];
    let (baked, _) = bake(&file, &options);
    assert_eq!(report(baked.path())["atlas"]["pages"], 2);
    let (points, before, after) = steps(baked.path());
    assert!(points >= 90, "two a texel of 48: {points}");
    // At so many rays steps are 2/255; what is left is where a texel may move no further.
    let case = format!("{before:?} > {after:?}");
    assert!(
        before[0] > 1.5 / 255.0 && after[0] < before[0] / 8.0,
        "{case}"
    );
    assert!(after[1] < before[1] / 3.0, "{case}");
    let (apart, _) = bake(&file, &[&options[..], &["--seams=object"]].concat());
    assert_eq!(steps(apart.path()).0, 0, "two objects");
    // Threads and resumed runs have no say in it: pages are finished in their order.
    let (one, _) = bake(&file, &[&options[..], &["--threads=1"]].concat());
    for page in 0..2 {
        let [a, b] = [&baked, &one].map(|baked| {
            let path = page_path(baked.path(), &file, page);
            std::fs::read(path).expect("a page")
        });
        assert!(a == b, "page {page}");
    }
}

#[test]
fn a_page_that_is_mostly_gutters_is_warned_of_with_a_size_that_is_not() {
    let file = scene("courtyard.obj");
    let file = file.to_str().expect("a UTF-8 path");
    let small = |size: &str| -> Option<String> {
        let plan = run_well(["plan", file, "--size", size, "--rays", "4", "--json"]);
        let plan: Value = serde_json::from_str(&plan).expect("JSON");
        let warnings = plan["warnings"].as_array().expect("a list").iter();
        let mut small = warnings.filter(|warning| warning["kind"] == "small-page");
        small.next().map(|warning| warning["message"].to_string())
    };
    let message = small("128").expect("a warning");
    let size = message.split("--size ").nth(1).expect("a size");
    let size = size.split('`').next().expect("a size");
    assert_eq!(small(size), None, "{message}");
}
