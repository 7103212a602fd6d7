//! The part of a texel's footprint that can be seen: what does not lie inside of a solid.
//!
//! A first look costs one test a texel: if no solid's surface comes near the footprint, it is buried as a whole or not at all.
//! Elsewhere the unit square of sample points is cut into strata. One whose corners lie in the open is kept,
//! and samples are spread over those that are kept. So all rays of a texel serve what can be seen of it.

use super::cell::Cell;
use glam::DVec3;
use rays::{NUDGE, Near, Solids};

/// Strata along an edge of the unit square.
const EDGE: usize = 8;

/// What can be seen of a footprint.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    /// Its share, 0..=1.
    pub share: f32,
    /// The strata that samples are drawn from; empty for all.
    strata: Vec<u8>,
}

/// The lattice with buried corners open where none beside them along a row or column is buried: a body that only touches the surface
/// there, or is thinner than a stratum.
fn without_touches(open: &[bool]) -> Vec<bool> {
    let row = EDGE + 1;
    let lonely = |at: usize| {
        let column = at % row;
        let beside = [
            (column > 0).then(|| at - 1),
            (column < EDGE).then(|| at + 1),
            at.checked_sub(row),
            (at + row < open.len()).then(|| at + row),
        ];
        beside.into_iter().flatten().all(|other| open[other])
    };
    (0..open.len()).map(|at| open[at] || lonely(at)).collect()
}

impl Seen {
    /// All of it.
    pub const ALL: Self = Self {
        share: 1.0,
        strata: Vec::new(),
    };

    /// Nothing of it.
    pub const NONE: Self = Self {
        share: 0.0,
        strata: Vec::new(),
    };

    /// Looks at a texel of these cells among solids whose boxes may meet its own. `choose` gives the
    /// cell under a point of the unit square by its first coordinate.
    pub fn of(
        cells: &[Cell],
        choose: impl Fn(f32) -> usize,
        solids: &Solids,
        near: &[u32],
    ) -> Self {
        let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let corners = cells.iter().flat_map(Cell::corners);
        let (low, high) = corners.fold(limits, |(low, high), p| (low.min(p), high.max(p)));
        let own = cells[0].body;
        let is_uniform = cells.iter().all(|cell| cell.body == own);
        let matters = |body: &u32| !(is_uniform && solids.spares(*body, own));
        let mut near = solids.narrowed(near, low, high);
        near.retain(matters);
        if near.is_empty() {
            return Self::ALL;
        }
        let extent = near.iter().map(|&body| solids.extent(body));
        let reach = extent.fold(low.abs().max(high.abs()).max_element(), f64::max);
        let tested = |position: DVec3, geometric: DVec3| position + NUDGE * reach * geometric;
        let faces: Vec<DVec3> = cells
            .iter()
            .map(|cell| cell.sample(cell.centre()).geometric)
            .collect();
        let corners: Vec<DVec3> = cells
            .iter()
            .zip(&faces)
            .flat_map(|(cell, &face)| cell.corners().map(|corner| tested(corner, face)))
            .collect();
        let corners = || corners.iter().copied();
        let point_at = |u: [f64; 2]| {
            let u = u.map(|u| u as f32);
            let index = choose(u[0]);
            let (cell, place) = (&cells[index], cells[index].place(u));
            // Where the shading normal does not change, neither does the side that it is on.
            let geometric = match cell.is_smooth() {
                true => cell.sample(place).geometric,
                false => faces[index],
            };
            (tested(cell.at(place), geometric), cell.body)
        };
        // A body whose surface does not come near counts the same all over the texel.
        let is_far =
            |&body: &u32| is_uniform && (own == Some(body) || !solids.meets(body, corners()));
        let (far, close): (Vec<u32>, Vec<u32>) = near.iter().partition(|body| is_far(body));
        let (middle, within) = point_at([0.5; 2]);
        let base: i32 = far
            .iter()
            .map(|&body| solids.depth(body, middle, within))
            .sum();
        if close.is_empty() {
            return if base <= 0 { Self::ALL } else { Self::NONE };
        }
        // A coordinate of 1 would choose no cell.
        let at = |k: usize| (k as f64 / EDGE as f64).min(1.0 - 1e-7);
        let mut close: Vec<Near> = close
            .into_iter()
            .map(|body| solids.near(body, corners()))
            .collect();
        let lattice: Vec<bool> = (0..=EDGE)
            .flat_map(|row| (0..=EDGE).map(move |column| [column, row]))
            .map(|place| {
                let (point, own) = point_at(place.map(at));
                let depth = |near: &mut Near| near.depth(point, own);
                base + close.iter_mut().map(depth).sum::<i32>() <= 0
            })
            .collect();
        let lattice = without_touches(&lattice);
        let open_corners = |stratum: usize| {
            let first = stratum / EDGE * (EDGE + 1) + stratum % EDGE;
            let steps = [0, 1, EDGE + 1, EDGE + 2].iter();
            steps.filter(|&step| lattice[first + step]).count()
        };
        let count: usize = (0..EDGE * EDGE).map(open_corners).sum();
        let share = count as f32 / (4 * EDGE * EDGE) as f32;
        let mut kept: Vec<usize> = (0..EDGE * EDGE)
            .filter(|&stratum| open_corners(stratum) == 4)
            .collect();
        if kept.is_empty() {
            return Self::NONE;
        }
        if kept.len() == EDGE * EDGE {
            return Self::ALL;
        }
        // From row to row without a jump, so that neighbouring numbers choose neighbouring strata.
        kept.sort_by_key(|&stratum| {
            let (row, column) = (stratum / EDGE, stratum % EDGE);
            (row, if row % 2 == 0 { column } else { EDGE - column })
        });
        Self {
            share,
            strata: kept.into_iter().map(|stratum| stratum as u8).collect(),
        }
    }

    /// True where samples are drawn from a part only.
    pub fn is_part(&self) -> bool {
        !self.strata.is_empty()
    }

    /// A point of the unit square moved into the part: uniform there for a uniform point.
    #[inline]
    pub fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        if self.strata.is_empty() {
            return [u, v];
        }
        let across = u * self.strata.len() as f32;
        let index = (across as usize).min(self.strata.len() - 1);
        let stratum = usize::from(self.strata[index]);
        let within = (across - index as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let edge = EDGE as f32;
        [
            ((stratum % EDGE) as f32 + within) / edge,
            ((stratum / EDGE) as f32 + v) / edge,
        ]
    }

    /// The middles of the strata that samples are drawn from.
    pub fn middles(&self) -> impl Iterator<Item = [f64; 2]> {
        let middle = |k: usize| (k as f64 + 0.5) / EDGE as f64;
        let strata = self.strata.iter().map(|&stratum| usize::from(stratum));
        strata.map(move |stratum| [middle(stratum % EDGE), middle(stratum / EDGE)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_even_over_the_strata_that_are_kept() {
        let strata = [3, 4, 17, 60];
        let seen = Seen {
            share: 4.0 / 64.0,
            strata: strata.to_vec(),
        };
        // Each stratum gets its part of the first coordinate, from its left edge to its right, and all of the second.
        for (k, &stratum) in strata.iter().enumerate() {
            let corner = [stratum % 8, stratum / 8].map(f32::from);
            for within in [0.0, 0.25, 0.5, 0.875] {
                for v in [0.0, 0.375] {
                    let placed = seen.place([(k as f32 + within) / 4.0, v]);
                    let expected = [(corner[0] + within) / 8.0, (corner[1] + v) / 8.0];
                    assert_eq!(placed, expected, "stratum {stratum}, {within}");
                }
            }
        }
        assert_eq!(Seen::ALL.place([0.3, 0.7]), [0.3, 0.7]);
    }
}
