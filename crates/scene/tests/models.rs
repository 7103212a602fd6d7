//! Every model of the shared collection loads, with the counts that its README states.

#[path = "../../../tests/skip.rs"]
mod skip;

use ambake_scene::{Alpha, MaterialModel, Scene, WarningKind, load};
use std::path::Path;

fn model(name: &str) -> Option<Scene> {
    let path = skip::model(name)?;
    let scene = load(&path).unwrap_or_else(|e| panic!("{e}"));
    check(&scene);
    Some(scene)
}

/// What [`Scene`] promises.
fn check(scene: &Scene) {
    assert!(!scene.materials.is_empty());
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.normals.is_empty() || mesh.normals.len() == n);
        assert!(
            mesh.normals
                .iter()
                .all(|normal| (normal.length() - 1.0).abs() < 1e-6),
            "{}",
            mesh.name
        );
        assert!(
            mesh.uv_sets
                .iter()
                .all(|set| set.len() == n && set.iter().all(|uv| uv.is_finite()))
        );
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
        assert!((mesh.material as usize) < scene.materials.len());
        assert!(
            mesh.source_triangles.is_empty() || mesh.source_triangles.len() == mesh.triangles.len()
        );
    }
    assert!(
        scene
            .instances
            .iter()
            .all(|i| (i.mesh as usize) < scene.meshes.len())
    );
    assert_eq!(scene.content_hash.len(), 64);
}

/// Triangles in the file: kept and dropped.
fn triangles(scene: &Scene) -> u64 {
    let kept: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    kept as u64 + scene.warned(WarningKind::ZeroAreaTriangles)
}

#[test]
fn boeing_787_has_its_triangles_and_tinted_reflectance() {
    let Some(scene) = model("boeing_787/scene.gltf") else {
        return;
    };
    assert_eq!(
        (triangles(&scene), scene.meshes.len(), scene.images.len()),
        (19_126, 12, 2)
    );
    let MaterialModel::MetallicRoughness {
        dielectric,
        metallic,
        ..
    } = scene.materials[0].surface
    else {
        panic!()
    };
    assert_eq!(dielectric.x, 0.04 * 0.345_905_8_f32);
    assert_eq!(metallic, 0.132_571_83_f32 as f64);
}

#[test]
fn flight_helmet_has_its_triangles_and_one_blend_material() {
    let Some(scene) = model("flight_helmet/FlightHelmet.gltf") else {
        return;
    };
    assert_eq!(triangles(&scene), 94_722);
    let blend = |m: &&ambake_scene::Material| matches!(m.alpha, Alpha::Blend { .. });
    assert_eq!(scene.materials.iter().filter(blend).count(), 1);
    // Five base colours and five metallic-roughness maps; normal maps are not decoded.
    assert_eq!((scene.images.len(), scene.packed_images.len()), (10, 5));
}

#[test]
fn game_level_without_materials_is_untinted() {
    let Some(scene) = model("game_level_zdm2.glb") else {
        return;
    };
    assert_eq!(triangles(&scene), 58_772);
    assert!(
        matches!(scene.materials[0].surface, MaterialModel::Phong { albedo, .. } if albedo == glam::Vec3::ONE)
    );
    assert!(
        scene.meshes[0].uv_sets[0]
            .iter()
            .any(|uv| uv.abs().max_element() > 2.0)
    );
}

#[test]
fn oak_has_masked_leaves() {
    let Some(scene) = model("oak_small_alphamask.glb") else {
        return;
    };
    assert_eq!(triangles(&scene), 6_806);
    let leaves = scene.materials.iter().find(|m| m.name == "leaves").unwrap();
    assert!(leaves.double_sided);
    let Alpha::Mask {
        cutoff,
        map: Some(map),
        ..
    } = &leaves.alpha
    else {
        panic!("{:?}", leaves.alpha)
    };
    assert_eq!(*cutoff, 0.5);
    let corner = scene.alpha(map, glam::Vec2::splat(0.001));
    let centre = scene.alpha(map, glam::Vec2::splat(0.5));
    assert!(
        corner < 0.5 && centre >= 0.5,
        "corner {corner}, centre {centre}"
    );
}

#[test]
fn cornell_box_has_two_uv_sets_an_object() {
    let Some(scene) = model("cornell_box/CornellBox.glb") else {
        return;
    };
    assert_eq!(triangles(&scene), 36);
    assert!(scene.meshes.iter().all(|mesh| mesh.uv_sets.len() == 2));
}

#[test]
fn suzi_has_no_uvs() {
    let Some(scene) = model("suzi.glb") else {
        return;
    };
    assert_eq!(triangles(&scene), 14_842);
    assert!(scene.meshes[0].uv_sets.is_empty() && !scene.meshes[0].normals.is_empty());
}

/// The triangles of an OBJ file as `tobj` reads it: corner positions, UVs (v upward) and normals.
fn referee(path: &Path) -> Vec<[[f32; 8]; 3]> {
    let (models, _) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS).unwrap();
    let corner = |mesh: &tobj::Mesh, i: usize| {
        let get = |from: &[f32], at: usize| from.get(at).copied().unwrap_or(0.0);
        let (p, t, n) = (&mesh.positions, &mesh.texcoords, &mesh.normals);
        let [x, y, z] = [0, 1, 2].map(|k| get(p, 3 * i + k));
        let [a, b, c] = [0, 1, 2].map(|k| get(n, 3 * i + k));
        [x, y, z, get(t, 2 * i), get(t, 2 * i + 1), a, b, c]
    };
    let triangles = |mesh: &tobj::Mesh| -> Vec<_> {
        mesh.indices
            .chunks_exact(3)
            .map(|t| [0, 1, 2].map(|k| corner(mesh, t[k] as usize)))
            .collect()
    };
    models
        .iter()
        .flat_map(|model| triangles(&model.mesh))
        .collect()
}

#[test]
fn obj_models_agree_with_tobj_corner_by_corner() {
    for (name, count) in [("spot.obj", 5_856), ("gazebo/gazebo.obj", 730)] {
        let Some(scene) = model(name) else { return };
        assert_eq!(triangles(&scene), count, "{name}");
        let referee = referee(&scene.path);
        let mut compared = 0;
        for mesh in &scene.meshes {
            assert!(mesh.source_triangles.is_empty(), "{name} loses triangles");
            for triangle in &mesh.triangles {
                for (k, &i) in triangle.iter().enumerate() {
                    let [x, y, z, u, v, a, b, c] = referee[compared][k];
                    let i = i as usize;
                    assert_eq!(mesh.positions[i].to_array(), [x, y, z]);
                    assert_eq!(mesh.uv_sets[0][i].to_array(), [u, 1.0 - v]);
                    let normal = mesh.normals.get(i).map_or([0.0; 3], |n| n.to_array());
                    let unit = glam::DVec3::new(a as f64, b as f64, c as f64)
                        .normalize_or_zero()
                        .as_vec3()
                        .to_array();
                    assert_eq!(normal, unit);
                }
                compared += 1;
            }
        }
        assert_eq!(compared, referee.len());
    }
}
