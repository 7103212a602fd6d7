//! The triangle sets that rays are cast at, and the boxes about them.

use crate::alpha_test::AlphaTest;
use crate::part::Part;
use glam::{DAffine3, DVec3, Vec3};
use scene::{AlphaBlocks, Mesh, Scene};
use std::ops::Deref;
use std::sync::Arc;

/// Triangles with one vertex array and one alpha test.
#[derive(Debug)]
pub struct Geometry {
    scene: Arc<Scene>,
    /// Index into the scene's meshes.
    pub mesh: u32,
    /// Vertex positions, indexed by [`Geometry::triangles`].
    pub positions: Positions,
    /// Decides which hits stop a ray; `None` where all do.
    pub alpha: Option<AlphaTest>,
    /// The box of the positions.
    pub(crate) extent: Option<(Vec3, Vec3)>,
}

/// Vertex positions, read as a slice. Those that equal the mesh's own are not held twice.
#[derive(Debug)]
pub enum Positions {
    /// The mesh's own array.
    Mesh(Arc<Scene>, u32),
    /// Placed in the world: computed in f64, rounded once.
    Placed(Vec<Vec3>),
}

/// An axis-aligned box in world space; both corners are 0 for a world without triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

impl Geometry {
    /// The geometry of a mesh: in its own space, or placed in the world where a transform is given.
    ///
    /// * `alpha_test`: an opaque mesh gets an alpha test too, one that keeps every hit.
    /// * `blocks`: [`crate::alpha_test::alpha_blocks`] of the scene.
    pub(crate) fn new(
        scene: &Arc<Scene>,
        mesh: u32,
        placed: Option<&DAffine3>,
        alpha_test: bool,
        blocks: &[Option<Arc<AlphaBlocks>>],
    ) -> Self {
        let positions = match placed {
            Some(transform) => Positions::Placed(place(&scene.meshes[mesh as usize], transform)),
            None => Positions::Mesh(Arc::clone(scene), mesh),
        };
        Self {
            scene: Arc::clone(scene),
            mesh,
            extent: extent(&positions),
            positions,
            alpha: AlphaTest::of(scene, mesh, alpha_test, blocks),
        }
    }

    /// Vertex indices, counter-clockwise seen from the front in mesh space.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.mesh().triangles
    }

    /// The mesh it stems from.
    pub fn mesh(&self) -> &Mesh {
        &self.scene.meshes[self.mesh as usize]
    }
}

impl Bounds {
    /// The box of all parts.
    pub(crate) fn of(geometries: &[Geometry], parts: &[Part]) -> Self {
        let mut corners = parts
            .iter()
            .flat_map(|part| part.outline(geometries[part.geometry as usize].extent));
        let Some(first) = corners.next() else {
            return Self {
                min: DVec3::ZERO,
                max: DVec3::ZERO,
            };
        };
        corners.fold(
            Self {
                min: first,
                max: first,
            },
            |bounds, corner| Self {
                min: bounds.min.min(corner),
                max: bounds.max.max(corner),
            },
        )
    }

    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// The length of the box's diagonal.
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }
}

impl Deref for Positions {
    type Target = [Vec3];

    fn deref(&self) -> &[Vec3] {
        match self {
            Self::Mesh(scene, mesh) => &scene.meshes[*mesh as usize].positions,
            Self::Placed(positions) => positions,
        }
    }
}

fn place(mesh: &Mesh, transform: &DAffine3) -> Vec<Vec3> {
    mesh.positions
        .iter()
        .map(|position| transform.transform_point3(position.as_dvec3()).as_vec3())
        .collect()
}

/// The box of the positions; a vertex that is not finite makes it infinite. `None` where there are none.
pub(crate) fn extent(positions: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = *positions.first()?;
    Some(
        positions
            .iter()
            .fold((first, first), |(low, high), &position| {
                let position = if position.is_finite() {
                    position
                } else {
                    Vec3::INFINITY
                };
                (low.min(position), high.max(position))
            }),
    )
}
