//! Whole scenes, written and loaded again.

use super::support::{assert_valid, corners, layout, open, write};
use glam::Vec3;
use scene::{MaterialModel, Scene, phong_from_metallic_roughness};
use serde_json::{Value, json};
use std::fs;

#[test]
fn real_models_are_valid_and_load_again() {
    let dir = tempfile::tempdir().unwrap();
    let mut written = Vec::new();
    for (name, split, pages) in [
        ("boeing_787/scene.gltf", true, 2),
        ("flight_helmet/FlightHelmet.gltf", false, 1),
        ("oak_small_alphamask.glb", true, 1),
        ("suzi.glb", true, 1),
        ("cornell_box/CornellBox.glb", false, 2),
        ("game_level_zdm2.glb", false, 1),
        ("spot.obj", true, 2),
        ("gazebo/gazebo.obj", false, 1),
    ] {
        let Some(model) = crate::skip::model(name) else {
            continue;
        };
        let before = scene::load(&model).unwrap();
        let file = format!("{}.glb", written.len());
        let path = write(&before, &layout(&before, split, pages), dir.path(), &file);
        // The same triangles in the same places, whatever the layout did to vertices and pages.
        let after = scene::load(&path).unwrap();
        assert_eq!(corners(&after), corners(&before), "{name}");
        assert!(
            after.meshes.iter().all(|mesh| mesh.uv_sets.len() >= 2),
            "{name}"
        );
        written.push(path);
    }
    assert_valid(&written);
}

#[test]
fn compressed_scenes_are_written_plain_and_valid() {
    let dir = tempfile::tempdir().unwrap();
    let fixtures = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../scene/tests/files/compressed"
    );
    let mut written = Vec::new();
    for name in [
        "pack",
        "pack_khr",
        "pack_float",
        "transform",
        "draco",
        "draco_sequential",
    ] {
        let before =
            scene::load(&std::path::Path::new(fixtures).join(format!("{name}.glb"))).unwrap();
        let path = write(
            &before,
            &layout(&before, true, 2),
            dir.path(),
            &format!("{name}.glb"),
        );
        assert_eq!(
            corners(&scene::load(&path).unwrap()),
            corners(&before),
            "{name}"
        );
        let (json, _) = open(&path);
        assert!(!json.to_string().contains("_compression"), "{name}");
        written.push(path);
    }
    assert_valid(&written);
}

#[test]
fn lamps_of_an_obj_scene_keep_their_radiance() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let lamps = "newmtl strong\nKe 6 3 1.5\nnewmtl weak\nKe 0.25 0.5 0\nnewmtl dark\nKe 0 0 0\n";
    fs::write(at("lamps.mtl"), lamps).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let faces = ["strong", "weak", "dark"].map(|name| format!("usemtl {name}\nf 1 2 3\n"));
    let text = format!("mtllib lamps.mtl\n{corners}{}", faces.concat());
    fs::write(at("lamps.obj"), text).unwrap();
    let before = scene::load(&at("lamps.obj")).unwrap();
    let path = write(&before, &layout(&before, false, 1), dir.path(), "lamps.glb");
    let after = scene::load(&path).unwrap();
    let radiances = |scene: &Scene| {
        let of = |mesh: &scene::Mesh| scene.materials[mesh.material as usize].emission.to_array();
        scene.meshes.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(
        radiances(&before),
        [[6.0, 3.0, 1.5], [0.25, 0.5, 0.0], [0.0; 3]]
    );
    assert_eq!(radiances(&after), radiances(&before));
    let (json, _) = open(&path);
    assert_eq!(
        json["extensionsUsed"],
        json!(["KHR_materials_specular", "KHR_materials_emissive_strength"])
    );
    assert_eq!(
        json["materials"][1]["extensions"],
        json!({ "KHR_materials_specular": { "specularFactor": 0.0 } })
    );
    assert_valid(&[path]);
}

/// The models of a picture from a bake must be those of the scene, or the picture is darker than the integrated one.
#[test]
fn materials_of_an_obj_scene_come_back_as_they_were() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let library = "newmtl matt\nKd 1 0.5 0.25\nnewmtl coat\nKd 0.5 0.25 0.125\nKs 0.25 0.5 0\nNs 40\nnewmtl both\n\
        Kd 1 1 1\nKs 1 1 1\n";
    fs::write(at("a.mtl"), library).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let faces = ["matt", "coat", "both"].map(|name| format!("usemtl {name}\nf 1 2 3\n"));
    let text = format!("mtllib a.mtl\n{corners}{}", faces.concat());
    fs::write(at("a.obj"), text).unwrap();
    let before = scene::load(&at("a.obj")).unwrap();
    let path = write(&before, &layout(&before, false, 1), dir.path(), "a.glb");
    let after = scene::load(&path).unwrap();
    let phong = |scene: &Scene| {
        let of = |mesh: &scene::Mesh| match &scene.materials[mesh.material as usize].surface {
            MaterialModel::Phong {
                albedo,
                specular,
                exponent,
                ..
            } => (*albedo, *specular, *exponent),
            MaterialModel::MetallicRoughness {
                base,
                metallic,
                roughness,
                dielectric,
                ..
            } => phong_from_metallic_roughness(*base, *metallic, *roughness, *dielectric),
            MaterialModel::SpecularGlossiness { .. } => unreachable!(),
        };
        scene.meshes.iter().map(of).collect::<Vec<_>>()
    };
    for (found, given) in phong(&after).iter().zip(phong(&before)) {
        let off = (found.0 - given.0).abs().max((found.1 - given.1).abs());
        assert!(off.max_element() < 1e-6, "{found:?} for {given:?}");
        assert!(
            (found.2 - given.2).abs() < 1e-4 * (1.0 + given.2),
            "{found:?} for {given:?}"
        );
    }
    // Engines multiply lightmaps by the base colour: it is the albedo, without a coat that takes light away.
    let (json, _) = open(&path);
    for (written, (albedo, specular, exponent)) in json["materials"]
        .as_array()
        .unwrap()
        .iter()
        .zip(phong(&before))
    {
        let base = &written["pbrMetallicRoughness"]["baseColorFactor"];
        assert_eq!(base, &json!([albedo.x, albedo.y, albedo.z, 1.0]));
        let coat = &written["extensions"]["KHR_materials_specular"];
        assert_eq!(coat["specularFactor"], 0.0);
        let highlight = match specular == Vec3::ZERO {
            true => Value::Null,
            false => json!({ "ambake": { "Ks": specular.to_array(), "Ns": exponent } }),
        };
        assert_eq!(written["extras"], highlight);
    }
    assert_valid(&[path]);
}
