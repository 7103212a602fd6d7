//! What stands in, on and before other bodies: walls in a ground, posts through a floor, planks at a wall, boxes.

use crate::buried::{SIZE, options};
use crate::support::{BOX_SIDES, Page, backends, bake, report};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Four walls about the origin from y = `low` to 1.1, turned by 20 degrees, in a level square ground at y = 0 of 200 x
/// 200.
fn rooted_walls(folder: &Path, low: f64) -> PathBuf {
    let mut text = String::from("o ground\n");
    for (x, z) in [(-100, -100), (-100, 100), (100, 100), (100, -100)] {
        writeln!(text, "v {x} 0 {z}").expect("a string");
    }
    text += "f 1 2 3 4\no walls\n";
    let (sin, cos) = 20f64.to_radians().sin_cos();
    for y in [low, 1.1] {
        for (x, z) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            writeln!(text, "v {} {y} {}", x * cos - z * sin, x * sin + z * cos).expect("a string");
        }
    }
    for [a, b] in [[0, 1], [1, 2], [2, 3], [3, 0]] {
        writeln!(text, "f {} {} {} {}", 5 + a, 9 + a, 9 + b, 5 + b).expect("a string");
    }
    let path = folder.join("rooted.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn walls_that_stand_in_an_open_ground_are_buried_below_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for backend in backends() {
        // What reaches further down than up is not taken for something that stands in the ground.
        for (low, exact) in [(-0.43, 1.1 / 1.53), (-1.5, 1.0)] {
            let file = rooted_walls(folder.path(), low);
            let flags = ["--size=64", "--exclude=ground", "--only=diffuse,validity"];
            let flags = [&flags[..], &["--backend", backend]].concat();
            let (_baked, page) = bake(&file, &flags);
            let coverage = page.plane("coverage").iter().map(|c| f64::from(*c));
            let texels: Vec<(f64, f64)> = (page.plane("validity").iter())
                .map(|validity| f64::from(*validity))
                .zip(coverage)
                .filter(|(_, coverage)| *coverage > 0.0)
                .collect();
            let covered: f64 = texels.iter().map(|(_, coverage)| coverage).sum();
            let seen: f64 = texels.iter().map(|(v, coverage)| v * coverage).sum();
            // Strata of an eighth of a texel, of which a wall has some 30 one above another.
            let off = seen / covered - exact;
            assert!(off.abs() < 0.004, "{backend}, from {low}: {off}");
            // A wall on a wide plane sees half of the sky, above it.
            let values = page.plane("diffuse").iter().zip(page.plane("validity"));
            let mut values = values.filter(|(_, validity)| **validity > 0.0);
            // 256 rays, five standard errors.
            assert!(
                values.all(|(value, _)| (value - 0.5).abs() < 0.05),
                "{backend}"
            );
        }
    }
}

/// A room of 8 x 3 x 8 that looks inward, without its wall toward +x where `open`, and the four sides of a post about
/// the origin from `low` to 1: one row of faces from the floor up, at 16 texels a unit, and one below.
fn post_in_a_room(folder: &Path, low: f64, open: bool) -> PathBuf {
    let mut text = String::from("o room\n");
    for (y, x, z) in (0..8).map(|k| ([0, 3][k >> 2], [-4, 4][k & 1], [-4, 4][k >> 1 & 1])) {
        writeln!(text, "v {x} {y} {z}").expect("a string");
    }
    let faces = [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ];
    for (number, face) in faces.iter().take(if open { 5 } else { 6 }).enumerate() {
        let at = |k: usize| {
            (
                0.2 + 0.01 * number as f64 + [0.0, 0.005][k & 1],
                [0.9, 0.905][k >> 1],
            )
        };
        for (u, v) in [0, 1, 3, 2].map(at) {
            writeln!(text, "vt {u} {v}").expect("a string");
        }
        let corner = |(k, corner): (usize, &str)| format!("{corner}/{}", 4 * number + k + 1);
        let corners: Vec<String> = face.split(' ').enumerate().map(corner).collect();
        writeln!(text, "f {}", corners.join(" ")).expect("a string");
    }
    text += "o post\n";
    let (sin, cos) = 17f64.to_radians().sin_cos();
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    for (side, rows) in (0..4).flat_map(|side| [(side, [0.0, 1.0]), (side, [low, 0.0])]) {
        if rows[0] == rows[1] {
            continue;
        }
        let mut line = String::from("f");
        for (k, (end, y)) in [(0, rows[0]), (0, rows[1]), (1, rows[1]), (1, rows[0])]
            .iter()
            .enumerate()
        {
            let (x, z) = corners[(side + end) % 4];
            let (u, v) = (
                0.05 + 0.25 * side as f64 + 0.1875 * *end as f64,
                0.2 + y * 0.25,
            );
            writeln!(
                text,
                "v {} {y} {}\nvt {u} {v}",
                x * cos - z * sin,
                x * sin + z * cos
            )
            .expect("a string");
            write!(line, " {0}/{0}", k as i32 - 4).expect("a string");
        }
        writeln!(text, "{line}").expect("a string");
    }
    let path = folder.join("room.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn a_post_through_the_floor_of_a_room_is_one_that_ends_there() {
    let folder = tempfile::tempdir().expect("a folder");
    for backend in backends() {
        for open in [false, true] {
            let mut flags = options(backend, &["--max-distance=1", "--seams=off"]);
            flags.push("--exclude=room");
            let bake = |low: f64| bake(&post_in_a_room(folder.path(), low, open), &flags);
            let (_cut, cut) = bake(0.0);
            let (_baked, through) = bake(-0.4);
            let mut seen = 0;
            for texel in 0..SIZE * SIZE {
                let at = |page: &Page, layer: &str| page.plane(layer)[texel];
                let row = texel / SIZE;
                let expected = match at(&cut, "coverage") {
                    1.0 => at(&cut, "diffuse"),
                    _ => continue,
                };
                seen += 1;
                let case = format!("{backend}, open {open}, texel {texel} in row {row}");
                assert_eq!(at(&through, "validity"), 1.0, "{case}");
                assert_eq!(at(&through, "diffuse"), expected, "{case}");
            }
            assert_eq!(seen, 4 * 11 * 15);
            // Four sides of 12 x 6.4 texels, with those that its borders cut; the floor cuts the uppermost row.
            let covered = through
                .plane("coverage")
                .iter()
                .zip(through.plane("validity"));
            let buried = covered
                .filter(|(coverage, seen)| **coverage > 0.0 && **seen == 0.0)
                .count();
            assert!((4 * 12 * 6..4 * 14 * 8).contains(&buried), "{buried}");
        }
    }
}

/// A wall whose front is z = 0, a row of planks 1.7 cm before it, as wide as 0.3 and as high as 1.4, and a post before
/// them; `blind` planks look at the wall.
fn planked(folder: &Path, blind: bool) -> PathBuf {
    let mut text = String::new();
    let mut block = |name: &str, low: [f64; 3], high: [f64; 3], faces: &[[u32; 4]]| {
        writeln!(text, "o {name}").expect("a string");
        for k in 0..8 {
            let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low } else { high }[axis]);
            writeln!(text, "v {} {} {}", at[0], at[1], at[2]).expect("a string");
        }
        for face in faces {
            let corners = [0, 1, 2, 3].map(|k| {
                let (right, up) = (face[k] & 1 == 1, face[k] >> 1 & 1 == 1);
                let u = (0.5 + 0.5 * low[0]).max(0.0) + if right { 0.12 } else { 0.0 };
                writeln!(text, "vt {u} {}", if up { 0.66 } else { 0.1 }).expect("a string");
                format!("{}/{}", face[k] as i64 - 8, k as i64 - 4)
            });
            writeln!(text, "f {}", corners.join(" ")).expect("a string");
        }
    };
    block("wall", [-2.0, -1.0, -0.2], [2.0, 2.0, 0.0], &BOX_SIDES);
    block("post", [-0.35, -1.0, 0.1], [-0.3, 2.0, 0.3], &BOX_SIDES);
    let side = if blind { [0, 2, 3, 1] } else { [0, 1, 3, 2] };
    for k in 0..4 {
        let x = 0.35 * f64::from(k) - 0.8;
        block(
            &format!("plank{k}"),
            [x, 0.0, 0.017],
            [x + 0.3, 1.4, 0.017],
            &[side],
        );
    }
    let path = folder.join("planked.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn planks_that_look_at_their_wall_bake_as_the_same_planks_turned_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let [seen, blind] = [false, true].map(|blind| {
        let flags = [
            "--size=64",
            "--rays=64",
            "--only=diffuse,normal",
            "--include=plank*",
        ];
        let (folder, page) = bake(&planked(folder.path(), blind), &flags);
        let report = report(folder.path());
        let warnings = report["warnings"].as_array().expect("a list");
        let turned = warnings.iter().find(|w| w["kind"] == "turned-over");
        let count = turned.map_or(0, |w| w["count"].as_u64().expect("a number"));
        assert_eq!(count, if blind { 4 } else { 0 }, "{warnings:?}");
        page
    });
    let covered: Vec<usize> = (0..SIZE * SIZE)
        .filter(|&k| blind.plane("coverage")[k] > 0.0)
        .collect();
    assert!(covered.len() > 1000, "{}", covered.len());
    for plane in ["coverage", "normal.Z", "diffuse"] {
        let apart = |&k: &usize| (seen.plane(plane)[k] - blind.plane(plane)[k]).abs();
        let sum: f32 = covered.iter().map(|k| apart(k).powi(2)).sum();
        let apart = (sum / covered.len() as f32).sqrt();
        // Their triangles run the other way, so noise is between the light of the two.
        let noise = if plane == "diffuse" { 0.015 } else { 1e-6 };
        assert!(apart < noise, "{plane}: {apart}");
    }
    // The post is 0.55 or farther beside the last one, and stands out by 0.283 from its plane. Even without an end it
    // hides no more than (1 - cos(atan(0.283 / 0.55))) / 2 of its light: 0.055. Four standard errors are 0.04.
    let last = covered.iter().filter(|&&k| k % SIZE >= 40);
    let darkest = last.map(|&k| blind.plane("diffuse")[k]).fold(1.0, f32::min);
    assert!(darkest > 0.9 && darkest < 1.0, "{darkest}");
}

#[test]
fn tops_of_boxes_that_are_level_but_for_rounding_take_no_light_from_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("slabs.obj");
    let top = 29.6f32;
    for below in [0, 1, 2] {
        let slab = |low: [f32; 3], high: [f32; 3]| {
            let corner = |k: usize| [0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]);
            let line = |[x, y, z]: [f32; 3]| format!("v {x:.9} {y:.9} {z:.9}\n");
            (0..8).map(corner).map(line).collect::<String>()
        };
        let faces = |first: u32| {
            let line = |side: [u32; 4]| side.map(|k| (first + k).to_string()).join(" ");
            BOX_SIDES.map(|side| format!("f {}\n", line(side))).concat()
        };
        let lower = f32::from_bits(top.to_bits() - below);
        let (a, b) = (
            slab([0.0, 29.0, 0.0], [4.0, top, 4.0]),
            slab([2.0, 28.9, 1.0], [6.0, lower, 5.0]),
        );
        let text = format!("o a\n{a}{}o b\n{b}{}", faces(1), faces(9));
        std::fs::write(&file, text).expect("a file");
        for backend in backends() {
            let layers = "--layers=validity,object,geometric";
            let options = ["--size=64", "--rays=64", layers, "--backend", backend];
            let (_baked, page) = bake(&file, &options);
            let tops = (0..page.plane("object").len())
                .filter(|&k| page.plane("coverage")[k] > 0.0 && page.plane("geometric.Y")[k] > 0.9);
            let least = |layer: &str| {
                let values = tops.clone().map(|k| page.plane(layer)[k]);
                values.fold(f32::INFINITY, f32::min)
            };
            let found = [least("validity"), least("diffuse")];
            assert_eq!(found, [1.0; 2], "{backend}, {below} ulps");
        }
    }
}

/// Three sheets that cross as walls in a corner. Much of each lies behind another, where a picture from outside shows
/// it.
#[test]
fn what_lies_far_behind_a_wall_has_no_more_grain_than_what_is_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("corner.obj");
    let text = "o floor\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3 4\n\
        o back\nv -2 -1 -1\nv 2 -1 -1\nv 2 3 -1\nv -2 3 -1\nf 5 6 7 8\n\
        o left\nv -1 -1 2\nv -1 -1 -2\nv -1 3 -2\nv -1 3 2\nf 9 10 11 12\n";
    std::fs::write(&path, text).expect("a file");
    let flags = ["--size", "128", "--only", "diffuse,validity"];
    let exact = bake(
        &path,
        &[&flags[..], &["--rays", "2048", "--denoise", "off"]].concat(),
    )
    .1;
    let rms = |more: &[&str], is_seen: bool| {
        let page = bake(&path, &[&flags[..], more].concat()).1;
        let places = exact.plane("coverage").iter().zip(exact.plane("validity"));
        let wanted = |(coverage, validity): (&f32, &f32)| {
            *coverage > 0.0
                && if is_seen {
                    *validity == 1.0
                } else {
                    *validity == 0.0
                }
        };
        let values = page.plane("diffuse").iter().zip(exact.plane("diffuse"));
        let own = values.zip(places).filter(|(_, place)| wanted(*place));
        let off: Vec<f32> = own
            .map(|((value, exact), _)| (value - exact).powi(2))
            .collect();
        assert!(off.len() > 2000, "{} texels", off.len());
        (off.iter().sum::<f32>() / off.len() as f32).sqrt()
    };
    let plain = rms(&["--rays", "64", "--denoise", "off"], false);
    let regression = ["--denoise", "regression"];
    let denoised = rms(&[&["--rays", "64"], &regression[..]].concat(), false);
    assert!(denoised < 0.5 * plain, "{denoised} for {plain}");
    // Those of a target are no fewer there.
    let target = [&["--target-error", "0.004"], &regression[..]].concat();
    let [hidden, seen] = [false, true].map(|seen| rms(&target, seen));
    assert!(hidden < 0.02 && seen < 0.006, "{hidden}, {seen}");
}
