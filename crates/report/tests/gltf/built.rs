//! Scenes that were built in memory.

use super::support::{assert_valid, corners, layout, open, write};
use ambake_report::SceneReport;
use scene::Scene;
use serde_json::json;

#[test]
fn a_scene_built_in_memory_becomes_a_document_of_its_own() {
    use scene::authored::{Material, Mesh, Texture};
    let mut leaf = Material::default();
    leaf.name = "leaf".into();
    leaf.albedo = [0.5, 1.0, 0.25];
    leaf.alpha_cutoff = Some(0.25);
    leaf.albedo_texture = Some(Texture::new(1, 2, vec![[255, 0, 0, 255], [0, 255, 0, 0]]));
    let mut near = Mesh::default();
    near.positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    near.uvs = vec![[0., 0.], [1., 0.], [0., 1.]];
    near.triangles = vec![[0, 1, 2]];
    let mut far = near.clone();
    far.transform[3] = [0.0, 0.0, 5.0, 1.0];
    let before = Scene::from_meshes(vec![near, far], vec![leaf]).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let atlas = layout(&before, true, 1);
    let path = write(&before, &atlas, dir.path(), "scene.glb");
    let after = scene::load(&path).unwrap();
    assert_eq!(corners(&after), corners(&before));
    let (json, _) = open(&path);
    let material = &json["materials"][0];
    assert_eq!(
        (
            &material["name"],
            &material["alphaMode"],
            &material["alphaCutoff"]
        ),
        (&json!("leaf"), &json!("MASK"), &json!(0.25))
    );
    assert_eq!(
        material["pbrMetallicRoughness"]["baseColorFactor"],
        json!([0.5, 1.0, 0.25, 1.0])
    );
    assert_eq!(after.images[0].pixels, before.images[0].pixels);
    let facts = SceneReport::of(&before);
    assert_eq!(
        (facts.path.as_str(), facts.format.as_str()),
        ("scene", "memory")
    );
    assert_valid(&[path]);
}
