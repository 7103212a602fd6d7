//! Scenes far from the origin, brought near it before coordinates are rounded to 32 bits.
//!
//! At 100,000 units from the origin neighbouring 32-bit numbers are 1/128 apart, and so are the origins of rays. The distance is taken
//! off in 64 bits first. It is a multiple of a power of two no less than half the scene's size, so that 32-bit corners of a mesh that
//! was modelled far away keep their bits' worth.

use glam::{DAffine3, DVec3};
use scene::Scene;
use std::sync::Arc;

/// A scene farther from the origin than so many times its size is moved.
const FAR: f64 = 8.0;

/// The scene, moved near the origin where it is far from it, and what was taken off.
pub(crate) fn brought_near(scene: Arc<Scene>) -> (Arc<Scene>, DVec3) {
    let Some((low, high)) = bounds(&scene) else {
        return (scene, DVec3::ZERO);
    };
    let (size, middle) = ((high - low).max_element(), 0.5 * (low + high));
    let is_far = middle.abs().max_element() > FAR * size;
    if !(is_far && size > 0.0 && middle.is_finite()) {
        return (scene, DVec3::ZERO);
    }
    let step = size.log2().floor().exp2();
    let origin = (middle / step).round() * step;
    let mut near = Scene::clone(&scene);
    for instance in &mut near.instances {
        instance.transform = DAffine3::from_translation(-origin) * instance.transform;
    }
    (Arc::new(near), origin)
}

/// The box of everything that is placed, from the boxes of the meshes.
fn bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
    let boxes: Vec<Option<(DVec3, DVec3)>> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let positions = mesh.positions.iter().map(|p| p.as_dvec3());
            positions.map(|p| (p, p)).reduce(join)
        })
        .collect();
    let corners = scene.instances.iter().flat_map(|instance| {
        let around = boxes[instance.mesh as usize].into_iter();
        let corner = |(low, high): (DVec3, DVec3), corner: usize| {
            let pick = |axis: usize| [low, high][corner >> axis & 1][axis];
            let p = DVec3::new(pick(0), pick(1), pick(2));
            instance.transform.transform_point3(p)
        };
        around.flat_map(move |around| (0..8).map(move |k| corner(around, k)))
    });
    corners.map(|p| (p, p)).reduce(join)
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

    #[test]
    fn the_box_of_a_turned_object_holds_its_own_box_turned() {
        let mut mesh = authored::Mesh::default();
        mesh.positions = vec![[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0], [1.0, -2.0, 3.0]];
        mesh.triangles = vec![[0, 1, 2]];
        let quarter = glam::Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let turned = |turn: glam::Mat4| {
            let mut mesh = mesh.clone();
            mesh.transform = turn.to_cols_array_2d();
            bounds(&Scene::from_meshes(vec![mesh], vec![]).unwrap()).unwrap()
        };
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-5, "{a} {b}");
        let (low, high) = turned(glam::Mat4::IDENTITY);
        near(low, DVec3::new(-1.0, -2.0, -3.0));
        near(high, DVec3::new(1.0, 2.0, 3.0));
        let (low, high) = turned(quarter);
        near(low, DVec3::new(-2.0, -1.0, -3.0));
        near(high, DVec3::new(2.0, 1.0, 3.0));
        let eighth = glam::Mat4::from_rotation_x(std::f32::consts::FRAC_PI_4);
        let (low, high) = turned(eighth);
        let wide = 5.0 / 2f64.sqrt();
        near(low, DVec3::new(-1.0, -wide, -wide));
        near(high, DVec3::new(1.0, wide, wide));
    }
}
