//! Bakes and merges that are stopped amid their bounces.

use crate::bounces::{bowl, obj};
use crate::support::{ambake, files};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A scene whose light is mostly that of bounces, in a folder of its own.
fn bounced_bowl(folder: &Path) -> PathBuf {
    let materials = "newmtl wall\nKd 0.7 0.6 0.5\nnewmtl lamp\nKe 3 3 3\n";
    obj(folder, materials, &bowl(0.5, -0.9))
}

/// A bake of it. Four of five rays are those of bounces.
fn bowl_bake(path: &Path, out: &Path, more: &[&str]) -> Command {
    let work = ["--size", "64", "--rays", "256", "--bounces", "4", "--quiet"];
    let mut command = ambake();
    command.arg("bake").arg(path).arg("-o").arg(out).args(work);
    command.args(more).stderr(Stdio::null());
    command
}

fn ends_well(mut command: Command) {
    assert!(command.status().expect("it runs").success());
}

/// A command stopped by SIGINT while it runs: about when 60 of 100 of `whole` are over, or sooner. `begin` makes its
/// folder.
fn stopped_amid(
    whole: Duration,
    begin: impl Fn() -> tempfile::TempDir,
    command: impl Fn(&Path) -> Command,
) -> tempfile::TempDir {
    let mut delay = whole.mul_f64(0.6);
    loop {
        let out = begin();
        let mut child = command(out.path()).spawn().expect("it starts");
        std::thread::sleep(delay);
        let signal = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        signal.expect("kill runs");
        if child.wait().expect("a status").code() == Some(130) {
            return out;
        }
        delay = delay.mul_f64(0.7);
        assert!(
            delay > Duration::from_millis(10),
            "it was always done before the signal"
        );
    }
}

/// The pictures of a folder.
fn pictures(out: &Path) -> Vec<Vec<u8>> {
    let names = files(out).into_iter();
    let names = names.filter(|name| name.ends_with(".png"));
    names
        .map(|name| std::fs::read(out.join(name)).expect("a file"))
        .collect()
}

#[test]
fn a_bake_that_was_stopped_amid_its_bounces_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = bounced_bowl(folder.path());
    let empty = || tempfile::tempdir().expect("a temporary directory");
    let whole = empty();
    let started = Instant::now();
    ends_well(bowl_bake(&path, whole.path(), &[]));
    let stopped = stopped_amid(started.elapsed(), empty, |out| bowl_bake(&path, out, &[]));
    ends_well(bowl_bake(&path, stopped.path(), &["--resume"]));
    assert!(
        pictures(whole.path()) == pictures(stopped.path()),
        "the bytes differ"
    );
}

#[test]
fn a_merge_that_was_stopped_amid_its_bounces_goes_on_from_what_it_gathered() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = bounced_bowl(folder.path());
    let empty = || tempfile::tempdir().expect("a temporary directory");
    let parts = empty();
    ends_well(bowl_bake(&path, parts.path(), &["--shard", "1/1"]));
    let copy = || {
        let out = empty();
        for name in files(parts.path()) {
            std::fs::copy(parts.path().join(&name), out.path().join(&name)).expect("a copy");
        }
        out
    };
    let merge = |out: &Path| {
        let mut command = ambake();
        command.arg("merge").arg(out).arg("--quiet");
        command.stderr(Stdio::null());
        command
    };
    let whole = copy();
    let started = Instant::now();
    ends_well(merge(whole.path()));
    let stopped = stopped_amid(started.elapsed(), copy, merge);
    let state = std::fs::metadata(stopped.path().join(".a.ambake-resume"));
    assert!(state.expect("the state of gathers").len() > 10_000);
    ends_well(merge(stopped.path()));
    assert_eq!(files(whole.path()), files(stopped.path()));
    assert!(
        pictures(whole.path()) == pictures(stopped.path()),
        "the bytes differ"
    );
}
