//! Bodies without a bottom: what is open only where it stands.
//!
//! Many props are modelled without the faces that nobody sees: a barrel, a column or a trunk has no bottom. Such a
//! surface has no inside as long as one may look in. It is *shut*, and a solid, where
//!
//! * its openings have flat borders, and it looks outward once they are filled;
//! * all of each opening lies on or behind one ground, in front of which the surface stands, or in another solid;
//! * nothing else lies wholly within: else it is a tent or a dome, and its inside is a place.

use super::placed::{NEAR, Placed, PlacedTree};
use super::{Inside, Solids};
use glam::DVec3;
use rayon::prelude::*;

impl Solids {
    /// Makes solids of the surfaces that are shut.
    pub(super) fn shut(&mut self) {
        for key in self.shut_surfaces() {
            let body = self.body_of(key);
            self.bodies[body as usize].inside = Inside::Solid;
        }
    }

    /// Placements and numbers of the surfaces that are shut.
    fn shut_surfaces(&self) -> Vec<(u32, u32)> {
        let placed = self.placed_surfaces();
        let hollow: Vec<&Placed> = (placed.iter())
            .filter(|placed| placed.surface.hollow > 0.0)
            .collect();
        if hollow.is_empty() {
            return Vec::new();
        }
        let all = PlacedTree::of(placed.iter().collect());
        let is_shut = |of: &&&Placed| {
            let lies_within = |other: &Placed| other.key != of.key && self.is_within(of, other);
            self.openings_are_hidden(of, &all) && !all.any(of.low, of.high, lies_within)
        };
        let found = hollow.par_iter().filter(is_shut);
        found.map(|of| of.key).collect()
    }

    /// True where all openings of a surface lie on or behind a ground that it stands on, or in another solid.
    fn openings_are_hidden(&self, of: &Placed, all: &PlacedTree) -> bool {
        let slack = NEAR * of.size();
        let (low, high) = (of.low - slack, of.high + slack);
        let near = all.meeting(low, high);
        let near = (near.into_iter())
            .map(|other| all.placed[other])
            .filter(|other| other.key != of.key);
        let near: Vec<&Placed> = near.collect();
        let is_ground = |other: &&&Placed| self.stands_before(other, of);
        let grounds: Vec<&Placed> = near.iter().filter(is_ground).copied().collect();
        let solids = near.iter().filter_map(|other| {
            let body = &self.bodies[*self.placements.get(&other.key)? as usize];
            (body.inside == Inside::Solid).then_some(body)
        });
        let solids: Vec<_> = solids.collect();
        let is_hidden = |point: DVec3| {
            let is_behind = |ground: &&Placed| {
                let front = ground.surface.front.unwrap_or_default();
                let tree = self.tree_of(ground.shape, ground.key.1);
                let local = ground.inverse.transform_point3(point);
                let height = tree.height_over(&self.scene, local, front, false);
                height.is_some_and(|height| height < 0.0)
            };
            grounds.iter().any(is_behind) || solids.iter().any(|body| self.holds(body, point))
        };
        let normals = of.inverse.matrix3.transpose();
        of.surface.openings.iter().all(|opening| {
            let out = (normals * opening.front()).normalize_or_zero() * slack;
            let panes = opening.panes.iter().flat_map(|pane| {
                let [a, b, c] = pane.map(|corner| DVec3::from(corner.map(f64::from)));
                [a, b, c, (a + b + c) / 3.0]
            });
            let mut points = panes.map(|point| of.transform.transform_point3(point) + out);
            points.all(is_hidden)
        })
    }
}
