//! What `ambake plan` predicts, beside what a bake takes.

use crate::support::{report, run_well, scene};

#[test]
fn a_plan_is_near_what_a_bake_takes() {
    // Many small charts; a large one, whose memory the denoiser decides; no seams and no denoiser; light that bounces;
    // one term alone; a sky from a picture. Pages of few layers are large, so that pictures and what the process holds
    // anyhow do not decide.
    let sky = format!("--sky={}", scene("sky.hdr").display());
    for (name, options) in [
        ("courtyard.obj", &["--size=512", "--rays=4"][..]),
        ("resting_sphere.obj", &["--size=1024", "--rays=4"]),
        (
            "palm.gltf",
            &["--size=1024", "--rays=4", "--seams=off", "--denoise=off"],
        ),
        ("interior.gltf", &["--size=512", "--rays=4", "--bounces=1"]),
        (
            "vehicles.gltf",
            &["--size=1024", "--rays=8", "--only=diffuse"],
        ),
        ("airliner.obj", &["--size=512", "--rays=4", &sky]),
    ] {
        let path = scene(name);
        let path = path.to_str().expect("UTF-8");
        let options = &[options, &["--threads=2"]].concat()[..];
        let planned = run_well([&["plan", path, "--json"], options].concat());
        let planned: serde_json::Value = serde_json::from_str(&planned).expect("JSON");
        let estimate = |name: &str| planned["estimate"][name].as_f64().expect("a number");
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().to_str().expect("UTF-8");
        run_well([&["bake", path, "-o", out], options].concat());
        let report = report(folder.path());
        let [rays, memory] =
            ["rays", "peak_memory_bytes"].map(|name| report[name].as_f64().expect("a number"));
        let ratios = [estimate("rays") / rays, estimate("memory_bytes") / memory];
        assert!((ratios[0] - 1.0).abs() < 0.3, "{name}: {ratios:?}");
        assert!((ratios[1] - 1.0).abs() < 0.15, "{name}: {ratios:?}");
        // No measure of speed: a unit that is mistaken is off by more.
        let seconds = estimate("cpu_seconds");
        assert!((0.001..1000.0).contains(&seconds), "{name}: {seconds} s");
    }
}
