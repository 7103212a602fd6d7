//! What a bake writes and what it must never touch.

use crate::support::{bake, files, report, run, run_well, scene};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A copy of an authored glTF scene in a folder of its own, with the files that it names.
fn copied(names: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary directory");
    for name in names {
        fs::copy(scene(name), folder.path().join(name)).expect("an authored file");
    }
    let first = folder.path().join(names[0]);
    (folder, first)
}

/// Runs a command that must be refused because of `input`, and checks that the input is as before.
fn refused(arguments: &[&str], input: &Path) {
    let before = fs::read(input).expect("the input is there");
    let output = run(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    let name = input.file_name().expect("a file").to_string_lossy();
    assert!(
        errors.contains(&*name) && errors.contains("is an input") && errors.contains("-o"),
        "{errors}"
    );
    assert!(
        fs::read(input).expect("still there") == before,
        "{name} was changed"
    );
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

#[test]
fn a_bake_never_replaces_its_scene() {
    let first = tempfile::tempdir().expect("a temporary directory");
    run_well([
        "bake",
        text(&scene("instances.gltf")),
        "-o",
        text(first.path()),
        "--size=64",
        "--rays=4",
        "--quiet",
    ]);
    // The GLB that ambake wrote, baked again into its own folder.
    let glb = first.path().join("instances.glb");
    let listed = files(first.path());
    let place = text(first.path());
    refused(
        &["bake", text(&glb), "-o", place, "--size=64", "--rays=4"],
        &glb,
    );
    assert_eq!(files(first.path()), listed, "nothing else was written");
}

#[test]
fn a_bake_never_replaces_a_texture_or_a_sky() {
    // A texture called as the preview of a layer will be, or as a scene that an engine loads.
    for name in ["masked_card.0.diffuse.png", "masked_card.lightmap.glb"] {
        let (folder, gltf) = copied(&["masked_card.gltf", "masked_card.png"]);
        let picture = folder.path().join(name);
        fs::rename(folder.path().join("masked_card.png"), &picture).expect("renamed");
        let json = fs::read_to_string(&gltf).expect("JSON");
        fs::write(&gltf, json.replace("masked_card.png", name)).expect("written");
        let words = ["--size=64", "--rays=4", "--for=gltf"];
        let place = ["bake", text(&gltf), "-o", text(folder.path())];
        refused(&[&place[..], &words].concat(), &picture);
    }

    let folder = tempfile::tempdir().expect("a temporary directory");
    let sky = folder.path().join("plane.0.exr");
    run_well([
        "map",
        "convert",
        text(&scene("sky.hdr")),
        "-o",
        text(&sky),
        "--to=polar",
        "--quiet",
    ]);
    refused(
        &[
            "bake",
            text(&scene("plane.obj")),
            "-o",
            text(folder.path()),
            "--size=32",
            "--rays=4",
            "--sky",
            text(&sky),
        ],
        &sky,
    );
}

#[test]
fn pictures_and_maps_never_replace_what_they_are_made_from() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let map = folder.path().join("sky.hdr");
    fs::copy(scene("sky.hdr"), &map).expect("copied");
    refused(
        &["map", "convert", text(&map), "-o", text(&map), "--to=polar"],
        &map,
    );
    let (_folder, gltf) = copied(&["masked_card.gltf", "masked_card.png"]);
    let texture = gltf.with_extension("png");
    refused(
        &[
            "render",
            text(&gltf),
            "-o",
            text(&texture),
            "--rays=1",
            "--samples=1",
            "--size=8x8",
        ],
        &texture,
    );
}

#[test]
fn a_picture_never_replaces_its_weights_or_the_pages_of_its_bake() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let weights = folder.path().join("weights.exr");
    let ball = scene("ball.obj");
    fs::write(&weights, "0 1\n1 0.5\n").expect("written");
    let sky = scene("sky.hdr");
    let mirror = ["--shader=mirror", "--environment", text(&sky)];
    for weight in ["--diffuse-weight", "--specular-weight"] {
        let picture = ["render", text(&ball), "-o", text(&weights), "--size=8x8"];
        refused(
            &[&picture[..], &mirror, &[weight, text(&weights)]].concat(),
            &weights,
        );
    }
    let (folder, _) = bake(&ball, &["--size=64", "--rays=4"]);
    let page = folder.path().join("ball.0.exr");
    refused(
        &[
            "render",
            text(&ball),
            "-o",
            text(&page),
            "--bake",
            text(folder.path()),
            "--size=8x8",
            "--samples=1",
        ],
        &page,
    );
}

#[test]
fn a_rebake_removes_what_the_earlier_one_listed_and_keeps_the_rest() {
    let (folder, _) = bake(
        &scene("plane.obj"),
        &["--size=32", "--rays=4", "--layers=bent,validity"],
    );
    fs::write(folder.path().join("notes.txt"), b"mine").expect("written");
    fs::write(folder.path().join("plane.0.mine.png"), b"mine").expect("written");
    let place = text(folder.path()).to_owned();
    let plane = scene("plane.obj");
    let again = [
        "bake",
        text(&plane),
        "-o",
        &place,
        "--size=32",
        "--rays=4",
        "--quiet",
    ];
    run_well(again);
    let names = files(folder.path());
    for gone in ["plane.0.bent.png", "plane.0.validity.png"] {
        assert!(!names.contains(&gone.to_owned()), "{gone} is a leftover");
    }
    for kept in [
        "notes.txt",
        "plane.0.mine.png",
        "plane.0.diffuse.png",
        "plane.glb",
    ] {
        assert!(
            names.contains(&kept.to_owned()),
            "{kept} is gone: {names:?}"
        );
    }
    let listed = report(folder.path())["files"]
        .as_array()
        .expect("files")
        .len();
    assert_eq!(listed + 2, names.len(), "{names:?}");
}

/// Bakes a scene small into a folder.
fn bake_into(folder: &Path, scene: &Path, more: &[&str]) {
    let words = ["bake", text(scene), "-o", text(folder)];
    let small = ["--size=32", "--rays=4", "--quiet"];
    run_well([&words[..], &small, more].concat());
}

/// What every file of a folder holds, by its name.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |name: &String| fs::read(folder.join(name)).expect("a file");
    let names = files(folder).into_iter();
    names.map(|name| (name.clone(), read(&name))).collect()
}

#[test]
fn scenes_that_share_a_folder_cost_each_other_nothing() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let folder = folder.path();
    let (plane, corner) = (scene("plane.obj"), scene("corner.obj"));
    bake_into(folder, &plane, &["--layers=bent"]);
    let of_plane = contents(folder);
    assert!(!of_plane.contains_key("plane.bake.json"), "it is alone");
    bake_into(folder, &corner, &["--layers=validity"]);
    let both = contents(folder);
    for (name, bytes) in &of_plane {
        let own = if name == "bake.json" {
            "plane.bake.json"
        } else {
            name
        };
        assert!(both.get(own) == Some(bytes), "{name} of the first scene");
    }
    assert_eq!(both["bake.json"], both["corner.bake.json"]);
    // Each removes leftovers of its own, whichever was baked last.
    bake_into(folder, &plane, &[]);
    let again = contents(folder);
    let gone: Vec<&String> = both
        .keys()
        .filter(|name| !again.contains_key(*name))
        .collect();
    assert_eq!(gone, ["plane.0.bent.png"]);
    for (name, bytes) in both.iter().filter(|(name, _)| name.starts_with("corner")) {
        assert!(again.get(name) == Some(bytes), "{name} of the second scene");
    }
    assert_eq!(again["bake.json"], again["plane.bake.json"]);
    assert!(report(folder)["scene"]["path"] == text(&plane));
    bake_into(
        folder,
        &corner,
        &["--layers=validity", "--update", text(folder)],
    );
    let update = report(folder)["update"].clone();
    assert_eq!(update["share"], 0.0, "its own state: {update}");
    bake_into(folder, &corner, &[]);
    let gone: Vec<String> = again
        .into_keys()
        .filter(|name| !files(folder).contains(name))
        .collect();
    assert_eq!(gone, ["corner.0.validity.png"]);
}

#[test]
fn a_scene_of_the_same_name_in_another_file_removes_nothing() {
    let (folder, first) = copied(&["plane.obj"]);
    let out = folder.path().join("out");
    bake_into(&out, &first, &["--layers=bent"]);
    let second = out.join("again").join("plane.obj");
    fs::create_dir(out.join("again")).expect("a folder");
    fs::copy(&first, &second).expect("copied");
    bake_into(&out, &second, &[]);
    assert!(out.join("plane.0.bent.png").exists());
    // It is the same file where the whole project has moved.
    bake_into(&out, &first, &["--layers=bent"]);
    let elsewhere = tempfile::tempdir().expect("a temporary directory");
    let moved = elsewhere.path().join("project");
    fs::rename(folder.path(), &moved).expect("renamed");
    bake_into(&moved.join("out"), &moved.join("plane.obj"), &[]);
    assert!(!moved.join("out/plane.0.bent.png").exists());
}

#[test]
fn whoever_reads_a_folder_of_two_bakes_is_told() {
    let plane = scene("plane.obj");
    let [old, new] = [(); 2].map(|()| tempfile::tempdir().expect("a temporary directory"));
    let small = ["--size=32", "--quiet"];
    for (folder, rays) in [(&old, "--rays=4"), (&new, "--rays=8")] {
        let words = ["bake", text(&plane), "-o", text(folder.path()), rays];
        run_well([&words[..], &small].concat());
    }
    let picture = new.path().join("picture.png");
    let dir = text(old.path());
    let render = ["render", text(&plane), "-o", text(&picture), "--bake", dir];
    let readers = [
        vec!["export", dir, "--for", "gltf"],
        vec!["compare", dir],
        vec!["view", dir, "--no-open"],
        [&render[..], &["--size=8x8", "--samples=1"]].concat(),
    ];
    // As a kill between two renames leaves it: the page is new, the report is old.
    let page = "plane.0.exr";
    let first = fs::read(old.path().join(page)).expect("a page");
    fs::copy(new.path().join(page), old.path().join(page)).expect("copied");
    for words in &readers {
        let output = run(words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{words:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{words:?}: {said}");
        let names = said.contains(page) && said.contains("an option differs; bake again");
        assert!(names, "{words:?}: {said}");
    }
    fs::write(old.path().join(page), first).expect("written");
    for words in &readers {
        run_well(words);
    }
}

#[test]
fn a_rebake_keeps_what_was_edited_since() {
    let (folder, _) = bake(
        &scene("plane.obj"),
        &["--size=32", "--rays=4", "--layers=bent,validity"],
    );
    let edited = folder.path().join("plane.0.bent.png");
    fs::write(&edited, b"mine").expect("written");
    bake_into(folder.path(), &scene("plane.obj"), &[]);
    assert_eq!(fs::read(&edited).expect("it is there"), b"mine");
    assert!(!folder.path().join("plane.0.validity.png").exists());
}

#[cfg(unix)]
#[test]
fn a_report_is_no_list_of_files_to_delete() {
    let (folder, file) = copied(&["plane.obj", "masked_card.gltf", "masked_card.png"]);
    let dir = folder.path();
    let outside = tempfile::tempdir().expect("a temporary directory");
    for name in [
        "thesis.txt",
        ".profile",
        "plane.txt",
        "plane.0.txt",
        "plane.0.0.exr",
        "plane.0.bent.png.txt",
        "corner.0.bent.png",
    ] {
        fs::write(dir.join(name), name).expect("written");
    }
    fs::create_dir(dir.join("sub")).expect("a folder");
    fs::write(dir.join("sub/plane.0.bent.png"), "mine").expect("written");
    fs::write(outside.path().join("mine"), "mine").expect("written");
    let link = dir.join("plane.0.validity.png");
    std::os::unix::fs::symlink(outside.path().join("mine"), &link).expect("a link");
    bake_into(dir, &file, &[]);
    let before = files(dir);
    let mut forged = report(dir);
    let outside = outside.path().join("mine");
    let others = [
        "sub/plane.0.bent.png",
        "./thesis.txt",
        "sub",
        text(&outside),
        "..",
        "",
    ];
    for name in before.iter().map(String::as_str).chain(others) {
        forged["files"]
            .as_array_mut()
            .expect("a list")
            .push(name.into());
        let bytes = fs::read(dir.join(name)).unwrap_or_default();
        forged["hashes"][name] = blake3::hash(&bytes).to_hex().as_str().into();
    }
    fs::write(dir.join("bake.json"), forged.to_string()).expect("written");
    bake_into(dir, &file, &[]);
    assert_eq!(files(dir), before);
    assert!(dir.join("sub/plane.0.bent.png").exists() && outside.exists());
}

#[test]
fn every_layer_that_is_asked_for_has_its_preview_and_its_line_of_help() {
    // Each model has layers that the other has not.
    let is_ggx = |layer: &layers::Layer| matches!(layer, layers::Layer::Ggx | layers::Layer::Base);
    let (ggx, phong): (Vec<_>, Vec<_>) = layers::Layer::all().partition(is_ggx);
    for (model, layers) in [("phong", phong), ("ggx", ggx)] {
        let names: Vec<&str> = layers.iter().map(|layer| layer.name()).collect();
        #[rustfmt::skip]
        let arguments = ["--size=32", "--rays=4", "--model", model, "--layers", &names.join(",")];
        let (folder, page) = bake(&scene("plane.obj"), &arguments);
        let there = files(folder.path());
        for layer in layers {
            let name = layer.name();
            let preview = there.contains(&format!("plane.0.{name}.png"));
            let wanted = layer.preview() != layers::Preview::None;
            assert_eq!(preview, wanted, "preview of {name}");
            let stored = match layer {
                layers::Layer::AnyView4 => layers::Layer::AnyView,
                layer => layer,
            };
            for channel in 0..stored.channels().len() {
                page.plane(&stored.channel_name(channel));
            }
        }
    }
    let names = layers::Layer::all().map(layers::Layer::name);
    let help = run_well(["bake", "--help"]);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for name in names {
        assert!(help.contains(name), "--help does not name {name}");
    }
}

#[test]
fn one_layer_alone_still_gives_the_scene_with_its_lightmap_coordinates() {
    let (folder, page) = bake(
        &scene("plane.obj"),
        &["--size=32", "--rays=4", "--only=lambert"],
    );
    assert_eq!(
        page.names(),
        ["coverage", "lambert.B", "lambert.G", "lambert.R"]
    );
    let glb = fs::read(folder.path().join("plane.glb")).expect("a GLB is written");
    let json = String::from_utf8_lossy(&glb);
    assert!(json.contains("TEXCOORD_1"), "lightmap coordinates");
    assert!(
        !json.contains("occlusionTexture"),
        "no diffuse term was baked"
    );
}

#[test]
fn an_option_that_changes_the_values_is_never_resumed() {
    let described = ambake::Options::default().describe();
    let keys: Vec<&String> = described.as_object().expect("an object").keys().collect();
    assert!(keys.len() >= 17, "{keys:?}");
    let (folder, _) = bake(&scene("plane.obj"), &["--size=32", "--rays=4"]);
    let options = report(folder.path())["options"].clone();
    for key in keys {
        assert!(options.get(key).is_some(), "bake.json does not name {key}");
    }
}

#[test]
fn a_mesh_without_material_stays_white_when_its_glb_is_baked_again() {
    let options = ["--size=32", "--rays=4"];
    let (first, _) = bake(&scene("masked_card.gltf"), &options);
    // glTF's own default material, which the file names nowhere, would make the floor a metal: its albedo is black.
    let (_again, page) = bake(&first.path().join("masked_card.glb"), &options);
    let (diffuse, lit) = (page.plane("diffuse"), page.plane("lambert.R"));
    let white = diffuse.iter().zip(lit).filter(|(d, l)| **d > 0.5 && d == l);
    assert!(white.count() > 200, "no white floor");
}
