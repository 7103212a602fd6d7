//! Pipes and links in the place of files: refused in one line, where to open a pipe would be to wait for ever, and a
//! link would have another file overwritten.
#![cfg(unix)]

use crate::support::{ambake, ended, files, scene};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_pipe_in_the_place_of_a_file_of_the_output_folder_hangs_nothing() {
    let path = scene("plane.obj").display().to_string();
    let work = ["--size", "8", "--rays", "1", "--quiet", "-o"];
    for (name, words, status) in [
        ("plane.layout", &["bake"][..], 0),
        (".plane.ambake-resume", &["bake", "--resume"], 1),
        ("plane.1-of-1.part", &["bake", "--shard", "1/1"], 0),
        ("plane.1-of-1.part", &["merge"], 1),
        ("bake.json", &["view"], 1),
        ("bake.json", &["export", "--for", "gltf"], 1),
        ("bake.json", &["compare"], 1),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join(name);
        let made = Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo runs").success());
        let mut command = ambake();
        command.args(words);
        if words[0] == "bake" {
            command.arg(&path).args(work);
        }
        let child = command
            .arg(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let (code, text) = ended(child).unwrap_or_else(|| panic!("{words:?} waits for {name}"));
        assert_eq!(code, Some(status), "{words:?} {name}: {text}");
        assert!(
            status == 0 || text.lines().count() == 1 && text.contains("a pipe or a device"),
            "{words:?} {name}: {text}"
        );
    }
}

#[test]
fn no_saved_state_is_written_through_a_link() {
    let square = std::fs::read(scene("plane.obj")).expect("a scene");
    let work = ["--size", "64", "--rays", "16", "--quiet", "-o"];
    let refused = Some("it is a symbolic link; remove it");
    for (name, words, target, problem) in [
        (
            ".plane.ambake-resume",
            &["--resume"][..],
            "plane.obj",
            refused,
        ),
        (".plane.ambake-resume", &["--resume"], "mine", refused),
        (".plane.ambake-resume", &["--resume"], "gone", refused),
        // Nothing is saved.
        (".plane.ambake-resume", &[], "plane.obj", None),
        (
            ".plane.1-of-1.ambake-resume",
            &["--shard", "1/1"],
            "mine",
            refused,
        ),
        // The part gets its name when it is complete, and takes the place of the link.
        ("plane.1-of-1.part", &["--shard", "1/1"], "mine", None),
        (
            "plane.1-of-1.part",
            &["--shard", "1/1"],
            "plane.obj",
            Some("is an input of this job"),
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let [input, mine, out] = ["plane.obj", "mine", "out"].map(|name| folder.path().join(name));
        std::fs::write(&input, &square).expect("the folder is writable");
        std::fs::write(&mine, "mine").expect("the folder is writable");
        std::fs::create_dir(&out).expect("the folder is writable");
        let link = Path::new("..").join(target);
        std::os::unix::fs::symlink(link, out.join(name)).expect("a link");
        let mut command = ambake();
        command.arg("bake").arg(&input).args(words).args(work);
        let output = command.arg(&out).output().expect("it runs");
        let text = String::from_utf8_lossy(&output.stderr);
        let case = format!("{words:?} {name} -> {target}: {text}");
        let read = |path| std::fs::read(path).expect("it is there");
        assert!(read(&input) == square && read(&mine) == b"mine", "{case}");
        assert_eq!(files(folder.path()), ["mine", "out", "plane.obj"], "{case}");
        assert_eq!(
            output.status.code(),
            Some(i32::from(problem.is_some())),
            "{case}"
        );
        if let Some(problem) = problem {
            assert!(text.contains(problem) && text.contains(name), "{case}");
            assert_eq!(
                (text.lines().count(), files(&out)),
                (1, vec![name.into()]),
                "{case}"
            );
        }
    }
}

#[test]
fn a_pipe_that_is_named_as_an_input_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe.png").display().to_string();
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo runs").success());
    let [out, sky] = [folder.path().join("out.hdr"), scene("sky.hdr")];
    let [out, sky] = [&out, &sky].map(|path| path.display().to_string());
    for words in [
        &["bake", &pipe, "-o", &out][..],
        &["map", "stats", &pipe],
        &["map", "merge", &pipe, &pipe, "-o", &out],
        &[
            "map", "specular", &sky, "--kernel", "table", "--table", &pipe, "-o", &out,
        ],
    ] {
        let mut command = ambake();
        command.args(words).stdout(Stdio::null());
        let child = command.stderr(Stdio::piped()).spawn();
        let child = child.expect("the program starts");
        let (code, text) = ended(child).unwrap_or_else(|| panic!("{words:?} waits for the pipe"));
        assert_eq!(code, Some(1), "{words:?}: {text}");
        assert_eq!(text.lines().count(), 1, "{words:?}: {text}");
        assert!(text.contains("pipe.png"), "{words:?}: {text}");
    }
}
