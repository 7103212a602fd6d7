//! Probes in parts, and probes that go on: the bytes are those of one piece, and what lacks is named.

use crate::support::{files, run, run_well, scene};
use ::ambake::{Places, ProbeOptions, Probes, Progress, Resume, Shard};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

const GRID: [&str; 4] = ["--grid=4x2x3", "--rays=64", "--tried=30", "--parts"];
const MAPS: [&str; 3] = [
    "--reflections=0,1.5,3;2,1,2",
    "--reflection-size=8",
    "--for=bevy,three",
];

/// Runs `probes` of the courtyard into a folder.
fn probes(folder: &Path, more: &[&str]) {
    let (courtyard, folder) = (scene("courtyard.obj"), folder.display().to_string());
    let words = [
        "probes",
        courtyard.to_str().expect("UTF-8"),
        "-o",
        &folder,
        "-q",
    ];
    run_well(words.into_iter().chain(more.iter().copied()));
}

/// The line of a merge that fails.
fn refused(folder: &Path) -> String {
    let before = files(folder);
    let output = run(["merge".as_ref(), folder.as_os_str()]);
    let text = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    assert_eq!(files(folder), before);
    text
}

fn assert_same(whole: &Path, other: &Path) {
    assert_eq!(files(whole), files(other));
    for name in files(whole) {
        let read = |folder: &Path| std::fs::read(folder.join(&name)).expect("it is there");
        assert!(read(whole) == read(other), "{name} differs");
    }
}

#[test]
fn parts_of_probes_make_the_bytes_of_one_piece_and_what_lacks_is_named() {
    let [whole, parts] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let words = [&GRID[..], &MAPS].concat();
    probes(whole.path(), &words);
    let part = |shard: &str, more: &[&str]| {
        probes(
            parts.path(),
            &[&words[..], more, &["--shard", shard]].concat(),
        );
    };
    part("3/3", &["--threads=1"]);
    let text = refused(parts.path());
    assert!(text.contains("1/3") && text.contains("2/3"), "{text}");
    part("1/3", &[]);
    part("2/3", &["--order=1"]);
    let text = refused(parts.path());
    assert!(text.contains("--order"), "{text}");
    part("2/3", &["--threads=3"]);
    let path = parts.path().join("courtyard.probes-2-of-3.part");
    let sound = std::fs::read(&path).expect("a part");
    let mut bytes = sound.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).expect("a part");
    let text = refused(parts.path());
    assert!(
        text.contains("--shard 2/3") && text.contains("damaged"),
        "{text}"
    );
    std::fs::write(&path, sound).expect("a part");
    run_well(["merge".as_ref(), parts.path().as_os_str(), "-q".as_ref()]);
    assert_same(whole.path(), parts.path());
}

#[test]
fn one_folder_takes_the_parts_of_a_bake_and_of_its_probes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plane, out) = (scene("plane.obj"), folder.path().display().to_string());
    let plane = plane.to_str().expect("UTF-8");
    run_well([
        "bake",
        plane,
        "-o",
        &out,
        "--size=16",
        "--rays=4",
        "--shard=1/1",
        "-q",
    ]);
    run_well([
        "probes",
        plane,
        "-o",
        &out,
        "--at=0,1,0",
        "--shard=1/1",
        "-q",
    ]);
    run_well(["merge", &out, "-q"]);
    for name in ["bake.json", "plane.0.exr", "plane.probes.json"] {
        assert!(files(folder.path()).contains(&name.to_owned()), "{name}");
    }
    assert!(
        !files(folder.path())
            .iter()
            .any(|name| name.ends_with(".part"))
    );
}

/// Stops a job after so many units, and hears what it says.
struct Stop {
    after: u64,
    seen: AtomicU64,
    total: AtomicU64,
    notes: Mutex<Vec<String>>,
}

impl Stop {
    fn after(after: u64) -> Self {
        Self {
            after,
            seen: AtomicU64::new(0),
            total: AtomicU64::new(0),
            notes: Mutex::new(Vec::new()),
        }
    }

    fn notes(&self) -> String {
        self.notes.lock().expect("no panic").join("\n")
    }
}

impl Progress for Stop {
    fn advance(&self, done: u64, total: u64) {
        self.seen.fetch_max(done, Ordering::Relaxed);
        self.total.fetch_max(total, Ordering::Relaxed);
    }

    fn note(&self, line: &str) {
        self.notes.lock().expect("no panic").push(line.to_owned());
    }

    fn cancelled(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.after
    }
}

#[test]
fn probes_that_were_stopped_go_on_to_the_same_bytes() {
    let scene = ::ambake::load(scene("courtyard.obj")).expect("a scene");
    let places = Places::Grid([4, 2, 3]);
    let mut options = ProbeOptions::default();
    options.rays = 64;
    options.tried = 30;
    options.reflections = vec![[0.0, 1.5, 3.0]];
    options.reflection_size = 8;
    let [whole, again] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let mut made = Probes::gather(&scene, &places, &options, &()).expect("probes");
    made.write(whole.path(), &[]).expect("written");
    let into = |options: &ProbeOptions, resume, stop: &Stop| {
        Probes::gather_into(&scene, &places, options, (again.path(), resume), stop)
    };
    let state = again.path().join(".courtyard.probes.ambake-resume");
    // Amid probes, amid the places between them, and amid the faces of a map: 24, 30 and 12 units.
    let mut left = 24 + 30 + 12;
    for after in [10, 30, 16] {
        let stop = Stop::after(after);
        let found = into(&options, Resume::IfFound, &stop);
        assert!(matches!(found, Err(::ambake::Error::Cancelled)));
        assert!(state.exists());
        assert_eq!(stop.total.load(Ordering::Relaxed), left, "{}", stop.notes());
        assert_eq!(stop.notes().contains("going on"), left < 66);
        left -= stop.seen.load(Ordering::Relaxed);
    }
    let stop = Stop::after(u64::MAX);
    let mut made = into(&options, Resume::IfFound, &stop).expect("probes");
    assert!(left > 0 && stop.total.load(Ordering::Relaxed) == left);
    made.write(again.path(), &[]).expect("written");
    assert_same(whole.path(), again.path());
    // What is of other options, or was damaged, is told of and not used.
    let begin = |options: &ProbeOptions, stop: &Stop| {
        assert!(into(options, Resume::IfFound, stop).is_err());
        stop.notes()
    };
    begin(&options, &Stop::after(5));
    options.rays = 128;
    let said = begin(&options, &Stop::after(5));
    assert!(said.contains("--rays differs; starting over"), "{said}");
    let mut bytes = std::fs::read(&state).expect("a state");
    let last = bytes.len() - 100;
    bytes[last] ^= 1;
    std::fs::write(&state, bytes).expect("written");
    let said = begin(&options, &Stop::after(5));
    assert!(said.contains("damaged"), "{said}");
    let stop = Stop::after(66);
    assert!(into(&options, Resume::Never, &stop).is_ok() && stop.notes().is_empty());
}

#[test]
fn a_part_is_gathered_once_and_by_one_run() {
    let scene = ::ambake::load(scene("plane.obj")).expect("a scene");
    let folder = tempfile::tempdir().expect("a folder");
    let (places, options) = (Places::Grid([3, 1, 3]), ProbeOptions::default());
    let shard = Shard { index: 2, of: 4 };
    let part = |stop: &Stop| {
        let place = (folder.path(), shard, &serde_json::Value::Null);
        Probes::gather_shard(&scene, &places, &options, place, stop)
    };
    // 9 probes and 1000 places, of which every fourth from the second on.
    let stop = Stop::after(3);
    assert!(part(&stop).is_err());
    let seen = stop.seen.load(Ordering::Relaxed);
    let found = part(&Stop::after(u64::MAX)).expect("a part");
    assert_eq!((found.already, found.places + seen), (false, 252));
    let found = part(&Stop::after(u64::MAX)).expect("a part");
    assert_eq!((found.already, found.places), (true, 0));
}
