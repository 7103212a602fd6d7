//! The part of a texel's footprint that can be seen: what does not lie inside of a solid.
//!
//! Texels of a body are looked at together first, then by quarters: where no solid's surface comes near, they are
//! buried all or not at all. Elsewhere the unit square of sample points is cut into strata. One whose corners lie in
//! the open is kept, and samples are spread over those that are kept. So all rays of a texel serve what can be seen of
//! it.

use super::cell::Cell;
use super::cells::{Cells, Ground};
use super::spot::{Spot, cavities};
use glam::DVec3;
use rays::{NUDGE, Near, Solids};

/// Strata along an edge of the unit square.
const EDGE: usize = 8;

/// Parts in which footprints are looked at that cannot be told together: of a tile four rows, a row, four texels, one.
const PARTS: usize = 4;

/// What can be seen of a footprint.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    /// Its share, 0..=1.
    pub share: f32,
    /// The strata that samples are drawn from; empty for all.
    strata: Vec<u8>,
}

/// True where nothing can bury any of a tile, so that all can be seen.
pub(super) fn is_free(solids: &Solids, ground: &Ground) -> bool {
    let cells = &ground.cells;
    Spot::about(cells.iter(), cells.iter().map(Cell::corners)).is_free(solids)
}

/// What can be seen of footprints, each with its number and its cells, of which neighbours mostly follow one another;
/// of those that are not among the answers all.
pub(super) fn look<'a>(
    solids: &Solids,
    footprints: impl Iterator<Item = (usize, &'a Cells)>,
) -> Vec<(usize, Seen)> {
    let footprint = |(number, cells)| (number, cells, Spot::of(cells));
    let mut footprints: Vec<Placed> = footprints.map(footprint).collect();
    // Bodies apart, so that what buries neither of two that lie far from one another is not asked for both.
    footprints.sort_by_key(|(.., spot)| spot.own);
    let mut found = Vec::new();
    for part in footprints.chunk_by(|(.., a), (.., b)| a.own == b.own) {
        if let Some(whole) = around(part) {
            let about = || solids.about(whole.low, whole.high);
            look_among(solids, (&about, None), (part, whole), &mut found);
        }
    }
    found
}

/// A footprint's number, its cells and where it is.
type Placed<'a> = (usize, &'a Cells, Spot);

fn around(footprints: &[Placed]) -> Option<Spot> {
    let spots = footprints.iter().map(|(.., spot)| *spot);
    spots.reduce(|whole, spot| whole.with(&spot))
}

/// The same for footprints that lie together in `whole`, among the bodies about them, of which these alone may count
/// for some of them, in order; `None` for all.
fn look_among(
    solids: &Solids,
    (about, counting): (&dyn Fn() -> Vec<u32>, Option<&[u32]>),
    (footprints, whole): (&[Placed], Spot),
    found: &mut Vec<(usize, Seen)>,
) {
    if whole.is_swallowed(solids) {
        found.extend((footprints.iter()).map(|(number, ..)| (*number, Seen::NONE)));
        return;
    }
    let near = whole.retained(solids, about());
    // How far off their surface points are tested depends on all bodies about them.
    let reach = whole.reach(solids, &near);
    let counts = |body: &u32| counting.is_none_or(|of| of.binary_search(body).is_ok());
    let left: Vec<u32> = near.iter().copied().filter(counts).collect();
    if left.is_empty() {
        return;
    }
    if let [(number, cells, _)] = footprints {
        found.push((
            *number,
            Seen::of(cells, &whole, solids, (&left, reach), true),
        ));
        return;
    }
    let left = match whole.alike(solids, left, reach) {
        Ok(is_seen) => {
            let seen = if is_seen { Seen::ALL } else { Seen::NONE };
            found.extend((footprints.iter()).map(|(number, ..)| (*number, seen.clone())));
            return;
        }
        Err(left) => left,
    };
    for part in footprints.chunks(footprints.len().div_ceil(PARTS)) {
        if let Some(whole) = around(part) {
            let about = || solids.narrowed(&near, whole.low, whole.high);
            look_among(solids, (&about, Some(&left)), (part, whole), found);
        }
    }
}

/// The lattice with buried corners open where none beside them along a row or column is buried: a body that only
/// touches the surface there, or is thinner than a stratum.
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

    /// Looks at a texel of these cells, which is `whole`, among the solids whose boxes may meet its own, up to this
    /// largest coordinate. Where grounds that only cut it leave nothing of it, it is looked at without.
    fn of(
        cells: &Cells,
        whole: &Spot,
        solids: &Solids,
        (near, reach): (&[u32], f64),
        by_cuts: bool,
    ) -> Self {
        let (own, is_uniform) = (cells.cell(0).body, whole.own.is_some());
        let tested = |position: DVec3, geometric: DVec3| position + NUDGE * reach * geometric;
        let corners: Vec<DVec3> = cells
            .corners()
            .zip(cells.iter())
            .flat_map(|(corners, cell)| corners.map(|corner| tested(corner, cell.geometric)))
            .collect();
        let corners = || corners.iter().copied();
        let point_at = |u: [f64; 2]| {
            let (index, place) = cells.place(u.map(|u| u as f32));
            let cell = cells.cell(index);
            (tested(cell.at(place), cell.geometric), cell.body)
        };
        // A body whose surface does not come near counts the same all over the texel.
        let is_far =
            |body: u32| is_uniform && (own == Some(body) || !solids.meets(body, corners()));
        let (middle, within) = point_at([0.5; 2]);
        let most_taken = cavities(solids, near);
        let (mut base, mut close) = (0, Vec::new());
        for &body in near {
            if !is_far(body) {
                close.push(body);
                continue;
            }
            base += solids.depth(body, middle, within);
            if base > most_taken {
                return Self::NONE;
            }
        }
        if close.is_empty() {
            return if base <= 0 { Self::ALL } else { Self::NONE };
        }
        let most_taken = cavities(solids, &close);
        // A coordinate of 1 would choose no cell.
        let at = |k: usize| (k as f64 / EDGE as f64).min(1.0 - 1e-7);
        let is_cut = |body: &u32| cells.iter().any(|cell| solids.cuts(*body, cell.body));
        let by_cuts = by_cuts && close.iter().any(is_cut);
        let mut close: Vec<(u32, Option<Near>)> =
            (close.into_iter().map(|body| (body, None))).collect();
        let mut is_open = |place: [usize; 2]| {
            let (point, own) = point_at(place.map(at));
            let mut sum = base;
            for number in 0..close.len() {
                let (body, near) = &mut close[number];
                let near = near.get_or_insert_with(|| solids.near(*body, corners()));
                sum += near.depth(point, own);
                sum += i32::from(by_cuts && near.cuts(point, own));
                if sum > most_taken {
                    // What buries a point mostly buries those beside it.
                    close[..=number].rotate_right(1);
                    return false;
                }
            }
            sum <= 0
        };
        let lattice: Vec<bool> = (0..=EDGE)
            .flat_map(|row| (0..=EDGE).map(move |column| [column, row]))
            .map(&mut is_open)
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
        if kept.is_empty() && by_cuts {
            return Self::of(cells, whole, solids, (near, reach), false);
        }
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

    /// The same where only so much of the footprint is left.
    pub fn left(self, left: f32) -> Self {
        Self {
            share: self.share * left,
            ..self
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
    use super::super::fixture;
    use super::*;
    use atlas::Piece;
    use rays::{Patch, PlaneErrors, World, WorldOptions};

    /// A floor over y = 0, larger than 8 x 8, under boxes given by their lowest and highest corners.
    fn world(boxes: &[[[f32; 3]; 2]]) -> World {
        let mut floor = scene::authored::Mesh::default();
        floor.positions = vec![[0.0; 3], [0.0, 0.0, 16.0], [16.0, 0.0, 0.0]];
        floor.triangles = vec![[0, 1, 2]];
        let block = |ends: &[[f32; 3]; 2]| {
            let mut mesh = scene::authored::Mesh::default();
            let corner = |k: usize| [0, 1, 2].map(|axis| ends[k >> axis & 1][axis]);
            mesh.positions = (0..8).map(corner).collect();
            let sides = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
            mesh.triangles = sides.into_iter().flat_map(halves).collect();
            mesh
        };
        let meshes = std::iter::once(floor).chain(boxes.iter().map(block));
        let scene = scene::Scene::from_meshes(meshes.collect(), vec![]).expect("a scene");
        World::new(std::sync::Arc::new(scene), WorldOptions::default()).expect("a world")
    }

    /// What can be seen of texels of the floor, half a unit wide, 16 x 16 of them, row by row.
    fn seen(world: &World) -> Vec<Seen> {
        let patch = Patch::of(world, &PlaneErrors::of(world), 0, 0);
        let weights = |x: f64, z: f64| DVec3::new(16.0 - x - z, z, x) / 16.0;
        let texel = |k: usize| {
            let [x, z] = [k % 16, k / 16].map(|k| k as f64 / 2.0);
            let piece = Piece {
                instance: 0,
                triangle: 0,
                number: 0,
                square: true,
                corners: [weights(x, z), weights(x + 0.5, z), weights(x, z + 0.5)],
                cumulative: 1.0,
            };
            fixture::cells(&patch, &[(piece, 1.0)])
        };
        let texels: Vec<Cells> = (0..256).map(texel).collect();
        let mut seen = vec![Seen::ALL; 256];
        for (number, found) in look(world.solids(), texels.iter().enumerate()) {
            seen[number] = found;
        }
        seen
    }

    #[test]
    fn texels_looked_at_together_are_buried_where_a_body_stands_on_them() {
        // Its sides are a sixteenth of a unit or less from borders of texels: no stratum is left of those that they
        // cut.
        let low = [2.03, -1.0, 2.03];
        let cases: [(&[[[f32; 3]; 2]], usize); 4] = [
            (&[], 0),
            (&[[low, [5.97, 1.0, 3.97]]], 8 * 4),
            // It hovers over the floor.
            (&[[[2.03, 0.01, 2.03], [5.97, 1.0, 3.97]]], 0),
            // All of the floor lies in it.
            (&[[[-1.0; 3], [17.0, 1.0, 17.0]]], 256),
        ];
        for (boxes, expected) in cases {
            let found = seen(&world(boxes));
            let within = |k: usize| {
                expected == 256 || (4..12).contains(&(k % 16)) && (4..8).contains(&(k / 16))
            };
            for (k, seen) in found.iter().enumerate() {
                let is_buried = expected > 0 && within(k);
                let expected = if is_buried { Seen::NONE } else { Seen::ALL };
                assert_eq!(*seen, expected, "{boxes:?} {k}");
            }
            assert_eq!(
                found.iter().filter(|seen| seen.share < 1.0).count(),
                expected
            );
        }
    }

    #[test]
    fn what_a_crowd_of_bodies_holds_is_buried_as_in_one() {
        // Twenty nested in each other: about all of the floor, and standing on 8 x 4 texels of it.
        let nested = |low: [f32; 3], high: [f32; 3]| -> Vec<[[f32; 3]; 2]> {
            let by = |k: u8| {
                [
                    low.map(|x| x + 1e-3 * f32::from(k)),
                    high.map(|x| x - 1e-3 * f32::from(k)),
                ]
            };
            (0..20).map(by).collect()
        };
        for (low, high) in [
            ([-1.0; 3], [17.0, 1.0, 17.0]),
            ([2.03, -1.0, 2.03], [5.97, 1.0, 3.97]),
        ] {
            let (crowd, one) = (
                seen(&world(&nested(low, high))),
                seen(&world(&[[low, high]])),
            );
            assert_eq!(crowd, one, "{low:?}");
            assert!(one.contains(&Seen::NONE), "{low:?}");
        }
    }

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
