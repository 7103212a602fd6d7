//! What is baked.

use crate::error::Error;
pub use ::scene::Warning;
pub use ::scene::authored::{AlphaMode, Material, Mesh, MetallicRoughness, Placement, Texture};
use std::ops::Deref;
use std::sync::Arc;

/// A validated scene. Clones share one copy.
///
/// It dereferences to its plain data: meshes, instances, materials, images, and the [`Warning`]s about what was
/// repaired or ignored.
#[derive(Debug, Clone)]
pub struct Scene(pub(crate) Arc<::scene::Scene>);

impl Scene {
    /// A scene of meshes in memory. Each mesh becomes one object. The validation is that of a file.
    ///
    /// * `materials`: [`Mesh::material`] indexes here. Without any, every mesh is white and Lambertian.
    ///
    /// # Errors
    /// One line that names the mesh, the place and the cure.
    pub fn from_meshes(meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Self, Error> {
        let scene = ::scene::Scene::from_meshes(meshes, materials)?;
        Ok(Self(Arc::new(scene)))
    }

    /// As [`Scene::from_meshes`], with each mesh placed as often as `placements` say: each placement becomes one
    /// object. Objects of one mesh share its triangles, its ray tree and the shape of its layout, and have a rectangle
    /// of texels each.
    ///
    /// # Errors
    /// As [`Scene::from_meshes`]; a placement's mesh number is out of range.
    ///
    /// ```
    /// # fn main() -> Result<(), ambake::Error> {
    /// use ambake::{Bake, Mesh, Placement, Scene};
    /// let mut slab = Mesh::default();
    /// slab.positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, 0.0]];
    /// slab.triangles = vec![[0, 1, 2], [0, 2, 3]];
    /// let (low, mut high) = (Placement::default(), Placement::default());
    /// high.transform[3] = [0.0, 1.5, 0.0, 1.0];
    /// let scene = Scene::from_placements(vec![slab], vec![], vec![low, high])?;
    /// let baked = Bake::new(&scene).size(32).rays(16).run(&())?;
    /// assert_eq!(baked.objects().count(), 2);
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_placements(
        meshes: Vec<Mesh>,
        materials: Vec<Material>,
        placements: Vec<Placement>,
    ) -> Result<Self, Error> {
        let scene = ::scene::Scene::from_placements(meshes, materials, placements)?;
        Ok(Self(Arc::new(scene)))
    }

    /// The name that output files begin with: the scene file's without its ending, else `scene`.
    pub fn stem(&self) -> String {
        let stem = self.0.path.file_stem();
        stem.map_or_else(
            || "scene".into(),
            |stem| stem.to_string_lossy().into_owned(),
        )
    }
}

impl Deref for Scene {
    type Target = ::scene::Scene;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl From<::scene::Scene> for Scene {
    fn from(scene: ::scene::Scene) -> Self {
        Self(Arc::new(scene))
    }
}

impl From<Arc<::scene::Scene>> for Scene {
    fn from(scene: Arc<::scene::Scene>) -> Self {
        Self(scene)
    }
}
