//! Sixteen sample streams walked in step: each lane is one replicate of one texel, each step casts one packet.
//!
//! Texels that share directions stand side by side in a gang, so its packets hold parallel rays from neighbouring
//! places. All arithmetic runs over arrays of sixteen, in whatever vector width the machine has; no fused operation is used, so that
//! every machine gets the same bits.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

mod light;
mod surfaces;

use super::{Sums, Task, Term};
use crate::options::View;
use crate::survey::Texel;
use ambient::sampling::{LANES, Lobe, Stream, Streams, Wide};
use glam::DVec3;
use light::Drawn;
use pulp::{Simd, WithSimd};
use rays::{Coherence, RayPacket};
use std::ops::Range;
use surfaces::{Frames, Surfaces, mirrored};

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
    /// Texels that need the lobe.
    reflects: &'a [bool],
    lanes: &'a [Lane],
    streams: Streams,
    surfaces: Surfaces,
    /// Frames at the last point, and whether they no longer hold.
    frames: Frames,
    stale: bool,
    /// Cell under each lane.
    cell: [usize; LANES],
    /// Lanes whose cell must be looked up at each point: their texels have several.
    walkers: u32,
    /// Lanes in use, and those among them that nothing stands above.
    used: u32,
    open: u32,
    /// 1 / (n + 1) of each lane's lobe, and the lanes that need it.
    lobe_scale: Wide,
    lobes: u32,
    packet: RayPacket<LANES>,
    /// Points cast of every lane.
    points: u64,
    sums: LaneSums<f64>,
    /// Sums over the block in work: short, so f32 holds them.
    block: LaneSums<f32>,
}

/// Sums over a lane's rays: weights of all rays and of the open ones, for two terms; bent normal; rays cast.
#[derive(Clone, Copy, Default)]
struct LaneSums<T> {
    all: [[T; LANES]; 2],
    open: [[T; LANES]; 2],
    bent: [[T; LANES]; 3],
    /// Light of a map above its floor, for two terms.
    light: [[[T; LANES]; 3]; 2],
    rays: [u32; LANES],
}

/// What one step sends out.
struct Step {
    directions: [Wide; 3],
    /// Weights of each ray in the two sums.
    weights: [Wide; 2],
    /// Lanes whose ray leaves the surface upward.
    above: u32,
    drawn: Drawn,
}

impl<'a> Gang<'a> {
    /// A gang without lanes.
    pub fn new(task: &Task<'_>, texels: &'a [Texel], reflects: &'a [bool]) -> Self {
        let mut gang = Self {
            texels,
            reflects,
            lanes: &[],
            streams: Streams::new(task.points),
            surfaces: Surfaces::none(),
            frames: Frames::about([[0.0; LANES], [0.0; LANES], [1.0; LANES]], [1.0; LANES]),
            stale: true,
            cell: [0; LANES],
            walkers: 0,
            used: 0,
            open: 0,
            lobe_scale: [1.0; LANES],
            lobes: 0,
            packet: RayPacket::default(),
            points: 0,
            sums: LaneSums::default(),
            block: LaneSums::default(),
        };
        gang.packet.t_max = [task.t_max; LANES];
        gang
    }

    /// Takes at most sixteen lanes, each at the start of its stream, and forgets those before.
    pub fn load(&mut self, lanes: &'a [Lane], stream: impl Fn(&Texel, u32) -> Stream) {
        assert!(lanes.len() <= LANES, "{} lanes in a gang", lanes.len());
        self.lanes = lanes;
        self.cell = [0; LANES];
        (self.walkers, self.used, self.open, self.lobes) = (0, 0, 0, 0);
        self.points = 0;
        self.sums = LaneSums::default();
        self.stale = true;
        for (l, lane) in lanes.iter().enumerate() {
            let texel = &self.texels[lane.texel];
            self.streams.set(l, &stream(texel, lane.replicate as u32));
            self.used |= 1 << l;
            self.open |= u32::from(texel.open) << l;
            self.walkers |= u32::from(texel.cells.len() > 1) << l;
            self.lobes |= u32::from(self.reflects[lane.texel]) << l;
            self.lobe_scale[l] = (1.0 / (texel.material.exponent + 1.0)) as f32;
            self.surfaces.set(l, &texel.cells[0]);
        }
    }

    /// Casts the points `range` of every lane.
    pub fn cast(&mut self, task: &Task<'_>, term: Term, range: Range<u32>) {
        struct Run<'g, 'a, 't>(&'g mut Gang<'a>, &'g Task<'t>, Term, Range<u32>);
        impl WithSimd for Run<'_, '_, '_> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) {
                self.0.run(self.1, self.2, self.3);
            }
        }
        task.arch.dispatch(Run(self, task, term, range));
    }

    #[inline(always)]
    fn run(&mut self, task: &Task<'_>, term: Term, range: Range<u32>) {
        self.points += u64::from(range.end.saturating_sub(range.start));
        for block in Streams::blocks(range) {
            self.streams.enter(block);
            for step in 0..block.steps() {
                self.shoot(task, term, step);
            }
            self.sums.absorb(&self.block);
            self.block = LaneSums::default();
        }
    }

    /// Casts one point of every lane.
    #[inline(always)]
    fn shoot(&mut self, task: &Task<'_>, term: Term, step: u32) {
        let [u0, u1, v0, v1] = self.streams.point(step);
        let mut at = self.surfaces.places(&v0, &v1);
        let mut walkers = self.walkers;
        while walkers != 0 {
            let l = walkers.trailing_zeros() as usize;
            walkers &= walkers - 1;
            let texel = &self.texels[self.lanes[l].texel];
            let cell = texel.choose(v0[l]);
            [at[0][l], at[1][l]] = texel.cells[cell].place([v0[l], v1[l]]);
            if cell != self.cell[l] {
                self.walk(l, cell);
            }
        }
        let step = self.step(task, term, [&u0, &u1], &at);
        let active = step.above & self.used;
        let cast = active & !self.open;
        let blocked = if cast == 0 {
            0
        } else {
            task.backend
                .occluded16(&self.packet, cast, Coherence::Coherent)
        };
        self.block.add(&step, active & !blocked, cast, task.bent);
        if let Some(sky) = task.sky.map() {
            self.shine(task, sky, &step, active & !blocked);
        }
    }

    /// Moves a lane to another cell of its texel.
    #[inline(always)]
    fn walk(&mut self, lane: usize, to: usize) {
        let cells = &self.texels[self.lanes[lane].texel].cells;
        let (old, new) = (&cells[self.cell[lane]], &cells[to]);
        self.cell[lane] = to;
        self.surfaces.set_position(lane, new);
        if !new.shades_like(old) {
            self.surfaces.set_normal(lane, new);
            self.stale = true;
        }
    }

    /// Fills the packet with the rays of one point of every lane.
    #[inline(always)]
    fn step(&mut self, task: &Task<'_>, term: Term, [u0, u1]: [&Wide; 2], at: &[Wide; 2]) -> Step {
        if self.stale {
            let (normal, side) = self.surfaces.normals(at);
            self.frames = Frames::about(normal, side);
            self.stale = self.surfaces.smooth != 0;
        }
        let Frames { normal, side, .. } = &self.frames;
        self.surfaces.origins(at, side, &mut self.packet.origin);
        let axes = |origin: &[Wide; 3]| match task.view {
            View::Normal => *normal,
            View::Eye(eye) => mirrored(normal, origin, eye),
        };
        let (directions, weights, drawn) = match term {
            Term::Hemisphere => {
                let (local, weights) = task.mixture.sample16(u0, u1);
                (self.frames.to_world(&local), weights, Drawn::Hemisphere)
            }
            Term::Lobe => {
                let local = Lobe::sample16(&self.lobe_scale, u0, u1);
                let directions = match task.view {
                    View::Normal => self.frames.to_world(&local),
                    View::Eye(_) => {
                        Frames::about(axes(&self.packet.origin), *side).to_world(&local)
                    }
                };
                let mut density = [0.0; LANES];
                if task.sky.map().is_some() {
                    // u0 = cos^(n + 1), so cos^n = u0 / cos.
                    for l in 0..LANES {
                        let scale = self.lobe_scale[l] * std::f32::consts::TAU;
                        density[l] = u0[l] / (scale * local[2][l].max(f32::MIN_POSITIVE));
                    }
                }
                (directions, [[1.0; LANES]; 2], Drawn::Lobe(density))
            }
            Term::Sky => {
                let Some(sky) = task.sky.map() else {
                    unreachable!("a uniform sky has no directions to draw");
                };
                let (directions, texels) = sky.sample16(u0, u1);
                let drawn = Drawn::Sky(texels, axes(&self.packet.origin));
                (directions, [[0.0; LANES]; 2], drawn)
            }
        };
        let geometric = &self.surfaces.geometric;
        let mut above = 0;
        for l in 0..LANES {
            let dot = |a: &[Wide; 3]| {
                a[0][l] * directions[0][l] + a[1][l] * directions[1][l] + a[2][l] * directions[2][l]
            };
            above |= u32::from((dot(geometric) * side[l] > 0.0) & (dot(normal) > 0.0)) << l;
        }
        self.packet.direction = directions;
        Step {
            directions,
            weights,
            above,
            drawn,
        }
    }

    /// Adds what the lanes have gathered to their texels' replicates.
    pub fn collect(&self, sums: &mut [[Sums; crate::integrate::REPLICATES as usize]]) {
        for (l, lane) in self.lanes.iter().enumerate() {
            let s = &self.sums;
            let three = |of: &[[f64; LANES]; 3]| DVec3::new(of[0][l], of[1][l], of[2][l]);
            sums[lane.texel][lane.replicate] += Sums {
                first: (s.open[0][l], s.all[0][l]),
                second: (s.open[1][l], s.all[1][l]),
                bent: three(&s.bent),
                light: [three(&s.light[0]), three(&s.light[1])],
                points: self.points,
                rays: u64::from(s.rays[l]),
            };
        }
    }
}

impl LaneSums<f32> {
    #[inline(always)]
    fn add(&mut self, step: &Step, open: u32, cast: u32, bent: bool) {
        let mut is_open = [0.0; LANES];
        for l in 0..LANES {
            is_open[l] = (open >> l & 1) as f32;
            self.rays[l] += cast >> l & 1;
        }
        for k in 0..2 {
            for l in 0..LANES {
                let w = step.weights[k][l];
                self.all[k][l] += w;
                self.open[k][l] += w * is_open[l];
            }
        }
        if bent {
            for a in 0..3 {
                for l in 0..LANES {
                    self.bent[a][l] += step.weights[0][l] * is_open[l] * step.directions[a][l];
                }
            }
        }
    }
}

impl LaneSums<f64> {
    #[inline(always)]
    fn absorb(&mut self, block: &LaneSums<f32>) {
        for l in 0..LANES {
            for k in 0..2 {
                self.all[k][l] += f64::from(block.all[k][l]);
                self.open[k][l] += f64::from(block.open[k][l]);
            }
            for a in 0..3 {
                self.bent[a][l] += f64::from(block.bent[a][l]);
                for k in 0..2 {
                    self.light[k][a][l] += f64::from(block.light[k][a][l]);
                }
            }
            self.rays[l] += block.rays[l];
        }
    }
}
