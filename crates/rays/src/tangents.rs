//! Normals and tangents of a mesh's triangles: glTF's, the file's where it has tangents, else MikkTSpace's.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use scene::Mesh;

/// Unit normals at a triangle's corners in mesh space: the mesh's, else its own.
pub(crate) fn normals(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    let vertices = mesh.triangles[triangle];
    if mesh.normals.is_empty() {
        let [a, b, c] = vertices.map(|v| mesh.positions[v as usize].as_dvec3());
        return [(b - a).cross(c - a).normalize_or_zero().as_vec3(); 3];
    }
    vertices.map(|v| mesh.normals[v as usize])
}

/// Tangents of every triangle's corners: the file's, or MikkTSpace's. Of a mesh without normals of its own the file's
/// are not used, as the glTF specification says.
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
