//! Which meshes rays may be carried into. A transform that single precision cannot serve gets its vertices placed in
//! the world.

use crate::geometry::extent;
use glam::{Affine3A, DVec3};
use scene::Scene;

/// How large the coordinates of rays get: twice the largest of the placed scene, and above the components of unit
/// directions.
pub(crate) fn room(scene: &Scene) -> f64 {
    let extents: Vec<_> = scene.meshes.iter().map(|m| extent(&m.positions)).collect();
    let farthest = |instance: &scene::Instance| {
        let (low, high) = extents[instance.mesh as usize]?;
        let corner = low.abs().max(high.abs()).as_dvec3();
        let matrix = instance.transform.matrix3.abs();
        Some((matrix * corner + instance.transform.translation.abs()).max_element())
    };
    let largest = scene.instances.iter().filter_map(farthest);
    2.0 * largest.fold(1.0, f64::max)
}

/// How far instancing may raise the rounding of a ray's origin above that of vertices placed in the world: at 2^10 an
/// origin stands off by 6e-5 of the scene's coordinates, which is what a surface may lose of what touches it.
const MOST_ROUNDING: f64 = 1024.0;

/// True where a mesh may be held once and rays be carried into its space by this f32 transform. Elsewhere its vertices
/// are placed in the world, in f64, which costs memory and no accuracy.
///
/// * `room`: bound on the coordinates of rays.
pub(crate) fn served(transform: &Affine3A, room: f64) -> bool {
    let backends =
        transform.inverse().is_finite() && embree::serves(&transform.to_cols_array_2d(), room);
    // The matrix of the bound of `Part::rounding`, per unit roundoff and coordinate.
    let (forth, back) = (
        transform.matrix3.as_dmat3(),
        transform.inverse().matrix3.as_dmat3(),
    );
    let there_and_back = forth.abs() * back.abs();
    let rounding = there_and_back * (there_and_back * DVec3::ONE);
    backends && 8.0 * rounding.max_element() <= MOST_ROUNDING
}
