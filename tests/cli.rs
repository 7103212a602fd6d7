//! The command line as scripts rely on it: verbs, machine-readable output, determinism, interruption, comparison, and
//! the planner's choices.

mod compare;
mod interrupt;
mod planner;

use crate::support::{Page, backends, bake, files, page_path, report, run, run_well, scene};
use serde_json::Value;
use std::path::Path;

/// Few texels and rays, but every feature of the showcase: unwrapping, gloss, several materials.
const SMALL: [&str; 4] = ["--size", "256", "--rays", "4"];

/// Everything in a finished bake but `bake.json`, which holds wall times.
fn pictures(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = files(folder).into_iter().filter(|name| name != "bake.json");
    names
        .map(|name| {
            (
                name.clone(),
                std::fs::read(folder.join(&name)).expect("it is there"),
            )
        })
        .collect()
}

/// The names of the files in which two bakes differ.
fn differences(a: &[(String, Vec<u8>)], b: &[(String, Vec<u8>)]) -> Vec<String> {
    let names = |side: &[(String, Vec<u8>)]| {
        side.iter()
            .map(|(name, _)| name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(a), names(b));
    a.iter()
        .zip(b)
        .filter(|(a, b)| a != b)
        .map(|(a, _)| a.0.clone())
        .collect()
}

#[test]
fn help_names_every_verb_and_the_unit_of_every_quantity() {
    let help = run_well(["--help"]);
    for verb in ["bake", "plan", "compare", "render", "doctor"] {
        assert!(help.contains(verb), "{help}");
    }
    let help = run_well(["bake", "--help"]).to_lowercase();
    let words: Vec<&str> = help.split_whitespace().collect();
    // One entry a flag, with line breaks undone.
    let entries = words.join(" ");
    for (flag, unit) in [
        ("--size", "texels"),
        ("--density", "texels per scene unit"),
        ("--rays", "rays per texel"),
        ("--sky", "radiance"),
        ("--view", "scene units"),
        ("--max-distance", "scene units"),
        ("--albedo", "reflectance"),
        ("--exponent", "exponent"),
        ("--threads", "threads"),
    ] {
        let entry = entries
            .split(" --")
            .find(|entry| entry.starts_with(&flag[2..]));
        let entry = entry.unwrap_or_else(|| panic!("no {flag} in\n{help}"));
        assert!(entry.contains(unit), "{flag} does not say {unit}: {entry}");
    }
    assert!(run_well(["--version"]).starts_with("ambake "));
}

#[test]
fn doctor_tells_what_was_loaded() {
    let text = run_well(["doctor"]);
    assert!(
        text.contains("obvhs") && text.to_lowercase().contains("embree"),
        "{text}"
    );
    let json: Value =
        serde_json::from_str(&run_well(["doctor", "--json"])).expect("doctor --json is JSON");
    assert!(json.is_object(), "{json}");
    if let Some(header) = embree::header_version() {
        let header = format!("{header:?}");
        println!("built against {header}: {json}");
        assert!(json.to_string().contains("embree"), "{json}");
    }
}

#[test]
fn plan_is_machine_readable_and_writes_nothing() {
    let plan = run_well([
        "plan".as_ref(),
        scene("courtyard.obj").as_os_str(),
        "--json".as_ref(),
        "--size".as_ref(),
        "256".as_ref(),
    ]);
    let json: Value = serde_json::from_str(&plan).expect("plan --json is JSON");
    assert!(json.to_string().contains("specular"), "{json}");
    let text = run_well([
        "plan".as_ref(),
        scene("courtyard.obj").as_os_str(),
        "--size".as_ref(),
        "256".as_ref(),
    ]);
    for word in ["texels", "rays", "iB of memory", "specular", "open"] {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
}

#[test]
fn bake_writes_the_files_of_the_contract() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = scene("courtyard.obj");
    let mut arguments = vec![
        "bake".as_ref(),
        path.as_os_str(),
        "-o".as_ref(),
        folder.path().as_os_str(),
        "--json".as_ref(),
    ];
    arguments.extend(SMALL.iter().map(std::ffi::OsStr::new));
    let summary: Value = serde_json::from_str(&run_well(arguments)).expect("bake --json is JSON");
    let text =
        std::fs::read_to_string(folder.path().join("bake.json")).expect("bake.json is there");
    assert!(
        text.trim_start_matches(['{', '\n', ' '])
            .starts_with("\"schema_version\""),
        "{}",
        &text[..80]
    );
    let json = report(folder.path());
    assert_eq!(summary["schema_version"], json["schema_version"]);
    for key in [
        "versions",
        "options",
        "plan",
        "atlas",
        "pages",
        "timings",
        "peak_memory_bytes",
        "warnings",
        "scene",
    ] {
        assert!(!json[key].is_null(), "no {key} in {json}");
    }
    for entry in json["plan"].as_array().expect("a list") {
        assert!(
            entry["reason"]
                .as_str()
                .is_some_and(|reason| reason.len() > 8),
            "{entry}"
        );
    }
    let names = files(folder.path());
    for name in [
        "courtyard.0.exr",
        "courtyard.0.diffuse.png",
        "courtyard.0.phong.png",
        "courtyard.glb",
        "bake.json",
    ] {
        assert!(names.iter().any(|n| n == name), "no {name} in {names:?}");
    }
    assert!(
        names
            .iter()
            .all(|name| !name.starts_with('.') && !name.contains("tmp")),
        "{names:?}"
    );
    let page = Page::read(&page_path(folder.path(), &path, 0));
    assert_eq!(page.size, 256);
    let models =
        ["traditional", "lambert", "phong"].map(|m| ["R", "G", "B"].map(|c| format!("{m}.{c}")));
    let terms = [
        "coverage",
        "visibility",
        "diffuse",
        "specular",
        "error",
        "rays",
    ]
    .map(String::from);
    for name in models.iter().flatten().chain(&terms) {
        assert!(page.plane(name).iter().all(|v| v.is_finite()), "{name}");
    }
    assert!(page.plane("specular").iter().any(|&v| v > 0.0));
}

#[test]
fn extra_layers_come_on_request_and_only_them_with_only() {
    let extra = "position,normal,geometric,bent,exponent,object,validity,difference.lambert,difference.phong";
    let mut arguments = SMALL.to_vec();
    arguments.extend(["--layers", extra]);
    let (_folder, page) = bake(&scene("courtyard.obj"), &arguments);
    for layer in extra.split(',') {
        let named = page
            .names()
            .iter()
            .any(|name| *name == layer || name.starts_with(&format!("{layer}.")));
        assert!(named, "no {layer} in {:?}", page.names());
    }
    let mut arguments = SMALL.to_vec();
    arguments.extend(["--only", "diffuse"]);
    let (_folder, page) = bake(&scene("courtyard.obj"), &arguments);
    assert_eq!(page.names(), ["coverage", "diffuse"]);
}

#[test]
fn models_are_composed_from_the_terms() {
    let mut arguments = SMALL.to_vec();
    arguments.extend([
        "--albedo",
        "0.5,0.25,0.125",
        "--specular",
        "0.25,0.5,0.125",
        "--exponent",
        "8",
        "--sky",
        "2,1,4",
    ]);
    let (_folder, page) = bake(&scene("courtyard.obj"), &arguments);
    let (sky, albedo, gloss) = (
        [2.0f32, 1.0, 4.0],
        [0.5f32, 0.25, 0.125],
        [0.25f32, 0.5, 0.125],
    );
    for (c, suffix) in ["R", "G", "B"].iter().enumerate() {
        for i in (0..256 * 256).filter(|&i| page.plane("coverage")[i] > 0.0) {
            let term = |name: &str| page.plane(name)[i];
            let model = |name: &str| page.plane(&format!("{name}.{suffix}"))[i];
            let lambert = sky[c] * albedo[c] * term("diffuse");
            let phong = lambert + sky[c] * gloss[c] * term("specular");
            let traditional = sky[c] * albedo[c] * term("visibility");
            for (ours, theirs) in [
                (lambert, model("lambert")),
                (phong, model("phong")),
                (traditional, model("traditional")),
            ] {
                // Powers of two: only the sum of the Phong model rounds.
                assert!(
                    (ours - theirs).abs() <= f32::EPSILON * 4.0,
                    "texel {i} {suffix}: {ours} {theirs}"
                );
            }
        }
    }
}

#[test]
fn bytes_do_not_depend_on_threads_but_on_the_seed() {
    let ways: [&[&str]; 2] = [&[], &["--target-error", "0.04", "--max-rays", "256"]];
    let first = backends()[0];
    let others = backends()
        .into_iter()
        .skip(1)
        .map(|other| (&ways[0], other));
    for (way, backend) in ways.iter().map(|way| (way, first)).chain(others) {
        let with = |threads: &str, seed: &str| {
            let mut arguments = SMALL.to_vec();
            if way.contains(&"--target-error") {
                let at = arguments.iter().position(|word| *word == "--rays");
                let at = at.expect("the small bake says its rays");
                arguments.drain(at..at + 2);
            }
            arguments.extend(["--backend", backend, "--threads", threads, "--seed", seed]);
            arguments.extend(way.iter());
            let (folder, _page) = bake(&scene("courtyard.obj"), &arguments);
            pictures(folder.path())
        };
        let one = with("1", "0");
        for threads in ["7", "2"] {
            assert_eq!(
                differences(&one, &with(threads, "0")),
                Vec::<String>::new(),
                "{backend} {way:?}, {threads} threads"
            );
        }
        let changed = differences(&one, &with("2", "1"));
        for file in [
            "courtyard.0.exr",
            "courtyard.0.diffuse.png",
            "courtyard.glb",
        ] {
            assert!(
                changed.iter().any(|name| name == file),
                "{backend} {way:?}: another seed leaves {file} as it was"
            );
        }
    }
}

#[test]
fn a_scene_without_a_word_is_baked_into_a_folder_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let copies = ["plane.obj", "corner.OBJ"].map(|name| {
        let copy = folder.path().join(name);
        std::fs::copy(scene(&name.to_lowercase()), &copy).expect("a copy");
        copy
    });
    let few = ["--size", "32", "--rays", "4", "--quiet"];
    let [plane, corner] = copies.each_ref().map(|copy| copy.to_str().expect("UTF-8"));
    run_well([&[plane][..], &few].concat());
    assert!(folder.path().join("plane.ambake/plane.glb").is_file());
    assert!(!folder.path().join("corner.ambake").exists());
    run_well([&[corner, plane][..], &few].concat());
    assert!(folder.path().join("corner.ambake/corner.glb").is_file());
}

#[test]
fn a_number_below_0_is_told_what_belongs_there() {
    let path = scene("plane.obj").display().to_string();
    for (flag, says) in [
        ("--max-distance", "above 0"),
        ("--rays", "whole number from 1"),
        ("--albedo", "three numbers"),
    ] {
        let output = run(["bake", &path, flag, "-1"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(flag) && errors.contains(says), "{errors}");
    }
}

#[test]
fn of_a_flag_that_stands_twice_the_last_one_counts_and_suns_add_up() {
    let path = scene("corner.obj").display().to_string();
    let planned = run_well([
        "plan", &path, "--json", "--size", "32", "--rays", "64", "--rays", "4", "--sun", "0,1,0,1",
        "--sun", "1,1,0,1",
    ]);
    let planned: Value = serde_json::from_str(&planned).expect("JSON");
    assert_eq!(planned["options"]["rays"], 4);
    let decisions = planned["plan"].as_array().expect("a list");
    let lights = decisions
        .iter()
        .find(|decision| decision["decision"] == "lights");
    let reason = lights.expect("a decision")["reason"]
        .as_str()
        .expect("words");
    assert!(reason.contains("2 suns"), "{reason}");
    assert!(run_well(["plan", &path, "--quiet"]).is_empty());
}
