//! Habits of a terminal: several scenes, standard input, a project file, completions, manual pages, colour.

use crate::support::{ambake, files, report, run, run_well, scene};
use std::fs;
use std::io::{Read, Write};
use std::process::Stdio;

const SMALL: [&str; 5] = ["--size", "32", "--rays", "1", "-q"];

#[test]
fn several_scenes_take_a_folder_each_and_one_failure_spoils_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out").display().to_string();
    let [wall, plane] =
        ["wall_long.obj", "plane.obj"].map(|name| scene(name).display().to_string());
    let output = run([
        &["bake", &wall, "absent.obj", &plane, "-o", &out][..],
        &SMALL,
    ]
    .concat());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("absent.obj") && errors.contains("1 of 3 scenes"),
        "{errors}"
    );
    for stem in ["wall_long", "plane"] {
        let inside = files(&folder.path().join("out").join(stem));
        assert!(inside.contains(&format!("{stem}.0.exr")), "{inside:?}");
    }
    let twice = run([&["bake", &wall, &wall, "-o", &out][..], &SMALL].concat());
    assert_eq!(twice.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&twice.stderr).contains("one by one"));
}

#[test]
fn a_scene_comes_from_standard_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = |bytes: &[u8], out: &str| {
        let out = folder.path().join(out);
        let mut command = ambake();
        command
            .args(["bake", "-", "-o", &out.display().to_string()])
            .args(SMALL);
        command.stdin(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let mut pipe = child.stdin.take().expect("a pipe");
        pipe.write_all(bytes).expect("written");
        drop(pipe);
        child.wait_with_output().expect("it ends")
    };
    let text = fs::read(scene("wall_long.obj")).expect("the scene");
    assert!(bake(&text, "a").status.success());
    assert!(files(&folder.path().join("a")).contains(&"scene.0.exr".into()));
    let options = report(&folder.path().join("a"));
    assert_eq!(options["scene"]["format"], "obj");
    for (bytes, word) in [(&b""[..], "empty"), (b"{ \"asset\": 1", "standard input")] {
        let output = bake(bytes, "b");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.contains(word) && errors.lines().count() == 1,
            "{errors}"
        );
        assert!(!errors.contains("/scene."), "no temporary name: {errors}");
    }
}

#[test]
fn a_phase_that_takes_long_is_told_of_in_plain_lines() {
    let start = |words: &[&str]| {
        let mut command = ambake();
        command.args(["plan", "-"]).args(words);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        command.stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let mut children = [start(&[]), start(&["--quiet"])];
    // It reads until its input ends.
    std::thread::sleep(std::time::Duration::from_secs(12));
    let text = fs::read(scene("wall_long.obj")).expect("the scene");
    let [loud, quiet] = children.each_mut().map(|child| {
        let mut pipe = child.stdin.take().expect("a pipe");
        pipe.write_all(&text).expect("written");
        drop(pipe);
        let mut errors = String::new();
        let mut pipe = child.stderr.take().expect("a pipe");
        pipe.read_to_string(&mut errors).expect("text");
        assert!(child.wait().expect("it ends").success(), "{errors}");
        errors
    });
    let told = loud.lines().filter(|line| line.starts_with("reading, "));
    assert_eq!(told.count(), 1, "{loud}");
    assert!(!quiet.contains("reading"), "{quiet}");
}

#[test]
fn a_project_file_beside_the_scene_completes_what_is_typed() {
    let folder = tempfile::tempdir().expect("a folder");
    let wall = folder.path().join("wall.obj");
    fs::copy(scene("wall_long.obj"), &wall).expect("copied");
    let project = folder.path().join("ambake.toml");
    fs::write(
        &project,
        "[bake]\nsize = 16\nrays = 2\n[scene.\"wall.obj\"]\nsize = 64\n",
    )
    .expect("written");
    let [wall, out] = [wall, folder.path().join("out")].map(|path| path.display().to_string());
    run_well(["bake", &wall, "-o", &out, "-q"]);
    let options = report(&folder.path().join("out"))["options"].clone();
    assert_eq!(options["size"], 64, "{options}");
    assert!(options.to_string().contains("\"rays\":2"), "{options}");
    run_well(["bake", &wall, "-o", &out, "-q", "--size", "32"]);
    assert_eq!(report(&folder.path().join("out"))["options"]["size"], 32);
    for (text, word) in [
        ("[bake]\nsise = 1", "sise"),
        ("[bake\n", "line 1"),
        ("[bake]\nsize = -1", "--size"),
    ] {
        fs::write(&project, text).expect("written");
        let output = run(["plan", &wall]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.contains("ambake.toml") && errors.contains(word),
            "{errors}"
        );
        assert_eq!(errors.lines().count(), 1, "{errors}");
    }
}

#[test]
fn completions_and_manual_pages_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = run_well(["completions", shell]);
        assert!(
            text.contains("view") && text.contains("target-error"),
            "{shell}"
        );
    }
    assert!(run_well(["man"]).contains(".TH ambake 1"));
    let folder = tempfile::tempdir().expect("a folder");
    let pages = folder.path().join("man").display().to_string();
    run_well(["man", "-o", &pages]);
    let pages = files(&folder.path().join("man"));
    for page in [
        "ambake.1",
        "ambake-bake.1",
        "ambake-map-convert.1",
        "ambake-view.1",
    ] {
        assert!(pages.contains(&page.into()), "{pages:?}");
    }
}

#[test]
fn no_colour_where_none_is_wanted() {
    let mut command = ambake();
    let output = command
        .args(["bake", "--help"])
        .env("NO_COLOR", "1")
        .env("CLICOLOR_FORCE", "0")
        .output();
    let output = output.expect("it runs");
    assert!(!output.stdout.contains(&0x1b));
}
