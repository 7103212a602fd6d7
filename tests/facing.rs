//! Faces that look into their own object while their backs are in the open: they are dark, and a line says so.

use crate::support::{BOX_SIDES, bake, report, run_well};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Writes boxes of glTF, drawn from one side, of which these sides look inward.
fn boxes(folder: &Path, inward: &[usize]) -> PathBuf {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1f32 } else { -1.0 });
    let corners: Vec<u8> = (0..8).flat_map(corner).flat_map(f32::to_le_bytes).collect();
    let sides = BOX_SIDES.iter().enumerate().flat_map(|(number, side)| {
        let [a, b, c, d] = match inward.contains(&number) {
            true => [side[3], side[2], side[1], side[0]],
            false => *side,
        };
        [a, b, c, a, c, d]
    });
    let indices: Vec<u8> = sides.flat_map(u32::to_le_bytes).collect();
    let text = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "box"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5125, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": corners.len()},
            {"buffer": 0, "byteOffset": corners.len(), "byteLength": indices.len()},
        ],
        "buffers": [{"uri": "box.bin", "byteLength": corners.len() + indices.len()}],
    });
    std::fs::write(folder.join("box.bin"), [corners, indices].concat()).expect("a file");
    let path = folder.join("box.gltf");
    std::fs::write(&path, text.to_string()).expect("a file");
    path
}

#[test]
fn a_side_of_a_box_that_looks_into_it_is_told_of() {
    for (inward, expected) in [(&[][..], 0.0), (&[2], 1.0 / 6.0), (&[5], 1.0 / 6.0)] {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, out) = (boxes(folder.path(), inward), folder.path().join("out"));
        let words = [
            "bake",
            "-o",
            "--size=64",
            "--rays=4",
            "--only=diffuse",
            "--quiet",
        ];
        let mut words: Vec<&std::ffi::OsStr> = words.iter().map(|word| word.as_ref()).collect();
        words.insert(2, out.as_os_str());
        words.insert(1, scene.as_os_str());
        run_well(words);
        let report = report(&out);
        let warnings = report["warnings"].as_array().expect("a list");
        let told = warnings.iter().find(|of| of["kind"] == "faces-away");
        assert_eq!(told.is_some(), expected > 0.0, "{inward:?}: {warnings:?}");
        if let Some(told) = told {
            assert_eq!(told["place"], "object `box / mesh 0 primitive 0`");
            let texels = report["pages"][0]["texels"].as_f64().expect("a number");
            let share = told["count"].as_f64().expect("a number") / texels;
            assert!((share - expected).abs() < 0.04, "{inward:?}: {share}");
        }
    }
}

/// Writes a box in a box that looks inward, so many times as large, as toon shading draws an outline, both drawn from
/// one side.
fn outlined(folder: &Path, scale: f64) -> PathBuf {
    let path = boxes(folder, &[]);
    let text = std::fs::read_to_string(&path).expect("a file");
    let mut scene: Value = serde_json::from_str(&text).expect("JSON");
    let shell = folder.join("shell");
    std::fs::create_dir(&shell).expect("a folder");
    boxes(&shell, &[0, 1, 2, 3, 4, 5]);
    let mut add = |list: &str, to: &dyn Fn(&mut Value)| {
        let list = scene[list].as_array_mut().expect("a list");
        for mut item in list.clone() {
            to(&mut item);
            list.push(item);
        }
    };
    add("buffers", &|of| of["uri"] = json!("shell/box.bin"));
    add("bufferViews", &|of| of["buffer"] = json!(1));
    add("accessors", &|of| {
        of["bufferView"] = json!(2 + of["bufferView"].as_u64().expect("a number"));
    });
    add("meshes", &|of| {
        of["primitives"][0] = json!({"attributes": {"POSITION": 2}, "indices": 3, "material": 0});
    });
    let size = [scale; 3];
    add("nodes", &|of| {
        *of = json!({"mesh": 1, "name": "outline", "scale": size});
    });
    scene["scenes"][0]["nodes"] = json!([0, 1]);
    std::fs::write(&path, scene.to_string()).expect("a file");
    path
}

#[test]
fn an_outline_around_an_object_is_told_of_with_flags_that_let_the_light_in() {
    let flags = ["--no-cast=outline", "--exclude=outline"];
    for (scale, more, told_of, light) in [
        (1.03, &[][..], true, 0.0),
        (1.03, &flags, false, 1.0),
        (3.0, &[], false, 0.0),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = outlined(folder.path(), scale);
        let words = ["--size=128", "--rays=4", "--only=diffuse,object"];
        let (out, page) = bake(&scene, &[&words, more].concat());
        let report = report(out.path());
        let warnings = report["warnings"].as_array().expect("a list");
        let told = warnings.iter().find(|of| of["kind"] == "outlines");
        assert_eq!(told.is_some(), told_of, "{scale} {more:?}: {warnings:?}");
        if let Some(told) = told {
            assert_eq!(told["place"], "object `outline`");
            let line = told["message"].as_str().expect("a text");
            let cure = "`--no-cast outline --exclude outline`";
            assert!(
                line.contains("object `box`") && line.contains(cure),
                "{line}"
            );
        }
        for texel in 0..page.plane("object").len() {
            if page.plane("coverage")[texel] > 0.0 && page.plane("object")[texel] == 0.0 {
                assert_eq!(page.plane("diffuse")[texel], light, "{scale} {more:?}");
            }
        }
    }
}

/// Writes a shed of sheets as an OBJ file: four walls and a floor, and a roof of two slopes that reaches over them, in
/// an object of its own or with the walls. What of it looks inward is given.
fn shed(folder: &Path, walls_in: bool, roof_in: bool, apart: bool) -> PathBuf {
    let mut text = String::new();
    for [x, y, z] in [
        [-2.0, 0.0, -2.0],
        [2.0, 0.0, -2.0],
        [2.0, 0.0, 2.0],
        [-2.0, 0.0, 2.0],
        [-2.0, 2.0, -2.0],
        [2.0, 2.0, -2.0],
        [2.0, 2.0, 2.0],
        [-2.0, 2.0, 2.0],
        [-2.3, 1.7, -2.3],
        [2.3, 1.7, -2.3],
        [2.3, 3.2, 0.0],
        [-2.3, 3.2, 0.0],
        [2.3, 1.7, 2.3],
        [-2.3, 1.7, 2.3],
    ] {
        text += &format!("v {x} {y} {z}\n");
    }
    let mut faces = |faces: &[[u32; 4]], turned: bool| {
        for face in faces {
            let [a, b, c, d] = face.map(|corner| corner.to_string());
            let corners = if turned { [d, c, b, a] } else { [a, b, c, d] };
            text += &format!("f {}\n", corners.join(" "));
        }
    };
    let walls = [
        [4, 3, 7, 8],
        [2, 1, 5, 6],
        [3, 2, 6, 7],
        [1, 4, 8, 5],
        [1, 2, 3, 4],
    ];
    faces(&walls, walls_in);
    let roof = [[12, 11, 10, 9], [14, 13, 11, 12]];
    let apart = if apart { "o roof\n" } else { "" };
    faces(&roof, roof_in);
    let (v, f) = text.split_at(text.find('f').expect("faces"));
    let second: usize = f.match_indices('\n').nth(4).expect("walls").0 + 1;
    let text = format!("{v}o walls\n{}{apart}{}", &f[..second], &f[second..]);
    let path = folder.join("shed.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn a_roof_of_sheets_that_looks_into_its_shed_is_told_of_and_a_room_is_not() {
    for (walls_in, roof_in, apart, expected) in [
        (false, false, false, None),
        (false, false, true, None),
        (true, true, false, None),
        (true, true, true, None),
        (false, true, false, Some("object `walls`")),
        (false, true, true, Some("object `roof`")),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = shed(folder.path(), walls_in, roof_in, apart);
        let (out, _) = bake(&file, &["--size=64", "--rays=4", "--only=diffuse"]);
        let report = report(out.path());
        let warnings = report["warnings"].as_array().expect("a list");
        let told = warnings.iter().find(|of| of["kind"] == "dark-sides");
        let place = told.map(|of| of["place"].as_str().expect("a name"));
        assert_eq!(place, expected, "{walls_in} {roof_in}: {warnings:?}");
    }
}

/// Writes a box as an OBJ file, with a normal for each side; those of these sides are turned round.
fn shaded(folder: &Path, turned: &[usize], lean: f32) -> PathBuf {
    let mut text = String::from("o box\n");
    for k in 0..8 {
        let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1 } else { -1 });
        text += &format!("v {} {} {}\n", at[0], at[1], at[2]);
    }
    for (number, side) in BOX_SIDES.iter().enumerate() {
        let out = side.map(|corner| [0, 1, 2].map(|axis| f32::from(corner >> axis & 1 == 1) - 0.5));
        let sign = if turned.contains(&number) { -lean } else { 1.0 };
        // The mean of the corners points out of the box; what is beside it leans along the side.
        let mean = [0, 1, 2].map(|axis| out.iter().map(|corner| corner[axis]).sum::<f32>() / 2.0);
        let along = (1.0 - sign * sign).max(0.0).sqrt();
        let beside = [mean[1], mean[2], mean[0]];
        let normal = [0, 1, 2].map(|axis| sign * mean[axis] + along * beside[axis]);
        text += &format!("vn {} {} {}\n", normal[0], normal[1], normal[2]);
        let corners = side.map(|corner| format!("{}//{}", corner + 1, number + 1));
        text += &format!("f {}\n", corners.join(" "));
    }
    let path = folder.join("shaded.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn a_box_in_the_open_is_light_whichever_way_normals_of_some_sides_point() {
    // Turned round, or perpendicular but for a rounding.
    for (turned, lean) in [
        (&[][..], 1.0),
        (&[1], 1.0),
        (&[0, 3], 1.0),
        (&[4], 1e-7),
        (&[4], -1e-7),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = shaded(folder.path(), turned, lean);
        let (out, page) = bake(&scene, &["--size=64", "--rays=16", "--only=diffuse"]);
        let covered = page.plane("diffuse").iter().zip(page.plane("coverage"));
        let covered = covered.filter(|(_, coverage)| **coverage > 0.0);
        let least = covered.map(|(diffuse, _)| *diffuse).fold(1.0, f32::min);
        assert!(least > 0.999, "{turned:?} {lean}: {least}");
        let report = report(out.path());
        let warnings = report["warnings"].as_array().expect("a list");
        let told = warnings.iter().any(|of| of["kind"] == "averse-normals");
        assert_eq!(
            told,
            !turned.is_empty() && lean > 0.0,
            "{turned:?} {lean}: {warnings:?}"
        );
    }
}

/// The mean of the diffuse term over the overhanging face of the ledge below, by a sum over its points and over
/// directions. Its shading normal, up, mirrored in the face is x; directions about that which point into the face are
/// mirrored in it too. The lower terrace alone stands before the face.
fn overhang() -> f64 {
    const POINTS: usize = 24;
    const RAYS: usize = 96;
    let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
    let half = 0.5f64.sqrt();
    let (mut open, mut all) = (0, 0);
    for (i, j) in (0..POINTS * POINTS).map(|k| (k / POINTS, k % POINTS)) {
        let [x, z] = [-0.6 * middle(i, POINTS), 4.0 * middle(j, POINTS) - 2.0];
        for (k, l) in (0..RAYS * RAYS).map(|k| (k / RAYS, k % RAYS)) {
            let (sine, turn) = (
                middle(k, RAYS).sqrt(),
                std::f64::consts::TAU * middle(l, RAYS),
            );
            let mut way = [
                (1.0 - sine * sine).sqrt(),
                sine * turn.cos(),
                sine * turn.sin(),
            ];
            let behind = half * (way[0] - way[1]);
            if behind < 0.0 {
                way[0] -= 2.0 * half * behind;
                way[1] += 2.0 * half * behind;
            }
            // A point of the face is as low as it lies to the left.
            let far = (-0.6 - x) / way[1];
            let [on_x, on_z] = [x + far * way[0], z + far * way[2]];
            let is_stopped = way[1] < 0.0 && (-0.6..=2.5).contains(&on_x) && on_z.abs() <= 2.0;
            open += u32::from(!is_stopped);
            all += 1;
        }
    }
    f64::from(open) / f64::from(all)
}

#[test]
fn an_overhang_of_a_smooth_ledge_is_baked_on_the_side_that_is_seen() {
    let mut text = String::from("o ledge\nvn 0 1 0\n");
    for [x, y] in [[-2.0, 0.0], [0.0, 0.0], [-0.6, -0.6], [2.5, -0.6]] {
        text += &format!("v {x} {y} -2\nv {x} {y} 2\n");
    }
    for k in [1, 3, 5] {
        text += &format!("f {}//1 {}//1 {}//1 {}//1\n", k, k + 1, k + 3, k + 2);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ledge.obj");
    std::fs::write(&path, text).expect("a file");
    let words = ["--size=128", "--layers=geometric", "--seams=off"];
    let (_out, page) = bake(&path, &words);
    let [across, down, value, coverage] =
        ["geometric.X", "geometric.Y", "diffuse", "coverage"].map(|layer| page.plane(layer));
    let (mut sum, mut area) = (0.0, 0.0);
    for k in (0..value.len()).filter(|&k| across[k].abs() > 0.7 && coverage[k] > 0.0) {
        assert!(
            across[k] > 0.0 && down[k] < 0.0,
            "{} {}",
            across[k],
            down[k]
        );
        sum += f64::from(value[k]) * f64::from(coverage[k]);
        area += f64::from(coverage[k]);
    }
    let (found, expected) = (sum / area, overhang());
    assert!(area > 500.0, "{area}");
    // Its other side sees a few hundredths of the sky.
    assert!(
        (found / expected - 1.0).abs() < 0.02,
        "{found}, not {expected}"
    );
}
