//! Blind sheets: those whose front nobody looks at, for something is close before all of it, as before a plank that
//! looks at its wall.
//!
//! A blind sheet looks to one side and is drawn from both. Straight before all of its front stands something opaque,
//! too close for anybody to look in or for light to get in, and behind some of it nothing is as close. Where several
//! surfaces stand before it and one of them lies in the gap, people may be there too, as between a floor with desks and
//! its ceiling. Two sheets that look at each other are a floor and a ceiling as well.

use super::placed::{ABOUT, Placed, PlacedTree};
use super::spread::{corners_too, parts};
use super::wound::LOOKS;
use super::{Covers, Solids};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// How close that is at most, in widths of the sheet: at the middle of a strip that leaves 3 % of a uniform light. No
/// more than [`ABOUT`] of its length either: people stand between a wide floor and its ceiling.
const NARROW: f64 = 0.125;

/// A surface of a placement: their numbers.
type Key = (u32, u32);

/// A surface that a straight way meets.
pub(super) struct Met {
    /// Its place in the list.
    pub place: usize,
    /// Its front is met.
    pub is_front: bool,
}

impl Solids {
    /// The blind sheets between which and what they look at none of these places lies.
    pub(super) fn blind_sheets(&self, places: &[DVec3]) -> HashSet<Key> {
        let placed = self.placed_surfaces();
        let opaque = placed.iter().filter(|of| !of.surface.masked);
        let all = PlacedTree::of(opaque.collect());
        let before = |sheet: &&Placed| Some((sheet.key, self.close_before(sheet, &all, places)?));
        let found: HashMap<Key, Vec<Key>> = all.placed.par_iter().filter_map(before).collect();
        let looks_back = |key: &Key, before: &Vec<Key>| {
            let others = before.iter().filter_map(|other| found.get(other));
            others.flatten().any(|other| other == key)
        };
        let blind = found
            .iter()
            .filter(|(key, before)| !looks_back(key, before));
        blind.map(|(&key, _)| key).collect()
    }

    /// What is close before a sheet of which all of the front is blind.
    fn close_before(&self, sheet: &Placed, all: &PlacedTree, places: &[DVec3]) -> Option<Vec<Key>> {
        let front = sheet.surface.front?;
        if !self.is_drawn_from_both_sides(sheet.surface) {
            return None;
        }
        let close = (ABOUT * sheet.size()).min(NARROW * sheet.side() / sheet.size());
        let reach = sheet.low.abs().max(sheet.high.abs()).max_element();
        let clear = Covers::least(reach);
        let sense = sheet.transform.matrix3.determinant().signum();
        let parts = parts(sheet.surface.faces.len());
        let points = || {
            let faces = sheet.faces(&self.scene);
            faces.flat_map(move |[a, b, c]| {
                let up = sense * (b - a).cross(c - a).normalize_or_zero();
                let parts = corners_too(parts).filter(move |_| up != DVec3::ZERO);
                parts.map(move |[u, v, w]| (u * a + v * b + w * c, up))
            })
        };
        let met = |at: DVec3, way: DVec3| {
            let met = self.nearest_met(sheet.key, all, at + clear * way, at + close * way);
            met.map(|met| met.place)
        };
        let mut before: Vec<usize> = Vec::new();
        for (at, up) in points() {
            let place = met(at, up)?;
            if !before.contains(&place) {
                before.push(place);
            }
        }
        let highest = close / sheet.transform.transform_vector3(front).length();
        let is_in_gap = |at: DVec3| {
            let local = sheet.inverse.transform_point3(at);
            let tree = self.tree_of(sheet.shape, sheet.key.1);
            let height = tree.height_over(&self.scene, local, front, false);
            height.is_some_and(|height| height > 0.0 && height <= highest)
        };
        let before: Vec<&Placed> = before.iter().map(|&place| all.placed[place]).collect();
        let stands = |other: &&Placed| 2 * other.count(&self.scene, LOOKS, is_in_gap) > LOOKS;
        let is_open = before.len() > 1 && before.iter().any(stands);
        let is_seen = || points().any(|(at, up)| met(at, -up).is_none());
        let is_blind = !is_open && !places.iter().any(|&place| is_in_gap(place)) && is_seen();
        is_blind.then(|| before.iter().map(|other| other.key).collect())
    }

    /// What a straight way meets first, but for `own`.
    pub(super) fn nearest_met(
        &self,
        own: Key,
        all: &PlacedTree,
        from: DVec3,
        to: DVec3,
    ) -> Option<Met> {
        let near = all.meeting(from.min(to), from.max(to)).into_iter();
        let met = near.filter_map(|place| {
            let other = all.placed[place];
            if other.key == own {
                return None;
            }
            let ends = [from, to].map(|at| other.inverse.transform_point3(at));
            let tree = self.tree_of(other.shape, other.key.1);
            let (share, is_front) = tree.nearest(&self.scene, ends[0], ends[1])?;
            Some((share, Met { place, is_front }))
        });
        met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, met)| met)
    }
}
