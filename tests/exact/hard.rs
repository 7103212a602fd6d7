//! Cases that break bakers with fixed epsilons: scale, thin gaps, coplanar and coincident faces.

use crate::support::{Page, backends, bake, scene};
use std::fmt::Write;

const TERMS: [&str; 2] = ["visibility", "diffuse"];

/// Bakes an OBJ text whose UVs are kept; every texel by rays.
fn bake_text(text: &str, backend: &str) -> Page {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("case.obj");
    std::fs::write(&path, text).expect("the folder is writable");
    #[rustfmt::skip]
    let arguments = [
        "--size", "16", "--rays", "1024", "--uv", "keep", "--backend", backend, "--plan-off", "open",
    ];
    bake(&path, &arguments).1
}

/// A quad `corner, corner + down, ..` turned about an axis that is none of the grid's, with its part of the page.
fn quad(text: &mut String, name: &str, corners: [[f64; 3]; 4], rect: [f64; 4], turned: bool) {
    let axis = glam::DVec3::new(0.3, 1.0, -0.2).normalize();
    let turn = glam::DQuat::from_axis_angle(axis, if turned { 0.7 } else { 0.0 });
    writeln!(text, "o {name}").expect("a string");
    for corner in corners {
        let p = (turn * glam::DVec3::from(corner)).as_vec3();
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("a string");
    }
    let [u0, v0, u1, v1] = rect;
    for (u, v) in [(u0, v0), (u0, v1), (u1, v1), (u1, v0)] {
        writeln!(text, "vt {u} {}", 1.0 - v).expect("a string");
    }
    text.push_str("f -4/-4 -3/-3 -2/-2 -1/-1\n");
}

/// A square about the y axis that looks up (or down) from the height `y`.
fn level(half: f64, y: f64, up: bool) -> [[f64; 3]; 4] {
    let mut corners = [
        [-half, y, -half],
        [-half, y, half],
        [half, y, half],
        [half, y, -half],
    ];
    if !up {
        corners.reverse();
    }
    corners
}

const LEFT: [f64; 4] = [0.0, 0.0, 0.5, 0.5];
const RIGHT: [f64; 4] = [0.5625, 0.0, 1.0, 0.5];
const BELOW: [f64; 4] = [0.0, 0.5625, 0.4375, 1.0];

/// Values of the texels of [`LEFT`].
fn left<'a>(page: &'a Page, term: &'a str) -> impl Iterator<Item = f32> + 'a {
    (0..64).map(move |i| page.plane(term)[i / 8 * 16 + i % 8])
}

#[test]
fn scene_scaled_by_a_power_of_two_bakes_to_the_same_bits() {
    for name in ["wall_finite.obj", "resting_sphere.obj", "groove_60.obj"] {
        let text = std::fs::read_to_string(scene(name)).expect("the scene is there");
        let scaled = |power: i32| {
            let mut out = String::new();
            for line in text.lines() {
                match line.strip_prefix("v ") {
                    Some(numbers) => {
                        let number = |word: &str| {
                            word.parse::<f32>().expect("a number") * 2.0f32.powi(power)
                        };
                        let words: Vec<String> =
                            numbers.split(' ').map(|w| number(w).to_string()).collect();
                        writeln!(out, "v {}", words.join(" ")).expect("a string");
                    }
                    None => writeln!(out, "{line}").expect("a string"),
                }
            }
            out
        };
        for backend in backends() {
            let plain = bake_text(&scaled(0), backend);
            for power in [-14, 17] {
                let other = bake_text(&scaled(power), backend);
                for term in TERMS {
                    let differ = plain
                        .plane(term)
                        .iter()
                        .zip(other.plane(term))
                        .filter(|(a, b)| a != b)
                        .count();
                    assert_eq!(
                        differ, 0,
                        "{name} {backend} times 2^{power}: texels of {term} that differ"
                    );
                }
            }
        }
    }
}

#[test]
fn thin_gap_is_dark() {
    // A turned plane lies in f32 only to within its rounding bound, about 1.4e-6 here: thinner gaps are not seen.
    for (turned, least) in [(false, 1e-6), (true, 1e-5)] {
        for gap in [1e-2, 1e-4, least] {
            let mut text = String::new();
            quad(&mut text, "floor", level(0.5, 0.0, true), LEFT, turned);
            quad(&mut text, "plate", level(1.0, gap, false), RIGHT, turned);
            // Without it one would see the floor from below, and that side would be baked.
            quad(&mut text, "base", level(1.0, -gap, true), BELOW, turned);
            for backend in backends() {
                let page = bake_text(&text, backend);
                let brightest = left(&page, "diffuse").fold(0.0, f32::max);
                // From the floor's rim the plate reaches half a unit on: only rays below mu = 2 gap can leave. Of 1,024
                // rays about 1024 gap are that flat (8 more by chance), and each weighs at most 4 mu / 1024.
                let most = (1024.0 * gap + 8.0) * 8.0 * gap / 1024.0;
                assert!(
                    f64::from(brightest) <= most,
                    "gap {gap}, turned {turned}, {backend}: {brightest} > {most}"
                );
            }
        }
    }
}

#[test]
fn coplanar_plate_hides_nothing() {
    let mut text = String::new();
    quad(&mut text, "floor", level(1.0, 0.0, true), LEFT, false);
    quad(&mut text, "plate", level(0.6, 0.0, true), RIGHT, false);
    for backend in backends() {
        let page = bake_text(&text, backend);
        for term in ["visibility", "diffuse"] {
            assert!(
                left(&page, term).all(|v| v == 1.0),
                "{backend}: {term} below 1"
            );
        }
    }
}

#[test]
fn coincident_quads_hide_nothing_from_each_other() {
    for turned in [false, true] {
        for same_way in [true, false] {
            let mut text = String::new();
            quad(&mut text, "one", level(1.0, 0.0, true), LEFT, turned);
            quad(&mut text, "other", level(1.0, 0.0, same_way), RIGHT, turned);
            for backend in backends() {
                let page = bake_text(&text, backend);
                for term in ["visibility", "diffuse"] {
                    let dark = left(&page, term).filter(|&v| v != 1.0).count();
                    assert_eq!(
                        dark, 0,
                        "turned {turned}, same way {same_way}, {backend}: texels of {term} below 1"
                    );
                }
            }
        }
    }
}

#[test]
fn coincident_occluders_count_once() {
    let text = |twice: bool| {
        let mut text = String::new();
        quad(&mut text, "floor", level(1.0, 0.0, true), LEFT, false);
        quad(
            &mut text,
            "plate",
            level(1.0, 1.0, false),
            [0.5625, 0.0, 1.0, 0.4],
            false,
        );
        let second = if twice { 1.0 } else { -5.0 };
        quad(
            &mut text,
            "again",
            level(1.0, second, false),
            [0.5625, 0.5, 1.0, 0.9],
            false,
        );
        text
    };
    for backend in backends() {
        let (once, twice) = (
            bake_text(&text(false), backend),
            bake_text(&text(true), backend),
        );
        for term in TERMS {
            assert!(
                left(&once, term).eq(left(&twice, term)),
                "{backend}: {term} changes"
            );
        }
    }
}

#[test]
fn closed_boxes_at_any_angle_are_exactly_dark() {
    let low = [-1.0, -0.75, -1.5];
    let corner = |bits: usize| {
        [0, 1, 2].map(|axis| {
            if bits >> axis & 1 == 1 {
                -low[axis]
            } else {
                low[axis]
            }
        })
    };
    // Faces that turn counter-clockwise as seen from inside.
    let faces = [
        [2, 6, 4, 0],
        [5, 7, 3, 1],
        [4, 5, 1, 0],
        [3, 7, 6, 2],
        [1, 3, 2, 0],
        [6, 7, 5, 4],
    ];
    for turned in [false, true] {
        let mut text = String::new();
        for (number, face) in faces.into_iter().enumerate() {
            let u = 0.3 * (number % 3) as f64 + 0.05;
            let v = 0.5 * (number / 3) as f64 + 0.05;
            let rect = [u, v, u + 0.23, v + 0.4];
            quad(&mut text, "wall", face.map(corner), rect, turned);
        }
        for backend in backends() {
            let page = bake_text(&text, backend);
            let texels = page.plane("coverage").iter().filter(|&&c| c > 0.0).count();
            assert!(texels > 100, "{texels} texels");
            assert!(
                page.plane("rays").iter().sum::<f32>() > 0.0,
                "turned {turned}: the faces look inward"
            );
            for term in TERMS {
                let brightest = page.plane(term).iter().copied().fold(0.0, f32::max);
                assert_eq!(brightest, 0.0, "{term}, turned {turned}, {backend}");
            }
        }
    }
}
