//! Scenes that were built in memory.

use super::support::{assert_valid, corners, layout, open, write};
use ambake_report::SceneReport;
use scene::Scene;
use serde_json::json;

#[test]
fn a_scene_built_in_memory_becomes_a_document_of_its_own() {
    use scene::authored::{AlphaMode, Material, Mesh, Texture};
    let mut leaf = Material::default();
    leaf.name = "leaf".into();
    leaf.albedo = [0.5, 1.0, 0.25];
    leaf.alpha_mode = AlphaMode::Mask { cutoff: 0.25 };
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

#[test]
fn materials_of_a_built_scene_come_back_from_its_file() {
    use scene::authored::{AlphaMode, Material, Mesh, MetallicRoughness, Texture};
    let texture = |k: u8| Some(Texture::new(2, 1, vec![[k, 200, 30, 255], [9, k, 0, 128]]));
    let mut given = Material::default();
    given.albedo = [0.5, 1.0, 0.25];
    given.albedo_texture = texture(1);
    given.alpha = 0.5;
    given.alpha_mode = AlphaMode::Blend;
    given.emission = [1.0, 0.5, 4.0];
    given.emission_texture = texture(2);
    given.normal_texture = texture(3);
    given.normal_scale = 0.5;
    let mut metal = MetallicRoughness::default();
    (metal.metallic, metal.roughness) = (0.25, 0.75);
    metal.texture = texture(4);
    metal.dielectric = [0.08, 0.04, 0.02];
    given.metallic_roughness = Some(metal);
    let mut plain = Material::default();
    plain.metallic_roughness = Some(MetallicRoughness::default());
    let mut mesh = Mesh::default();
    mesh.positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    mesh.normals = vec![[0., 0., 1.]; 3];
    mesh.tangents = vec![[1., 0., 0., 1.]; 3];
    mesh.uvs = vec![[0., 0.], [1., 0.], [0., 1.]];
    mesh.colors = vec![[1.0, 0.5, 0.25, 0.75]; 3];
    mesh.triangles = vec![[0, 1, 2]];
    let mut other = mesh.clone();
    other.material = 1;
    other.transform[3] = [0.0, 0.0, 5.0, 1.0];
    let before = Scene::from_meshes(vec![mesh, other], vec![given, plain]).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let atlas = layout(&before, true, 1);
    let path = write(&before, &atlas, dir.path(), "scene.glb");
    let after = scene::load(&path).unwrap();
    for (a, b) in before.materials.iter().zip(&after.materials) {
        let pictures = |scene: &Scene, of: &scene::Material| -> Vec<Vec<[u8; 4]>> {
            let maps = of
                .textures()
                .map(|t| scene.images[t.image as usize].pixels.clone());
            let normals = of
                .normal_map
                .iter()
                .map(|map| scene.normal_image(map).unwrap().pixels);
            maps.chain(normals).collect()
        };
        assert_eq!(pictures(&before, a), pictures(&after, b));
        let words = |of: &scene::Material| {
            let mut of = of.clone();
            of.name.clear();
            // The numbers of pictures may differ.
            let words = format!("{of:?}");
            words
                .split("image: ")
                .map(|w| w.trim_start_matches(char::is_numeric).to_owned())
                .collect::<String>()
        };
        assert_eq!(words(a), words(b));
    }
    assert_eq!(
        format!("{:?}", before.meshes[0].tangents),
        format!("{:?}", after.meshes[0].tangents)
    );
    assert_eq!(before.meshes[0].colors, after.meshes[0].colors);
    assert_eq!(before.meshes[0].alphas, after.meshes[0].alphas);
    assert_valid(&[path]);
}
