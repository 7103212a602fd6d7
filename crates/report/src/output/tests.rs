//! What stands in a folder while an output is staged, and after it is published or dropped.

use super::*;

fn names(dir: &Path) -> Vec<String> {
    let mut all: Vec<_> = fs::read_dir(dir)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    all.sort();
    all
}

#[test]
fn files_appear_only_on_publish() {
    let dir = tempfile::tempdir().unwrap();
    let target = dir.path().join("a/b");
    let mut out = Output::create(&target).unwrap();
    out.stage_bytes("x.png", b"one").unwrap();
    out.stage_bytes("bake.json", b"{}").unwrap();
    assert!(!target.join("x.png").exists());
    assert_eq!(
        out.publish().unwrap(),
        [target.join("x.png"), target.join("bake.json")]
    );
    assert_eq!(names(&target), ["bake.json", "x.png"]);
}

#[cfg(unix)]
#[test]
fn a_second_job_is_refused_and_leftovers_of_a_killed_one_go() {
    let dir = tempfile::tempdir().unwrap();
    let mut first = Output::exclusive(dir.path()).unwrap();
    let error = Output::exclusive(dir.path()).unwrap_err().to_string();
    assert!(
        error.contains("another bake") && error.contains("-o"),
        "{error}"
    );
    // A verb that adds a file beside the bake is no second bake.
    let mut picture = Output::create(dir.path()).unwrap();
    picture.stage_bytes("lit.png", b"one").unwrap();
    first.stage_bytes("x.png", b"one").unwrap();
    // As if the process were killed: the files stay, the locks go.
    let killed = dir.path().join(".ambake-staged-killed");
    fs::create_dir(&killed).unwrap();
    fs::write(killed.join("x"), b"half").unwrap();
    drop(first);
    assert_eq!(names(dir.path()).len(), 2, "{:?}", names(dir.path()));
    // Whoever writes there next removes what was left, and nothing that somebody still writes.
    let second = Output::create(dir.path()).unwrap();
    assert!(!killed.exists());
    drop(second);
    picture.publish().unwrap();
    assert_eq!(names(dir.path()), ["lit.png"]);
}

#[test]
fn a_program_that_panics_takes_what_it_staged_with_it() {
    const FOLDER: &str = "AMBAKE_TEST_PANICS_IN";
    const NAME: &str = "output::tests::a_program_that_panics_takes_what_it_staged_with_it";
    if let Some(dir) = std::env::var_os(FOLDER) {
        let mut out = Output::create(dir.as_ref()).unwrap();
        out.stage_bytes("x.png", b"half").unwrap();
        // As where a panic does not unwind: nothing is dropped.
        std::mem::forget(out);
        remove_staged_on_panic();
        panic!("as asked");
    }
    let dir = tempfile::tempdir().unwrap();
    let mut other = Output::create(dir.path()).unwrap();
    let program = std::env::current_exe().unwrap();
    let run = std::process::Command::new(program)
        .args(["--exact", NAME])
        .env(FOLDER, dir.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(!run.status.success() && said.contains("as asked"), "{said}");
    // What another program stages there stays.
    other.stage_bytes("y.png", b"whole").unwrap();
    other.publish().unwrap();
    assert_eq!(names(dir.path()), ["y.png"]);
}

#[test]
fn a_failed_write_leaves_good_output_untouched() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("x.png"), b"good").unwrap();
    let mut out = Output::create(dir.path()).unwrap();
    out.stage_bytes("x.png", b"new").unwrap();
    let full = |_: &mut File| Err(Error::write(Path::new(""), ErrorKind::StorageFull.into()));
    let error = out.stage("y.png", full).unwrap_err().to_string();
    assert!(
        error.contains("y.png") && error.contains("free some space"),
        "{error}"
    );
    drop(out);
    assert_eq!(names(dir.path()), ["x.png"]);
    assert_eq!(fs::read(dir.path().join("x.png")).unwrap(), b"good");
}

#[test]
fn directories_that_were_made_for_nothing_go_again() {
    let dir = tempfile::tempdir().unwrap();
    let inner = dir.path().join("a/b");
    drop(Output::create(&inner).unwrap());
    assert!(names(dir.path()).is_empty());
    let mut out = Output::exclusive(&inner).unwrap();
    out.stage_bytes("x.png", b"new").unwrap();
    out.publish().unwrap();
    assert_eq!(names(&inner), ["x.png"]);
    fs::create_dir(dir.path().join("mine")).unwrap();
    drop(Output::create(&dir.path().join("mine")).unwrap());
    assert_eq!(names(dir.path()), ["a", "mine"]);
}

#[test]
fn a_file_in_place_of_the_directory_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out");
    fs::write(&path, b"").unwrap();
    for bad in [path.clone(), path.join("below")] {
        let error = Output::create(&bad).unwrap_err().to_string();
        assert!(
            error.contains(bad.to_str().unwrap()) && error.contains("-o"),
            "{error}"
        );
        assert!(!error.contains('\n'));
    }
}

#[test]
fn a_directory_in_place_of_a_file_stops_the_whole_set() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("bake.json")).unwrap();
    let mut out = Output::create(dir.path()).unwrap();
    out.stage_bytes("x.png", b"one").unwrap();
    out.stage_bytes("bake.json", b"{}").unwrap();
    let error = out.publish().unwrap_err().to_string();
    assert!(error.contains("bake.json"), "{error}");
    assert_eq!(names(dir.path()), ["bake.json"]);
}

#[test]
fn an_input_is_never_replaced_under_any_of_its_names() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("scene.glb");
    fs::write(&input, b"mine").unwrap();
    let mut out = Output::create(dir.path()).unwrap();
    out.protect([dir.path().join("./scene.glb")]);
    let error = out
        .stage_bytes("scene.glb", b"new")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("scene.glb") && error.contains("-o"),
        "{error}"
    );
    #[cfg(unix)]
    {
        let folder = dir.path().join("linked");
        fs::create_dir(&folder).unwrap();
        fs::hard_link(&input, folder.join("copy.glb")).unwrap();
        std::os::unix::fs::symlink(&input, folder.join("link.glb")).unwrap();
        let mut out = Output::create(&folder).unwrap();
        out.protect([input.clone()]);
        assert!(out.check("copy.glb").is_err() && out.check("link.glb").is_err());
    }
    out.stage_bytes("other.glb", b"new").unwrap();
    out.publish().unwrap();
    assert_eq!(fs::read(&input).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn only_what_still_has_the_content_of_the_earlier_set_goes_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("out");
    fs::create_dir_all(folder.join("sub")).unwrap();
    for name in ["old", "edited", "input", "kept", "sub/old", "../old"] {
        fs::write(folder.join(name), b"one").unwrap();
    }
    std::os::unix::fs::symlink("input", folder.join("link")).unwrap();
    fs::write(folder.join("edited"), b"two").unwrap();
    let hash = blake3::hash(b"one").to_hex().to_string();
    let listed = [
        "old", "edited", "input", "kept", "sub/old", "../old", "link", "gone", "sub",
    ];
    let mut out = Output::create(&folder).unwrap();
    out.protect([folder.join("input")]);
    out.supersede(listed.map(|name| (name.to_owned(), hash.clone())));
    out.stage_bytes("kept", b"one").unwrap();
    assert_eq!(out.listed(), [("kept".to_owned(), hash)]);
    out.publish().unwrap();
    assert_eq!(names(&folder), ["edited", "input", "kept", "link", "sub"]);
    assert_eq!(names(&folder.join("sub")), ["old"]);
    assert_eq!(names(dir.path()), ["old", "out"]);
}

/// Runs `job` for each of `count` numbers at the same moment.
fn at_once(count: usize, job: impl Fn(usize) + Sync) {
    let start = std::sync::Barrier::new(count);
    std::thread::scope(|scope| {
        for number in 0..count {
            let (start, job) = (&start, &job);
            scope.spawn(move || {
                start.wait();
                job(number);
            });
        }
    });
}

#[cfg(unix)]
#[test]
fn outputs_that_begin_at_once_in_an_absent_folder_take_nothing_from_each_other() {
    let dir = tempfile::tempdir().unwrap();
    for round in 0..20 {
        let folder = dir.path().join(format!("{round}/a/b"));
        at_once(32, |number| {
            // Some end at once, with all that they made.
            let mut out = Output::create(&folder).unwrap();
            if number % 2 == 1 {
                out.stage_bytes(&number.to_string(), b"one").unwrap();
                out.publish().unwrap();
            }
        });
        assert_eq!(names(&folder).len(), 16, "{:?}", names(&folder));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_with_what_to_do() {
    let mut options = fs::OpenOptions::new();
    let mut full = options.write(true).open("/dev/full").unwrap();
    let error = Error::write(Path::new("out/x.exr"), full.write_all(b"x").unwrap_err()).to_string();
    assert!(
        error.contains("out/x.exr") && error.contains("free some space"),
        "{error}"
    );
}
