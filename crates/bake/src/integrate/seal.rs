//! Seals: what stands so close above a surface that it takes all light from it.
//!
//! A box that stands a millimetre above a floor leaves the floor under it as dark as if it stood on it, and the
//! texels beside it bright. Smoothing over such a step would blur it, and half of a furnished room's error
//! would lie there. The share of a texel that is sealed therefore does not count where surfaces are fitted: its
//! light is 0, and the rest is fitted as if the seal were an edge of the surface.
//!
//! Seals are found by short rays along the normal: from the middle of each dark texel, and from
//! places all over those where a seal may end.

use super::task::Task;
use super::terms::Terms;
use crate::survey::Texel;
use ambient::sampling::LANES;
use atlas::TILE;
use rays::{Coherence, RayPacket};

/// How far rays reach, in edges of their texel.
const REACH: f64 = 0.2;

/// Places along an edge of a texel where a seal may end: as many rays as a quarter of its own, and within these.
const EDGE: [u32; 2] = [4, 8];

/// A texel is sealed in the middle only where it has no more light than this.
const DARK: f64 = 0.5;

/// Texels beside the border of a tile that have more light than this are not asked whether a seal ends in them
/// that lies in the next: there, all along the border, it would have begun.
const BRIGHT: f64 = 0.75;

/// A texel and a place of its unit square.
type Place = (usize, [f64; 2]);

/// The share of each texel of a tile that is sealed, 0..=1: no more than what its rays leave.
pub(crate) fn seals(task: &Task<'_>, texels: &[Texel], terms: &[Terms]) -> Vec<f32> {
    let light = |i: usize| terms[i].diffuse.value.max(terms[i].visibility.value);
    let can_be = |i: usize| !texels[i].open && texels[i].seen.share > 0.0;
    let middles = (0..texels.len()).filter(|&i| can_be(i) && light(i) <= DARK);
    let middles: Vec<Place> = middles.map(|i| (i, [0.5; 2])).collect();
    let mut whole = vec![false; texels.len()];
    for (&(i, _), is_sealed) in middles.iter().zip(sealed(task, texels, &middles)) {
        whole[i] = is_sealed;
    }
    let neighbours = Neighbours::of(texels);
    let edge = (task.rays / 4).isqrt().clamp(EDGE[0], EDGE[1]);
    let ends_beside = |&i: &usize| neighbours.of_texel(i).any(|j| whole[j] != whole[i]);
    let (mut ends, others): (Vec<usize>, Vec<usize>) = (0..texels.len())
        .filter(|&i| can_be(i))
        .partition(ends_beside);
    let outer = (others.into_iter())
        // Of a part of a texel, corners are not where its sides are.
        .filter(|&i| light(i) <= BRIGHT && !texels[i].seen.is_part())
        .flat_map(|i| sides_at_border(&texels[i]).map(move |side| (i, side)));
    let outer: Vec<(usize, [u32; 2])> = outer.collect();
    let corners = outer.iter().flat_map(|&(i, side)| {
        side.map(|corner| {
            (
                i,
                in_grid([corner % 2, corner / 2].map(|k| k * (edge - 1)), edge),
            )
        })
    });
    let found = sealed(task, texels, &corners.collect::<Vec<Place>>());
    // A middle that is sealed and a side that is not, or the other way round, have an end between them.
    let found = outer.iter().zip(found.chunks_exact(2));
    ends.extend(
        found
            .filter(|((i, _), found)| **found == [!whole[*i]; 2])
            .map(|((i, _), _)| i),
    );
    ends.sort_unstable();
    ends.dedup();
    let all = |is_sealed: bool| if is_sealed { edge * edge } else { 0 };
    let mut counts: Vec<u32> = whole.iter().map(|&is| all(is)).collect();
    // Corners first: where they agree, the rest mostly does.
    let of_corners = count(task, texels, &ends, edge, |is_corner| is_corner);
    for (&i, &corners) in ends.iter().zip(&of_corners) {
        counts[i] = match corners {
            1..4 => corners,
            _ => all(corners > 0),
        };
    }
    let apart = ends.iter().zip(of_corners);
    let apart = apart.filter(|(_, corners)| (1..4).contains(corners));
    let apart: Vec<usize> = apart.map(|(&i, _)| i).collect();
    let of_others = count(task, texels, &apart, edge, |is_corner| !is_corner);
    for (&i, others) in apart.iter().zip(of_others) {
        counts[i] += others;
    }
    let places = f64::from(edge * edge);
    let share = |(i, &count): (usize, &u32)| {
        (f64::from(count) / places).min(1.0 - light(i)).max(0.0) as f32
    };
    counts.iter().enumerate().map(share).collect()
}

/// How many of those places of each of the texels `which` are sealed that are wanted, corners or others.
fn count(
    task: &Task<'_>,
    texels: &[Texel],
    which: &[usize],
    edge: u32,
    wanted: impl Fn(bool) -> bool,
) -> Vec<u32> {
    let is_end = |k: u32| k == 0 || k == edge - 1;
    let grid = (0..edge * edge).map(|k| [k % edge, k / edge]);
    let grid: Vec<[f64; 2]> = grid
        .filter(|&[x, y]| wanted(is_end(x) && is_end(y)))
        .map(|place| in_grid(place, edge))
        .collect();
    let places = which
        .iter()
        .flat_map(|&i| grid.iter().map(move |&place| (i, place)));
    let found = sealed(task, texels, &places.collect::<Vec<Place>>());
    let counts = found.chunks_exact(grid.len());
    counts
        .map(|found| found.iter().map(|&is| u32::from(is)).sum())
        .collect()
}

/// The middle of a cell of a texel that has so many of them along an edge.
fn in_grid(cell: [u32; 2], edge: u32) -> [f64; 2] {
    cell.map(|k| (f64::from(k) + 0.5) / f64::from(edge))
}

/// The two corners, row-major, of each side of a texel that the next tile lies beyond.
fn sides_at_border(texel: &Texel) -> impl Iterator<Item = [u32; 2]> + use<> {
    let [left, top] = [texel.x, texel.y].map(|at| at % TILE == 0);
    let [right, bottom] = [texel.x, texel.y].map(|at| at % TILE == TILE - 1);
    let sides = [
        (left, [0, 2]),
        (right, [1, 3]),
        (top, [0, 1]),
        (bottom, [2, 3]),
    ];
    sides
        .into_iter()
        .filter_map(|(is_border, side)| is_border.then_some(side))
}

/// Which places have something close above them.
fn sealed(task: &Task<'_>, texels: &[Texel], places: &[Place]) -> Vec<bool> {
    let mut found = Vec::with_capacity(places.len());
    let mut packet = RayPacket::<LANES>::default();
    for places in places.chunks(LANES) {
        for (lane, &(i, place)) in places.iter().enumerate() {
            let texel = &texels[i];
            let (sample, origin) = texel.start(place);
            let direction = sample.geometric.as_vec3().to_array();
            for axis in 0..3 {
                packet.origin[axis][lane] = origin[axis];
                packet.direction[axis][lane] = direction[axis];
            }
            let edge = (texel.area / f64::from(texel.coverage)).sqrt();
            packet.t_max[lane] = ((REACH * edge) as f32).min(task.t_max);
        }
        let active = (1 << places.len()) - 1;
        let blocked = task
            .backend
            .occluded16(&packet, active, Coherence::Incoherent);
        found.extend((0..places.len()).map(|lane| blocked >> lane & 1 == 1));
    }
    found
}

/// Which texels of a tile lie beside each other.
struct Neighbours<'a> {
    texels: &'a [Texel],
    /// One more than the number of the texel at each place of the tile; 0 where there is none.
    at: [u16; (TILE * TILE) as usize],
}

impl<'a> Neighbours<'a> {
    fn of(texels: &'a [Texel]) -> Self {
        let mut at = [0; (TILE * TILE) as usize];
        for (number, texel) in (1..).zip(texels) {
            at[(texel.y % TILE * TILE + texel.x % TILE) as usize] = number;
        }
        Self { texels, at }
    }

    /// Texels of one object with a texel, in the eight places about it that lie in the tile.
    fn of_texel(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let own = &self.texels[i];
        let about = |at: u32| (at % TILE).saturating_sub(1)..(at % TILE + 2).min(TILE);
        let places = about(own.y).flat_map(move |y| about(own.x).map(move |x| y * TILE + x));
        let found = places.filter_map(|place| usize::from(self.at[place as usize]).checked_sub(1));
        found.filter(move |&j| self.texels[j].object == own.object)
    }
}
