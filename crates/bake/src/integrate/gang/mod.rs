//! Sixteen sample streams walked in step: each lane is one replicate of one texel, each step casts one packet.
//!
//! The name is that of M. Pharr and W. R. Mark, "ispc: A SPMD Compiler for High-Performance CPU Programming"
//! (Innovative Parallel Computing, 2012): a gang is the program instances that one vector unit runs in step, a lane
//! each.
//!
//! Texels that share directions stand side by side in a gang, so its packets hold parallel rays from neighbouring
//! places. All arithmetic runs over arrays of sixteen, in whatever vector width the machine has; no fused operation is
//! used, so that every machine gets the same bits.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

mod aim;
mod borders;
mod collect;
mod directional;
mod gloss;
mod lane_sums;
mod light;
mod moments;
mod step;
mod surfaces;

use super::lobe::Lobe;
use super::sums::Technique;
use super::task::{Joint, Task};
use crate::options::Model;
use crate::survey::Texel;
use ambient::sampling::{Counts, Guide, LANES, PointSet, Streams, Wide};
use atlas::TILE;
use borders::Borders;
pub(crate) use directional::DirectionSums;
use directional::LaneDirections;
use gloss::LaneGloss;
use lane_sums::LaneSums;
use light::{Lobes, add_map_light};
use moments::LaneMoments;
pub(crate) use moments::{Moments, coefficients};
use pulp::{Simd, WithSimd};
use rays::{Coherence, RayPacket};
use std::ops::Range;
use std::rc::Rc;
use surfaces::{Frames, LaneSurfaces};

/// One lane: a texel of the tile and one of its replicates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lane {
    /// Index into the tile's texels.
    pub texel: usize,
    pub replicate: usize,
}

/// Up to sixteen lanes and what they have gathered.
pub(crate) struct Gang<'a> {
    texels: &'a [Texel],
    /// The lobes of texels that reflect.
    highlights: &'a [Option<Lobe>],
    /// Where the hemisphere rays of texels were sent, if not everywhere alike; of all texels or of none.
    sent: &'a [Option<Rc<Guide>>],
    lanes: &'a [Lane],
    streams: Streams,
    /// Column and row of each lane's texel, and the lanes of the second replicate.
    at: [[u32; LANES]; 2],
    second: u32,
    surfaces: LaneSurfaces,
    /// Frames at the last point, and whether they no longer hold.
    frames: Frames,
    stale: bool,
    /// Cell under each lane, where points choose it: lanes whose texels have several.
    cell: [u32; LANES],
    borders: Borders<'a>,
    /// Lanes whose texels can be seen in part.
    parted: u32,
    /// Lanes in use, and those among them that nothing stands above, and whose hemisphere rays a guide sent.
    used: u32,
    open: u32,
    guided: u32,
    /// 1 / (n + 1) of each lane's lobe, its rays for each ray of the other techniques, and the lanes that need it.
    lobe_scale: Wide,
    lobe_share: Wide,
    lobes: u32,
    packet: RayPacket<LANES>,
    /// Points cast of every lane.
    points: u64,
    sums: LaneSums<f64>,
    /// Sums over the block in work: short, so f32 holds them.
    block: LaneSums<f32>,
    /// Harmonics of the open directions, where any view is asked for.
    moments: Option<LaneMoments>,
    /// The lobes of GGX.
    gloss: Option<LaneGloss>,
    /// Where lanes are open and whence their light comes, where a layer asks for it.
    directions: Option<LaneDirections>,
    /// Where hemisphere directions are sent, if not everywhere alike.
    guide: Option<&'a Guide>,
    /// Which points of the hemisphere were open, while that is being learnt.
    counts: Option<&'a mut Counts>,
}

impl<'a> Gang<'a> {
    /// A gang without lanes.
    pub fn new(
        task: &Task<'_>,
        texels: &'a [Texel],
        highlights: &'a [Option<Lobe>],
        sent: &'a [Option<Rc<Guide>>],
    ) -> Self {
        let has_gloss = task.model == Model::Ggx && highlights.iter().any(Option::is_some);
        let mut gang = Self {
            texels,
            highlights,
            sent,
            lanes: &[],
            streams: Streams::new(task.points),
            at: [[0; LANES]; 2],
            second: 0,
            surfaces: LaneSurfaces::none(),
            frames: Frames::about([[0.0; LANES], [0.0; LANES], [1.0; LANES]]),
            stale: true,
            cell: [0; LANES],
            borders: Borders::none(),
            parted: 0,
            used: 0,
            open: 0,
            guided: 0,
            lobe_scale: [1.0; LANES],
            lobe_share: [1.0; LANES],
            lobes: 0,
            packet: RayPacket::default(),
            points: 0,
            sums: LaneSums::default(),
            block: LaneSums::default(),
            moments: None,
            gloss: has_gloss.then(LaneGloss::new),
            directions: task.directional.then(LaneDirections::new),
            guide: None,
            counts: None,
        };
        gang.packet.t_max = [task.t_max; LANES];
        gang
    }

    /// Gathers harmonics up to an order too.
    pub fn gather_moments(&mut self, order: usize) {
        self.moments = Some(LaneMoments::new(order));
    }

    /// Sends hemisphere directions by a guide.
    pub fn send_by(&mut self, guide: &'a Guide) {
        self.guide = Some(guide);
    }

    /// Notes which points are open.
    pub fn note_in(&mut self, counts: &'a mut Counts) {
        self.counts = Some(counts);
    }

    /// Takes at most sixteen lanes, and forgets those before.
    pub fn load(&mut self, lanes: &'a [Lane]) {
        assert!(lanes.len() <= LANES, "{} lanes in a gang", lanes.len());
        self.lanes = lanes;
        self.cell = [0; LANES];
        self.borders.clear();
        (self.used, self.open, self.guided) = (0, 0, 0);
        (self.lobes, self.parted, self.second) = (0, 0, 0);
        self.points = 0;
        self.sums = LaneSums::default();
        self.stale = true;
        if let Some(moments) = &mut self.moments {
            moments.clear();
        }
        if let Some(gloss) = &mut self.gloss {
            gloss.clear();
        }
        if let Some(directions) = &mut self.directions {
            directions.clear();
        }
        for l in 0..lanes.len() {
            let Lane { texel, replicate } = lanes[l];
            self.second |= (replicate as u32) << l;
            // Its other replicate follows mostly; what both have in common is looked up once.
            let twin = lanes[l + 1..].iter().position(|lane| lane.texel == texel);
            if self.used >> l & 1 == 0 {
                self.put([l, twin.map_or(l, |steps| l + 1 + steps)], texel);
            }
        }
    }

    /// Puts a texel under both lanes, which may be one.
    #[inline(always)]
    fn put(&mut self, both: [usize; 2], texel: usize) {
        let own = 1 << both[0] | 1 << both[1];
        let (sent, lobe) = (self.sent.get(texel), &self.highlights[texel]);
        let texel = &self.texels[texel];
        let if_so = |is: bool| if is { own } else { 0 };
        self.used |= own;
        self.open |= if_so(texel.open);
        self.guided |= if_so(sent.is_some_and(Option::is_some));
        self.parted |= if_so(texel.seen.is_part());
        self.lobes |= if_so(lobe.is_some());
        self.surfaces.set(both, &texel.cells);
        for &l in &both[..1 + usize::from(both[0] != both[1])] {
            (self.at[0][l], self.at[1][l]) = (texel.x, texel.y);
            self.borders.set(l, &texel.cells);
            if let Some(lobe) = lobe {
                (self.lobe_scale[l], self.lobe_share[l]) = (lobe.scale, lobe.share);
                if let Some(gloss) = &mut self.gloss {
                    gloss.set(l, lobe);
                }
            }
            if let Some(moments) = &mut self.moments {
                moments.set(l, texel);
            }
        }
    }

    /// Casts so many of the points that every lane has of a net.
    pub fn cast(
        &mut self,
        task: &Task<'_>,
        joint: &Joint,
        technique: Technique,
        (net, points): (Range<u32>, u32),
    ) {
        // A closure would not be compiled for the vector width.
        struct Run<'g, 'a, 't> {
            gang: &'g mut Gang<'a>,
            task: &'g Task<'t>,
            joint: &'g Joint,
            technique: Technique,
            net: Range<u32>,
            points: u32,
        }
        impl WithSimd for Run<'_, '_, '_> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) {
                self.gang.follow(self.task, self.joint, &self.net);
                self.gang.run(self.task, self.technique, self.points);
            }
        }
        task.arch.dispatch(Run {
            gang: self,
            task,
            joint,
            technique,
            net,
            points,
        });
    }

    /// Takes the points of each lane: parts of one sequence. Errors of neighbours tend to cancel, and smoothed pages
    /// gain.
    #[inline(always)]
    fn follow(&mut self, task: &Task<'_>, joint: &Joint, net: &Range<u32>) {
        if task.points == PointSet::Sobol {
            let [a, b] = &joint.streams;
            let [x, y] = &self.at;
            self.streams
                .join([a, b], self.second, [x, y], TILE.ilog2(), net);
            return;
        }
        for (l, lane) in self.lanes.iter().enumerate() {
            let Texel { x, y, .. } = self.texels[lane.texel];
            let stream = task.stream(x, y, joint.label, lane.replicate as u32);
            self.streams.set(l, &stream);
        }
    }

    #[inline(always)]
    fn run(&mut self, task: &Task<'_>, technique: Technique, points: u32) {
        self.points += u64::from(points);
        for block in Streams::blocks(0..points) {
            self.streams.enter(block);
            for step in 0..block.steps() {
                self.cast_point(task, technique, step);
            }
            self.sums.absorb(&self.block);
            self.block = LaneSums::default();
            if let Some(moments) = &mut self.moments {
                moments.absorb();
            }
            if let Some(gloss) = &mut self.gloss {
                gloss.absorb();
            }
            if let Some(directions) = &mut self.directions {
                directions.absorb();
            }
        }
    }

    /// Casts one point of every lane.
    #[inline(always)]
    fn cast_point(&mut self, task: &Task<'_>, technique: Technique, step: u32) {
        let [mut u0, mut u1, mut v0, mut v1] = self.streams.point(step);
        let guided = self.guide.map(|guide| guide.warp16(&mut u0, &mut u1));
        let mut parted = self.parted;
        while parted != 0 {
            let l = parted.trailing_zeros() as usize;
            parted &= parted - 1;
            let seen = &self.texels[self.lanes[l].texel].seen;
            [v0[l], v1[l]] = seen.place([v0[l], v1[l]]);
        }
        if self.borders.any() {
            let cells = self.borders.cells(&v0, &v1);
            let mut moved = 0;
            for l in 0..LANES {
                moved |= u32::from(cells[l] != self.cell[l]) << l;
            }
            while moved != 0 {
                let l = moved.trailing_zeros() as usize;
                moved &= moved - 1;
                self.walk(l, cells[l]);
            }
        }
        let at = self.surfaces.places(&v0, &v1);
        let mut step = self.step(task, technique, [&u0, &u1], &at);
        if let Some(guided) = guided {
            for weights in &mut step.weights {
                for l in 0..LANES {
                    weights[l] *= guided[l];
                }
            }
        }
        let active = step.above & self.used;
        let cast = active & !self.open;
        let blocked = if cast == 0 {
            0
        } else {
            // Nearly parallel, but Embree 4 is up to half slower where told so (vendor-notes/embree.md).
            task.backend
                .occluded16(&self.packet, cast, Coherence::Incoherent)
        };
        self.block.add(&step, active & !blocked, cast);
        if let Some(counts) = &mut self.counts {
            for l in 0..self.lanes.len() {
                counts.add([u0[l], u1[l]], (active & !blocked) >> l & 1 == 1);
            }
        }
        if let Some(moments) = &mut self.moments {
            moments.add(&step, active & !blocked);
        }
        if let Some(directions) = &mut self.directions {
            directions.add(&step, active & !blocked);
        }
        let normal = &self.frames.normal;
        if let Some(sky) = task.sky.map() {
            let lobes = Lobes {
                scale: &self.lobe_scale,
                share: &self.lobe_share,
                gloss: self.gloss.as_ref(),
                used: self.lobes,
            };
            let open = active & !blocked;
            let sums = (&mut self.block.light, self.directions.as_mut());
            add_map_light(task, sky, &step, open, normal, lobes, sums);
        }
        let joins = technique == Technique::Hemisphere;
        if let Some(gloss) = self.gloss.as_mut().filter(|gloss| joins && gloss.joins()) {
            let view = self.frames.views_of(task.view, &self.packet.origin);
            let share = &self.lobe_share;
            gloss.add(&step, active & !blocked, [normal, &view], share);
        }
    }
}
