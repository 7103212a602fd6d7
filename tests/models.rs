//! Real models, baked short. Each is skipped with a printed line where it is absent. `parity.rs` asks both backends of
//! them.

use crate::support::{Page, backends, bake, files, model, page_path, report};
use serde_json::Value;

/// Bakes `name`; holds what any bake must fulfil, and returns the report.
fn sane(name: &str, size: usize, least_coverage: f64) -> Option<Value> {
    let path = model(name)?;
    let stem = path
        .file_stem()
        .expect("a stem")
        .to_string_lossy()
        .into_owned();
    let backend = backends()[0];
    let edge = size.to_string();
    let (folder, _page) = bake(
        &path,
        &["--size", &edge, "--rays", "16", "--backend", backend],
    );
    let json = report(folder.path());
    let names = files(folder.path());
    for file in [
        format!("{stem}.0.diffuse.png"),
        format!("{stem}.glb"),
        "bake.json".into(),
    ] {
        assert!(names.contains(&file), "no {file} in {names:?}");
    }
    let pages = json["pages"].as_array().expect("pages").len();
    assert!(pages >= 1);
    let (mut covered, mut mean) = (0.0, 0.0);
    for number in 0..pages {
        let page = Page::read(&page_path(folder.path(), &path, number as u32));
        for (channel, value) in page.values() {
            assert!(
                value.is_finite(),
                "{name} {backend}: {channel} holds {value}"
            );
        }
        for channel in ["coverage", "visibility", "diffuse", "specular"] {
            let (low, high) = page
                .plane(channel)
                .iter()
                .fold((0.0f32, 0.0f32), |(l, h), &v| (l.min(v), h.max(v)));
            // A mean of weighted samples may pass 1 by its own error.
            let limit = if channel == "coverage" {
                1.0 + 1e-6
            } else {
                1.5
            };
            assert!(
                low >= 0.0 && high <= limit,
                "{name} {backend}: {channel} in {low}..{high}"
            );
        }
        let coverage = page.plane("coverage");
        covered += coverage.iter().map(|&c| f64::from(c)).sum::<f64>();
        mean += coverage
            .iter()
            .zip(page.plane("diffuse"))
            .map(|(&c, &d)| f64::from(c * d))
            .sum::<f64>();
    }
    let used = covered / (pages * size * size) as f64;
    mean /= covered;
    let atlas = &json["atlas"];
    println!(
        "{name} {backend}: {} pages {pages}, coverage {used:.3}, mean diffuse {mean:.4}, {} charts, {} s",
        atlas["source"], atlas["charts"], json["seconds"]
    );
    assert!(
        used >= least_coverage,
        "{name} {backend}: only {used} of the page is used"
    );
    assert!(
        mean > 0.02 && mean < 1.0,
        "{name} {backend}: mean diffuse {mean}"
    );
    assert_eq!(
        (&atlas["overlaps"], &atlas["missing"]),
        (&Value::from(0), &Value::from(0)),
        "{name}: {atlas}"
    );
    Some(json)
}

#[test]
fn gazebo_keeps_the_shapes_of_its_own_charts_which_touch() {
    if let Some(json) = sane("gazebo/gazebo.obj", 256, 0.3) {
        // Packed anew; what the author gave them stays.
        assert_eq!(json["atlas"]["source"], "repacked", "{}", json["atlas"]);
    }
}

#[test]
fn boeing_787_bakes() {
    sane("boeing_787/scene.gltf", 512, 0.2);
}

#[test]
fn flight_helmet_bakes() {
    sane("flight_helmet/FlightHelmet.gltf", 512, 0.2);
}

#[test]
fn game_level_bakes() {
    sane("game_level_zdm2.glb", 512, 0.1);
}

#[test]
fn suzi_without_uvs_bakes() {
    if let Some(json) = sane("suzi.glb", 256, 0.2) {
        assert_eq!(json["atlas"]["source"], "unwrapped", "{}", json["atlas"]);
    }
}

#[test]
fn oak_with_masked_leaves_bakes() {
    sane("oak_small_alphamask.glb", 512, 0.1);
}

#[test]
fn cornell_box_bakes() {
    sane("cornell_box/CornellBox.glb", 256, 0.2);
}

#[test]
fn spot_without_normals_bakes() {
    sane("spot.obj", 256, 0.2);
}
