//! Parts of scenes: meshes whose lightmap coordinates are given in texels of a page.

use glam::{DAffine3, DQuat, DVec2, DVec3, Mat4};
use scene::authored::{Material, Mesh};

/// A rectangle of a page in texels: left, top, right, bottom.
pub(super) type Rect = [f64; 4];

/// An empty mesh.
pub(super) fn mesh(name: &str) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.name = name.into();
    mesh
}

/// White, single-sided or double-sided.
pub(super) fn material(double_sided: bool) -> Material {
    let mut material = Material::default();
    material.double_sided = double_sided;
    material
}

/// Adds a polygon, counter-clockwise seen from its front, with its places on a page of `size` texels.
pub(super) fn polygon(mesh: &mut Mesh, size: u32, corners: &[DVec3], places: &[DVec2]) {
    let first = mesh.positions.len() as u32;
    let positions = corners.iter().map(|p| p.as_vec3().to_array());
    mesh.positions.extend(positions);
    let uv = |p: &DVec2| (*p / f64::from(size)).as_vec2().to_array();
    mesh.uvs.extend(places.iter().map(uv));
    for k in 2..corners.len() as u32 {
        mesh.triangles.push([first, first + k - 1, first + k]);
    }
}

/// Adds a quad, counter-clockwise seen from its front, that fills a rectangle of the page: the first corner lies at
/// left and top, the second to the right of it.
pub(super) fn quad(mesh: &mut Mesh, size: u32, corners: [DVec3; 4], [l, t, r, b]: Rect) {
    let places = [[l, t], [r, t], [r, b], [l, b]].map(DVec2::from);
    polygon(mesh, size, &corners, &places);
}

/// A quad as an object of its own.
pub(super) fn sheet(name: &str, size: u32, corners: [DVec3; 4], rect: Rect) -> Mesh {
    let mut sheet = mesh(name);
    quad(&mut sheet, size, corners, rect);
    sheet
}

/// The rectangle `x` by `y` at a height, seen from above.
pub(super) fn level([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> [DVec3; 4] {
    [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]].map(DVec3::from)
}

/// The six faces of the box `-half..half`, counter-clockwise seen from outside: the four upright ones, top, bottom.
pub(super) fn faces(half: DVec3) -> [[DVec3; 4]; 6] {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) * half;
    let side = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| {
        [
            at(ax, ay, -1.0),
            at(bx, by, -1.0),
            at(bx, by, 1.0),
            at(ax, ay, 1.0),
        ]
    };
    let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let flat = |z: f64, [p, q, r, s]: [[f64; 2]; 4]| [p, q, r, s].map(|[x, y]| at(x, y, z));
    [
        side(a, b),
        side(b, c),
        side(c, d),
        side(d, a),
        flat(1.0, [a, b, c, d]),
        flat(-1.0, [d, c, b, a]),
    ]
}

/// Where a scene stands: scaled, then moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub scale: f64,
    pub shift: DVec3,
}

impl Place {
    /// As it was built.
    pub const HOME: Place = Place {
        scale: 1.0,
        shift: DVec3::ZERO,
    };

    /// Puts a mesh there by its transform; its positions keep their digits.
    pub fn put(&self, mesh: &mut Mesh) {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::splat(self.scale),
            DQuat::IDENTITY,
            self.shift,
        );
        mesh.transform = Mat4::from(place.as_affine3a()).to_cols_array_2d();
    }

    /// Where a point of the world was built.
    pub fn home(&self, point: DVec3) -> DVec3 {
        (point - self.shift) / self.scale
    }
}

/// Every triangle turned over, and every normal.
pub(super) fn invert(mesh: &mut Mesh) {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    for normal in &mut mesh.normals {
        *normal = normal.map(|c| -c);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_a_box_look_outward() {
        for face in faces(DVec3::new(1.0, 2.0, 3.0)) {
            let normal = (face[1] - face[0]).cross(face[2] - face[0]);
            let middle = 0.25 * face.iter().sum::<DVec3>();
            assert!(normal.dot(middle) > 0.0, "{face:?}");
        }
    }
}
