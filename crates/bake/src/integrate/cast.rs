//! Casts the rays of one technique for the texels of a tile.

use super::estimate::{Gathered, Known};
use super::gang::{DirectionSums, Gang, Lane, Moments};
use super::guides::{self, guide, probes, surfaces};
use super::lobe::Lobe;
use super::sums::{REPLICATES, Replicates, Technique, rays};
use super::task::Task;
use crate::survey::Texel;
use ambient::sampling::{Counts, Guide, LANES};
use atlas::TILE;
use std::ops::Range;
use std::rc::Rc;

/// Where hemisphere points go.
pub(super) enum Aim<'a> {
    /// Everywhere alike.
    Even,
    /// The same, and what they meet is noted.
    Learning(&'a mut Counts),
    Guided(&'a Guide),
}

/// What one technique gathers of a tile, by texel.
pub(super) struct Caster<'a> {
    pub task: &'a Task<'a>,
    pub texels: &'a [Texel],
    pub lobes: &'a [Option<Lobe>],
    pub technique: Technique,
    pub sums: Vec<Replicates>,
    /// Points that the sums hold, and whether a guide sent them.
    pub points: Vec<u32>,
    pub guided: Vec<bool>,
    /// Where hemisphere rays are sent, where that is not everywhere alike and their lobes ask; of all texels or of
    /// none.
    pub sent: Vec<Option<Rc<Guide>>>,
    /// What hemisphere rays have found for lobes, and where they were sent.
    pub beside: &'a HemisphereLobes,
    /// Of all texels or of none, as the next.
    pub moments: &'a mut [[Moments; REPLICATES as usize]],
    pub directions: Vec<[DirectionSums; REPLICATES as usize]>,
}

/// What hemisphere rays found for lobes, and where they were sent; of all texels or of none.
#[derive(Default)]
pub(super) struct HemisphereLobes {
    pub sums: Vec<Replicates>,
    pub sent: Vec<Option<Rc<Guide>>>,
}

impl Caster<'_> {
    /// Casts so many rays for each of the texels `which`, and for their lobes what these are worth.
    pub fn spend(&mut self, rays: u32, which: &[usize]) {
        if self.technique == Technique::Lobe {
            let mut own: Vec<(u32, usize)> =
                which.iter().map(|&i| (self.rays_of(i, rays), i)).collect();
            own.sort_unstable();
            for alike in own.chunk_by(|a, b| a.0 == b.0) {
                let which: Vec<usize> = alike.iter().map(|&(_, i)| i).collect();
                match alike[0].0 {
                    0 => self.borrow(&which),
                    rays => self.cast_rays(&which, rays, Aim::Even),
                }
            }
            return;
        }
        let (surfaces, mut even) = self.surfaces(which, rays / REPLICATES >= guides::FEWEST_POINTS);
        for surface in surfaces {
            let [first, mut others] = probes(self.texels, &surface, rays, BLOCK);
            let mut counts = Counts::default();
            self.cast_rays(&first, rays, Aim::Learning(&mut counts));
            match guide(&counts) {
                None => even.append(&mut others),
                Some(guide) => {
                    self.turn(&first, &guide);
                    self.remember(&others, &guide);
                    self.cast_rays(&surface, rays, Aim::Guided(&guide));
                }
            }
        }
        self.cast_rays(&even, rays, Aim::Even);
    }

    /// Takes the points of the hemisphere for lobes that have none of their own: what these weigh is added where all
    /// of a lobe's are.
    fn borrow(&mut self, which: &[usize]) {
        for &i in which {
            for (own, above) in self.sums[i].iter_mut().zip(&self.beside.sums[i]) {
                own.points = above.points;
                self.points[i] += above.points as u32;
            }
        }
    }

    /// Turns the rays of a surface to a guide: what it has gathered without is forgotten.
    fn turn(&mut self, surface: &[usize], guide: &Guide) {
        surface.iter().for_each(|&i| self.forget(i));
        self.remember(surface, guide);
    }

    /// What the rays so far say.
    pub fn gathered(&self) -> Known<'_> {
        let gathered = Gathered {
            task: self.task,
            technique: self.technique,
            texels: self.texels,
            sums: &self.sums,
            points: &self.points,
            guided: &self.guided,
            lobes: self.lobes,
            beside: &self.beside.sums,
        };
        gathered.known()
    }

    /// The rays that a texel takes where the hemisphere takes so many.
    fn rays_of(&self, i: usize, rays: u32) -> u32 {
        match (self.technique, &self.lobes[i]) {
            (Technique::Lobe, Some(lobe)) => lobe.rays(rays),
            _ => rays,
        }
    }

    /// The texels by surfaces that may have guides, and the rest.
    fn surfaces(&self, which: &[usize], pays: bool) -> (Vec<Vec<usize>>, Vec<usize>) {
        // A map's light is shared with directions drawn from it, unless the map is constant.
        let is_even = self.task.sky.map().is_none_or(|map| map.scale() == 0.0);
        let may_guide = pays && self.technique == Technique::Hemisphere && is_even;
        match may_guide {
            true => surfaces(self.texels, which),
            false => (Vec::new(), which.to_vec()),
        }
    }

    /// Forgets what a texel has gathered, but not the rays that it took.
    fn forget(&mut self, i: usize) {
        let rays = rays(&self.sums[i]);
        self.sums[i] = Replicates::default();
        self.sums[i][0].rays = rays;
        self.points[i] = 0;
        if let Some(moments) = self.moments.get_mut(i) {
            *moments = Default::default();
        }
        if let Some(directions) = self.directions.get_mut(i) {
            *directions = Default::default();
        }
    }

    /// Notes where the rays of texels go: for lobes that they count for, too.
    fn remember(&mut self, which: &[usize], guide: &Guide) {
        which.iter().for_each(|&i| self.guided[i] = true);
        if self.sent.is_empty() {
            return;
        }
        let guide = Rc::new(guide.clone());
        which
            .iter()
            .for_each(|&i| self.sent[i] = Some(guide.clone()));
    }

    /// Casts so many rays for each of the texels `which`, which have none.
    fn cast_rays(&mut self, which: &[usize], rays: u32, mut aim: Aim<'_>) {
        let (each, rest) = (rays / REPLICATES, rays % REPLICATES);
        self.cast_replicates(which, 0..REPLICATES, 0..each, &mut aim);
        self.cast_replicates(which, 0..rest, each..each + 1, &mut aim);
    }

    fn cast_replicates(
        &mut self,
        which: &[usize],
        replicates: Range<u32>,
        range: Range<u32>,
        aim: &mut Aim<'_>,
    ) {
        let Some(&first) = which.first() else {
            return;
        };
        if replicates.is_empty() || range.is_empty() {
            return;
        }
        let lanes = lanes(self.texels, which, replicates.clone());
        which.iter().for_each(|&i| {
            self.points[i] += replicates.len() as u32 * range.len() as u32;
        });
        let task = self.task;
        let technique = self.technique;
        let mut gang = Gang::new(task, self.texels, self.lobes, &self.beside.sent);
        if let (Some(order), false) = (task.any_view, self.moments.is_empty()) {
            gang.gather_moments(order);
        }
        let is_guided = matches!(aim, Aim::Guided(_));
        let joint = task.joint(&self.texels[first], technique, is_guided);
        match aim {
            Aim::Even => {}
            Aim::Learning(counts) => gang.note_in(counts),
            Aim::Guided(guide) => gang.send_by(guide),
        }
        for lanes in lanes.chunks(LANES) {
            gang.load(lanes);
            for net in nets(range.clone()) {
                gang.cast(task, &joint, technique, net);
            }
            gang.collect(technique, &mut self.sums);
            gang.collect_moments(self.moments);
            if !self.directions.is_empty() {
                gang.collect_directions(&mut self.directions);
            }
        }
    }
}

/// The nets over a tile that make up a range of points, and how many points of each a texel takes.
///
/// A number from 1.25 to 2 times a power of two is a share of the next one: texels leave out different points of it.
/// Fewer are the power of two and nets that continue it, for a smaller share of a net is worse than the net of half the
/// size.
fn nets(range: Range<u32>) -> impl Iterator<Item = (Range<u32>, u32)> {
    let mut start = range.start;
    std::iter::from_fn(move || {
        let left = range.end.checked_sub(start).filter(|left| *left > 0)?;
        let first = start;
        let whole = left.next_power_of_two();
        if first == 0 && 8 * left >= 5 * whole {
            start = range.end;
            return Some((0..whole, left));
        }
        let points = 1 << first.trailing_zeros().min(left.ilog2());
        start += points;
        Some((first..start, points))
    })
}

/// Edge of the blocks of texels whose lanes stand side by side: both replicates of 2 x 2 texels, two blocks to a
/// packet.
const BLOCK: u32 = 2;

/// The lanes of the texels `which`, block by block.
fn lanes(texels: &[Texel], which: &[usize], replicates: Range<u32>) -> Vec<Lane> {
    // Texels of one packet stand side by side: block by block, row by row in each.
    let mut places = [None; (TILE * TILE) as usize];
    for &i in which {
        let [x, y] = [texels[i].x, texels[i].y].map(|at| at % TILE);
        let block = y / BLOCK * (TILE / BLOCK) + x / BLOCK;
        places[((block * BLOCK + y % BLOCK) * BLOCK + x % BLOCK) as usize] = Some(i);
    }
    let mut lanes = Vec::with_capacity(which.len() * replicates.len());
    for block in places.chunks_exact((BLOCK * BLOCK) as usize) {
        for replicate in replicates.clone().map(|replicate| replicate as usize) {
            let own = block.iter().flatten();
            lanes.extend(own.map(|&texel| Lane { texel, replicate }));
        }
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_points_are_nets_or_large_shares_of_one() {
        let of = |range| nets(range).collect::<Vec<_>>();
        assert_eq!(of(0..16), [(0..16, 16)]);
        assert_eq!(of(0..24), [(0..32, 24)]);
        assert_eq!(of(0..20), [(0..32, 20)]);
        assert_eq!(of(0..18), [(0..16, 16), (16..18, 2)]);
        assert_eq!(of(8..24), [(8..16, 8), (16..24, 8)]);
        assert_eq!(of(3..3), []);
        for end in 1..300 {
            let points: u32 = of(0..end).iter().map(|(_, points)| points).sum();
            assert_eq!(points, end);
        }
    }
}
