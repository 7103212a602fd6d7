//! Pipes in the place of files: refused in one line, where to open them would be to wait for ever.
#![cfg(unix)]

use crate::support::{ambake, ended, scene};
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
