//! Reports that are read back, and files that are none.

use super::*;
use serde_json::json;

pub(crate) fn report() -> BakeReport {
    BakeReport {
        schema_version: BAKE_SCHEMA_VERSION,
        versions: Versions {
            backend: "obvhs".into(),
            ..Versions::default()
        },
        scene: SceneReport {
            path: "räume/\"a\".glb".into(),
            ..SceneReport::default()
        },
        options: json!({ "size": 64, "sky": [1.0, 0.1, 1e-7], "density": null })
            .as_object()
            .cloned()
            .unwrap(),
        seed: u64::MAX,
        view: "eye 1,2,3".into(),
        convention: "linear".into(),
        plan: vec![DecisionReport {
            decision: "specular".into(),
            modelled: false,
            reason: "no material reflects specularly".into(),
            method: Some("off".into()),
        }],
        atlas: AtlasReport {
            kept_set: Some(1),
            density: 0.1 + 0.2,
            ..AtlasReport::default()
        },
        layout: crate::LayoutReport::default(),
        pages: vec![PageReport {
            mean_error: 1.0 / 3.0,
            ..PageReport::default()
        }],
        seams: Some(SeamReport::default()),
        bounces: Some(BounceReport::default()),
        picture: Some(PictureReport {
            eye: [1.5, 2.0, -3.0],
            forward: [0.0, 0.0, 1.0],
            fov_deg: 65.0,
            aspect: 1.5,
        }),
        update: Some(UpdateReport::default()),
        any_view: Some(AnyViewReport::default()),
        objects: vec![ObjectReport::default()],
        timings: vec![PhaseReport::default()],
        seconds: 1e-9,
        rays: u64::MAX - 1,
        buried: BuriedReport::default(),
        peak_memory_bytes: None,
        warnings: vec![WarningReport::default()],
        notes: vec!["TEXCOORD_0 overlaps itself".into()],
        lightmaps: Vec::new(),
        files: vec!["a.0.exr".into()],
        hashes: [("a.0.exr".into(), "00".into())].into(),
    }
}

#[test]
fn bake_json_comes_back_whole_and_begins_with_its_version() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bake.json");
    let text = report().to_json();
    assert!(text.starts_with("{\n  \"schema_version\": 1,\n"), "{text}");
    std::fs::write(&path, &text).unwrap();
    assert_eq!(read_bake_report(&path).unwrap(), report());
}

#[test]
fn other_versions_and_damage_are_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bake.json");
    let text = report().to_json();
    let newer = text.replacen("1,", "7,", 1);
    for (text, word) in [
        (newer.as_str(), "schema version 7"),
        (&text[..text.len() / 2], "damaged"),
        ("{}", "schema_version"),
        ("", "damaged"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = read_bake_report(&path).unwrap_err().to_string();
        assert!(
            error.contains(word) && error.contains("bake.json"),
            "{error}"
        );
    }
    std::fs::remove_file(&path).unwrap();
    let error = read_bake_report(&path).unwrap_err().to_string();
    assert!(
        error.contains("name the directory of a finished bake"),
        "{error}"
    );
}
