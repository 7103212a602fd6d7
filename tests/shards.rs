//! Bakes in parts: any order, interruptions and odd numbers of parts give the bytes of a whole bake, and what lacks is
//! named.

use crate::support::{ambake, files, report, run, run_well, scene};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// Words of a `bake` into a folder.
fn words(file: &Path, folder: &Path, more: &[&str]) -> Vec<String> {
    let mut words = vec![
        "bake".to_owned(),
        file.display().to_string(),
        "-o".into(),
        folder.display().to_string(),
        "--quiet".into(),
    ];
    words.extend(more.iter().map(ToString::to_string));
    words
}

/// Bakes part `shard`.
fn part(file: &Path, folder: &Path, shard: &str, more: &[&str]) {
    let mut words = words(file, folder, more);
    words.extend(["--shard".into(), shard.into()]);
    run_well(words);
}

fn merge(folder: &Path) -> Output {
    run(["merge".as_ref(), folder.as_os_str(), "--quiet".as_ref()])
}

fn merge_well(folder: &Path) {
    let output = merge(folder);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert_eq!(text, "");
}

/// The line that a failed merge prints; nothing but parts is in the folder.
fn refused(folder: &Path) -> String {
    let before = files(folder);
    let output = merge(folder);
    let text = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    assert_eq!(files(folder), before);
    text
}

/// `bake.json` without times and what the host adds.
fn facts(folder: &Path) -> Value {
    let mut report = report(folder);
    for name in ["timings", "seconds", "peak_memory_bytes"] {
        report[name] = Value::Null;
    }
    for page in report["pages"].as_array_mut().expect("pages") {
        page["seconds"] = Value::Null;
        page["rays_per_second"] = Value::Null;
    }
    report
}

/// Both folders hold the same files of the same bytes.
fn assert_same(whole: &Path, merged: &Path) {
    assert_eq!(files(whole), files(merged));
    for name in files(whole).iter().filter(|name| *name != "bake.json") {
        let read = |folder: &Path| std::fs::read(folder.join(name)).expect("it is there");
        assert!(read(whole) == read(merged), "{name} differs");
    }
    assert_eq!(facts(whole), facts(merged));
}

/// Bakes `file` whole and in the given parts, and compares; the number of pages.
fn compare(file: &Path, shards: &[&str], more: &[&str]) -> usize {
    let whole = tempfile::tempdir().expect("a folder");
    run_well(words(file, whole.path(), more));
    let parts = tempfile::tempdir().expect("a folder");
    for shard in shards {
        part(file, parts.path(), shard, more);
    }
    merge_well(parts.path());
    assert_same(whole.path(), parts.path());
    facts(parts.path())["pages"].as_array().map_or(0, Vec::len)
}

#[test]
fn parts_in_any_order_make_the_bytes_of_a_whole_bake() {
    let lamp = scene("lamp.obj");
    let small = ["--size", "64", "--rays", "4"];
    compare(&lamp, &["3/3", "1/3", "2/3"], &small);
    compare(&lamp, &["1/1"], &small);
    // A page of one tile: five parts are empty.
    let tiny = ["--size", "16", "--rays", "4"];
    let six = ["1/6", "2/6", "3/6", "4/6", "5/6", "6/6"];
    compare(&scene("plane.obj"), &six, &tiny);
}

#[test]
fn parts_hold_for_pages_skies_targets_and_the_denoiser() {
    let sky = scene("sky.hdr").display().to_string();
    let sphere = scene("resting_sphere.obj");
    let two = ["2/2", "1/2"];
    let small = ["--size", "64", "--rays", "4"];
    let pages = compare(&scene("airliner.obj"), &two, &small);
    assert!(pages > 1, "{pages}");
    let lit = ["--size", "48", "--rays", "4", "--sky", &sky];
    compare(&sphere, &two, &lit);
    let until = ["--size", "48", "--target-error", "0.1", "--max-rays", "64"];
    compare(&sphere, &two, &until);
    let smooth = ["--size", "48", "--rays", "8", "--denoise", "regression"];
    compare(&sphere, &two, &smooth);
}

#[test]
fn what_lacks_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = scene("corner.obj");
    let small = ["--size", "32", "--rays", "4"];
    let text = refused(folder.path());
    assert!(text.contains("no part"), "{text}");
    part(&file, folder.path(), "1/3", &small);
    let text = refused(folder.path());
    assert!(text.contains("2/3") && text.contains("3/3"), "{text}");
    part(&file, folder.path(), "3/3", &small);
    let text = refused(folder.path());
    assert!(text.contains("2/3") && !text.contains("3/3"), "{text}");
    // Another seed: the part is whole, and of another bake.
    part(
        &file,
        folder.path(),
        "2/3",
        &["--size", "32", "--rays", "5"],
    );
    let text = refused(folder.path());
    assert!(text.contains("--rays"), "{text}");
    part(&file, folder.path(), "2/3", &small);
    // A flipped byte.
    let path = folder.path().join("corner.2-of-3.part");
    let sound = std::fs::read(&path).expect("a part");
    let mut bytes = sound.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, &bytes).expect("a part");
    let text = refused(folder.path());
    assert!(
        text.contains("--shard 2/3") && text.contains("damaged"),
        "{text}"
    );
    // Cut short.
    std::fs::write(&path, &sound[..sound.len() - 3]).expect("a part");
    assert!(refused(folder.path()).contains("2/3"));
    part(&file, folder.path(), "2/3", &small);
    // Parts of another number beside them.
    part(&file, folder.path(), "1/2", &small);
    let text = refused(folder.path());
    assert!(text.contains("several"), "{text}");
    std::fs::remove_file(folder.path().join("corner.1-of-2.part")).expect("a part");
    merge_well(folder.path());
}

#[test]
fn a_scene_that_changed_under_its_parts_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("my scene 50%.obj");
    std::fs::copy(scene("corner.obj"), &file).expect("a copy");
    let out = folder.path().join("out");
    let small = ["--size", "32", "--rays", "4"];
    part(&file, &out, "1/2", &small);
    let mut text = std::fs::read_to_string(&file).expect("a scene");
    text.push_str("v 0 9 0\nv 1 9 0\nv 0 9 1\nf -1 -2 -3\n");
    std::fs::write(&file, text).expect("a scene");
    part(&file, &out, "2/2", &small);
    let text = refused(&out);
    assert!(text.contains("the scene differs"), "{text}");
    part(&file, &out, "1/2", &small);
    merge_well(&out);
    assert!(out.join("my scene 50%.0.exr").exists());
}

/// A part as it lies there while it is in work: its last block is cut off.
fn begun(folder: &Path, stem: &str) -> std::path::PathBuf {
    let done = folder.join(format!("{stem}.1-of-1.part"));
    let work = folder.join(format!(".{stem}.1-of-1.ambake-resume"));
    let bytes = std::fs::read(&done).expect("a part");
    std::fs::remove_file(done).expect("a part");
    std::fs::write(&work, &bytes[..bytes.len() - 1]).expect("a state");
    work
}

#[test]
fn a_part_that_was_killed_goes_on_unless_it_is_damaged_or_of_another_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("corner.obj");
    std::fs::copy(scene("corner.obj"), &file).expect("a copy");
    let out = folder.path().join("out");
    let small = ["--size", "32", "--rays", "4"];
    let go_on = || -> (u64, String) {
        let mut words = words(&file, &out, &small);
        words.retain(|word| word != "--quiet");
        words.extend(["--shard", "1/1", "--json"].map(String::from));
        let output = run(words);
        let said: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let text = String::from_utf8(output.stderr).expect("UTF-8");
        (said["texels"].as_u64().expect("a number"), text)
    };
    let (all, _) = go_on();
    assert!(all > 0);
    assert_eq!(go_on(), (0, String::new()), "it was complete already");
    begun(&out, "corner");
    assert_eq!(go_on(), (0, String::new()), "every tile was saved");
    // Killed after its last block, before it had its name.
    let [done, work] = ["corner.1-of-1.part", ".corner.1-of-1.ambake-resume"];
    std::fs::rename(out.join(done), out.join(work)).expect("a part");
    assert_eq!(go_on(), (0, String::new()), "nothing was missing");
    let work = begun(&out, "corner");
    let mut bytes = std::fs::read(&work).expect("a state");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&work, bytes).expect("a state");
    let (texels, text) = go_on();
    assert_eq!((texels, text.lines().count()), (all, 1), "{text}");
    assert!(
        text.contains("damaged") && text.contains("starting over"),
        "{text}"
    );
    // The same options, a scene of the same size: nothing of it may be taken.
    begun(&out, "corner");
    let text = std::fs::read_to_string(&file).expect("a scene");
    std::fs::write(&file, format!("{text}# another scene\n")).expect("a scene");
    assert_eq!(go_on(), (all, String::new()));
}

#[test]
fn what_does_not_fit_into_memory_is_refused_with_a_size_that_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = scene("plane.obj");
    let bake = |size: &str, memory: &str| {
        let more = ["--rays", "1", "--size", size, "--max-memory", memory];
        run(words(&file, folder.path(), &more))
    };
    let output = bake("8192", "400M");
    let text = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(text.contains("GiB") && text.contains("--size "), "{text}");
    assert_eq!(files(folder.path()), Vec::<String>::new());
    assert!(bake("64", "400M").status.success());
    assert_eq!(bake("64", "400X").status.code(), Some(2));
}

#[test]
fn a_wrong_part_is_a_wrong_command_line() {
    let file = scene("plane.obj").display().to_string();
    for wrong in ["0/4", "5/4", "1/0", "1", "a/b", "1/2/3", "-1/2", "1/100001"] {
        let shard = format!("--shard={wrong}");
        let output = run(["bake", &file, "-o", "never", &shard]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn relative_paths_are_merged_from_anywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(scene("corner.obj"), folder.path().join("corner.obj")).expect("a copy");
    std::fs::copy(scene("sky.hdr"), folder.path().join("sky.hdr")).expect("a copy");
    let bake = |folder: &Path, words: &str| {
        let words: Vec<&str> = words.split(' ').collect();
        let output = ambake().current_dir(folder).args(words).output();
        let output = output.expect("the program starts");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{text}");
    };
    let small = "bake corner.obj --size 32 --rays 4 --sky sky.hdr --quiet";
    bake(folder.path(), &format!("{small} -o whole"));
    bake(folder.path(), &format!("{small} -o parts --shard 1/1"));
    bake(&folder.path().join("parts"), "merge . --quiet");
    assert_same(&folder.path().join("whole"), &folder.path().join("parts"));
}

#[test]
fn a_layout_is_the_bake_s_and_is_taken_from_its_file() {
    let file = scene("corner.obj");
    let folder = tempfile::tempdir().expect("a folder");
    let layout = |folder: &Path| -> Value {
        let text = run_well([
            "layout".as_ref(),
            file.as_os_str(),
            "-o".as_ref(),
            folder.as_os_str(),
            "--size".as_ref(),
            "64".as_ref(),
            "--json".as_ref(),
        ]);
        serde_json::from_str(&text).expect("JSON")
    };
    let said = layout(folder.path());
    let names = ["corner.0.layout.png", "corner.layout", "layout.json"];
    assert_eq!(files(folder.path()), names);
    let text = std::fs::read_to_string(folder.path().join("layout.json")).expect("a file");
    assert_eq!(said, serde_json::from_str::<Value>(&text).expect("JSON"));
    let small = ["--size", "64", "--rays", "4"];
    run_well(words(&file, folder.path(), &small));
    let baked = report(folder.path());
    assert_eq!(
        (&baked["layout"], &baked["atlas"]),
        (&said["layout"], &said["atlas"])
    );
    // The same bytes as without the file.
    let bare = tempfile::tempdir().expect("a folder");
    run_well(words(&file, bare.path(), &small));
    for name in files(bare.path())
        .iter()
        .filter(|name| *name != "bake.json")
    {
        let read = |folder: &Path| std::fs::read(folder.join(name)).expect("it is there");
        assert!(read(bare.path()) == read(folder.path()), "{name} differs");
    }
    // A damaged file is as good as none.
    let path = folder.path().join("corner.layout");
    let mut bytes = std::fs::read(&path).expect("a file");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).expect("a file");
    run_well(words(&file, folder.path(), &small));
    assert_eq!(report(folder.path())["layout"], said["layout"]);
}

#[test]
fn one_command_line_serves_the_layout_and_the_parts_of_a_farm() {
    let (file, folder) = (scene("corner.obj"), tempfile::tempdir().expect("a folder"));
    let flags = [
        "--size=64",
        "--rays=4",
        "--for=three",
        "--report",
        "--resume",
    ];
    let mut words = words(&file, folder.path(), &flags);
    words[0] = "layout".into();
    run_well(words);
    assert!(folder.path().join("corner.layout").is_file());
    for shard in ["1/2", "2/2"] {
        part(&file, folder.path(), shard, &flags);
    }
    merge_well(folder.path());
    let made = files(folder.path());
    for name in ["corner.0.lightmap.ktx2", "report.html"] {
        assert!(made.iter().any(|file| file == name), "{name}: {made:?}");
    }
}

#[test]
fn a_project_file_serves_every_verb_and_a_merge_makes_its_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::copy(scene("trench.obj"), at("trench.obj")).expect("a scene");
    let text =
        "[bake]\nsize = 32\nrays = 4\nreport = true\nfor = ['three']\nthreads = 1\nseed = 7\n";
    std::fs::write(at("ambake.toml"), text).expect("a file");
    let file = at("trench.obj");
    let holds = |folder: &Path| {
        let names = files(folder);
        assert!(names.contains(&"report.html".to_owned()), "{names:?}");
        assert!(
            names.iter().any(|name| name.ends_with("lightmap.glb")),
            "{names:?}"
        );
        let facts = report(folder);
        assert_eq!(facts["options"]["size"], 32);
        assert_eq!(facts["options"]["rays"], 4);
        assert_eq!(facts["options"]["seed"], 7);
    };
    // Without a verb, the last of a flag counts.
    let typed = [
        file.as_os_str(),
        "--rays".as_ref(),
        "2".as_ref(),
        "--rays".as_ref(),
        "4".as_ref(),
    ];
    run_well(typed);
    holds(&at("trench.ambake"));
    for shard in ["1/2", "2/2"] {
        part(&file, &at("parts"), shard, &[]);
    }
    merge_well(&at("parts"));
    holds(&at("parts"));
    let layout = at("layout");
    run_well([
        "layout".as_ref(),
        file.as_os_str(),
        "-o".as_ref(),
        layout.as_os_str(),
    ]);
    let told = run_well(["plan".as_ref(), file.as_os_str(), "--json".as_ref()]);
    let plan: Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(plan["options"]["size"], 32);
    // The bake takes the layout of the same size.
    run_well(words(&file, &layout, &[]));
    holds(&layout);
    std::fs::write(at("ambake.toml"), "[bake]\nresume = true\n").expect("a file");
    let output = run(["plan".as_ref(), file.as_os_str()]);
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        line.contains("`resume` in [bake] belongs to one run"),
        "{line}"
    );
}
