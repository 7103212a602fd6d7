//! What bodies count at many points that lie near one another.

use super::tree::climb;
use super::{Body, Solids};
use glam::DVec3;

/// A closed surface about a box. The first point is looked at from far away, as [`Solids::depth`] does; from there to
/// the others, what lies between is counted.
#[derive(Debug)]
pub struct Near<'a> {
    solids: &'a Solids,
    body: u32,
    /// The box, in the body's space.
    low: DVec3,
    high: DVec3,
    /// All faces that may meet it.
    faces: Vec<[[f32; 3]; 3]>,
    /// A point in the body's space, and how often the surface winds around it.
    known: Option<(DVec3, i32)>,
}

impl Near<'_> {
    /// The closed surface.
    pub fn body(&self) -> u32 {
        self.body
    }

    /// As [`Solids::depth`]; soon known of points in the box.
    pub fn depth(&mut self, point: DVec3, own: Option<u32>) -> i32 {
        let solids = self.solids;
        solids.depth_by(self.body, point, own, |of| {
            solids.holds_by(of, point, |local| self.winding(of, local))
        })
    }

    fn winding(&mut self, body: &Body, point: DVec3) -> i32 {
        let far = || self.solids.winding(body, point);
        if point.cmplt(self.low).any() || point.cmpgt(self.high).any() {
            return far();
        }
        let climbed = self
            .known
            .and_then(|(from, winding)| Some(winding + climb(&self.faces, from, point)?));
        let winding = climbed.unwrap_or_else(far);
        self.known.get_or_insert((point, winding));
        winding
    }
}

impl Solids {
    /// A closed surface about the box of some points, for the depth at many points in it.
    pub fn near(&self, body: u32, points: impl Iterator<Item = DVec3>) -> Near<'_> {
        let of = &self.bodies[body as usize];
        let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points
            .map(|point| of.inverse.transform_point3(point))
            .fold(limits, |(low, high), point| {
                (low.min(point), high.max(point))
            });
        // Points between those given are rounded too.
        let slack = 1e-6 * (high - low).max_element();
        let (low, high) = (low - slack, high + slack);
        Near {
            solids: self,
            body,
            low,
            high,
            faces: {
                let mut faces = self.tree(of).about(&self.scene, low, high);
                faces.extend(self.panes(of));
                faces
            },
            known: None,
        }
    }
}
