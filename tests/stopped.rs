//! Pictures, frames, figures and captures that are stopped: exit status, and nothing half-written.

use crate::support::{ambake, files, load_image, save_image, scene};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Starts a job of minutes in `folder` and sends `signal` a second later; the exit status and what was printed.
fn stopped(folder: &Path, words: &[&str], signal: &str) -> (Option<i32>, String) {
    let mut delay = Duration::from_secs(1);
    loop {
        let child = ambake()
            .current_dir(folder)
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(delay);
        let sent = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status()
            .expect("kill runs");
        assert!(sent.success(), "{words:?} ended before the signal");
        let output = child.wait_with_output().expect("a status");
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(text).expect("UTF-8");
        // Killed before it listened, on a busy machine.
        if output.status.code().is_none() && delay < Duration::from_secs(60) {
            delay *= 2;
            continue;
        }
        return (output.status.code(), text);
    }
}

#[test]
fn a_stopped_picture_figure_or_capture_leaves_nothing_behind() {
    let courtyard = scene("courtyard.obj").display().to_string();
    let plane = scene("plane.obj").display().to_string();
    let (courtyard, plane) = (courtyard.as_str(), plane.as_str());
    let picture = "-o x.exr -o x.png --rays 4096 --size 2000x2000 --quiet";
    let figure = "-o figure --figure fig3 --rays 4096 --size 2000x2000 --quiet";
    let points = "-o figure --figure fig1 --rays 65536 --quiet";
    let capture = "-o x.exr --at 0,1.5,0 --rays 4096 --face 1024 --quiet";
    for (verb, file, words, signal, status) in [
        (&["render"][..], courtyard, picture, "-INT", 130),
        (&["render"], courtyard, picture, "-TERM", 143),
        (&["render"], courtyard, figure, "-INT", 130),
        (&["render"], plane, points, "-INT", 130),
        (&["map", "capture"], courtyard, capture, "-INT", 130),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let words: Vec<&str> = verb
            .iter()
            .copied()
            .chain([file])
            .chain(words.split(' '))
            .collect();
        let (code, text) = stopped(folder.path(), &words, signal);
        assert_eq!(code, Some(status), "{words:?} {signal}: {text}");
        assert_eq!(text, "", "{words:?} is quiet");
        assert_eq!(files(folder.path()), Vec::<String>::new(), "{words:?}");
    }
}

#[test]
fn a_stopped_sequence_leaves_whole_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = environment::Image::filled(64, 32, [0.5; 3]);
    save_image(folder.path().join("I.exr"), &image);
    let ball = scene("ball.obj").display().to_string();
    let words =
        "--shader mirror --environment I.exr --frames 100000 --size 200x200 --quiet -o x.exr";
    let words: Vec<&str> = ["render", &ball]
        .into_iter()
        .chain(words.split(' '))
        .collect();
    let (code, text) = stopped(folder.path(), &words, "-INT");
    assert_eq!((code, text.as_str()), (Some(130), ""));
    let frames: Vec<String> = files(folder.path())
        .into_iter()
        .filter(|name| name != "I.exr")
        .collect();
    for (number, name) in frames.iter().enumerate() {
        assert_eq!(*name, format!("x.{number:04}.exr"));
        load_image(folder.path().join(name));
    }
}
