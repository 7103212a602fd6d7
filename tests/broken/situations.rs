//! Sound files in hopeless situations, and command lines that are wrong.

use super::{Case, refuse_all};
use crate::support::{files, run_well, scene};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const STACKED: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 2/2 4/3\n";

fn case(what: &'static str, arguments: &[&'static str], status: i32, names: &'static str) -> Case {
    let files = vec![
        ("a.obj", TRIANGLE.into()),
        ("stacked.obj", STACKED.into()),
        ("wall", b"a file".to_vec()),
    ];
    Case {
        what,
        files,
        arguments: arguments.to_vec(),
        status,
        names,
    }
}

#[test]
fn hopeless_situations_are_refused() {
    refuse_all(&[
        case(
            "a scene that is not there",
            &["bake", "@gone.obj"],
            1,
            "gone.obj",
        ),
        case("a directory for a scene", &["bake", "@."], 1, "ambake: "),
        case("an ending nobody reads", &["bake", "wall"], 1, "wall"),
        case(
            "a file where DIR should be",
            &["bake", "a.obj", "-o", "@wall"],
            1,
            "wall",
        ),
        case(
            "DIR below a file",
            &["bake", "a.obj", "-o", "@wall/out"],
            1,
            "wall",
        ),
        case(
            "--uv keep without UVs",
            &["bake", "a.obj", "--uv", "keep"],
            1,
            "a.obj",
        ),
        case(
            "--uv keep with UVs that overlap",
            &["bake", "stacked.obj", "--uv", "keep"],
            1,
            "stacked.obj",
        ),
        case(
            "a density beyond all pages",
            &["bake", "a.obj", "--density", "1e9"],
            1,
            "density",
        ),
        case(
            "plan of a scene that is not there",
            &["plan", "@gone.obj"],
            1,
            "gone.obj",
        ),
        case("compare of nothing", &["compare", "@gone"], 1, "gone"),
        case(
            "compare of a directory without a bake",
            &["compare", "@."],
            1,
            "bake.json",
        ),
        case(
            "compare of files that are no pages",
            &["compare", "wall", "a.obj"],
            1,
            "wall",
        ),
    ]);
}

#[test]
fn directories_named_like_scenes_are_refused() {
    for name in ["folder.obj", "folder.gltf", "folder.glb"] {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let path = folder.path().join(name);
        std::fs::create_dir(&path).expect("the folder is writable");
        let output = crate::support::run([
            &"bake".into(),
            &path,
            &"-o".into(),
            &folder.path().join("out"),
        ]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.starts_with("ambake: ") && errors.contains(name) && errors.lines().count() == 1,
            "{errors}"
        );
    }
}

#[test]
fn wrong_command_lines_end_with_status_2() {
    let wrong = |what, arguments: &[&'static str], names| {
        let mut all = vec!["bake", "a.obj", "-o", "@out"];
        all.extend(arguments);
        case(what, &all, 2, names)
    };
    refuse_all(&[
        case("no verb", &["--quiet"], 2, "ambake"),
        case("an unknown verb", &["cook", "a.obj"], 2, "cook"),
        case("no scene", &["plan"], 2, "SCENE"),
        wrong("an unknown flag", &["--fast"], "--fast"),
        wrong("rays in words", &["--rays", "many"], "many"),
        wrong("negative rays", &["--rays", "-5"], "-5"),
        wrong("no rays", &["--rays", "0"], "--rays"),
        wrong("a size of 0", &["--size", "0"], "--size"),
        wrong("an absurd size", &["--size", "1000000000"], "--size"),
        wrong(
            "a density that is not a number",
            &["--density", "NaN"],
            "--density",
        ),
        wrong("a negative density", &["--density=-1"], "--density"),
        wrong("a negative exponent", &["--exponent=-1"], "--exponent"),
        wrong("an absurd exponent", &["--exponent", "1e9"], "--exponent"),
        wrong("a sky of two numbers", &["--sky", "1,1"], "--sky"),
        wrong("an infinite sky", &["--sky", "1,1,inf"], "--sky"),
        wrong(
            "a sky that 32 bits do not hold",
            &["--sky", "1e39,1,1"],
            "at most 3.4e38",
        ),
        wrong("a view in words", &["--view", "above"], "--view"),
        wrong("an unknown layer", &["--layers", "diffuse,shiny"], "shiny"),
        wrong("an unknown backend", &["--backend", "voxels"], "voxels"),
        wrong("an unknown way with UVs", &["--uv", "perhaps"], "perhaps"),
        wrong("no threads", &["--threads", "0"], "--threads"),
        wrong("a negative seed", &["--seed=-1"], "--seed"),
        wrong(
            "a negative distance",
            &["--max-distance=-2"],
            "--max-distance",
        ),
        wrong(
            "an unknown decision",
            &["--plan-off", "everything"],
            "everything",
        ),
    ]);
}

#[test]
fn a_bake_that_fails_leaves_good_output_alone() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let scene = scene("plane.obj");
    let arguments = |more: &[&str]| -> Vec<std::ffi::OsString> {
        let mut all: Vec<std::ffi::OsString> = vec!["bake".into(), scene.clone().into()];
        all.extend(["--size", "16", "--rays", "4", "--quiet", "-o"].map(Into::into));
        all.push(folder.path().into());
        all.extend(more.iter().map(Into::into));
        all
    };
    run_well(arguments(&[]));
    let bytes = || -> Vec<(String, Vec<u8>)> {
        let read = |name: String| {
            (
                name.clone(),
                std::fs::read(folder.path().join(&name)).expect("it is there"),
            )
        };
        files(folder.path()).into_iter().map(read).collect()
    };
    let before = bytes();
    assert!(before.len() >= 3, "{:?}", files(folder.path()));
    let output = crate::support::run(arguments(&["--density", "1e9"]));
    assert_eq!(
        output.status.code(),
        Some(1),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        before == bytes(),
        "a failed bake changed {:?}",
        files(folder.path())
    );
}
