//! Grounds: open surfaces that other bodies are sunk in, such as a terrain or the plane that a scene stands on.
//!
//! An open surface has no inside. But where all its faces look to one side, what stands in it is hidden behind it, and sees under
//! it what nobody is to see. A surface is *rooted* in such a sheet where
//!
//! * it crosses the sheet, and stands out in front of it at least as far as it reaches behind it, along the sheet's mean normal;
//! * nothing that does not cross the sheet too comes near its part behind. So no column is buried by the floor of the next storey.
//!
//! The part behind is buried, for this surface alone. But a sheet that has something else behind it which does not cross it, and is not
//! small beside it, is no ground: people stand under an awning, and see what it is fastened to.

use super::topology::{Surface, corners};
use super::tree::SurfaceTree;
use super::{Body, Inside, Solids, placed_box};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use scene::Scene;
use std::collections::BTreeMap;

/// Faces of a surface that are asked where it stands; of a larger one so many, evenly.
const ASKED: usize = 1000;
/// What comes this near counts as near, in sizes of the part behind.
const NEAR: f64 = 1e-3;
/// Smaller than this share of a sheet, a surface behind it does not matter: a footing, a pipe.
const SMALL: f64 = 0.5;
/// Faces of a sheet from which one looks for what is behind it.
const LOOKS: usize = 64;
/// How far a crossing surface stands at least on either side, in sizes of its box: what only touches does not cross.
const CROSSES: f64 = 1e-5;

/// A surface where it is placed.
struct Placed<'a> {
    /// Placement and number of the surface.
    key: (u32, u32),
    shape: u32,
    surface: &'a Surface,
    transform: DAffine3,
    low: DVec3,
    high: DVec3,
}

impl Placed<'_> {
    /// Some of its corners, in the world.
    fn corners<'b>(&'b self, scene: &'b Scene) -> impl Iterator<Item = DVec3> + 'b {
        let step = self.surface.faces.len().div_ceil(ASKED);
        let faces = self.surface.faces.iter().step_by(step);
        faces.flat_map(move |&face| {
            corners(scene, face).map(|corner| self.transform.transform_point3(corner.as_dvec3()))
        })
    }

    fn meets(&self, low: DVec3, high: DVec3) -> bool {
        self.low.cmple(high).all() && self.high.cmpge(low).all()
    }

    fn size(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

/// Where a surface stands to a sheet.
struct Stand {
    /// How far it goes in front and behind, in lengths of the mesh's space.
    front: f64,
    behind: f64,
    /// The box of its corners behind, in the world.
    low: DVec3,
    high: DVec3,
}

impl Stand {
    fn of(scene: &Scene, sheet: &Placed, tree: &SurfaceTree, other: &Placed) -> Option<Self> {
        let (inverse, front) = (sheet.transform.inverse(), sheet.surface.front?);
        let mut stand = Self {
            front: 0.0,
            behind: 0.0,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        for corner in other.corners(scene) {
            let Some(height) = tree.height(scene, inverse.transform_point3(corner), front) else {
                continue;
            };
            stand.front = stand.front.max(height);
            stand.behind = stand.behind.max(-height);
            if height < 0.0 {
                (stand.low, stand.high) = (stand.low.min(corner), stand.high.max(corner));
            }
        }
        let size = inverse.transform_vector3(other.high - other.low).length();
        let least = CROSSES * size;
        (stand.front > least && stand.behind > least).then_some(stand)
    }
}

impl Solids {
    /// Finds the grounds of a scene and what is rooted in them, and makes bodies of both.
    pub(super) fn root(&mut self) {
        let found = self.rooted();
        for (sheet, rooted) in found {
            let rooted: Vec<u32> = rooted.into_iter().map(|key| self.body_of(key)).collect();
            let sheet = self.body_of(sheet);
            let limits = |body: &u32| {
                let body = &self.bodies[*body as usize];
                (body.low, body.high)
            };
            let (low, high) = rooted
                .iter()
                .map(limits)
                .fold(limits(&sheet), |a, b| (a.0.min(b.0), a.1.max(b.1)));
            let mut members = rooted;
            members.sort_unstable();
            let sheet = &mut self.bodies[sheet as usize];
            (sheet.low, sheet.high) = (low, high);
            sheet.inside = Inside::Behind(members);
        }
    }

    /// By sheet, what is rooted in it: placements and numbers of surfaces.
    fn rooted(&self) -> BTreeMap<(u32, u32), Vec<(u32, u32)>> {
        let placed = self.placed_surfaces();
        let mut order: Vec<usize> = (0..placed.len()).collect();
        order.sort_by(|&a, &b| placed[a].low.x.total_cmp(&placed[b].low.x).then(a.cmp(&b)));
        let of = |sheet: &Placed| {
            let last = order.partition_point(|&other| placed[other].low.x <= sheet.high.x);
            let others: Vec<&Placed> = order[..last]
                .iter()
                .map(|&other| &placed[other])
                .filter(|other| other.key != sheet.key && other.meets(sheet.low, sheet.high))
                .collect();
            if others.is_empty() {
                return None;
            }
            let tree = self.tree_of(sheet.shape, sheet.key.1);
            let stand = |other: &&Placed| Stand::of(&self.scene, sheet, tree, other);
            let stands: Vec<Option<Stand>> = others.iter().map(stand).collect();
            let crossing: Vec<(u32, u32)> = others
                .iter()
                .zip(&stands)
                .filter(|(_, stand)| stand.is_some())
                .map(|(other, _)| other.key)
                .collect();
            let rooted = others.iter().zip(&stands).filter_map(|(other, stand)| {
                let stand = stand.as_ref().filter(|stand| stand.front >= stand.behind)?;
                let slack = NEAR * (stand.high - stand.low).max_element();
                let (low, high) = (stand.low - slack, stand.high + slack);
                let last = order.partition_point(|&near| placed[near].low.x <= high.x);
                let mut near = order[..last].iter().map(|&near| &placed[near]);
                let is_other = |near: &Placed| {
                    near.key != sheet.key && near.key != other.key && near.meets(low, high)
                };
                let is_alone = !near.any(|near| is_other(near) && !crossing.contains(&near.key));
                is_alone.then_some(other.key)
            });
            let mut rooted: Vec<(u32, u32)> = rooted.collect();
            rooted.sort_unstable();
            let is_other = |other: &&Placed| {
                other.key != sheet.key
                    && !crossing.contains(&other.key)
                    && other.size() >= SMALL * sheet.size()
            };
            let mut others = placed.iter().filter(is_other);
            let is_ground = !rooted.is_empty() && !others.any(|other| self.is_behind(sheet, other));
            is_ground.then_some((sheet.key, rooted))
        };
        let sheets = placed.par_iter().filter(|s| s.surface.front.is_some());
        sheets.filter_map(of).collect()
    }

    /// True where one looks from a sheet's faces, against their mean normal, at another surface.
    fn is_behind(&self, sheet: &Placed, other: &Placed) -> bool {
        let Some(front) = sheet.surface.front else {
            return false;
        };
        let back = -sheet.transform.transform_vector3(front);
        let open = |toward: f64, limit: f64, end: f64| if toward > 0.0 { end } else { limit };
        let mut high = sheet.high;
        let mut low = sheet.low;
        for axis in 0..3 {
            high[axis] = open(back[axis], high[axis], f64::INFINITY);
            low[axis] = open(-back[axis], low[axis], f64::NEG_INFINITY);
        }
        if !other.meets(low, high) {
            return false;
        }
        let inverse = other.transform.inverse();
        let direction = inverse.transform_vector3(back);
        let tree = self.tree_of(other.shape, other.key.1);
        let step = sheet.surface.faces.len().div_ceil(LOOKS);
        let mut faces = sheet.surface.faces.iter().step_by(step);
        faces.any(|&face| {
            let [a, b, c] = corners(&self.scene, face).map(|corner| corner.as_dvec3());
            let middle = sheet.transform.transform_point3((a + b + c) / 3.0);
            tree.is_ahead(&self.scene, inverse.transform_point3(middle), direction)
        })
    }

    /// Every surface of every placement.
    fn placed_surfaces(&self) -> Vec<Placed<'_>> {
        let mut known = std::collections::HashSet::new();
        let mut placed = Vec::new();
        for (index, &(shape, _, placement)) in self.instances.iter().enumerate() {
            if !known.insert(placement) {
                continue;
            }
            let transform = self.scene.instances[index].transform;
            for (number, surface) in self.shapes[shape as usize].surfaces.iter().enumerate() {
                let (low, high) = placed_box(surface, &transform);
                placed.push(Placed {
                    key: (placement, number as u32),
                    shape,
                    surface,
                    transform,
                    low,
                    high,
                });
            }
        }
        placed
    }

    /// The body of a placed surface, made if it has none.
    fn body_of(&mut self, key: (u32, u32)) -> u32 {
        if let Some(&body) = self.placements.get(&key) {
            return body;
        }
        let of = |&(_, _, placement): &(u32, u32, u32)| placement == key.0;
        let instance = self.instances.iter().position(of);
        let instance = instance.expect("a placement has instances");
        let (shape, ..) = self.instances[instance];
        let transform = self.scene.instances[instance].transform;
        let surface = &self.shapes[shape as usize].surfaces[key.1 as usize];
        let (low, high) = placed_box(surface, &transform);
        let body = self.bodies.len() as u32;
        self.bodies.push(Body {
            shape,
            surface: key.1,
            inverse: transform.inverse(),
            low,
            high,
            inside: Inside::Nothing,
        });
        self.placements.insert(key, body);
        body
    }
}
