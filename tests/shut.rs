//! Shut spaces beside what light gets to: nobody is in a cupboard.

use crate::support::{BOX_SIDES, bake, report};
use std::fs;

#[test]
fn insides_of_shut_cupboards_are_hidden_faces_and_no_interior() {
    // Four in a row, of six boards each, 2 cm thick.
    let mut text = String::new();
    let mut count = 0;
    for x in [0.0, 0.62, 1.24, 1.86] {
        for [low, high] in [
            [[0.0, 0.0, 0.0], [0.02, 0.8, 0.6]],
            [[0.58, 0.0, 0.0], [0.6, 0.8, 0.6]],
            [[0.02, 0.0, 0.0], [0.58, 0.02, 0.6]],
            [[0.02, 0.78, 0.0], [0.58, 0.8, 0.6]],
            [[0.02, 0.02, 0.0], [0.58, 0.78, 0.02]],
            [[0.0, 0.0, 0.6], [0.6, 0.8, 0.62]],
        ] {
            text += &format!("o board{count}\n");
            for k in 0..8 {
                let at = |axis: usize| [low, high][k >> axis & 1][axis];
                text += &format!("v {} {} {}\n", x + at(0), at(1), at(2));
            }
            for side in BOX_SIDES {
                let [a, b, c, d] = side.map(|corner| 8 * count + corner + 1);
                text += &format!("f {a} {b} {c} {d}\n");
            }
            count += 1;
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cupboards.obj");
    fs::write(&path, text).expect("a file");
    let (out, _) = bake(&path, &["--size", "256", "--rays", "16"]);
    let baked = report(out.path());
    let warnings = baked["warnings"].as_array().expect("a list");
    let told = |kind: &str| warnings.iter().find(|of| of["kind"] == kind);
    assert!(told("interior").is_none(), "{warnings:?}");
    let line = told("hidden-faces").expect("a line")["message"].to_string();
    let share: f64 =
        (line[1..].split(' ').next()).map_or(0.0, |share| share.parse().expect("a number"));
    // Of the area of a cupboard's boards, 5.389, its inside is 2.382, and 0.31 is of boards that touch.
    assert!((share - 50.0).abs() < 6.0, "{line}");
}
