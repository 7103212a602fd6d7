//! Directions of the world in the tangent frames of its surfaces.

use crate::tangents::{normals, tangents};
use crate::world::World;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::sync::OnceLock;

/// The frames of a world's surfaces in which engines read normals: tangents along the first texture coordinates, which
/// normal maps are mostly read at.
pub struct Frames<'a, F> {
    world: &'a World,
    layout: F,
    /// By mesh, made when first asked for.
    tangents: Vec<OnceLock<Vec<[Vec4; 3]>>>,
}

impl<'a, F: Fn(u32, u32) -> [Vec2; 3]> Frames<'a, F> {
    /// * `layout`: coordinates of the corners of a triangle (mesh, triangle), for meshes without texture coordinates; v
    ///   grows down.
    pub fn new(world: &'a World, layout: F) -> Self {
        let meshes = world.scene().meshes.iter();
        Self {
            world,
            layout,
            tangents: meshes.map(|_| OnceLock::new()).collect(),
        }
    }

    /// A direction of the world, of unit length, in the frame of a point of a surface: x along the tangent, y along the
    /// bitangent (up in the picture), z along the interpolated normal. A normal map that holds it gives it back. Zero
    /// for zero.
    ///
    /// * `weights`: corner weights of the triangle.
    pub fn local(&self, instance: u32, triangle: u32, weights: DVec3, direction: DVec3) -> DVec3 {
        let (part, geometry) = self.world.part(instance);
        let mesh = geometry.mesh();
        let tangents = self.tangents[geometry.mesh as usize].get_or_init(|| {
            tangents(mesh, |[triangle, corner]| match mesh.uv_sets.first() {
                Some(set) => set[mesh.triangles[triangle][corner] as usize],
                None => (self.layout)(geometry.mesh, triangle as u32)[corner],
            })
        });
        let corners = tangents[triangle as usize];
        let mean = |of: [Vec3; 3]| {
            let [a, b, c] = of.map(|v| v.as_dvec3());
            (a * weights.x + b * weights.y + c * weights.z).normalize_or_zero()
        };
        let normal = mean(normals(mesh, triangle as usize));
        let tangent = mean(corners.map(Vec4::truncate));
        let bitangent = normal.cross(tangent) * f64::from(corners[0].w);
        // As normal maps are read: bent in the mesh's space, then carried into the world.
        let own = part.fetch_normal(direction).normalize_or_zero();
        // A back is drawn with all of the frame reversed.
        let own = match self.world.reverses(instance, triangle) {
            true => -own,
            false => own,
        };
        DVec3::new(own.dot(tangent), own.dot(bitangent), own.dot(normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{scene, soup, world};

    #[test]
    fn a_frame_is_that_of_the_interpolated_normal_and_tangent() {
        let mut mesh = soup(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
        mesh.normals = vec![Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.6, 0.8)];
        mesh.uv_sets = vec![vec![Vec2::ZERO, Vec2::X, Vec2::NEG_Y]];
        let normals = mesh.normals.clone();
        let world = world(scene(vec![mesh]));
        let frames = Frames::new(&world, |_, _| unreachable!("the mesh has coordinates"));
        for weights in [
            DVec3::new(0.5, 0.375, 0.125),
            DVec3::new(0.125, 0.25, 0.625),
            DVec3::new(0.25, 0.625, 0.125),
        ] {
            let at = |k: usize| normals[k].as_dvec3() * weights[k];
            let normal = (at(0) + at(1) + at(2)).normalize();
            let local = |direction: DVec3| frames.local(0, 0, weights, direction);
            assert!(
                (local(normal) - DVec3::Z).length() < 0.08,
                "{}",
                local(normal)
            );
            let up = local(normal).z;
            assert!((up - 1.0).abs() < 1e-6, "{up} along the normal");
            // The tangent follows u, the bitangent points against v.
            let east = local(DVec3::X).normalize();
            let north = local(DVec3::Y).normalize();
            assert!(east.x > 0.85 && east.y.abs() < 0.2, "{east}");
            assert!(north.y > 0.85 && north.x.abs() < 0.2, "{north}");
            // What is at right angles to the normal has no part along it.
            assert!(local(normal.any_orthonormal_vector()).z.abs() < 1e-6);
        }
    }
}
