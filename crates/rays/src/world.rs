//! What the rays see: the scene's meshes placed in the world, in the precision of the ray queries.
//!
//! Everything that judges a ray, places its origin or reads its hit takes its corners from here, so all agree on where
//! the triangles are, to the last bit.

use crate::alpha_test::alpha_blocks;
use crate::error::Error;
use crate::geometry::{Bounds, Geometry};
use crate::instancing::{room, served};
use crate::material::has_tints;
use crate::normal_maps::NormalMaps;
use crate::origin::brought_near;
use crate::part::Part;
use crate::solid::Solids;
use glam::{DAffine3, DVec3};
use scene::Scene;
use std::collections::{HashMap, HashSet};
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

/// Mean cosine between shading normals and the winding's below which they clearly look to the other side.
const CLEARLY: f64 = 0.5;

/// Least cosine between a shading normal and the surface's: one degree above it.
const LOWEST: f64 = 0.017_452_406_437_283_51;

/// A unit shading normal, that leans no farther from the unit normal of its surface than it may.
pub fn above(normal: DVec3, up: DVec3) -> DVec3 {
    if normal.dot(up) >= LOWEST {
        return normal;
    }
    let along = (normal - up * normal.dot(up)).try_normalize();
    along.map_or(up, |along| {
        up * LOWEST + along * (1.0 - LOWEST * LOWEST).sqrt()
    })
}

/// A triangle as it is lit.
pub(crate) struct Lit {
    /// See [`World::face`].
    pub face: DVec3,
    /// See [`World::normals`].
    pub normals: Option<[DVec3; 3]>,
    /// The file's normals point away from the lit side, though it is known, or have none and it is not the winding's.
    pub is_reversed: bool,
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
    backs: HashMap<u32, HashSet<u32>>,
    /// By mesh, the triangles whose normals alone point to the other side; see [`World::turn_over`].
    averse: HashMap<u32, HashSet<u32>>,
    /// See [`World::solids`].
    solids: OnceLock<Solids>,
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
        let tinted = has_tints(&scene);
        Ok(Self {
            scene,
            geometries,
            parts,
            bounds,
            origin: DVec3::ZERO,
            normal_maps: None,
            backs: HashMap::new(),
            averse: HashMap::new(),
            solids: OnceLock::new(),
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

    /// A direction by the normals of the file, reversed where these are reversed.
    pub(crate) fn on_lit_side(&self, by_file: DVec3, instance: u32, triangle: u32) -> DVec3 {
        let corners = self.corners(instance, triangle);
        match self.lit(instance, triangle, &corners).is_reversed {
            true => -by_file,
            false => by_file,
        }
    }

    /// The scene this world was built from.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// True where light passes a surface with a tint: the channels of one ray then differ.
    pub fn has_tints(&self) -> bool {
        self.tinted
    }

    /// The solids of this world, found when first asked.
    pub fn solids(&self) -> &Solids {
        self.solids.get_or_init(|| Solids::of(&self.scene))
    }

    /// Lights closed bodies that look inward from behind where nobody is within, and sheets that look at something
    /// close ([`Solids::backs`]): normals point to the other side, and nothing else changes. So do those that point
    /// into a body which looks outward, or away from where their surface looks ([`Solids::averse`]).
    ///
    /// * `places`: where lights and eyes are, in the coordinates of the file.
    pub fn turn_over(&mut self, places: impl Iterator<Item = DVec3>) {
        [self.backs, self.averse] = self.backs_by(places);
    }

    /// True where [`World::turn_over`] with these places would change nothing.
    pub fn is_turned_by(&self, places: impl Iterator<Item = DVec3>) -> bool {
        let [backs, averse] = self.backs_by(places);
        backs == self.backs && averse == self.averse
    }

    /// By mesh, the triangles whose backs are lit, and those whose normals alone turn round.
    fn backs_by(&self, places: impl Iterator<Item = DVec3>) -> [HashMap<u32, HashSet<u32>>; 2] {
        let places: Vec<DVec3> = places.map(|place| place - self.origin).collect();
        let solids = self.solids();
        [solids.backs(&places), solids.averse(&places)].map(|found| {
            let found = found.into_iter();
            found
                .map(|(mesh, of)| (mesh, of.into_iter().collect()))
                .collect()
        })
    }

    /// True where a triangle is lit from behind.
    #[inline]
    pub fn is_turned_over(&self, instance: u32, triangle: u32) -> bool {
        !self.backs.is_empty() && {
            let mesh = self.part(instance).1.mesh;
            (self.backs.get(&mesh)).is_some_and(|of| of.contains(&triangle))
        }
    }

    /// True where some of an instance is lit from behind.
    pub fn has_turned_over(&self, instance: u32) -> bool {
        self.backs.contains_key(&self.part(instance).1.mesh)
    }

    /// The share of an instance's surface, 0..=1, of which the normals alone point to the other side than the one that
    /// is lit.
    pub fn averse_share(&self, instance: u32) -> f64 {
        let geometry = self.part(instance).1;
        let Some(averse) = self.averse.get(&geometry.mesh) else {
            return 0.0;
        };
        let (mut all, mut own) = (0.0, 0.0);
        for triangle in 0..geometry.triangles().len() as u32 {
            let [a, b, c] = self.corners(instance, triangle);
            let area = (b - a).cross(c - a).length();
            all += area;
            own += if averse.contains(&triangle) {
                area
            } else {
                0.0
            };
        }
        own / f64::max(all, f64::MIN_POSITIVE)
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

    /// The normal of a triangle on its lit side, to which texels send their rays, of twice its area's length.
    pub fn face(&self, instance: u32, triangle: u32) -> DVec3 {
        self.lit(instance, triangle, &self.corners(instance, triangle))
            .face
    }

    /// Unit shading normals at a triangle's corners in world space, on its lit side; `None` where the mesh has none.
    pub fn normals(&self, instance: u32, triangle: u32) -> Option<[DVec3; 3]> {
        self.lit(instance, triangle, &self.corners(instance, triangle))
            .normals
    }

    /// A triangle with these corners as it is lit. Its lit side is that of its winding, which mirroring objects and
    /// [`World::turn_over`] turn round; or that of the file's normals, where they clearly look to the other side and
    /// nothing is known of a body. Normals that then point away are reversed where the side is known, and none leans
    /// farther than [`LOWEST`] allows.
    #[inline]
    pub(crate) fn lit(&self, instance: u32, triangle: u32, [a, b, c]: &[DVec3; 3]) -> Lit {
        let is_turned_over = self.is_turned_over(instance, triangle);
        let mut face = (*b - *a).cross(*c - *a);
        if self.part(instance).0.mirrors() != is_turned_over {
            face = -face;
        }
        let Some(mut normals) = self.normals_by_file(instance, triangle) else {
            return Lit {
                face,
                normals: None,
                is_reversed: is_turned_over,
            };
        };
        let lean = (normals[0] + normals[1] + normals[2]).dot(face);
        let mut is_reversed = false;
        if lean < 0.0 {
            if is_turned_over || self.is_averse(instance, triangle) {
                is_reversed = true;
                normals = normals.map(|normal| -normal);
            } else if lean < -3.0 * CLEARLY * face.length() {
                face = -face;
            }
        }
        let leans_far = |normal: &DVec3| normal.dot(face) < LOWEST * face.length();
        if normals.iter().any(leans_far)
            && let Some(up) = face.try_normalize()
        {
            normals = normals.map(|normal| above(normal, up));
        }
        Lit {
            face,
            normals: Some(normals),
            is_reversed,
        }
    }

    #[inline]
    fn normals_by_file(&self, instance: u32, triangle: u32) -> Option<[DVec3; 3]> {
        let (part, geometry) = self.part(instance);
        let mesh = geometry.mesh();
        (!mesh.normals.is_empty()).then(|| {
            mesh.triangles[triangle as usize].map(|vertex| {
                (part.carry_normal(mesh.normals[vertex as usize].as_dvec3())).normalize_or_zero()
            })
        })
    }

    #[inline]
    fn is_averse(&self, instance: u32, triangle: u32) -> bool {
        !self.averse.is_empty() && {
            let mesh = self.part(instance).1.mesh;
            (self.averse.get(&mesh)).is_some_and(|of| of.contains(&triangle))
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, placed_scene, square};
    use crate::geometry::Positions;
    use glam::Vec3;

    fn build(places: &[DAffine3], instancing: bool) -> Result<World, Error> {
        let placed: Vec<_> = places.iter().map(|place| (0, *place)).collect();
        let mut square = square(0.0);
        square.normals = vec![Vec3::new(0.6, 0.0, 0.8); 4];
        World::new(
            Arc::new(placed_scene(vec![square], &placed)),
            WorldOptions {
                instancing,
                alpha_test_all: false,
            },
        )
    }

    #[test]
    fn normals_of_what_is_lit_from_behind_point_outward() {
        for (mirror, side, instancing) in [
            (1.0, None, true),
            (-1.0, None, true),
            (1.0, Some(-1.0), false),
            (-1.0, Some(-1.0), true),
            (1.0, Some(1.0), true),
            (-1.0, Some(1.0), false),
        ] {
            let mut stone = block(Vec3::ZERO, Vec3::ONE, true);
            let outward = |side: f32| {
                let along = |p: &Vec3| side * p.normalize();
                stone.positions.iter().map(along).collect()
            };
            stone.normals = side.map_or(Vec::new(), outward);
            let scale = DVec3::new(mirror, 1.0, 1.0);
            let [near, far] = [3.0, 9.0].map(|x| DVec3::new(x, 0.0, 0.0));
            let places = [near, far].map(|at| {
                DAffine3::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, at)
            });
            let placed = [(0, places[0]), (0, places[1]), (1, DAffine3::IDENTITY)];
            let scene = placed_scene(vec![stone, square(-5.0)], &placed);
            let options = WorldOptions {
                instancing,
                ..WorldOptions::default()
            };
            let mut world = World::new(Arc::new(scene), options).expect("a world");
            // A light in one of the two: they share their mesh.
            world.turn_over([far].into_iter());
            assert!(!world.has_turned_over(0) && !world.has_turned_over(1));
            assert!(world.is_turned_by([far].into_iter()) && !world.is_turned_by([].into_iter()));
            world.turn_over([].into_iter());
            assert!(
                world.has_turned_over(0) && world.has_turned_over(1) && !world.has_turned_over(2)
            );
            for (instance, at) in [(0, near), (1, far)] {
                for triangle in 0..12 {
                    let corners = world.corners(instance, triangle);
                    let middle = corners.iter().sum::<DVec3>() / 3.0 - at;
                    assert!(world.face(instance, triangle).dot(middle) > 0.0);
                    let normals = world.normals(instance, triangle);
                    assert_eq!(normals.is_some(), side.is_some());
                    let is_outward = |[n, ..]: [DVec3; 3]| n.dot(middle) > 0.0;
                    assert!(normals.is_none_or(is_outward), "{mirror} {side:?}");
                    let away = side != Some(1.0);
                    assert_eq!(
                        world.lit(instance, triangle, &corners).is_reversed,
                        away,
                        "{mirror} {side:?}"
                    );
                }
            }
        }
    }

    fn turned(at: DVec3) -> DAffine3 {
        let turn = glam::DQuat::from_rotation_z(0.3);
        DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 3.0, -4.0), turn, at)
    }

    #[test]
    fn a_mesh_is_instanced_only_where_it_is_used_twice_and_asked_for() {
        let shape = |world: World| (world.geometries.len(), world.parts[0].transform.is_some());
        let (once, twice) = ([turned(DVec3::X)], [turned(DVec3::X), turned(DVec3::Y)]);
        assert_eq!(shape(build(&once, true).unwrap()), (1, false));
        assert_eq!(shape(build(&twice, true).unwrap()), (1, true));
        assert_eq!(shape(build(&twice, false).unwrap()), (2, false));
    }

    #[test]
    fn flattened_corners_are_the_f64_product_rounded_once() {
        let place = turned(DVec3::new(0.1, 0.2, 0.3));
        let world = build(&[place], true).unwrap();
        let expected = place
            .transform_point3(DVec3::new(-1.0, -1.0, 0.0))
            .as_vec3()
            .as_dvec3();
        assert_eq!(world.corners(0, 0)[0], expected);
        assert_eq!(
            (
                world.parts[0].stretch(),
                world.parts[0].rounding(DVec3::Z, &world.corners(0, 0))
            ),
            (1.0, 0.0)
        );
    }

    #[test]
    fn instanced_corners_are_the_f32_transform_applied_in_f64() {
        let places = [turned(DVec3::new(0.1, 0.2, 0.3)), turned(DVec3::Y)];
        let world = build(&places, true).unwrap();
        let single = places[0].as_affine3a().as_daffine3();
        assert_eq!(
            world.corners(0, 0)[0],
            single.transform_point3(DVec3::new(-1.0, -1.0, 0.0))
        );
        let bounds = world.bounds();
        for instance in 0..2 {
            for corner in world.corners(instance, 0) {
                assert!(corner.cmpge(bounds.min).all() && corner.cmple(bounds.max).all());
            }
        }
    }

    #[test]
    fn a_far_scene_is_brought_near_and_says_from_where() {
        let far = DAffine3::from_translation(DVec3::new(4e6, 0.0, -3e6));
        let scene = Arc::new(placed_scene(vec![square(0.0)], &[(0, far)]));
        let options = WorldOptions::default();
        let near = World::near(scene.clone(), options).unwrap();
        let far = World::new(scene, options).unwrap();
        assert_eq!(far.origin(), DVec3::ZERO);
        assert!(near.scale_bound() < 10.0, "{}", near.scale_bound());
        for (near_corner, far_corner) in near.corners(0, 0).into_iter().zip(far.corners(0, 0)) {
            assert_eq!(near_corner + near.origin(), far_corner);
        }
    }

    #[test]
    fn unplaced_positions_are_the_meshes_own() {
        let world = build(&[DAffine3::IDENTITY], true).unwrap();
        assert!(matches!(world.geometries[0].positions, Positions::Mesh(..)));
        let expected = Bounds {
            min: DVec3::new(-1.0, -1.0, 0.0),
            max: DVec3::new(1.0, 1.0, 0.0),
        };
        assert_eq!((world.bounds(), world.scale_bound()), (expected, 1.0));
    }

    #[test]
    fn normals_stay_perpendicular_and_outside_under_mirrored_stretching() {
        let world = build(&[DAffine3::from_scale(DVec3::new(2.0, 1.0, -1.0))], true).unwrap();
        assert!(world.parts[0].mirrors());
        let [normal, ..] = world.normals(0, 0).unwrap();
        // (0.6 / 2, 0, 0.8 / -1), to length 1.
        let expected = DVec3::new(0.3, 0.0, -0.8).normalize();
        assert!(
            (normal - expected).length() < 1e-7,
            "{normal}: the f32 input holds 24 bits"
        );
    }

    #[test]
    fn placements_beyond_single_precision_are_an_error() {
        for place in [
            DAffine3::from_scale(DVec3::splat(1e39)),
            DAffine3::from_translation(DVec3::splat(1e300)),
        ] {
            let error = build(&[place], true).unwrap_err().to_string();
            assert!(error.starts_with("object object of fixture.obj"), "{error}");
            assert!(build(&[place, place], true).is_err());
        }
    }

    #[test]
    fn what_rays_cannot_be_carried_into_is_flattened_and_nothing_else() {
        let shape = |world: World| -> Vec<bool> {
            (world.parts.iter().map(|part| part.transform.is_some())).collect()
        };
        let scaled = |scale: DVec3, x: f64| {
            DAffine3::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, DVec3::X * x)
        };
        let mut shear = DAffine3::IDENTITY;
        shear.matrix3.z_axis = DVec3::new(1.0, 1.0, 1e-8);
        for odd in [
            scaled(DVec3::splat(1e-9), 1e9),
            scaled(DVec3::splat(1e-6), 1e12),
            scaled(DVec3::splat(1e-11), 1e7),
            scaled(DVec3::new(1.0, 1e-14, 1.0), 0.0),
            scaled(DVec3::splat(1e13), 0.0),
            shear,
        ] {
            let places = [DAffine3::IDENTITY, turned(DVec3::X), odd];
            let world = build(&places, true).unwrap();
            assert_eq!(shape(world), [true, true, false], "{odd:?}");
        }
        // Near the end of the range no instance has room for the rays of the scene.
        let world = build(&[DAffine3::IDENTITY, scaled(DVec3::ONE, 9.5e17)], true).unwrap();
        assert_eq!(shape(world), [false, false]);
        let plain = [scaled(DVec3::new(1.0, 1e-6, 1.0), 1e5), turned(DVec3::Y)];
        assert_eq!(shape(build(&plain, true).unwrap()), [true, true]);
    }

    #[test]
    fn a_transform_that_vanishes_in_single_precision_is_flattened() {
        let tiny = DAffine3::from_scale(DVec3::new(1e-60, 1.0, 1.0));
        let world = build(&[tiny, DAffine3::IDENTITY], true).unwrap();
        assert!(world.parts[0].transform.is_none() && world.parts[1].transform.is_some());
    }
}
