//! What the rays see: the scene's meshes placed in the world, in the precision of the ray queries.
//!
//! Everything that judges a ray, places its origin or reads its hit takes its corners from here, so all agree on where
//! the triangles are, to the last bit.

pub(crate) mod lit;
#[cfg(test)]
mod tests;

use crate::alpha_test::alpha_blocks;
use crate::error::Error;
use crate::geometry::{Bounds, Geometry};
use crate::instancing::{room, served};
use crate::material::{has_panes, has_tints};
use crate::normal_maps::NormalMaps;
use crate::origin::brought_near;
use crate::part::Part;
use crate::solid::Solids;
use glam::{DAffine3, DVec3};
use lit::Triangles;
use scene::Scene;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// How a [`World`] is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorldOptions {
    /// A mesh with several instances is held once with a transform for each; otherwise every instance is flattened.
    pub instancing: bool,
    /// Opaque meshes get an alpha test too, one that keeps every hit: shows that leaving it out changes nothing.
    pub alpha_test_all: bool,
}

impl Default for WorldOptions {
    /// Instancing, and alpha tests only where a material is masked.
    fn default() -> Self {
        Self {
            instancing: true,
            alpha_test_all: false,
        }
    }
}

/// The placed scene.
#[derive(Debug)]
pub struct World {
    scene: Arc<Scene>,
    /// Distinct triangle sets: flattened meshes in world space, instanced meshes in mesh space.
    pub geometries: Vec<Geometry>,
    /// One part for each of the scene's instances, in the same order.
    pub parts: Vec<Part>,
    bounds: Bounds,
    /// See [`World::origin`].
    origin: DVec3,
    normal_maps: Option<NormalMaps>,
    /// By mesh, the triangles whose back is lit; see [`World::turn_over`].
    backs: Triangles,
    /// By mesh, the triangles whose normals alone point to the other side; see [`World::turn_over`].
    averse: Triangles,
    /// By mesh, the triangles of folds, which keep the side of their winding; see [`World::turn_over`].
    folds: Triangles,
    /// See [`World::solids`].
    solids: OnceLock<Solids>,
    /// See [`World::has_panes`].
    panes: bool,
    /// See [`World::has_tints`].
    tinted: bool,
}

impl World {
    /// The world of a scene.
    ///
    /// # Errors
    /// A placed vertex or a transform that leaves the range of single precision.
    pub fn new(scene: Arc<Scene>, options: WorldOptions) -> Result<Self, Error> {
        let mut uses = vec![0u32; scene.meshes.len()];
        for instance in &scene.instances {
            uses[instance.mesh as usize] += 1;
        }
        let room = room(&scene);
        let blocks = alpha_blocks(&scene);
        let mut shared: Vec<Option<u32>> = vec![None; scene.meshes.len()];
        let mut geometries = Vec::new();
        let mut parts = Vec::with_capacity(scene.instances.len());
        for instance in &scene.instances {
            let mesh = instance.mesh;
            let single = instance.transform.as_affine3a();
            let instanced = options.instancing && uses[mesh as usize] > 1 && served(&single, room);
            let geometry = match shared[mesh as usize].filter(|_| instanced) {
                Some(geometry) => geometry,
                None => {
                    let own = instanced || instance.transform == DAffine3::IDENTITY;
                    let placed = (!own).then_some(&instance.transform);
                    let all = options.alpha_test_all;
                    geometries.push(Geometry::new(&scene, mesh, placed, all, &blocks));
                    let geometry = geometries.len() as u32 - 1;
                    if instanced {
                        shared[mesh as usize] = Some(geometry);
                    }
                    geometry
                }
            };
            let part = Part::new(geometry, instanced.then_some(single), &instance.transform);
            let corners = part.outline(geometries[geometry as usize].extent);
            if corners.iter().any(|corner| !corner.as_vec3().is_finite()) {
                return Err(Error::OutOfRange {
                    file: scene.path.display().to_string(),
                    instance: instance.name.clone(),
                });
            }
            parts.push(part);
        }
        let bounds = Bounds::of(&geometries, &parts);
        let (panes, tinted) = (has_panes(&scene), has_tints(&scene));
        Ok(Self {
            scene,
            geometries,
            parts,
            bounds,
            origin: DVec3::ZERO,
            normal_maps: None,
            backs: HashMap::new(),
            averse: HashMap::new(),
            folds: HashMap::new(),
            solids: OnceLock::new(),
            panes,
            tinted,
        })
    }

    /// The world of a scene, whose coordinates count from [`World::origin`]: a place near the scene where that is far
    /// from its own origin.
    ///
    /// # Errors
    /// See [`World::new`].
    pub fn near(scene: Arc<Scene>, options: WorldOptions) -> Result<Self, Error> {
        let (scene, origin) = brought_near(scene);
        Ok(Self {
            origin,
            ..Self::new(scene, options)?
        })
    }

    /// What world coordinates count from, in the coordinates of the file: 0 but for [`World::near`].
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Takes in the normal maps of the materials, for [`World::bent_normal`]. Rays do not see them.
    ///
    /// # Errors
    /// The maps that placed meshes read are too large.
    pub fn read_normal_maps(&mut self) -> Result<(), Error> {
        self.normal_maps = Some(NormalMaps::of(&self.scene)?);
        Ok(())
    }

    /// The names of the normal maps that count as absent, for they are broken or in a format that is not read, and what
    /// is wrong with each; none where [`World::read_normal_maps`] was not called.
    pub fn broken_normal_maps(&self) -> &[(String, String)] {
        self.normal_maps.as_ref().map_or(&[], |maps| &maps.broken)
    }

    /// The unit mean of the shading normals over a piece of a triangle, bent by the normal map of its material; `None`
    /// where it has none, or where [`World::read_normal_maps`] was not called.
    ///
    /// * `corners`: corner weights of the triangle at three corners of the piece.
    /// * `square`: the piece is the parallelogram on them, not the triangle.
    pub fn bent_normal(
        &self,
        instance: u32,
        triangle: u32,
        corners: [DVec3; 3],
        square: bool,
    ) -> Option<DVec3> {
        let (part, geometry) = self.part(instance);
        let maps = self.normal_maps.as_ref()?;
        let bent = maps.mean(&self.scene, part, geometry.mesh, triangle, corners, square)?;
        Some(self.on_lit_side(bent, instance, triangle))
    }

    /// True where a normal map may bend the shading normals of an instance.
    pub fn bends_normals(&self, instance: u32) -> bool {
        let (_, geometry) = self.part(instance);
        let mesh = &self.scene.meshes[geometry.mesh as usize];
        let has_map = self.scene.materials[mesh.material as usize]
            .normal_map
            .is_some();
        self.normal_maps.is_some() && has_map
    }

    /// The unit shading normal at a point of a triangle, bent by the normal map of its material; `None` where it has
    /// none, or where [`World::read_normal_maps`] was not called.
    pub(crate) fn bent_at(&self, instance: u32, triangle: u32, weights: DVec3) -> Option<DVec3> {
        let (part, geometry) = self.part(instance);
        let maps = self.normal_maps.as_ref()?;
        let bent = maps.at(&self.scene, part, geometry.mesh, triangle, weights)?;
        Some(self.on_lit_side(bent, instance, triangle))
    }

    /// The scene this world was built from.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// True where a surface lets a share of light pass: no cut-out, which stops or lets through.
    pub fn has_panes(&self) -> bool {
        self.panes
    }

    /// True where light passes a surface with a tint: the channels of one ray then differ.
    pub fn has_tints(&self) -> bool {
        self.tinted
    }

    /// The solids of this world, found when first asked.
    pub fn solids(&self) -> &Solids {
        self.solids.get_or_init(|| Solids::of(&self.scene))
    }

    /// The part and the geometry of an instance.
    pub fn part(&self, instance: u32) -> (&Part, &Geometry) {
        let part = &self.parts[instance as usize];
        (part, &self.geometries[part.geometry as usize])
    }

    /// A box around everything of an instance that a ray can meet; `None` where its mesh has no vertices.
    pub fn box_of(&self, instance: u32) -> Option<(DVec3, DVec3)> {
        let (part, geometry) = self.part(instance);
        let outline = part.outline(geometry.extent);
        let boxes = outline.into_iter().map(|corner| (corner, corner));
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// World positions of a triangle's corners as the rays see them: the f32 values of a flattened mesh, or the f32
    /// transform applied in f64 to the f32 values of an instanced one.
    pub fn corners(&self, instance: u32, triangle: u32) -> [DVec3; 3] {
        let (part, geometry) = self.part(instance);
        geometry.triangles()[triangle as usize].map(|vertex| {
            let position = geometry.positions[vertex as usize].as_dvec3();
            part.transform
                .map_or(position, |_| part.placed().transform_point3(position))
        })
    }

    /// True where both sides of an instance's surface are drawn, so that it has no back.
    pub fn is_double_sided(&self, instance: u32) -> bool {
        let mesh = self.part(instance).1.mesh();
        self.scene.materials[mesh.material as usize].double_sided
    }

    /// True where what is buried of an instance is baked like the rest of it.
    pub fn keeps_buried(&self, instance: u32) -> bool {
        self.scene.instances[instance as usize].keeps_buried == Some(true)
    }

    /// True where rays meet an instance.
    pub fn casts(&self, instance: u32) -> bool {
        self.scene.instances[instance as usize].casts
    }

    /// Points whose convex hull holds every triangle that a ray can meet: all vertices of flattened parts, the corners
    /// of the transformed
    /// mesh box of instanced ones.
    pub fn hull_points(&self) -> Vec<DVec3> {
        let mut points = Vec::new();
        for (part, _) in self
            .parts
            .iter()
            .zip(&self.scene.instances)
            .filter(|(_, of)| of.casts)
        {
            let geometry = &self.geometries[part.geometry as usize];
            match part.transform {
                None => points.extend(geometry.positions.iter().map(|p| p.as_dvec3())),
                Some(_) => points.extend(part.outline(geometry.extent)),
            }
        }
        points
    }

    /// The smallest known box around all triangles: exact for flattened parts, the box of the transformed mesh box for
    /// instanced ones.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The largest absolute coordinate of [`World::bounds`]; positions round to within this times 2^-24.
    pub fn scale_bound(&self) -> f64 {
        self.bounds
            .min
            .abs()
            .max(self.bounds.max.abs())
            .max_element()
    }
}
