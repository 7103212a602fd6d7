//! Grounds: open surfaces that other bodies are sunk in, such as a terrain or the plane that a scene stands on.
//!
//! An open surface has no inside. But where all its faces look to one side, what stands in it is hidden behind it, and sees under
//! it what nobody is to see. A surface is *rooted* in such a sheet where
//!
//! * it crosses the sheet, and stands out in front of it at least as far as it reaches behind it, along the sheet's mean normal;
//! * nothing that neither crosses the sheet too nor lies in it, as the next panel of a floor does, comes near its part behind. So no
//!   column is buried by the floor of the next storey.
//!
//! The part behind is buried, for this surface alone. But a sheet that has something else behind it which does not cross it, and is not
//! small beside it, is no ground: people stand under an awning, and see what it is fastened to.

use super::placed::{Among, CROSSES, NEAR, Placed, SMALL};
use super::topology::corners;
use super::tree::SurfaceTree;
use super::{Inside, Solids};
use glam::DVec3;
use rayon::prelude::*;
use scene::Scene;
use std::collections::{BTreeMap, HashSet};

/// Faces of a sheet from which one looks for what is behind it.
const LOOKS: usize = 64;
/// The cosine of the angle at which one sheet may go on where another ends.
const ALONG: f64 = 0.999;

/// Where a surface stands to a sheet.
struct Stand {
    /// How far it goes in front and behind, in lengths of the mesh's space; what is less than `least` only touches.
    front: f64,
    behind: f64,
    least: f64,
    /// Some of it is before or behind the sheet, not beside it.
    meets: bool,
    /// The box of its points behind, in the world.
    low: DVec3,
    high: DVec3,
}

impl Stand {
    fn of(scene: &Scene, sheet: &Placed, tree: &SurfaceTree, other: &Placed) -> Self {
        let inverse = sheet.inverse;
        let size = inverse.transform_vector3(other.high - other.low).length();
        let mut stand = Self {
            front: 0.0,
            behind: 0.0,
            least: CROSSES * size,
            meets: false,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        let Some(front) = sheet.surface.front else {
            return stand;
        };
        // Edges of panels may run along one another, where corners are as often beside a sheet as not: so the middles too.
        let points = other.faces(scene).flat_map(|[a, b, c]| {
            let middles = [a + b, b + c, c + a].map(|sum| 0.5 * sum);
            [a, b, c, (a + b + c) / 3.0].into_iter().chain(middles)
        });
        for point in points {
            let Some(height) = tree.height(scene, inverse.transform_point3(point), front) else {
                continue;
            };
            stand.meets = true;
            stand.front = stand.front.max(height);
            stand.behind = stand.behind.max(-height);
            if height < 0.0 {
                (stand.low, stand.high) = (stand.low.min(point), stand.high.max(point));
            }
        }
        stand
    }

    fn crosses(&self) -> bool {
        self.front > self.least && self.behind > self.least
    }

    /// True for a surface that lies in a sheet and looks to the same side.
    fn continues(&self, sheet: &Placed, other: &Placed) -> bool {
        let front = |placed: &Placed| {
            let front = placed.surface.front?;
            let normal = placed.inverse.matrix3.transpose() * front;
            normal.try_normalize()
        };
        let looks = match (front(sheet), front(other)) {
            (Some(sheet), Some(other)) => sheet.dot(other) > ALONG,
            _ => false,
        };
        looks && self.meets && self.front <= self.least && self.behind <= self.least
    }
}

impl Solids {
    /// Finds the grounds of a scene and what is rooted in them, and makes bodies of both.
    pub(super) fn root(&mut self) {
        let found = self.rooted_in_grounds();
        for (sheet, rooted) in found {
            let mut members: Vec<u32> = rooted.into_iter().map(|key| self.body_of(key)).collect();
            members.sort_unstable();
            let sheet = self.body_of(sheet);
            self.widen(sheet, &members);
            self.bodies[sheet as usize].inside = Inside::Behind(members);
        }
    }

    /// By sheet, what is rooted in it: placements and numbers of surfaces.
    fn rooted_in_grounds(&self) -> BTreeMap<(u32, u32), Vec<(u32, u32)>> {
        let placed = self.placed_surfaces();
        let all = Among::of(placed.iter().collect());
        let of = |sheet: &Placed| {
            let near = all.meeting(sheet.low, sheet.high).into_iter();
            let others: Vec<&Placed> = near
                .map(|other| &placed[other])
                .filter(|other| other.key != sheet.key)
                .collect();
            if others.is_empty() {
                return None;
            }
            let tree = self.tree_of(sheet.shape, sheet.key.1);
            let stand = |other: &&Placed| Stand::of(&self.scene, sheet, tree, other);
            let stands: Vec<Stand> = others.iter().map(stand).collect();
            let chosen = |take: &dyn Fn(&Placed, &Stand) -> bool| -> HashSet<(u32, u32)> {
                let stands = others.iter().zip(&stands);
                let taken = stands.filter(|(other, stand)| take(other, stand));
                taken.map(|(other, _)| other.key).collect()
            };
            let crossing = chosen(&|_, stand| stand.crosses());
            // What lies in the sheet, such as the next panel of a floor, is as little behind it as the sheet.
            let level = chosen(&|other, stand| stand.continues(sheet, other));
            let rooted = others.iter().zip(&stands).filter_map(|(other, stand)| {
                if !stand.crosses() || stand.front < stand.behind {
                    return None;
                }
                let slack = NEAR * (stand.high - stand.low).max_element();
                let (low, high) = (stand.low - slack, stand.high + slack);
                let lays_open = |near: &Placed| {
                    let is_other = near.key != sheet.key && near.key != other.key;
                    is_other && !crossing.contains(&near.key) && !level.contains(&near.key)
                };
                (!all.any(low, high, lays_open)).then_some(other.key)
            });
            let mut rooted: Vec<(u32, u32)> = rooted.collect();
            rooted.sort_unstable();
            let lays_bare = |other: &Placed| {
                other.key != sheet.key
                    && !crossing.contains(&other.key)
                    && other.size() >= SMALL * sheet.size()
                    && self.is_behind(sheet, other)
            };
            let (low, high) = behind(sheet);
            let is_ground = !rooted.is_empty() && !all.any(low, high, lays_bare);
            is_ground.then_some((sheet.key, rooted))
        };
        let sheets = placed.par_iter().filter(|s| s.surface.front.is_some());
        sheets.filter_map(of).collect()
    }

    /// True where one looks from a sheet's faces, against their mean normal, at another surface.
    fn is_behind(&self, sheet: &Placed, other: &Placed) -> bool {
        let Some(back) = backward(sheet) else {
            return false;
        };
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
}

/// The direction to which the back of a sheet looks.
fn backward(sheet: &Placed) -> Option<DVec3> {
    let front = sheet.surface.front?;
    Some(-sheet.transform.transform_vector3(front))
}

/// The box, without an end to some sides, of all that lies behind a sheet.
fn behind(sheet: &Placed) -> (DVec3, DVec3) {
    let (mut low, mut high) = (sheet.low, sheet.high);
    let back = backward(sheet).unwrap_or_default();
    for axis in 0..3 {
        if back[axis] > 0.0 {
            high[axis] = f64::INFINITY;
        }
        if back[axis] < 0.0 {
            low[axis] = f64::NEG_INFINITY;
        }
    }
    (low, high)
}
