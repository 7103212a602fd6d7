//! Which bodies are about a box.

use super::{NUDGE, Solids};
use glam::DVec3;

/// So few boxes are sooner looked at than found in a tree.
const FEW: usize = 16;

impl Solids {
    /// The bodies that bury or lay open, whose boxes meet this one or touch it but for rounding, ascending.
    pub fn about(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let (low, high) = grown(low, high);
        self.counting.meeting(low, high)
    }

    /// True where those are more than a few.
    pub fn is_crowded(&self, low: DVec3, high: DVec3) -> bool {
        let (low, high) = grown(low, high);
        let mut found = 0;
        self.counting.any(low, high, |_| {
            found += 1;
            found > FEW
        })
    }

    /// Those of the bodies about a box that are about a smaller one in it.
    pub fn narrowed(&self, about: &[u32], low: DVec3, high: DVec3) -> Vec<u32> {
        if about.len() > FEW {
            return self.about(low, high);
        }
        let (low, high) = grown(low, high);
        let reaches = |body: &u32| self.reaches(*body, low, high);
        about.iter().copied().filter(reaches).collect()
    }

    /// True where this box meets that of a closed surface.
    fn reaches(&self, body: u32, low: DVec3, high: DVec3) -> bool {
        let body = &self.bodies[body as usize];
        body.low.cmple(high).all() && body.high.cmpge(low).all()
    }
}

/// A box with room for points that are tested [`NUDGE`] off their surface.
fn grown(low: DVec3, high: DVec3) -> (DVec3, DVec3) {
    let slack = NUDGE * low.abs().max(high.abs()).max_element();
    (low - slack, high + slack)
}
