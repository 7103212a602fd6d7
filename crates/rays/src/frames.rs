//! Tangent frames of surfaces: glTF's, the file's where it has tangents, else MikkTSpace's.

use crate::world::World;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec3, Vec2, Vec3, Vec4};
use scene::Mesh;
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

/// Unit normals at a triangle's corners in mesh space: the mesh's, else its own.
pub(crate) fn normals(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    let vertices = mesh.triangles[triangle];
    if mesh.normals.is_empty() {
        let [a, b, c] = vertices.map(|v| mesh.positions[v as usize].as_dvec3());
        return [(b - a).cross(c - a).normalize_or_zero().as_vec3(); 3];
    }
    vertices.map(|v| mesh.normals[v as usize])
}

/// Tangents of every triangle's corners: the file's, or MikkTSpace's. Of a mesh without normals of its own the file's are
/// not used, as the glTF specification says.
///
/// * `uv`: coordinates of a triangle's corner, v growing down.
pub(crate) fn tangents(mesh: &Mesh, uv: impl Fn([usize; 2]) -> Vec2) -> Vec<[Vec4; 3]> {
    if !mesh.tangents.is_empty() && !mesh.normals.is_empty() {
        let corners = |triangle: &[u32; 3]| triangle.map(|v| mesh.tangents[v as usize]);
        return mesh.triangles.iter().map(corners).collect();
    }
    let mut made = Made {
        mesh,
        uv,
        // Where a triangle has no texture area and no neighbour that has, the map does not bend it.
        tangents: vec![[Vec4::W; 3]; mesh.triangles.len()],
    };
    // It knows no error today; triangles that it did not reach would stay unbent.
    let _ = generate_tangents(&mut made);
    made.tangents
}

/// A mesh as MikkTSpace reads and writes it.
struct Made<'a, F> {
    mesh: &'a Mesh,
    uv: F,
    tangents: Vec<[Vec4; 3]>,
}

impl<F: Fn([usize; 2]) -> Vec2> Geometry for Made<'_, F> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[self.mesh.triangles[face][vert] as usize].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        normals(self.mesh, face)[vert].to_array()
    }

    /// With v upward, as the green of a normal map is.
    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        let uv = (self.uv)([face, vert]);
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        if let Some(space) = space {
            self.tangents[face][vert] = Vec4::from(space.tangent_encoded());
        }
    }
}
