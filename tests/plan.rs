//! What `plan` says of a bake, against the bake.

use crate::support::{report, run_well, scene};
use serde_json::Value;

/// Bakes that differ in what decides memory. The model's constants were chosen on the first three; the others judge.
const BAKES: [(&str, &[&str]); 6] = [
    ("courtyard.obj", &["--size", "1024"]),
    ("airliner.obj", &["--size", "1024", "--layers", "position"]),
    ("interior.gltf", &["--size", "768", "--bounces", "1"]),
    ("town.gltf", &["--size", "1024", "--denoise", "off"]),
    ("vehicles.gltf", &["--size", "1024", "--sky", "sky.hdr"]),
    ("palm.gltf", &["--size", "1024", "--only", "diffuse"]),
];

#[test]
fn peak_memory_is_planned_within_15_percent_and_room_on_the_disk_is_enough() {
    let sky = scene("sky.hdr").display().to_string();
    let mut wrong = Vec::new();
    for (name, more) in BAKES {
        let file = scene(name).display().to_string();
        let more = more.iter().map(|word| match *word {
            "sky.hdr" => sky.as_str(),
            word => word,
        });
        let words: Vec<&str> = [file.as_str(), "--rays", "8", "--threads", "2"]
            .into_iter()
            .chain(more)
            .collect();
        let planned = run_well([&["plan", "--json"], words.as_slice()].concat());
        let planned: Value = serde_json::from_str(&planned).expect("JSON");
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().display().to_string();
        run_well([&["bake", "--quiet", "-o", &out], words.as_slice()].concat());
        // The largest resident memory as the system counted it for the process: what getrusage(2) says too.
        let took = report(folder.path())["peak_memory_bytes"].as_f64();
        let Some(took) = took else {
            return crate::support::skip("the system does not tell a process's memory");
        };
        let estimate = |name: &str| planned["estimate"][name].as_f64().expect("a number");
        let ratio = estimate("memory_bytes") / took;
        let files = std::fs::read_dir(folder.path()).expect("a folder");
        let files = files.map(|file| file.and_then(|file| file.metadata()).expect("a file").len());
        let room = estimate("disk_peak_bytes") / files.sum::<u64>() as f64;
        if (ratio - 1.0).abs() > 0.15 || room < 1.0 {
            wrong.push(format!("{name}: {ratio:.2} of {took}, disk {room:.2}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
