//! Mouths of tubes that open into a room.
//!
//! A corridor that ends at a door, and a tunnel whose mouth is a hole in a wall, are seen from within, however narrow
//! they are. At the mouth of such a tube nothing is, and about it, in the mouth's plane, is the wall. A post may stand
//! on a floor or bear a beam: what is about its end is before its mouth too. It may stand beside a wall: that is on one
//! side of it. So what counts is what stands on opposite sides of an open mouth.

use super::Solids;
use super::placed::{Placed, PlacedTree};
use super::spread::{middles, parts};
use glam::DVec3;

/// What stops a hole stands this near to its panes, in widths of the hole, or through them.
pub(super) const STOP: f64 = 0.125;

/// The share of a portal's mouth that may be met, and the share of the way around it that has a wall on opposite sides,
/// at least: beside the door of a low room, the wall is on the left and on the right alone.
const MET: f64 = 0.5;
const BETWEEN: f64 = 1.0 / 3.0;
/// How far from the mouth's middle one asks, as a share of the way to its rim: a tube may fit its hole loosely.
const BEYOND: f64 = 1.15;
/// About so many places around a mouth are asked.
const AROUND: usize = 64;

/// A hole of a surface where it is placed.
pub(super) struct Mouth {
    panes: Vec<[DVec3; 3]>,
    /// Away from what the surface encloses, of unit length.
    pub outward: DVec3,
    /// The root of its area.
    pub width: f64,
}

impl Mouth {
    /// Of what fills a hole of a surface that looks inward, in the space of its mesh.
    pub fn of(of: &Placed, cap: &[[[f32; 3]; 3]]) -> Self {
        let place = |corner: [f32; 3]| {
            let corner = DVec3::from(corner.map(f64::from));
            of.transform.transform_point3(corner)
        };
        let sense = of.transform.matrix3.determinant().signum();
        let panes: Vec<[DVec3; 3]> = cap.iter().map(|pane| pane.map(place)).collect();
        let hole: DVec3 = panes.iter().map(|pane| sense * across(pane)).sum();
        Self {
            panes,
            // A pane's front is that of the faces, which look inward.
            outward: -hole.normalize_or_zero(),
            width: hole.length().sqrt(),
        }
    }

    /// The share of its area for which something holds.
    pub fn share(&self, holds: impl Fn(DVec3) -> bool) -> f64 {
        let points: Vec<[f64; 3]> = middles(parts(self.panes.len())).collect();
        let (mut asked, mut found) = (0.0, 0.0);
        for pane in &self.panes {
            let [a, b, c] = *pane;
            let places = points.iter().map(|[u, v, w]| *u * a + *v * b + *w * c);
            let share = across(pane).length() / points.len() as f64;
            asked += share * points.len() as f64;
            found += share * places.filter(|&at| holds(at)).count() as f64;
        }
        found / asked
    }

    /// Places evenly around it, as ways from its middle to a little beyond its rim; and the middle.
    fn around(&self) -> (DVec3, Vec<DVec3>) {
        // One triangle, or a fan about its middle.
        let (middle, edges) = match self.panes[..] {
            [[a, b, c]] => ((a + b + c) / 3.0, vec![[a, b], [b, c], [c, a]]),
            _ => (
                self.panes[0][0],
                self.panes.iter().map(|[_, a, b]| [*a, *b]).collect(),
            ),
        };
        let around: f64 = edges.iter().map(|[a, b]| (*b - *a).length()).sum();
        let mut ways = Vec::new();
        for [a, b] in edges {
            let count = (AROUND as f64 * (b - a).length() / around).ceil() as usize;
            let steps = (0..count).map(|k| (k as f64 + 0.5) / count as f64);
            ways.extend(steps.map(|step| BEYOND * (a.lerp(b, step) - middle)));
        }
        (middle, ways)
    }
}

/// Along a triangle's normal, of the length of its area.
fn across([a, b, c]: &[DVec3; 3]) -> DVec3 {
    0.5 * (*b - *a).cross(*c - *a)
}

impl Solids {
    /// True where one looks into a mouth of a tube from a room: hardly anything is in it, and a wall is about it.
    pub(super) fn is_portal(&self, of: &Placed, mouth: &Mouth, all: &PlacedTree) -> bool {
        let reach = STOP * mouth.width * mouth.outward;
        let is_met = |at: DVec3| {
            let met = self.nearest_met(of.key, all, at + reach, at - reach);
            met.is_some()
        };
        let (middle, ways) = mouth.around();
        let met: Vec<(DVec3, bool)> = (ways.into_iter())
            .map(|way| (way, is_met(middle + way)))
            .collect();
        // A wall on the other side of the middle too.
        let is_between = |(way, is_met): &&(DVec3, bool)| {
            let along = |of: &DVec3| of.normalize_or_zero().dot(*way);
            let opposite = met
                .iter()
                .min_by(|a, b| along(&a.0).total_cmp(&along(&b.0)));
            *is_met && opposite.is_some_and(|(_, is_met)| *is_met)
        };
        let between = met.iter().filter(is_between).count();
        between as f64 >= BETWEEN * met.len() as f64 && mouth.share(is_met) <= MET
    }
}
