//! Dark surfaces, whose rays go to what is open: a corridor with one end open, whose other end sees a square of sky.

use super::polygon::{Setting, shares};
use crate::support::{Page, backends, bake, report};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Length of the corridor; its ends are unit squares.
const LENGTH: f64 = 3.0;

/// A corridor from z = 0, where it is open, to [`LENGTH`]; all faces look inward.
fn corridor(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for z in [0.0, LENGTH] {
        text += &format!("v 0 0 {z}\nv 1 0 {z}\nv 1 1 {z}\nv 0 1 {z}\n");
    }
    text += "o end\nf 5 8 7 6\no sides\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
    let path = folder.join("corridor.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

/// Errors of the texels of the closed end: how far the diffuse term and the visibility are from the truth, and what is
/// stated of them.
fn errors(page: &Page) -> [Vec<[f64; 2]>; 2] {
    let window = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut found = [Vec::new(), Vec::new()];
    for i in 0..page.plane("coverage").len() {
        let of = |name: &str| f64::from(page.plane(name)[i]);
        let vector =
            |name: &str| DVec3::from(["X", "Y", "Z"].map(|axis| of(&format!("{name}.{axis}"))));
        let normal = vector("normal");
        if of("coverage") < 1.0 || normal.z > -0.99 {
            continue;
        }
        let at = Setting {
            normal,
            geometric: normal,
            mirror: normal,
            exponent: 1,
        };
        let point = vector("position");
        let exact = shares(&window.map(|[x, y]| DVec3::new(x, y, 0.0) - point), &at);
        found[0].push([of("diffuse") - exact.diffuse, of("error")]);
        found[1].push([of("visibility") - exact.visibility, of("error.visibility")]);
    }
    found
}

#[test]
fn the_end_of_a_corridor_is_right_with_a_quarter_of_the_variance() {
    const RAYS: f64 = 64.0;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = corridor(folder.path());
    for backend in backends() {
        let arguments = [
            "--size",
            "64",
            "--rays",
            "64",
            "--denoise",
            "off",
            "--seams",
            "off",
            "--backend",
            backend,
            "--only",
            "diffuse,visibility,error,error.visibility,position,normal,coverage",
        ];
        let (out, page) = bake(&scene, &arguments);
        for (term, errors) in ["diffuse", "visibility"].iter().zip(errors(&page)) {
            let texels = errors.len() as f64;
            assert!(texels >= 100.0, "{texels} texels");
            let mean = |of: &dyn Fn(&[f64; 2]) -> f64| errors.iter().map(of).sum::<f64>() / texels;
            let (bias, square) = (mean(&|e| e[0]), mean(&|e| e[0] * e[0]));
            let stated = mean(&|e| e[1] * e[1]);
            let standard = (square / texels).sqrt();
            assert!(
                bias.abs() < 3.5 * standard,
                "{backend}, {term}: {bias}, not {standard}"
            );
            // Of random rays; a bake without guides has 0.9 of it here.
            let share = 0.035;
            let random = share * (1.0 - share) / RAYS;
            assert!(
                square < 0.25 * random,
                "{backend}, {term}: {square} of {random}"
            );
            let ratio = (square / stated).sqrt();
            assert!(
                (0.8..1.25).contains(&ratio),
                "{backend}, {term}: {ratio} of what is stated"
            );
        }
        let report = report(out.path());
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        let each = number(&report["rays"]) / number(&report["pages"][0]["texels"]);
        assert!(each > RAYS && each <= 1.25 * RAYS, "{each} rays a texel");
    }
}
