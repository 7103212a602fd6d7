//! Runs that start at the same moment in one folder: none takes anything from another.
#![cfg(unix)]

use crate::support::{ambake, ended, files, run_well, scene};
use std::path::Path;
use std::process::{Child, Stdio};

/// How many parts start at a time.
const PARTS: usize = 8;

/// Starts one part of a small bake.
fn start(folder: &Path, part: usize) -> Child {
    let shard = format!("--shard={part}/{PARTS}");
    let mut command = ambake();
    command.arg("bake").arg(scene("plane.obj"));
    command.arg("-o").arg(folder);
    command.args(["--size=32", "--rays=1", "--quiet", "--threads=1", &shard]);
    let child = command.stderr(Stdio::piped()).spawn();
    child.expect("the program starts")
}

#[test]
fn parts_that_start_at_once_in_an_absent_or_an_existing_folder_all_end_well() {
    let place = tempfile::tempdir().expect("a temporary directory");
    let whole = place.path().join("whole");
    let words = ["--size=32", "--rays=1", "--quiet"];
    let path = scene("plane.obj");
    let bake = [
        "bake".as_ref(),
        path.as_os_str(),
        "-o".as_ref(),
        whole.as_os_str(),
    ];
    run_well(bake.into_iter().chain(words.iter().map(AsRef::as_ref)));
    for round in 0..8 {
        let folder = place.path().join(format!("{round}/parts"));
        if round % 2 == 1 {
            // What a killed run left there is swept by all of them at the same time.
            let left = folder.join(".ambake-staged-killed");
            std::fs::create_dir_all(&left).expect("a folder");
            std::fs::write(left.join("half"), "half").expect("a file");
        }
        let children: Vec<Child> = (1..=PARTS).map(|part| start(&folder, part)).collect();
        for (number, child) in children.into_iter().enumerate() {
            let ended = ended(child);
            let well = Some((Some(0), String::new()));
            assert_eq!(ended, well, "round {round}, part {}", number + 1);
        }
        let parts = (1..=PARTS).map(|part| format!("plane.{part}-of-{PARTS}.part"));
        assert_eq!(files(&folder), parts.collect::<Vec<_>>(), "round {round}");
        run_well(["merge".as_ref(), folder.as_os_str(), "--quiet".as_ref()]);
        let page = |folder: &Path| std::fs::read(folder.join("plane.0.exr")).expect("a page");
        assert!(page(&folder) == page(&whole), "round {round}");
    }
}
