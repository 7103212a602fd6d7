//! Where footprints are, and which bodies may count for some of them.

use super::cell::Cell;
use super::cells::Cells;
use glam::DVec3;
use rays::{NUDGE, Solids};

/// Where footprints are.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub low: DVec3,
    pub high: DVec3,
    /// The closed surface that all of it is part of, if any; `None` where that differs.
    pub own: Option<Option<u32>>,
}

impl Spot {
    /// Where cells with these corners are, of which there are some.
    pub fn about<'a>(
        mut cells: impl Iterator<Item = &'a Cell>,
        corners: impl Iterator<Item = [DVec3; 4]>,
    ) -> Self {
        let (low, high) = rays::around(corners.flatten());
        let own = cells.next().map(|cell| cell.body);
        let own = own.filter(|&own| cells.all(|cell| cell.body == own));
        Self { low, high, own }
    }

    pub fn of(cells: &Cells) -> Self {
        Self::about(cells.iter(), cells.corners())
    }

    /// True where nothing can bury any of it.
    pub fn is_free(&self, solids: &Solids) -> bool {
        let near = solids.about(self.low, self.high);
        self.retained(solids, near).is_empty()
    }

    pub fn with(self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            own: self.own.filter(|_| self.own == other.own),
        }
    }

    /// True where a crowd of bodies is near it and one of them holds all of it: what is nested in many bodies is
    /// asked of one.
    pub fn is_swallowed(&self, solids: &Solids) -> bool {
        let by_one = |own| solids.swallow(self.low, self.high, own);
        solids.is_crowded(self.low, self.high) && self.own.is_some_and(by_one)
    }

    /// Those of the bodies about it that may bury some of it.
    pub fn retained(&self, solids: &Solids, mut near: Vec<u32>) -> Vec<u32> {
        let slack = NUDGE * self.reach(solids, &near);
        let (low, high) = (self.low - slack, self.high + slack);
        near.retain(|&body| {
            let is_spared = self.own.is_some_and(|own| solids.spares(body, own));
            !is_spared && !solids.is_before(body, low, high)
        });
        near
    }

    /// The largest coordinate of it and of the bodies near it.
    pub fn reach(&self, solids: &Solids, near: &[u32]) -> f64 {
        let extent = near.iter().map(|&body| solids.extent(body));
        extent.fold(self.low.abs().max(self.high.abs()).max_element(), f64::max)
    }

    /// Whether every footprint can be seen or none; where that may differ, those of the bodies near it that count for
    /// some of it.
    pub fn alike(&self, solids: &Solids, near: Vec<u32>, reach: f64) -> Result<bool, Vec<u32>> {
        let Some(own) = self.own else {
            return Err(near);
        };
        let slack = NUDGE * reach;
        let ends = [self.low - slack, self.high + slack];
        let corner = |k: usize| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2];
            DVec3::new(ends[x].x, ends[y].y, ends[z].z)
        };
        let corners = (0..8).map(corner);
        let may_differ = |body: u32| {
            let is_close = || own != Some(body) && solids.meets(body, corners.clone());
            solids.is_ground(body) || is_close()
        };
        let middle = 0.5 * (self.low + self.high);
        let most_taken = cavities(solids, &near);
        let (mut base, mut left, mut is_alike) = (0, Vec::new(), true);
        for body in near {
            if may_differ(body) {
                is_alike = false;
                left.push(body);
                continue;
            }
            let depth = solids.depth(body, middle, own);
            if depth != 0 {
                left.push(body);
            }
            base += depth;
            if base > most_taken {
                return Ok(false);
            }
        }
        match is_alike {
            true => Ok(base <= 0),
            false => Err(left),
        }
    }
}

/// How much some bodies can take at most from what others count: cavities alone do, one each.
pub(super) fn cavities(solids: &Solids, bodies: &[u32]) -> i32 {
    (bodies.iter().filter(|&&body| solids.is_cavity(body))).count() as i32
}
