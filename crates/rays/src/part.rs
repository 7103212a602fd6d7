//! Where one of the scene's instances stands, and what its transform costs in rounding.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};

/// Unit roundoff of f32.
const UNIT_ROUNDOFF: f64 = 1.0 / 16_777_216.0;

/// One of the scene's instances as the rays see it.
#[derive(Debug)]
pub struct Part {
    /// Index into [`crate::World::geometries`].
    pub geometry: u32,
    /// Mesh space to world space as the backends take it; `None` where the geometry is in world space.
    pub transform: Option<Affine3A>,
    mirrored: bool,
    placed: DAffine3,
    inverse: DAffine3,
    normals: DMat3,
}

impl Part {
    pub(crate) fn new(geometry: u32, transform: Option<Affine3A>, exact: &DAffine3) -> Self {
        let placed = transform.map_or(DAffine3::IDENTITY, |single| single.as_daffine3());
        Self {
            geometry,
            transform,
            mirrored: exact.matrix3.determinant() < 0.0,
            placed,
            inverse: placed.inverse(),
            normals: exact.matrix3.inverse().transpose(),
        }
    }

    /// True where the placement turns counter-clockwise into clockwise.
    pub fn mirrors(&self) -> bool {
        self.mirrored
    }

    /// A normal of the mesh's space in the world, not of unit length.
    pub(crate) fn carry_normal(&self, normal: DVec3) -> DVec3 {
        self.normals * normal
    }

    /// The inverse of [`Part::carry_normal`].
    pub(crate) fn fetch_normal(&self, normal: DVec3) -> DVec3 {
        self.normals.inverse() * normal
    }

    /// World space to the geometry's space, in f64; the identity for a flattened part.
    pub fn inverse(&self) -> &DAffine3 {
        &self.inverse
    }

    /// Geometry space to world space, in f64: exactly [`Part::transform`], or the identity.
    pub fn placed(&self) -> &DAffine3 {
        &self.placed
    }

    /// A bound on how much the part's transform lengthens a vector; 1 for a flattened part.
    pub fn stretch(&self) -> f64 {
        let columns = [
            self.placed.matrix3.x_axis,
            self.placed.matrix3.y_axis,
            self.placed.matrix3.z_axis,
        ];
        match self.transform {
            None => 1.0,
            Some(_) => columns
                .iter()
                .map(|column| column.length_squared())
                .sum::<f64>()
                .sqrt(),
        }
    }

    /// A bound, in world units along the unit vector `normal`, on what an f32 transformation of a ray into mesh space
    /// moves it near these world-space corners; 0 for a flattened part.
    ///
    /// With M the transform, N its inverse and s the translation, a computed inverse and one transformed point differ
    /// from the exact by at most `8 u |N| |M| |N| (|o| + |s|)` in mesh space, first order in u = 2^-24 (running error
    /// analysis: Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, sections 3 and 14).
    pub fn rounding(&self, normal: DVec3, corners: &[DVec3; 3]) -> f64 {
        if self.transform.is_none() {
            return 0.0;
        }
        let (forth, back) = (self.placed.matrix3, self.inverse.matrix3);
        let reach = corners[0].abs().max(corners[1].abs()).max(corners[2].abs())
            + self.placed.translation.abs();
        let moved = back.abs() * (forth.abs() * (back.abs() * reach));
        8.0 * UNIT_ROUNDOFF * (forth.transpose() * normal).abs().dot(moved)
    }

    /// Points whose box encloses the placed geometry, from the box of its positions; none without one.
    pub(crate) fn outline(&self, extent: Option<(Vec3, Vec3)>) -> Vec<DVec3> {
        let Some((low, high)) = extent else {
            return Vec::new();
        };
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        if self.transform.is_none() {
            return vec![low, high];
        }
        (0..8)
            .map(|corner| {
                let pick = |axis: usize| {
                    if corner >> axis & 1 == 0 {
                        low[axis]
                    } else {
                        high[axis]
                    }
                };
                self.placed
                    .transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
            })
            .collect()
    }
}
