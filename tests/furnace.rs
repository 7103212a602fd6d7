//! An open plane under a uniform sky of 1: it sends out what its material reflects, and never more than it receives.

use crate::support::{Page, backends, bake, report, run_well, scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A square in the plane y = 0, of one metallic-roughness material.
fn plane(folder: &Path, material: Value) -> PathBuf {
    let corners: [f32; 12] = [0., 0., 0., 0., 0., 1., 1., 0., 0., 1., 0., 1.];
    let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    std::fs::write(folder.join("plane.bin"), &bytes).expect("a file");
    let json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": "plane.bin", "byteLength": 48 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                        "min": [0, 0, 0], "max": [1, 0, 1] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 5, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "materials": [material],
    });
    let path = folder.join("plane.gltf");
    std::fs::write(&path, json.to_string()).expect("a file");
    path
}

/// The one colour of the `phong` layer.
fn radiance(page: &Page) -> [f32; 3] {
    ["phong.R", "phong.G", "phong.B"].map(|channel| {
        let inside = page.plane(channel).iter().zip(page.plane("coverage"));
        let mut values = inside.filter(|(_, c)| **c > 0.0).map(|(value, _)| *value);
        let first = values.next().expect("a texel");
        assert!(
            values.all(|value| value == first),
            "{channel} varies from {first}"
        );
        first
    })
}

#[test]
fn white_dielectrics_and_metals_send_out_what_they_receive() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let pbr = |metallic: f64, roughness: f64| {
        json!({ "pbrMetallicRoughness": {
            "metallicFactor": metallic, "roughnessFactor": roughness } })
    };
    let mut tinted = pbr(0.0, 0.5);
    tinted["extensions"] = json!({ "KHR_materials_ior": { "ior": 0 },
        "KHR_materials_specular": { "specularColorFactor": [0.5, 0.25, 0] } });
    for (material, expected) in [
        (pbr(0.0, 0.5), [1.0, 1.0, 1.0]),
        (pbr(0.0, 1.0), [1.0, 1.0, 1.0]),
        (pbr(0.5, 0.2), [1.0, 1.0, 1.0]),
        (pbr(1.0, 0.5), [1.0, 1.0, 1.0]),
        // The coat takes its largest channel, 0.5, from the whole base and gives back its own.
        (tinted, [1.0, 0.75, 0.5]),
    ] {
        let path = plane(folder.path(), material.clone());
        for backend in backends() {
            let (_folder, page) = bake(
                &path,
                &["--size", "8", "--backend", backend, "--model", "phong"],
            );
            let found = radiance(&page);
            let worst = (0..3)
                .map(|c| (found[c] - expected[c]).abs())
                .fold(0.0, f32::max);
            // Three products and a sum in f32.
            assert!(
                worst <= 3e-7,
                "{backend}, {material}: {found:?}, not {expected:?}"
            );
        }
    }
}

#[test]
fn a_glossy_obj_material_bakes_at_most_one_and_says_what_was_scaled() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let library = "newmtl gloss\nKd 1 0.5 0.25\nKs 1 1 1\nNs 20\n";
    std::fs::write(folder.path().join("a.mtl"), library).expect("a file");
    let path = folder.path().join("a.obj");
    let text = "mtllib a.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nusemtl gloss\nf 1 2 3 4\n";
    std::fs::write(&path, text).expect("a file");
    let (baked, page) = bake(&path, &["--size", "8"]);
    let found = radiance(&page);
    let worst = found
        .iter()
        .zip([1.0, 0.75, 0.625])
        .map(|(value, expected)| (value - expected).abs())
        .fold(0.0, f32::max);
    assert!(worst <= 3e-7, "{found:?}: both are halved");
    let warning = &report(baked.path())["warnings"][0];
    assert_eq!(
        (&warning["kind"], &warning["place"], &warning["count"]),
        (
            &json!("reflectance-scaled"),
            &json!("material `gloss`"),
            &json!(1)
        )
    );
}

#[test]
fn coefficients_that_reflect_more_than_arrives_are_told_of() {
    let told = |words: &[&str]| {
        let scene = scene("plane.obj").display().to_string();
        let plan = run_well([&["plan", &scene, "--json"], words].concat());
        let plan: Value = serde_json::from_str(&plan).expect("JSON");
        let warnings = plan["warnings"].as_array().expect("a list").clone();
        let mut warnings = warnings.into_iter();
        warnings.find_map(|warning| match warning["kind"] == "too-bright" {
            true => warning["message"].as_str().map(String::from),
            false => None,
        })
    };
    let white = told(&["--albedo", "1,1,1", "--specular", "1,1,1"]).expect("a warning");
    assert!(white.contains("reflect 2 times the light"), "{white}");
    assert!(told(&["--albedo", "0,0.75,0", "--specular", "0,0.5,0"]).is_some());
    for quiet in [
        &["--albedo", "0.75,0.75,0.75", "--specular", "0.25,0.25,0.25"][..],
        &["--albedo", "1,1,1"],
        &["--albedo", "1,0,1", "--specular", "0,1,0"],
        &["--albedo", "1,1,1", "--specular", "1,1,1", "--model", "ggx"],
    ] {
        assert_eq!(told(quiet), None, "{quiet:?}");
    }
}
