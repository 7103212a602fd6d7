//! Whole scenes, written and loaded again.

use super::support::{assert_valid, corners, layout, open, write};
use scene::Scene;
use serde_json::json;
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
fn lamps_of_an_obj_scene_keep_their_radiance() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let lamps = "newmtl strong\nKe 6 3 1.5\nnewmtl weak\nKe 0.25 1 0\nnewmtl dark\nKe 0 0 0\n";
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
        [[6.0, 3.0, 1.5], [0.25, 1.0, 0.0], [0.0; 3]]
    );
    assert_eq!(radiances(&after), radiances(&before));
    let (json, _) = open(&path);
    assert_eq!(
        json["extensionsUsed"],
        json!(["KHR_materials_emissive_strength"])
    );
    assert_eq!(json["materials"][1].get("extensions"), None);
    assert_valid(&[path]);
}
