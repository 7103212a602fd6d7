//! Casts the rays of one technique for the texels of a tile: a fixed number, or in rounds until a target is met.

use super::estimate::Gathered;
use super::gang::{Beside, DirectionSums, Gang, Lane, Moments};
use super::guides::{self, guide, probes, surfaces};
use super::sums::{REPLICATES, Replicates, Sums, Technique};
use super::target::{Target, Together};
use super::task::{SHARE, Task};
use crate::options::Pattern;
use crate::survey::Texel;
use ambient::sampling::{Counts, Guide, LANES};
use std::ops::Range;
use std::rc::Rc;

/// Points of each replicate in the first round of a bake with a target.
const FIRST_ROUND: u32 = 8;

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
    pub reflects: &'a [bool],
    pub technique: Technique,
    pub sums: Vec<Replicates>,
    /// Points that the sums hold, and whether a guide sent them.
    pub points: Vec<u32>,
    pub guided: Vec<bool>,
    /// Of all texels or of none, as the next.
    pub moments: &'a mut [[Moments; REPLICATES as usize]],
    pub directions: Vec<[DirectionSums; REPLICATES as usize]>,
    pub beside: &'a mut [Beside],
}

impl Caster<'_> {
    /// Casts so many rays for each of the texels `which`.
    pub fn spend(&mut self, rays: u32, which: &[usize]) {
        let (surfaces, mut even) = self.surfaces(which, rays / REPLICATES >= guides::FEWEST_POINTS);
        for surface in surfaces {
            let [first, mut others] =
                probes(self.texels, &surface, rays, packet_edge(self.task.pattern));
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

    /// Casts rays for each of the texels `which` until it has enough, or all of them have.
    pub fn reach(&mut self, target: Target, which: &[usize]) {
        let most = target.max_rays / REPLICATES;
        let first = FIRST_ROUND.min(most);
        let (surfaces, mut even) = self.surfaces(which, most > 2 * first);
        self.cast(&even, 0..first, Aim::Even);
        let mut guided = Vec::new();
        for mut surface in surfaces {
            let mut counts = Counts::default();
            self.cast(&surface, 0..first, Aim::Learning(&mut counts));
            match guide(&counts) {
                None => even.append(&mut surface),
                Some(guide) => guided.push((surface, guide)),
            }
        }
        if self.task.denoises {
            self.rounds_together(target, which, &even, &guided, first..most);
            return;
        }
        self.rounds(target, even, first..most, None);
        for (mut surface, guide) in guided {
            self.retain_unmet(target, &mut surface);
            self.turn(&surface, &guide);
            self.rounds(target, surface, 0..most - first, Some(&guide));
        }
    }

    /// Round after round for all texels `which`, of which these are guided, until they have enough together or all points are cast.
    fn rounds_together(
        &mut self,
        target: Target,
        which: &[usize],
        even: &[usize],
        guided: &[(Vec<usize>, Guide)],
        points: Range<u32>,
    ) {
        let mut done = points.start;
        for (surface, guide) in guided {
            self.turn(surface, guide);
            self.cast(surface, 0..done, Aim::Guided(guide));
        }
        let together = Together::new(self.texels, which);
        while done < points.end {
            let excess = target.excess(&self.gathered(), &together);
            if excess <= 1.0 {
                return;
            }
            let enough = target.points(done, excess).min(4 * done);
            let next = enough.max(done + done / 4).next_multiple_of(4);
            let range = done..next.min(points.end);
            done = range.end;
            self.cast(even, range.clone(), Aim::Even);
            for (surface, guide) in guided {
                self.cast(surface, range.clone(), Aim::Guided(guide));
            }
        }
    }

    /// Turns the rays of a surface to a guide: what it has gathered without is forgotten.
    fn turn(&mut self, surface: &[usize], guide: &Guide) {
        surface.iter().for_each(|&i| self.forget(i));
        self.remember(surface, guide);
    }

    /// Round after round for the texels `which`, until none is left or all points of the range are cast.
    fn rounds(
        &mut self,
        target: Target,
        mut which: Vec<usize>,
        points: Range<u32>,
        guide: Option<&Guide>,
    ) {
        let mut done = points.start;
        loop {
            if done > 0 {
                self.retain_unmet(target, &mut which);
            }
            let range = done..next_round(done).min(points.end);
            if range.is_empty() || which.is_empty() {
                return;
            }
            done = range.end;
            self.cast(&which, range, guide.map_or(Aim::Even, Aim::Guided));
        }
    }

    fn retain_unmet(&self, target: Target, which: &mut Vec<usize>) {
        let gathered = self.gathered();
        which.retain(|&i| !target.is_met(&gathered, i));
    }

    fn gathered(&self) -> Gathered<'_> {
        Gathered::new(
            self.task.sky,
            self.technique,
            self.texels,
            &self.sums,
            &self.points,
            &self.guided,
        )
    }

    /// The texels by surfaces that may have guides, and the rest.
    fn surfaces(&self, which: &[usize], pays: bool) -> (Vec<Vec<usize>>, Vec<usize>) {
        // A map's light is shared with directions drawn from it, unless the map is constant; tiled texels share theirs.
        let is_even = self.task.sky.map().is_none_or(|map| map.scale() == 0.0);
        let may_guide = pays
            && self.technique == Technique::Hemisphere
            && is_even
            && self.task.pattern == Pattern::Joint;
        match may_guide {
            true => surfaces(self.texels, which),
            false => (Vec::new(), which.to_vec()),
        }
    }

    /// Forgets what a texel has gathered, but not the rays that it took.
    fn forget(&mut self, i: usize) {
        let rays = Sums::of(&self.sums[i]).rays;
        self.sums[i] = Replicates::default();
        self.sums[i][0].rays = rays;
        self.points[i] = 0;
        if let Some(moments) = self.moments.get_mut(i) {
            *moments = Default::default();
        }
        if let Some(directions) = self.directions.get_mut(i) {
            *directions = Default::default();
        }
        if let Some(beside) = self.beside.get_mut(i) {
            beside.sums = Default::default();
        }
    }

    /// Notes where the rays of texels go: for lobes that share them, too.
    fn remember(&mut self, which: &[usize], guide: &Guide) {
        which.iter().for_each(|&i| self.guided[i] = true);
        if self.beside.is_empty() {
            return;
        }
        let guide = Rc::new(guide.clone());
        for &i in which {
            self.beside[i].guide = Some(guide.clone());
        }
    }

    /// Casts so many rays for each of the texels `which`, which have none.
    fn cast_rays(&mut self, which: &[usize], rays: u32, mut aim: Aim<'_>) {
        let (each, rest) = (rays / REPLICATES, rays % REPLICATES);
        self.cast_replicates(which, 0..REPLICATES, 0..each, &mut aim);
        self.cast_replicates(which, 0..rest, each..each + 1, &mut aim);
    }

    /// Casts the points `range` of all replicates of the texels `which`.
    fn cast(&mut self, which: &[usize], range: Range<u32>, mut aim: Aim<'_>) {
        self.cast_replicates(which, 0..REPLICATES, range, &mut aim);
    }

    fn cast_replicates(
        &mut self,
        which: &[usize],
        replicates: Range<u32>,
        range: Range<u32>,
        aim: &mut Aim<'_>,
    ) {
        let lanes = lanes(self.task, self.texels, which, replicates.clone());
        which.iter().for_each(|&i| {
            self.points[i] += replicates.len() as u32 * range.len() as u32;
        });
        let task = self.task;
        let mut gang = Gang::new(task, self.texels, self.reflects);
        if let (Some(order), false) = (task.any_view, self.moments.is_empty()) {
            gang = gang.with_moments(order);
        }
        if !self.beside.is_empty() {
            gang = gang.with_gloss();
        }
        let is_guided = matches!(aim, Aim::Guided(_));
        gang = match aim {
            Aim::Even => gang,
            Aim::Learning(counts) => gang.with_counts(counts),
            Aim::Guided(guide) => gang.with_guide(guide),
        };
        for lanes in lanes.chunks(LANES) {
            gang.load(lanes, self.beside, |texel, replicate| {
                task.pattern_stream(texel, self.technique, replicate, is_guided)
            });
            gang.cast(task, self.technique, range.clone());
            gang.collect(self.technique, &mut self.sums);
            gang.collect_moments(self.moments);
            gang.collect_gloss(self.beside);
            if !self.directions.is_empty() {
                gang.collect_directions(&mut self.directions);
            }
        }
    }
}

/// How many points a replicate has after the round that follows `points`: 8, 16, 32, 48, 64, 96 ... so that the rounds of easy
/// texels are few and hard ones overshoot by half at most.
fn next_round(points: u32) -> u32 {
    match points {
        0 => FIRST_ROUND,
        1..32 => 2 * points,
        _ => points + (1 << points.ilog2()) / 2,
    }
}

/// Edge of the blocks of texels whose lanes stand side by side: both replicates of 2 x 2 texels, two blocks to a packet, or one replicate of
/// 4 x 4 texels, which share it.
fn packet_edge(pattern: Pattern) -> u32 {
    match pattern {
        Pattern::Joint => 2,
        Pattern::Tiled => SHARE,
    }
}

/// The lanes of the texels `which`, block by block.
fn lanes(task: &Task<'_>, texels: &[Texel], which: &[usize], replicates: Range<u32>) -> Vec<Lane> {
    let edge = packet_edge(task.pattern);
    let group = |i: usize| (texels[i].y / edge, texels[i].x / edge);
    // Texels of one packet stand side by side; what is left of them after a round still does.
    let mut which = which.to_vec();
    which.sort_by_key(|&i| (group(i), i));
    which
        .chunk_by(|&a, &b| group(a) == group(b))
        .flat_map(|group| {
            replicates.clone().flat_map(move |replicate| {
                let replicate = replicate as usize;
                group.iter().map(move |&texel| Lane { texel, replicate })
            })
        })
        .collect()
}
