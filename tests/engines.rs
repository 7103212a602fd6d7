//! `--for` and `export`: files that engines load, the same from both, and what `bake.json` says of them.

use crate::support::{Page, bake, files, report, run, run_well, scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

const ALL: &str = "gltf,three,blender,bevy,godot,unity,unreal";

/// A copy of an authored scene under a name with a space and a per cent sign.
pub fn named_oddly(name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("a room 50%.obj");
    fs::copy(scene(name), &path).expect("copied");
    (folder, path)
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

/// Files of two folders that differ, apart from `bake.json`.
fn differing(a: &Path, b: &Path) -> Vec<String> {
    let mut names = [files(a), files(b)].concat();
    names.sort();
    names.dedup();
    names.retain(|name| {
        let read = |folder: &Path| fs::read(folder.join(name)).ok();
        name != "bake.json" && read(a) != read(b)
    });
    names
}

#[test]
fn an_export_makes_the_files_of_the_bake_byte_for_byte() {
    let (_folder, room) = named_oddly("instances_twin.obj");
    let sky = scene("sky.hdr");
    for light in [
        &["--sky", "0.3,0.7,2", "--mips", "2"][..],
        &["--sky", text(&sky), "--density", "4"],
    ] {
        let options = [&["--size", "32", "--rays", "8"], light].concat();
        let (at_once, page) = bake(&room, &[&options[..], &["--for", ALL]].concat());
        let (later, _) = bake(&room, &options);
        run_well(["export", text(later.path()), "--for", ALL, "--quiet"]);
        assert_eq!(
            differing(at_once.path(), later.path()),
            Vec::<String>::new()
        );
        // Once more, for one engine: nothing else moves.
        let before = report(later.path());
        run_well(["export", text(later.path()), "--for", "three", "--quiet"]);
        assert_eq!(
            differing(at_once.path(), later.path()),
            Vec::<String>::new()
        );
        let [before, after] = [before, report(later.path())].map(|r| r["lightmaps"].clone());
        assert_eq!(
            before.as_array().map(Vec::len),
            after.as_array().map(Vec::len)
        );

        let bake_json = report(at_once.path());
        let listed = bake_json["files"].as_array().expect("a list");
        let maps = bake_json["lightmaps"].as_array().expect("a list");
        for name in ["a room 50%.lit.glb", "a room 50%.lightmap.glb"] {
            assert!(listed.iter().any(|file| *file == name), "{name}");
        }
        for (number, _) in bake_json["pages"]
            .as_array()
            .expect("pages")
            .iter()
            .enumerate()
        {
            for ending in [
                "lightmap.exr",
                "lightmap.hdr",
                "lightmap.ktx2",
                "ao.png",
                "ao8.png",
            ] {
                let name = format!("a room 50%.{number}.{ending}");
                assert!(listed.iter().any(|file| *file == *name), "{name}");
            }
            for engine in ALL.split(',') {
                let file = format!("a room 50%.{number}.lightmap.exr");
                let found = maps
                    .iter()
                    .find(|m| m["engine"] == engine && m["file"] == *file);
                let map = found.unwrap_or_else(|| panic!("{engine} has no {file}"));
                assert!(map["scale"].as_f64().is_some_and(|scale| scale >= 1.0));
                assert!(map["unit"].is_string() && map["use"].is_string());
            }
        }
        assert!(
            bake_json["pages"]
                .as_array()
                .is_some_and(|pages| pages.len() > 1 || light.contains(&"2"))
        );
        // The light is the bake's, rounded to half floats, without albedo.
        let lightmap = Page::read(&at_once.path().join("a room 50%.0.lightmap.exr"));
        assert_eq!(lightmap.names(), ["B", "G", "R"]);
        for (channel, c) in [("R", 0), ("G", 1), ("B", 2)] {
            let light = lightmap.plane(channel);
            for (i, coverage) in page.plane("coverage").iter().enumerate() {
                let expected = match page.names().contains(&"irradiance.R") {
                    true => page.plane(["irradiance.R", "irradiance.G", "irradiance.B"][c])[i],
                    false => page.plane("diffuse")[i] * [0.3, 0.7, 2.0][c],
                };
                let close = (light[i] - expected).abs() <= expected * 0.0005 + 1e-7;
                assert!(
                    *coverage == 0.0 || close,
                    "texel {i}: {} {expected}",
                    light[i]
                );
                assert!(light[i] > 0.0 || *coverage > 0.0, "texel {i} is void");
            }
        }
    }
}

#[test]
fn engine_files_that_a_rebake_does_not_make_go() {
    let (folder, _) = bake(
        &scene("plane.obj"),
        &["--size=16", "--rays=4", "--for", "three"],
    );
    assert!(folder.path().join("plane.0.lightmap.ktx2").exists());
    let place = text(folder.path()).to_owned();
    let plane = scene("plane.obj");
    let again = [
        "bake",
        text(&plane),
        "-o",
        &place,
        "--size=16",
        "--rays=4",
        "--quiet",
    ];
    run_well(again);
    let left: Vec<String> = files(folder.path());
    assert!(
        left.iter()
            .all(|name| !name.contains("lightmap") && !name.contains(".ao")),
        "{left:?}"
    );
    assert!(report(folder.path()).get("lightmaps").is_none());
}

#[test]
fn what_cannot_be_exported_is_said_in_one_line() {
    let empty = tempfile::tempdir().expect("a temporary directory");
    let (pure, _) = bake(
        &scene("plane.obj"),
        &["--size=16", "--rays=4", "--only", "visibility"],
    );
    let (bad, _) = bake(&scene("plane.obj"), &["--size=16", "--rays=4"]);
    fs::write(bad.path().join("plane.0.exr"), b"no picture").expect("written");
    for (folder, words) in [
        (empty.path(), ["bake.json", "finished bake"]),
        (pure.path(), ["plane.0.exr", "--layers diffuse"]),
        (bad.path(), ["plane.0.exr", "bake again"]),
    ] {
        let before = files(folder);
        let output = run(["export", text(folder), "--for", "bevy"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
        assert!(words.iter().all(|word| errors.contains(word)), "{errors}");
        assert_eq!(files(folder), before, "nothing is written");
    }
    for arguments in [&["export", "x", "--for", "quake"][..], &["export", "x"]] {
        assert_eq!(run(arguments).status.code(), Some(2));
    }
}

#[test]
fn what_bevy_loads_with_reads_the_files() {
    let plane = scene("plane.obj");
    let (folder, _) = bake(
        &plane,
        &[
            "--size=16",
            "--rays=4",
            "--mips=1",
            "--sky=2,1,0.5",
            "--for=bevy",
        ],
    );
    // The crate `image` reads OpenEXR by this call.
    let picture = exr::prelude::read_first_rgba_layer_from_file(
        folder.path().join("plane.0.lightmap.exr"),
        |size, _| vec![[0.0f32; 4]; size.area()],
        |pixels: &mut Vec<[f32; 4]>, at, (r, g, b, a): (f32, f32, f32, f32)| {
            pixels[at.1 * 16 + at.0] = [r, g, b, a];
        },
    );
    let pixels = picture
        .expect("channels R, G, B")
        .layer_data
        .channel_data
        .pixels;
    assert!(pixels.iter().all(|pixel| *pixel == [2.0, 1.0, 0.5, 1.0]));

    let bytes = fs::read(folder.path().join("plane.0.lightmap.ktx2")).expect("written");
    let container = ktx2::Reader::new(bytes).expect("a KTX2 container");
    let header = container.header();
    assert_eq!(header.format, Some(ktx2::Format::R16G16B16A16_SFLOAT));
    assert_eq!(
        (header.pixel_width, header.pixel_height, header.level_count),
        (16, 16, 2)
    );
    let lengths: Vec<usize> = container.levels().map(|level| level.data.len()).collect();
    assert_eq!(lengths, [16 * 16 * 8, 8 * 8 * 8]);
    assert_eq!(container.dfd_blocks().count(), 1);
}

#[test]
fn light_by_direction_gives_back_the_light_in_both_packings() {
    let plane = scene("plane.obj");
    let options = ["--size=16", "--rays=4", "--sky=2,1,0", "--layers=sh"];
    let (folder, _) = bake(&plane, &[&options[..], &["--for=godot,bevy"]].concat());
    let (later, _) = bake(&plane, &options);
    run_well(["export", text(later.path()), "--for=godot,bevy", "--quiet"]);
    assert_eq!(differing(folder.path(), later.path()), Vec::<String>::new());
    let maps = report(folder.path())["lightmaps"].clone();
    for (engine, file) in [("godot", "plane.0.sh.exr"), ("bevy", "plane.0.sh.ktx2")] {
        let named = |map: &&Value| map["engine"] == engine && map["file"] == file;
        assert!(
            maps.as_array()
                .is_some_and(|maps| maps.iter().any(|map| named(&map)))
        );
    }
    // An open plane that faces +y: E/pi of a normal n is (1 + n.y) / 2 of the sky.
    let picture = exr::prelude::read_first_rgba_layer_from_file(
        folder.path().join("plane.0.sh.exr"),
        |size, _| (size, vec![[0.0f32; 3]; size.area()]),
        |(size, pixels): &mut (exr::math::Vec2<usize>, Vec<[f32; 3]>),
         at,
         (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.1 * size.0 + at.0] = [r, g, b];
        },
    );
    let (size, pixels) = picture
        .expect("channels R, G, B")
        .layer_data
        .channel_data
        .pixels;
    assert_eq!((size.0, size.1), (16, 64), "four slices");
    let sky = [2.0, 1.0, 0.0];
    for n in [[0.0, 1.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, -1.0]] {
        for (c, sky) in sky.iter().enumerate() {
            let slice = |k: usize| pixels[16 * 16 * k + 40][c];
            let sides = (slice(1) - 0.5) * n[1] + (slice(2) - 0.5) * n[2] + (slice(3) - 0.5) * n[0];
            let found = slice(0) * (1.0 + 8.0 * sides);
            assert!(
                (found - sky * (1.0 + n[1]) / 2.0).abs() < 2e-3,
                "{n:?}: {found}"
            );
        }
    }
    let bytes = fs::read(folder.path().join("plane.0.sh.ktx2")).expect("written");
    let container = ktx2::Reader::new(bytes).expect("a KTX2 container");
    let header = container.header();
    assert_eq!((header.layer_count, header.level_count), (4, 1));
    let level = container.levels().next().expect("a level");
    assert_eq!(level.data.len(), 4 * 16 * 16 * 8);
    let number = |layer: usize, c: usize| {
        let at = (layer * 256 + 40) * 8 + 2 * c;
        exr::prelude::f16::from_le_bytes([level.data[at], level.data[at + 1]]).to_f32()
    };
    let layers: Vec<[f32; 3]> = (0..4).map(|k| [0, 1, 2].map(|c| number(k, c))).collect();
    assert_eq!(
        layers,
        [[1.0, 0.5, 0.0], [0.0; 3], [0.5, 0.25, 0.0], [0.0; 3]]
    );
}
