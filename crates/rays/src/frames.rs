//! Directions of the world in the tangent frames of its surfaces.

use crate::tangents::{normals, tangents};
use crate::world::World;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::sync::OnceLock;

/// The frames of a world's surfaces in which engines read normals: tangents along the first texture coordinates, which normal maps are
/// mostly read at.
pub struct Frames<'a, F> {
    world: &'a World,
    layout: F,
    /// By mesh, made when first asked for.
    tangents: Vec<OnceLock<Vec<[Vec4; 3]>>>,
}

impl<'a, F: Fn(u32, u32) -> [Vec2; 3]> Frames<'a, F> {
    /// * `layout`: coordinates of the corners of a triangle (mesh, triangle), for meshes without texture coordinates; v grows down.
    pub fn new(world: &'a World, layout: F) -> Self {
        let meshes = world.scene().meshes.iter();
        Self {
            world,
            layout,
            tangents: meshes.map(|_| OnceLock::new()).collect(),
        }
    }

    /// A direction of the world, of unit length, in the frame of a point of a surface: x along the tangent, y along the bitangent (up in
    /// the picture), z along the interpolated normal. A normal map that holds it gives it back. Zero for zero.
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
        DVec3::new(own.dot(tangent), own.dot(bitangent), own.dot(normal))
    }
}
