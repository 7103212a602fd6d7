//! `bench --peers` runs other programs through Python; here a script stands in for it.

use crate::support::{ambake, scene};
use tempfile::tempdir;

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Makes environments of itself, refuses to install bpy, and writes down how the comparison was called.
#[cfg(unix)]
const PYTHON: &str = r#"#!/bin/sh
case "$1 $2 $*" in
  "-m venv "*) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;;
  "-m pip "*bpy) exit 1 ;;
  "-m pip "*) exit 0 ;;
  */generate.py*) mkdir -p "$2" && : > "$2/$4.obj" ;;
  */run.py*) test -f "$(dirname "$1")/bake_pymeshlab.py" && test -x "$AMBAKE" &&
    ls "$2" > "$4/peers.md" && shift 4 && echo "called with $*" >> "$OUT" ;;
  *) exit 1 ;;
esac
"#;

#[cfg(unix)]
#[test]
fn peers_are_installed_run_and_skipped_where_they_cannot_be() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempdir().unwrap();
    let (python, out) = (dir.path().join("my python"), dir.path().join("out %1"));
    std::fs::write(&python, PYTHON).unwrap();
    std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).unwrap();
    let called = dir.path().join("called");
    let output = ambake()
        .args(["bench", "--peers", "--size", "64", "--rays", "8", "-o"])
        .arg(&out)
        .arg("--python")
        .arg(&python)
        .env("OUT", &called)
        .output()
        .unwrap();
    let errors = text(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert!(
        errors.contains("skip bpy: it could not be installed"),
        "{errors}"
    );
    assert_eq!(
        text(&output.stdout).split_whitespace().collect::<Vec<_>>(),
        ["colonnade.obj", "displaced.obj", "room.obj"]
    );
    let called = std::fs::read_to_string(&called).unwrap();
    assert_eq!(called.trim(), "called with --repeats 3 --size 64 --rays 8");
}

#[test]
fn peers_without_python_are_one_clear_line() {
    let dir = tempdir().unwrap();
    let output = ambake()
        .args(["bench", "--peers", "--python", "no such python", "-o"])
        .arg(dir.path())
        .output()
        .unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(errors.trim().lines().count(), 1, "{errors}");
    assert!(
        errors.contains("no such python") && errors.contains("--python PATH"),
        "{errors}"
    );
}

#[test]
fn a_target_is_measured_too() {
    let folder = tempdir().expect("a temporary directory");
    let out = folder.path().join("bench");
    let mut command = ambake();
    let words = [
        "bench",
        "--size",
        "32",
        "--repeats",
        "1",
        "--target-error",
        "0.1",
        "-o",
    ];
    let output = command
        .args(words)
        .arg(&out)
        .arg(scene("lamp.obj"))
        .output();
    let output = output.expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert!(out.join("bench.csv").is_file());
}
