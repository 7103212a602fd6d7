//! Interrupted bakes: exit status, nothing broken, and the same bytes after `--resume`.

use super::{differences, pictures};
use crate::support::{Page, ambake, bake, files, page_path, run_well, scene};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[rustfmt::skip]
const WORK: [&str; 8] = ["--size", "256", "--rays", "512", "--threads", "2", "--denoise", "regression"];

/// Starts a bake of the courtyard and sends `signal` after `delay`; the exit status, or `None` where the bake was done
/// before.
fn interrupted(folder: &Path, signal: &str, delay: Duration) -> Option<i32> {
    let path = scene("courtyard.obj");
    let mut child = ambake()
        .args([
            "bake".as_ref(),
            path.as_os_str(),
            "-o".as_ref(),
            folder.as_os_str(),
            "--quiet".as_ref(),
        ])
        .args(WORK)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while start.elapsed() < delay {
        if child.try_wait().expect("a status").is_some() {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .expect("kill runs");
    let output = child.wait_with_output().expect("a status");
    if !sent.success() || output.status.success() {
        return None;
    }
    println!(
        "{signal} after {delay:?}: {}",
        String::from_utf8_lossy(&output.stderr).trim_end()
    );
    Some(
        output
            .status
            .code()
            .unwrap_or_else(|| panic!("{signal} killed it: {}", output.status)),
    )
}

#[test]
fn interrupted_bake_resumes_to_the_same_bytes() {
    let (whole, _page) = bake(&scene("courtyard.obj"), &WORK);
    let whole = pictures(whole.path());
    for (signal, status) in [("-INT", 130), ("-TERM", 143)] {
        let mut delay = Duration::from_millis(1600);
        loop {
            let folder = tempfile::tempdir().expect("a temporary directory");
            let Some(code) = interrupted(folder.path(), signal, delay) else {
                delay /= 2;
                assert!(
                    delay > Duration::from_millis(20),
                    "the bake is always done before the signal"
                );
                continue;
            };
            assert_eq!(code, status, "{signal}");
            let left = files(folder.path());
            println!("left after {signal}: {left:?}");
            if left.contains(&"bake.json".into()) {
                // It met the program between its last file and its end: then all is there.
                assert!(differences(&whole, &pictures(folder.path())).is_empty());
                delay /= 2;
                continue;
            }
            assert!(!left.iter().any(|name| name.ends_with(".glb")), "{left:?}");
            for name in left.iter().filter(|name| name.ends_with(".exr")) {
                Page::read(&folder.path().join(name));
            }
            let path = scene("courtyard.obj");
            let mut arguments = vec![
                "bake".as_ref(),
                path.as_os_str(),
                "-o".as_ref(),
                folder.path().as_os_str(),
            ];
            arguments.extend(
                ["--quiet", "--resume"]
                    .iter()
                    .chain(&WORK)
                    .map(std::ffi::OsStr::new),
            );
            run_well(arguments);
            assert_eq!(
                differences(&whole, &pictures(folder.path())),
                Vec::<String>::new()
            );
            Page::read(&page_path(folder.path(), &path, 0));
            break;
        }
    }
}
