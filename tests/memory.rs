//! Memory that the system refuses: one line, and nothing lost.
#![cfg(target_os = "linux")]

use crate::support::{files, report, run_well, scene, shell, skip};
use std::path::Path;

/// The program under a limit on its addresses in KiB, with traces asked for, as some have it in their shells.
fn within_addresses(kib: u64, words: &[&str]) -> (Option<i32>, String) {
    let output = shell(&format!("ulimit -v {kib} && ambake \"$@\""))
        .args(words)
        .env("RUST_BACKTRACE", "1")
        .output()
        .expect("sh starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), text)
}

#[test]
fn a_limit_on_addresses_refuses_what_does_not_fit_and_names_a_size_that_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let (out, path) = (
        folder.path().display().to_string(),
        scene("plane.obj").display().to_string(),
    );
    let bake = |size: &str| {
        let words = ["bake", &path, "-o", &out, "--size", size, "--rays", "1"];
        within_addresses(
            700_000,
            &[&words[..], &["--threads", "1", "--quiet"]].concat(),
        )
    };
    let (status, line) = bake("8192");
    assert_eq!((status, line.lines().count()), (Some(1), 1), "{line}");
    assert!(line.contains("(ulimit)"), "{line}");
    let size = line
        .split_once("`--size ")
        .and_then(|(_, rest)| rest.split_once('`'));
    let (size, _) = size.expect("a size that fits");
    assert_eq!(bake(size), (Some(0), String::new()), "{size}");
}

#[test]
fn memory_that_the_system_refuses_ends_a_bake_in_one_line_and_loses_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("corner.obj").display().to_string();
    let words = |out: &Path| {
        let out = out.display().to_string();
        let fixed = "--size 512 --rays 1 --quiet --max-memory 1000G --resume";
        let mut words = vec!["bake".into(), path.clone(), "-o".into(), out];
        words.extend(fixed.split(' ').map(String::from));
        words
    };
    let (whole, out) = (folder.path().join("whole"), folder.path().join("out"));
    run_well(words(&whole));
    let mut refused = 0;
    for kib in (50_000..500_000).step_by(50_000) {
        let words = words(&out);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let (status, line) = within_addresses(kib, &words);
        // Too little to load the program's libraries.
        if status == Some(127) {
            continue;
        }
        if status == Some(0) {
            assert_eq!(line, "", "{kib}");
            std::fs::remove_dir_all(&out).expect("it is there");
            continue;
        }
        assert_eq!((status, line.lines().count()), (Some(1), 1), "{kib} {line}");
        assert!(line.starts_with("ambake: "), "{kib} {line}");
        assert!(line.contains("memory"), "{kib} {line}");
        assert!(!out.join("bake.json").exists(), "{kib} {line}");
        refused += 1;
    }
    assert!(refused > 0, "no limit was too low");
    run_well(words(&out));
    for name in ["corner.0.exr", "corner.glb"] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).expect("a result");
        assert!(read(&whole) == read(&out), "{name}");
    }
}

#[test]
fn what_is_said_of_refused_memory_reaches_no_file_where_standard_error_is_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let words = "--size 4096 --rays 1 --max-memory 1000G --threads 1 --quiet";
    let bake = |streams: &str| {
        let line =
            format!(r#"ulimit -v 400000 && ambake bake "$1" -o "$2" {words} --fresh {streams}"#);
        let output = shell(&line)
            .args([scene("plane.obj"), out.clone()])
            .output();
        let output = output.expect("sh starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    };
    let (status, said) = bake("");
    assert!(
        status == Some(1) && said.contains("the system refuses"),
        "{status:?} {said}"
    );
    // Number 2 is then free for the first file that is opened.
    assert_eq!(bake("2>&-"), (Some(1), String::new()));
    // What was being written may still lie in its staging folder.
    let mut folders = vec![out];
    while let Some(folder) = folders.pop() {
        for name in files(&folder) {
            let path = folder.join(&name);
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let bytes = std::fs::read(&path).expect("a file");
            assert!(!bytes.windows(7).any(|w| w == b"refuses"), "{name}");
        }
    }
}

#[test]
fn a_scene_that_runs_out_of_memory_is_one_line_and_the_others_are_baked() {
    if std::env::var_os("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER").is_some() {
        return skip("the loader that starts the program is not known to it");
    }
    let folder = tempfile::tempdir().expect("a folder");
    // 400 MB of grey in 400 kB.
    let grey = image::GrayImage::new(10_000, 10_000);
    grey.save(folder.path().join("grey.png"))
        .expect("a picture");
    std::fs::write(
        folder.path().join("big.mtl"),
        "newmtl grey\nmap_Kd grey.png\n",
    )
    .expect("a file");
    let plane = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\n";
    let textured =
        format!("mtllib big.mtl\n{plane}vt 0 0\nvt 1 0\nvt 1 1\nusemtl grey\nf 1/1 2/2 3/3\n");
    let files = [
        ("a.obj", "f 1 2 3 4\n"),
        ("big.obj", &textured),
        ("z.obj", "f 1 2 3 4\n"),
    ];
    let paths = files.map(|(name, text)| {
        let path = folder.path().join(name);
        let text = if name == "big.obj" {
            text.into()
        } else {
            format!("{plane}{text}")
        };
        std::fs::write(&path, text).expect("a scene");
        path.display().to_string()
    });
    let out = folder.path().join("out").display().to_string();
    let words = [
        "bake",
        "--quiet",
        "-o",
        &out,
        "--size=32",
        "--rays=1",
        "--threads=1",
        "--",
    ];
    let words: Vec<&str> = words
        .into_iter()
        .chain(paths.iter().map(String::as_str))
        .collect();
    let (status, lines) = within_addresses(400_000, &words);
    let lines: Vec<&str> = lines.lines().collect();
    let [refused, told] = lines[..] else {
        panic!("{lines:?}")
    };
    assert!(
        refused.starts_with(&format!("ambake: {}: the system refuses", paths[1])),
        "{refused}"
    );
    assert_eq!(
        (status, told),
        (Some(1), "ambake: 1 of 3 scenes were not baked")
    );
    for stem in ["a", "z"] {
        report(&folder.path().join("out").join(stem));
    }
    assert!(!folder.path().join("out/big/bake.json").exists());
}
