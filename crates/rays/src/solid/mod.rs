//! Solids: closed surfaces whose inside is not air. What lies in one is buried, and no light of a scene reaches it.
//!
//! **Which surfaces.** Triangles of a mesh that hang together over edges are a surface. Where a mesh leaves surfaces
//! open, those of all meshes under one placement are joined once more, for a body of several materials is several
//! meshes. A surface without a border and without cut-out triangles is closed and has an inside; an open one has none
//! and buries nothing. `doubleSided` says how a surface is drawn and nothing about its inside, so it is not asked.
//!
//! **What is inside.** The sign of its volume says whether the front faces of a closed surface look outward or inward,
//! in mesh space, so that a mirroring placement changes nothing. Of one that crosses itself most of its faces say it.
//!
//! * Outward: a solid.
//! * Inward, and all but an eighth of it inside a solid: its cavity, which is air again.
//! * Inward, and some whole other surface lies in it: a room. It is air.
//! * Inward, some surface lies in it for the most part, and nothing large outside: a room too.
//! * Inward and none of these: a solid wound the wrong way. `inward.rs` says when its outside is baked, also of
//!   bodies with a hole and of several in one surface.
//!
//! An open surface whose openings all lie on what it stands on is closed by that, and a solid too: `shut.rs` says when.
//!
//! What is rooted in an open ground or in a room has a part that nobody is to see: `ground` and `rooms.rs` say which.
//!
//! A point is buried where it lies in more solids than cavities. Distances do not matter: a limit on the distance of
//! occluders limits what darkens a place, not where the place is. `depth.rs` counts,
//! for the bodies that `about.rs` finds.

mod about;
mod blind;
mod covers;
mod depth;
mod fold;
mod ground;
mod inward;
mod level;
mod near;
mod opening;
mod placed;
mod portal;
mod rims;
mod rooms;
mod shape;
mod shut;
mod spread;
mod topology;
mod tree;
mod weld;
mod wound;

use crate::boxes::Boxes;
pub use covers::{Cover, Covering, Covers};
use glam::{DAffine3, DVec3, Vec3};
pub use near::Near;
use placed::{box_corners, placed_box};
use rayon::prelude::*;
pub use rims::Rim;
use scene::Scene;
use shape::Shape;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use topology::{Surface, corners};
use tree::SurfaceTree;

/// What the inside of a closed surface counts.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Inside {
    Solid,
    Cavity,
    Room,
    /// An open surface that only is rooted in others.
    Nothing,
    /// What lies behind an open surface, for the bodies that are rooted in it, in order.
    Behind(Vec<u32>),
    /// What lies outside of this and of every other room, for the bodies that are rooted in it, in order.
    Around(Vec<u32>),
}

impl Inside {
    /// The bodies for which alone it counts, in order; `None` where it does not depend on that.
    fn rooted(&self) -> Option<&[u32]> {
        match self {
            Self::Behind(rooted) | Self::Around(rooted) => Some(rooted),
            _ => None,
        }
    }
}

/// A surface in the world that is closed or shut, is rooted in a ground, or is one.
#[derive(Debug)]
struct Body {
    shape: u32,
    surface: u32,
    inverse: DAffine3,
    low: DVec3,
    high: DVec3,
    inside: Inside,
    /// The bodies that a ground cuts and does not bury, in order.
    cut: Vec<u32>,
}

/// How far off its surface a point is tested, per unit of the coordinates: clear of their rounding in the world and in
/// a mesh's space. Faces that coincide are so told apart by the side that they face.
pub const NUDGE: f64 = 8.0 / 16_777_216.0;

/// The solids of a scene, in its own space.
#[derive(Debug)]
pub struct Solids {
    scene: Arc<Scene>,
    shapes: Vec<Shape>,
    bodies: Vec<Body>,
    /// Shape, number of the mesh in it, and placement of each instance.
    instances: Vec<(u32, u32, u32)>,
    /// Body of placements' surfaces, by their numbers.
    placements: HashMap<(u32, u32), u32>,
    /// First instance of each placement.
    firsts: Vec<u32>,
    /// All rooms, where something is rooted in one.
    rooms: Vec<u32>,
    /// Where they are, and where bodies are that bury or lay open.
    room_boxes: Boxes,
    counting: Boxes,
    cavities: Boxes,
    /// The longest edge of their boxes.
    longest: f64,
    /// What sheets cut off from placements' surfaces.
    rims: HashMap<(u32, u32), Vec<Rim>>,
    /// What may cover placements' surfaces.
    covers: Covering,
}

impl Solids {
    /// The solids of a scene.
    pub fn of(scene: &Arc<Scene>) -> Self {
        let scene = Arc::clone(scene);
        let mut groups: Vec<Vec<u32>> = Vec::new();
        let mut group_of = HashMap::new();
        for (index, instance) in scene.instances.iter().enumerate() {
            let place = instance.transform.to_cols_array().map(f64::to_bits);
            let group = *group_of
                .entry((instance.casts, place))
                .or_insert(groups.len());
            if group == groups.len() {
                groups.push(Vec::new());
            }
            groups[group].push(index as u32);
        }
        let twins = twins(&scene);
        let mut shape_of: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut lists: Vec<Vec<u32>> = Vec::new();
        let mut instances = vec![(0, 0, 0); scene.instances.len()];
        // Copies that coincide are one body, or each would be asked about all of the others.
        let mut known = HashMap::new();
        let mut firsts: Vec<u32> = Vec::new();
        for group in &groups {
            let (mut meshes, mut numbers) = (Vec::new(), HashMap::new());
            let number = |&instance: &u32| {
                let mesh = twins[scene.instances[instance as usize].mesh as usize];
                *numbers.entry(mesh).or_insert_with(|| {
                    meshes.push(mesh);
                    meshes.len() as u32 - 1
                })
            };
            let members: Vec<u32> = group.iter().map(number).collect();
            let shape = *shape_of.entry(meshes.clone()).or_insert_with(|| {
                lists.push(meshes);
                lists.len() as u32 - 1
            });
            let first = &scene.instances[group[0] as usize];
            let place = first.transform.to_cols_array().map(f64::to_bits);
            let placement = *known.entry((shape, first.casts, place)).or_insert_with(|| {
                firsts.push(group[0]);
                firsts.len() as u32 - 1
            });
            for (mesh, &instance) in members.into_iter().zip(group) {
                instances[instance as usize] = (shape, mesh, placement);
            }
        }
        let shapes: Vec<Shape> = lists
            .into_par_iter()
            .map(|meshes| Shape::of(&scene, meshes))
            .collect();
        let mut bodies = Vec::new();
        let mut placements = HashMap::new();
        for (placement, &first) in firsts.iter().enumerate() {
            if !scene.instances[first as usize].casts {
                continue;
            }
            let transform = scene.instances[first as usize].transform;
            let shape = instances[first as usize].0;
            for (surface, of) in shapes[shape as usize].surfaces.iter().enumerate() {
                if of.volume == 0.0 {
                    continue;
                }
                let (low, high) = placed_box(of, &transform);
                placements.insert((placement as u32, surface as u32), bodies.len() as u32);
                bodies.push(Body {
                    shape,
                    surface: surface as u32,
                    inverse: transform.inverse(),
                    low,
                    high,
                    inside: Inside::Solid,
                    cut: Vec::new(),
                });
            }
        }
        let mut solids = Self {
            scene,
            shapes,
            bodies,
            instances,
            placements,
            firsts,
            rooms: Vec::new(),
            room_boxes: Boxes::default(),
            counting: Boxes::default(),
            cavities: Boxes::default(),
            longest: 0.0,
            rims: HashMap::new(),
            covers: Covering::default(),
        };
        solids.classify();
        solids.shut();
        solids.root();
        solids.root_in_rooms();
        let counting = (0..solids.bodies()).filter(|&body| solids.box_of(body).is_some());
        let counting: Vec<u32> = counting.collect();
        let cavities = counting
            .iter()
            .copied()
            .filter(|&body| solids.is_cavity(body));
        solids.cavities = solids.boxes_of(cavities);
        let extents = counting.iter().map(|&body| solids.extent(body));
        solids.longest = extents.fold(0.0, f64::max);
        solids.counting = solids.boxes_of(counting.into_iter());
        solids.room_boxes = solids.boxes_of(solids.rooms.iter().copied());
        (solids.rims, solids.covers) = solids.rims_and_covers();
        solids
    }

    fn boxes_of(&self, bodies: impl Iterator<Item = u32>) -> Boxes {
        Boxes::of(bodies.map(|body| {
            let of = &self.bodies[body as usize];
            (body, of.low, of.high)
        }))
    }

    /// How many there are, wrongly wound ones too, and grounds, and rooms that something is rooted in.
    pub fn count(&self) -> usize {
        let buries = |body: &&Body| body.inside == Inside::Solid || body.inside.rooted().is_some();
        self.bodies.iter().filter(buries).count()
    }

    /// True where nothing is buried in any of them, nothing has a rim and nothing is covered.
    pub fn is_idle(&self) -> bool {
        self.count() == 0 && self.rims.is_empty() && self.covers.is_empty()
    }

    /// The body that a triangle is part of.
    pub fn own(&self, instance: u32, triangle: u32) -> Option<u32> {
        let key = self.surface_key(instance, triangle);
        self.placements.get(&key).copied()
    }

    /// Placement and number of the surface of a triangle.
    fn surface_key(&self, instance: u32, triangle: u32) -> (u32, u32) {
        let (shape, mesh, placement) = self.instances[instance as usize];
        let surface_of = &self.shapes[shape as usize].surface_of[mesh as usize];
        (placement, surface_of[triangle as usize])
    }

    /// True for a ground. What lies behind it may end far from its surface, beside it.
    pub fn is_ground(&self, body: u32) -> bool {
        matches!(self.bodies[body as usize].inside, Inside::Behind(_))
    }

    /// True where all of a box lies in front of a ground: nothing in it lies behind.
    pub fn is_before(&self, body: u32, low: DVec3, high: DVec3) -> bool {
        let of = &self.bodies[body as usize];
        let Some(front) = self.surface(of).front else {
            return false;
        };
        if !self.is_ground(body) {
            return false;
        }
        // In the space of its mesh, where the sheet's own box is the tightest.
        let ends = box_corners(low, high).map(|p| of.inverse.transform_point3(p).dot(front));
        let surface = self.surface(of);
        let sheet = box_corners(surface.low.as_dvec3(), surface.high.as_dvec3());
        let top = sheet
            .into_iter()
            .map(|p| p.dot(front))
            .fold(f64::NEG_INFINITY, f64::max);
        ends.into_iter().fold(f64::INFINITY, f64::min) > top
    }

    /// The longest edge of a closed surface's box, in scene units.
    pub fn extent(&self, body: u32) -> f64 {
        let body = &self.bodies[body as usize];
        (body.high - body.low).max_element()
    }

    /// How many bodies there are, whether they bury or not.
    pub fn bodies(&self) -> u32 {
        self.bodies.len() as u32
    }

    /// The box of a body that buries or lays open; `None` for others.
    pub fn box_of(&self, body: u32) -> Option<(DVec3, DVec3)> {
        let of = &self.bodies[body as usize];
        let counts = !matches!(of.inside, Inside::Room | Inside::Nothing);
        counts.then_some((of.low, of.high))
    }

    /// The bodies for which alone a ground or a room buries, in order; nothing for other bodies.
    pub fn rooted(&self, body: u32) -> &[u32] {
        self.bodies[body as usize].inside.rooted().unwrap_or(&[])
    }

    /// The bodies that a ground cuts and does not bury, in order: one may look at what lies behind it, but not at both
    /// parts of a texel that it divides.
    pub fn cut(&self, body: u32) -> &[u32] {
        &self.bodies[body as usize].cut
    }

    /// All rooms, where something is rooted in one: what buries outside of a room asks the others too.
    pub fn rooms(&self) -> &[u32] {
        &self.rooms
    }

    /// True where a body counts nothing that lies in another room.
    pub fn asks_rooms(&self, body: u32) -> bool {
        matches!(self.bodies[body as usize].inside, Inside::Around(_))
    }

    /// A number that says what the inside of a body counts, but for which other bodies it does; [`Self::rooted`] tells.
    pub fn kind(&self, body: u32) -> u8 {
        match self.bodies[body as usize].inside {
            Inside::Solid => 0,
            Inside::Cavity => 1,
            Inside::Room => 2,
            Inside::Nothing => 3,
            Inside::Behind(_) => 4,
            Inside::Around(_) => 5,
        }
    }

    /// Hands over, as bytes, which surface a body is and where.
    pub fn content(&self, body: u32, take: &mut dyn FnMut(&[u8])) {
        let body = &self.bodies[body as usize];
        for number in body.inverse.to_cols_array() {
            take(&number.to_le_bytes());
        }
        let surface = self.surface(body);
        take(&surface.volume.to_le_bytes());
        for face in &surface.faces {
            let corners = corners(&self.scene, *face).map(|corner| corner.to_array());
            take(
                corners
                    .map(|p| p.map(f32::to_le_bytes))
                    .as_flattened()
                    .as_flattened(),
            );
        }
    }

    fn surface(&self, body: &Body) -> &Surface {
        &self.shapes[body.shape as usize].surfaces[body.surface as usize]
    }

    fn tree(&self, body: &Body) -> &SurfaceTree {
        self.tree_of(body.shape, body.surface)
    }

    fn tree_of(&self, shape: u32, surface: u32) -> &SurfaceTree {
        let (shape, surface) = (&self.shapes[shape as usize], surface as usize);
        let faces = &shape.surfaces[surface].faces;
        shape.trees[surface].get_or_init(|| SurfaceTree::build(&self.scene, faces))
    }
}

/// For each mesh the first one with the same triangles at the same corners, of the same material.
fn twins(scene: &Scene) -> Vec<u32> {
    let hashes: Vec<u64> = (scene.meshes.par_iter())
        .map(|mesh| {
            let mut hash = DefaultHasher::new();
            let bits = |p: &Vec3| p.to_array().map(f32::to_bits);
            (mesh.positions.iter()).for_each(|p| bits(p).hash(&mut hash));
            (&mesh.triangles, mesh.material).hash(&mut hash);
            hash.finish()
        })
        .collect();
    let mut first: HashMap<u64, u32> = HashMap::new();
    let of = |(index, hash): (u32, &u64)| {
        let twin = *first.entry(*hash).or_insert(index);
        let [own, other] = [index, twin].map(|mesh| &scene.meshes[mesh as usize]);
        let is_same = own.positions == other.positions
            && own.triangles == other.triangles
            && own.material == other.material;
        if is_same { twin } else { index }
    };
    (0..).zip(&hashes).map(of).collect()
}

#[cfg(test)]
mod tests;
