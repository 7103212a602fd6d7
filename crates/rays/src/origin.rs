//! Scenes far from the origin, brought near it before coordinates are rounded to 32 bits.
//!
//! At 100,000 units from the origin neighbouring 32-bit numbers are 1/128 apart, and so are the origins of
//! rays. The distance ([`scene::far`]) is taken off in 64 bits first.

use glam::{DAffine3, DVec3};
use scene::Scene;
use std::sync::Arc;

/// The scene, moved near the origin where it is far from it, and what was taken off.
pub(crate) fn brought_near(scene: Arc<Scene>) -> (Arc<Scene>, DVec3) {
    let placed = scene.instances.iter();
    let placed = placed.map(|of| (&scene.meshes[of.mesh as usize], &of.transform));
    let origin = scene::far::home_of(placed);
    if origin == DVec3::ZERO {
        return (scene, origin);
    }
    let mut near = Scene::clone(&scene);
    for instance in &mut near.instances {
        instance.transform = DAffine3::from_translation(-origin) * instance.transform;
    }
    (Arc::new(near), origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::authored;

    fn at(shift: DVec3) -> (Arc<Scene>, DVec3) {
        let mut mesh = authored::Mesh::default();
        mesh.positions = vec![[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [1.5, 0.0, 1.25]];
        mesh.triangles = vec![[0, 1, 2]];
        mesh.transform = glam::Mat4::from_translation(shift.as_vec3()).to_cols_array_2d();
        let scene = Scene::from_meshes(vec![mesh], vec![]).unwrap();
        let placed = scene.instances[0].transform.translation;
        (Arc::new(scene), placed)
    }

    #[test]
    fn a_far_scene_keeps_its_shape_and_a_near_one_its_place() {
        let (scene, far) = at(DVec3::new(1e5, -3e4, 2e4) + 0.3);
        let (near, origin) = brought_near(scene);
        let placed = near.instances[0].transform.translation;
        assert!(
            (placed + origin - far).length() < 1e-10,
            "{placed} + {origin}"
        );
        assert!(placed.abs().max_element() <= 2.0, "{placed}");
        assert_eq!(
            origin,
            origin.round(),
            "whole steps keep the bits of 32-bit corners"
        );
        let (scene, home) = at(DVec3::new(3.0, 2.0, 1.0));
        let (near, origin) = brought_near(scene);
        assert_eq!(near.instances[0].transform.translation, home);
        assert_eq!(origin, DVec3::ZERO);
    }
}
