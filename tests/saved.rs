//! What becomes of a bake that a signal, a second bake or a full disk stops.

use crate::support::{ambake, ended, files, run_well, scene, shell};
use std::fs::TryLockError;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// `bake SCENE -o DIR` at a size of minutes.
fn long(scene: &Path, out: &Path) -> Command {
    let mut command = ambake();
    command.args([
        "bake".as_ref(),
        scene.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    command
        .args(["--size", "2048", "--rays", "65536", "--quiet"])
        .stderr(Stdio::piped());
    command
}

pub fn wait_for(what: &str, mut is_there: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_there() {
        assert!(start.elapsed() < Duration::from_secs(120), "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn signal(name: &str, id: u32) {
    let sent = Command::new("kill").args([name, &id.to_string()]).status();
    assert!(sent.expect("kill runs").success(), "{id} ended before");
}

#[cfg(target_os = "linux")]
#[test]
fn a_second_bake_into_one_folder_is_refused_and_a_second_signal_ends_the_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, out) = (scene("courtyard.obj"), folder.path().join("out"));
    let mut first = long(&scene, &out).spawn().expect("the program starts");
    // The lock is held from the end of the layout on, and for a moment when the bake begins. A bake that tried it again
    // and again would hold it itself when the first wants it.
    let mut seen = 0;
    wait_for("the lock", || {
        let folder = std::fs::File::open(&out);
        let is_held =
            |folder: std::fs::File| matches!(folder.try_lock(), Err(TryLockError::WouldBlock));
        seen = if folder.is_ok_and(is_held) {
            seen + 1
        } else {
            0
        };
        seen == 20
    });
    let mut second = ambake();
    second.args([
        "bake".as_ref(),
        scene.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    second.args(["--size", "8", "--rays", "1", "--quiet"]);
    let second = second.output().expect("the program starts");
    let refusal = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(1), "{refusal}");
    assert!(
        refusal.starts_with("ambake: another bake into") && refusal.lines().count() == 1,
        "{refusal}"
    );
    signal("-INT", first.id());
    // Whether the first signal is still being obeyed or not, the second ends it at once.
    let _ = Command::new("kill")
        .args(["-INT", &first.id().to_string()])
        .status();
    let start = Instant::now();
    let status = first.wait().expect("a status");
    assert_eq!(status.code(), Some(130), "{status}");
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "{:?}",
        start.elapsed()
    );
}

#[cfg(unix)]
#[test]
fn a_write_that_fails_keeps_what_was_baked() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let blocked = out.join("corner.glb");
    std::fs::create_dir_all(&blocked).expect("the folder is writable");
    let path = scene("corner.obj");
    let mut words = vec![
        "bake".as_ref(),
        path.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ];
    let rest = [
        "--size", "64", "--rays", "16", "--only", "diffuse", "--quiet",
    ];
    words.extend(rest.iter().map(std::ffi::OsStr::new));
    let failed = crate::support::run(&words);
    let line = String::from_utf8_lossy(&failed.stderr);
    assert_eq!(failed.status.code(), Some(1), "{line}");
    assert!(
        line.contains("corner.glb") && line.contains("the same command goes on"),
        "{line}"
    );
    let left = files(&out);
    assert!(left.iter().any(|name| name.contains("resume")), "{left:?}");
    assert!(!left.iter().any(|name| name.contains("staged")), "{left:?}");
    std::fs::remove_dir(&blocked).expect("it is empty");
    run_well(&words);
    assert!(files(&out).contains(&"corner.glb".into()));
    assert!(
        !files(&out).iter().any(|name| name.contains("resume")),
        "{:?}",
        files(&out)
    );
}

/// The end of a bake of the corner into `out` with more words, and what it said.
fn corner_bake(out: &Path, more: &str) -> (Option<i32>, String) {
    let mut command = ambake();
    command
        .arg("bake")
        .arg(scene("corner.obj"))
        .arg("-o")
        .arg(out);
    command.args("--size 64 --only diffuse".split(' '));
    let output = command.args(more.split(' ')).output().expect("it runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    (output.status.code(), said)
}

#[test]
fn a_bake_goes_on_from_what_was_saved_of_it_by_itself_and_says_so() {
    let whole = tempfile::tempdir().expect("a folder");
    assert_eq!(corner_bake(whole.path(), "--rays 16").0, Some(0));
    let page = |folder: &Path| std::fs::read(folder.join("corner.0.exr")).expect("a page");
    for (more, line) in [
        ("--rays 16", Some("going on from what was saved in")),
        (
            "--rays 16 --resume",
            Some("going on from what was saved in"),
        ),
        ("--rays 32", Some("differs; starting over")),
        ("--rays 16 --fresh", None),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path();
        let blocked = out.join("corner.glb");
        std::fs::create_dir(&blocked).expect("the folder is writable");
        let (code, said) = corner_bake(out, "--rays 16 --quiet");
        assert_eq!((code, said.lines().count()), (Some(1), 1), "{said}");
        std::fs::remove_dir(&blocked).expect("it is empty");
        let (code, said) = corner_bake(out, more);
        assert_eq!(code, Some(0), "{more}: {said}");
        let told = |word: &str| said.lines().filter(|line| line.contains(word)).count();
        let all = told("going on") + told("starting over");
        assert_eq!(all, usize::from(line.is_some()), "{more}: {said}");
        assert_eq!(line.map_or(1, told), 1, "{more}: {said}");
        assert_eq!(
            page(out) == page(whole.path()),
            more != "--rays 32",
            "{more}"
        );
        assert!(
            files(out).iter().all(|name| !name.starts_with('.')),
            "{more}"
        );
    }
    assert_eq!(
        corner_bake(whole.path(), "--rays 16 --resume --fresh").0,
        Some(2)
    );
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_one_line_and_the_bake_goes_on_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let bake = |before: &str, more: &str| {
        let words = "--size 64 --rays 16 --only diffuse --quiet";
        let line = format!(r#"{before} ambake bake "$1" -o "$2" {words} {more}"#);
        let mut command = shell(&line);
        command.args([scene("corner.obj"), out.clone()]);
        let output = command.output().expect("sh runs");
        let text = String::from_utf8(output.stderr).expect("UTF-8");
        (output.status.code(), text)
    };
    // Blocks of 512 bytes.
    let (code, line) = bake("ulimit -f 4;", "");
    assert_eq!((code, line.lines().count()), (Some(1), 1), "{line}");
    assert!(line.contains("cannot write"), "{line}");
    let left = files(&out);
    assert!(left.iter().all(|name| name.starts_with('.')), "{left:?}");
    assert_eq!(bake("", "").0, Some(0));
    assert!(files(&out).contains(&"bake.json".into()));
}

#[cfg(unix)]
#[test]
fn a_signal_before_the_first_tile_ends_the_program() {
    let folder = tempfile::tempdir().expect("a folder");
    // A terrain of 90,000 triangles without coordinates: a second or more to load, plan, unwrap and build.
    let side = 212;
    let mut text = String::new();
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        text += &format!("v {i} {} {j}\n", (i * i + 3 * j * i) % 7);
    }
    for (i, j) in (1..side).flat_map(|i| (1..side).map(move |j| (i, j))) {
        let a = (i - 1) * side + j;
        text += &format!(
            "f {a} {} {}\nf {a} {} {}\n",
            a + 1,
            a + side + 1,
            a + side + 1,
            a + side
        );
    }
    let terrain = folder.path().join("terrain.obj");
    std::fs::write(&terrain, text).expect("the folder is writable");
    let out = folder.path().join("out");
    // From standard input nothing comes: it loads until the signal.
    for (scene, milliseconds) in [("-", 300), ("terrain.obj", 250), ("terrain.obj", 700)] {
        let mut child = ambake()
            .current_dir(folder.path())
            .args(["bake", scene, "-o", "out", "--quiet", "--uv", "unwrap"])
            .args(["--size", "512", "--rays", "4096"])
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let input = child.stdin.take();
        std::thread::sleep(Duration::from_millis(milliseconds));
        let start = Instant::now();
        signal("-INT", child.id());
        let (code, text) = ended(child).unwrap_or_else(|| panic!("{scene} goes on"));
        let seconds = start.elapsed().as_secs_f64();
        drop(input);
        // On a busy machine the signal may come before it listens.
        assert!(matches!(code, Some(130) | None), "{scene}: {code:?} {text}");
        // A second, and what other processes take of a busy machine; the bake itself would take minutes.
        assert!(seconds < 20.0, "{scene}: {seconds} s");
        let left = if out.exists() {
            files(&out)
        } else {
            Vec::new()
        };
        assert!(left.iter().all(|name| name.starts_with('.')), "{left:?}");
    }
}
