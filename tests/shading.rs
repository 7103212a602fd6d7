//! Smooth shading of coarse bodies: production shading against the smooth surface, exact shading against the facets.

use crate::support::{Page, backends, bake};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Sides of the prism.
const SIDES: usize = 8;

/// A prism of height 2 about the y axis with its corners on the unit circle, its side smooth-shaded: closed by caps, or
/// open and turned inside out.
fn prism(folder: &Path, inward: bool) -> PathBuf {
    let sign = if inward { -1.0 } else { 1.0 };
    let mut text = String::new();
    for y in [-1.0, 1.0] {
        for side in 0..SIDES {
            let (sin, cos) = (2.0 * PI * side as f64 / SIDES as f64).sin_cos();
            text += &format!("v {cos} {y} {sin}\nvn {} 0 {}\n", sign * cos, sign * sin);
        }
    }
    text += "vn 0 -1 0\nvn 0 1 0\n";
    for side in 1..=SIDES {
        let next = side % SIDES + 1;
        let mut face = [side, side + SIDES, next + SIDES, next];
        if inward {
            face.reverse();
        }
        let corners = face.map(|v| format!("{v}//{v}"));
        text += &format!("f {}\n", corners.join(" "));
    }
    if !inward {
        let cap = |first: usize, normal: usize| {
            let corners = (first..first + SIDES).map(|v| format!("{v}//{normal}"));
            corners.collect::<Vec<_>>()
        };
        let (bottom, mut top) = (cap(1, 2 * SIDES + 1), cap(SIDES + 1, 2 * SIDES + 2));
        top.reverse();
        text += &format!("f {}\nf {}\n", bottom.join(" "), top.join(" "));
    }
    let path = folder.join("prism.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

/// The values of a layer where the page is covered.
fn covered(page: &Page, layer: &str) -> Vec<f64> {
    let inside = page.plane(layer).iter().zip(page.plane("coverage"));
    let values = inside.filter(|(_, coverage)| **coverage > 0.0);
    values.map(|(value, _)| f64::from(*value)).collect()
}

fn extremes(values: &[f64]) -> (f64, f64) {
    let fold = |(low, high): (f64, f64), value: &f64| (low.min(*value), high.max(*value));
    values.iter().fold((f64::INFINITY, 0.0), fold)
}

#[test]
fn a_convex_smooth_body_does_not_darken_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = prism(folder.path(), false);
    for backend in backends() {
        let given = [
            "--size=64",
            "--rays=64",
            "--exponent=9",
            "--backend",
            backend,
        ];
        let (_baked, page) = bake(&file, &given);
        for layer in ["diffuse", "visibility", "specular"] {
            let found = extremes(&covered(&page, layer));
            assert_eq!(found, (1.0, 1.0), "{backend}, {layer}");
        }
        let (_baked, page) = bake(&file, &[&given[..], &["--shading=exact"]].concat());
        let (least, most) = extremes(&covered(&page, "diffuse"));
        // cos²(δ/2) at the edges of the facets, where the normal leans by half the angle of a side.
        let edge = (0.5 * PI / SIDES as f64).cos().powi(2);
        assert!(
            least >= edge && least < edge + 0.01,
            "{backend}: {least}, not {edge}"
        );
        assert_eq!(most, 1.0, "{backend}: the caps are flat");
    }
}

#[test]
fn rays_agree_with_the_closed_form_of_a_convex_smooth_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = prism(folder.path(), false);
    for backend in backends() {
        let (_baked, page) = bake(
            &file,
            &[
                "--size=64",
                "--rays=64",
                "--plan-off=open",
                "--backend",
                backend,
            ],
        );
        let values = covered(&page, "diffuse");
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        // The two triangles of a side are coplanar to 1e-7 only: a ray in 100,000 that grazes one meets the other.
        assert!(mean > 1.0 - 1e-5, "{backend}: {mean}");
    }
}

#[test]
fn production_lies_above_exact_by_at_most_the_share_of_the_wedge() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = prism(folder.path(), true);
    let bake = |shading: &str| {
        let arguments = ["--size=64", "--rays=256", "--shading", shading];
        let (_baked, page) = bake(&file, &arguments);
        (covered(&page, "diffuse"), covered(&page, "error"))
    };
    let ((production, errors), (exact, _)) = (bake("production"), bake("exact"));
    let wedge = (0.5 * PI / SIDES as f64).sin().powi(2);
    for ((p, e), error) in production.iter().zip(&exact).zip(errors) {
        // Both bakes draw the same directions but where what was met guides them, so the difference has no more noise
        // than both together.
        assert!(
            *p >= *e - 4.0 * error && p - e <= wedge + 4.0 * error,
            "production {p}, exact {e}, wedge {wedge}"
        );
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!(mean(&production) > mean(&exact), "the wedge sees something");
}

/// Nothing stands above a square, so its hemisphere takes no rays; where a leaning normal hides a part of a rough
/// lobe, the lobe alone says how much.
#[test]
fn rough_lobes_of_open_surfaces_are_the_same_with_or_without_the_diffuse_term() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("leaning.obj");
    let square = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nvn 0.8 0.6 0\nf 1//1 2//1 3//1 4//1\n";
    std::fs::write(&file, square).expect("a file");
    let mean = |layers: &str| {
        let rough = ["--size=64", "--rays=256", "--model=ggx", "--exponent=0"];
        let arguments = [&rough[..], &["--shading=exact", layers]].concat();
        let (_baked, page) = bake(&file, &arguments);
        let values = covered(&page, "specular");
        values.iter().sum::<f64>() / values.len() as f64
    };
    let [alone, beside] = ["--only=specular", "--only=specular,diffuse,visibility"].map(mean);
    assert!(alone < 0.95, "the surface hides something: {alone}");
    // Thousands of texels of 256 rays each.
    assert!((alone - beside).abs() < 1e-3, "{alone}, {beside}");
}
