//! A kill among the last renames of a bake: whoever reads the folder works with one bake or says that there are two.

use crate::support::{files, report, run, run_well};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a scene of a floor and boxes of these sizes on it into `folder`; returns its path.
fn write(folder: &Path, sizes: &[f32]) -> PathBuf {
    let mut text = String::from("o floor\nv 0 0 0\nv 0 0 4\nv 9 0 4\nv 9 0 0\nf 1 2 3 4\n");
    for (number, size) in sizes.iter().enumerate() {
        writeln!(text, "o box{number}").expect("memory");
        for corner in 0..8u8 {
            let along = |bit: u8| f32::from(corner >> bit & 1) * size;
            let x = 3.0 * number as f32 + along(2);
            writeln!(text, "v {x} {} {}", 0.1 + along(1), 1.0 + along(0)).expect("memory");
        }
        for face in [
            "1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4",
        ] {
            let corners = face
                .split(' ')
                .map(|corner| corner.parse().expect("a number"));
            let corners: Vec<String> = corners
                .map(|corner: usize| (corner + 4 + 8 * number).to_string())
                .collect();
            writeln!(text, "f {}", corners.join(" ")).expect("memory");
        }
    }
    fs::create_dir_all(folder).expect("a folder");
    let path = folder.join("boxes.obj");
    fs::write(&path, text).expect("a file");
    path
}

fn bake(scene: &Path, folder: &Path, more: &[&str]) {
    let own = [
        "bake",
        text(scene),
        "-o",
        text(folder),
        "--size=48",
        "--quiet",
    ];
    run_well([&own[..], more].concat());
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

fn copy(from: &Path, names: &[String], to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for name in names {
        fs::copy(from.join(name), to.join(name)).expect("copied");
    }
}

/// What a reader makes of `folder`: the files of that many whose names end so, or the line that it ends with.
fn made(words: &[&str], folder: &Path, endings: &[&str]) -> Result<Vec<Vec<u8>>, String> {
    let output = run(words);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if !output.status.success() {
        assert_eq!(output.status.code(), Some(1), "{words:?}: {said}");
        return Err(said);
    }
    let names = files(folder).into_iter();
    let names = names.filter(|name| endings.iter().any(|ending| name.ends_with(ending)));
    let made: Vec<_> = names
        .map(|name| fs::read(folder.join(name)).expect("a file"))
        .collect();
    assert!(!made.is_empty(), "{words:?} made nothing");
    Ok(made)
}

/// What every reader makes of `folder`, each of a copy of its own.
fn read_by_all(scene: &Path, folder: &Path) -> Vec<Result<Vec<Vec<u8>>, String>> {
    let place = tempfile::tempdir().expect("a temporary directory");
    let copy_for = |reader: &str| {
        let path = place.path().join(reader);
        copy(folder, &files(folder), &path);
        path
    };
    let [export, compare, view, render, update] =
        ["export", "compare", "view", "render", "update"].map(copy_for);
    let picture = render.join("picture.exr");
    let updated = place.path().join("updated");
    let drawn = [
        "render",
        text(scene),
        "-o",
        text(&picture),
        "--bake",
        text(&render),
        "--size=8x8",
        "--samples=1",
    ];
    let again = [
        "bake",
        text(scene),
        "-o",
        text(&updated),
        "--update",
        text(&update),
        "--quiet",
    ];
    vec![
        made(
            &["export", text(&export), "--for=gltf"],
            &export,
            &[".lightmap.glb"],
        ),
        made(
            &["compare", text(&compare)],
            &compare,
            &[".difference.traditional-lambert.png"],
        ),
        made(&["view", text(&view), "--no-open"], &view, &["report.html"]),
        made(&drawn, &render, &["picture.exr"]),
        made(
            &[&again[..], &["--size=48", "--rays=2"]].concat(),
            &updated,
            &[".exr", ".glb"],
        ),
    ]
}

/// Checks every state that a kill can leave of a publication of what is in `new` over what is in `old`, both bakes
/// of `scene`.
fn check(scene: &Path, old: &Path, new: &Path) {
    let [before, after] = [old, new].map(|folder| read_by_all(scene, folder));
    assert!(before.iter().chain(&after).all(Result::is_ok), "{before:?}");
    let names = report(new)["files"].as_array().expect("a list").clone();
    let names: Vec<String> = names
        .iter()
        .map(|name| name.as_str().expect("a name").into())
        .collect();
    assert_eq!(names.last().map(String::as_str), Some("bake.json"));
    let mut refused = 0;
    for renamed in 1..names.len() {
        let mixed = tempfile::tempdir().expect("a temporary directory");
        copy(old, &files(old), mixed.path());
        copy(new, &names[..renamed], mixed.path());
        let now = read_by_all(scene, mixed.path());
        for (reader, now) in now.iter().enumerate() {
            let at = format!("reader {reader} after {}", names[renamed - 1]);
            match now {
                Ok(made) => assert!(
                    before[reader].as_ref() == Ok(made) || after[reader].as_ref() == Ok(made),
                    "{at}: neither bake"
                ),
                Err(said) => {
                    assert_eq!(said.lines().count(), 1, "{at}: {said}");
                    assert!(said.contains("of another bake"), "{at}: {said}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 0, "the bakes do not differ");
}

#[test]
fn a_kill_among_the_renames_of_a_bake_with_other_options_is_told() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let at = |name: &str| folder.path().join(name);
    let scene = write(&at("scene"), &[1.0, 2.0]);
    bake(&scene, &at("old"), &["--rays=1"]);
    bake(&scene, &at("new"), &["--rays=2", "--pages=2"]);
    check(&scene, &at("old"), &at("new"));
}

#[test]
fn a_kill_among_the_renames_of_a_bake_with_another_layout_is_told() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let at = |name: &str| folder.path().join(name);
    let first = write(&at("first"), &[1.0]);
    bake(&first, &at("earlier"), &["--rays=2", "--density=3"]);
    let scene = write(&at("scene"), &[1.0, 2.0]);
    bake(&scene, &at("old"), &["--rays=2", "--density=3"]);
    // Of the same scene with the same options, laid out around what an earlier bake had.
    let earlier = at("earlier");
    let update = ["--rays=2", "--density=3", "--update", text(&earlier)];
    bake(&scene, &at("new"), &update);
    check(&scene, &at("old"), &at("new"));
}
