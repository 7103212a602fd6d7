//! Sixteen sample streams walked in step: each lane is one replicate of one texel, each step casts one packet.
//!
//! Texels that share directions stand side by side in a gang, so its packets hold parallel rays from neighbouring
//! places. All arithmetic runs over arrays of sixteen, in whatever vector width the machine has; no fused operation is used, so that
//! every machine gets the same bits.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use crate::cell::{Cell, place_in};
use crate::integrate::{Sums, Task, Term};
use crate::options::View;
use crate::texel::Texel;
use ambient::sampling::{LANES, Lobe, SkyMap, Stream, Streams, Wide};
use embree::{Coherence, RayPacket};
use glam::DVec3;
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// One lane: a texel of the tile and one of its replicates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lane {
    /// Index into the tile's texels.
    pub texel: usize,
    pub replicate: usize,
}

/// f64 numbers of all lanes.
type Deep = [f64; LANES];

/// The surfaces under the lanes, as structures of arrays: see [`Cell`] for what each is.
#[derive(Clone)]
struct Surfaces {
    position: [[Deep; 3]; 3],
    /// Geometric normal times offset.
    lift: [Deep; 3],
    normal: [[Wide; 3]; 3],
    geometric: [Wide; 3],
    /// Start, inverse share and fold.
    place: [Wide; 3],
    /// Lanes whose shading normal changes over their cell.
    smooth: u32,
}

/// Frames about the lanes' shading normals.
#[derive(Clone)]
struct Frames {
    normal: [Wide; 3],
    tangent: [Wide; 3],
    bitangent: [Wide; 3],
    /// The side of the geometric normal that the shading normal is on: 1 or -1.
    side: Wide,
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

/// How the directions of a step were drawn, as far as light of a map needs it.
enum Drawn {
    /// Probability per steradian is what the weights say.
    Hemisphere,
    /// Probability per steradian.
    Lobe(Wide),
    /// Texels of the map, and the axes of the lobes.
    Sky([u32; LANES], [Wide; 3]),
}

impl<'a> Gang<'a> {
    /// A gang without lanes.
    pub fn new(task: &Task<'_>, texels: &'a [Texel], reflects: &'a [bool]) -> Self {
        let mut gang = Self {
            texels,
            reflects,
            lanes: &[],
            streams: Streams::new(task.points),
            surfaces: Surfaces {
                position: [[[0.0; LANES]; 3]; 3],
                lift: [[0.0; LANES]; 3],
                normal: [[[0.0; LANES]; 3]; 3],
                geometric: [[0.0; LANES]; 3],
                place: [[0.0; LANES]; 3],
                smooth: 0,
            },
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

    /// Adds the light that open lanes see above the floor of a map, each by its share of the power heuristic.
    #[inline(always)]
    fn shine(&mut self, task: &Task<'_>, sky: &SkyMap, step: &Step, open: u32) {
        use std::f32::consts::{FRAC_1_PI, TAU};
        let [cosine, uniform] = {
            let share = task.mixture.cosine_share() as f32;
            [2.0 * share / TAU, (1.0 - share) / TAU]
        };
        let texels = match &step.drawn {
            Drawn::Sky(texels, _) => *texels,
            _ => sky.texels16(&step.directions),
        };
        let mut light = [[0.0; LANES]; 3];
        let mut rest = open;
        while rest != 0 {
            let l = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            for (axis, value) in light.iter_mut().zip(sky.excess(texels[l])) {
                axis[l] = value;
            }
        }
        let drawn = if task.draw_sky { 1.0 } else { 0.0 };
        let mut kernels = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let by_sky = drawn * (light[0][l] + light[1][l] + light[2][l]);
            kernels[0][l] = match &step.drawn {
                Drawn::Hemisphere => {
                    let own = 1.0 / (TAU * step.weights[1][l]);
                    step.weights[0][l] * share(own, by_sky)
                }
                Drawn::Lobe(density) => share(density[l], by_sky),
                Drawn::Sky(..) => {
                    let normal = &self.frames.normal;
                    let mu = normal[0][l] * step.directions[0][l]
                        + normal[1][l] * step.directions[1][l]
                        + normal[2][l] * step.directions[2][l];
                    mu * FRAC_1_PI * share_of(by_sky, cosine * mu + uniform)
                }
            };
        }
        if let Drawn::Sky(_, axes) = &step.drawn {
            let mut rest = open & self.lobes;
            while rest != 0 {
                let l = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let [axis, direction] = [axes, &step.directions].map(|of| of.map(|a| a[l]));
                let by_sky = light[0][l] + light[1][l] + light[2][l];
                let density = lobe_density(self.lobe_scale[l], axis, direction);
                kernels[1][l] = density * share_of(by_sky, density);
            }
        }
        for k in 0..2 {
            for c in 0..3 {
                for l in 0..LANES {
                    self.block.light[k][c][l] += light[c][l] * kernels[k][l];
                }
            }
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

impl Surfaces {
    fn set(&mut self, lane: usize, cell: &Cell) {
        self.set_position(lane, cell);
        self.set_normal(lane, cell);
        for (row, value) in self.place.iter_mut().zip(cell.placement()) {
            row[lane] = value;
        }
    }

    #[inline(always)]
    fn set_position(&mut self, lane: usize, cell: &Cell) {
        for axis in 0..3 {
            for k in 0..3 {
                self.position[k][axis][lane] = cell.position[k][axis];
            }
            self.lift[axis][lane] = cell.lift[axis];
        }
    }

    #[inline(always)]
    fn set_normal(&mut self, lane: usize, cell: &Cell) {
        for axis in 0..3 {
            for k in 0..3 {
                self.normal[k][axis][lane] = cell.normal[k][axis] as f32;
            }
            self.geometric[axis][lane] = cell.geometric[axis] as f32;
        }
        self.smooth = self.smooth & !(1 << lane) | u32::from(cell.is_smooth()) << lane;
    }

    /// (s, t) in the cells of points of the unit square.
    #[inline(always)]
    fn places(&self, v0: &Wide, v1: &Wide) -> [Wide; 2] {
        let mut at = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let place = [self.place[0][l], self.place[1][l], self.place[2][l]];
            [at[0][l], at[1][l]] = place_in(place, [v0[l], v1[l]]);
        }
        at
    }

    /// Unit shading normals, and the side of the geometric normals that they are on: 1 or -1.
    #[inline(always)]
    fn normals(&self, [s, t]: &[Wide; 2]) -> ([Wide; 3], Wide) {
        let mut unit = [[0.0; LANES]; 3];
        let mut side = [0.0; LANES];
        let ([n0, ns, nt], g) = (&self.normal, &self.geometric);
        for l in 0..LANES {
            let n = [0, 1, 2].map(|a: usize| n0[a][l] + ns[a][l] * s[l] + nt[a][l] * t[l]);
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            // Corner normals that cancel: the geometric normal stands in.
            let has_length = square > 1e-20;
            let scale = 1.0 / (if has_length { square } else { 1.0 }).sqrt();
            let n = [0, 1, 2].map(|a: usize| if has_length { n[a] * scale } else { g[a][l] });
            let cos = n[0] * g[0][l] + n[1] * g[1][l] + n[2] * g[2][l];
            side[l] = if cos < 0.0 { -1.0 } else { 1.0 };
            for a in 0..3 {
                unit[a][l] = n[a];
            }
        }
        (unit, side)
    }

    /// Ray origins: positions in f64, lifted off the surface, rounded once.
    #[inline(always)]
    fn origins(&self, [s, t]: &[Wide; 2], side: &Wide, out: &mut [Wide; 3]) {
        for a in 0..3 {
            let [p0, ps, pt] = &self.position;
            for l in 0..LANES {
                let (s, t) = (f64::from(s[l]), f64::from(t[l]));
                let p = p0[a][l] + ps[a][l] * s + pt[a][l] * t;
                out[a][l] = (p + self.lift[a][l] * f64::from(side[l])) as f32;
            }
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

impl Frames {
    /// Frames about unit axes. T. Duff and others, "Building an Orthonormal Basis, Revisited", JCGT 2017.
    #[inline(always)]
    fn about(axis: [Wide; 3], side: Wide) -> Self {
        let (mut tangent, mut bitangent) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for l in 0..LANES {
            let [x, y, z] = [axis[0][l], axis[1][l], axis[2][l]];
            let sign = 1.0_f32.copysign(z);
            let a = -1.0 / (sign + z);
            let b = x * y * a;
            tangent[0][l] = 1.0 + sign * x * x * a;
            tangent[1][l] = sign * b;
            tangent[2][l] = -sign * x;
            bitangent[0][l] = b;
            bitangent[1][l] = sign + y * y * a;
            bitangent[2][l] = -y;
        }
        Self {
            normal: axis,
            tangent,
            bitangent,
            side,
        }
    }

    /// Local directions in the world.
    #[inline(always)]
    fn to_world(&self, local: &[Wide; 3]) -> [Wide; 3] {
        let mut out = [[0.0; LANES]; 3];
        for a in 0..3 {
            for l in 0..LANES {
                out[a][l] = self.tangent[a][l] * local[0][l]
                    + self.bitangent[a][l] * local[1][l]
                    + self.normal[a][l] * local[2][l];
            }
        }
        out
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The share of a technique of density `own` beside another in the power heuristic with exponent 2.
#[inline(always)]
fn share(own: f32, other: f32) -> f32 {
    own * share_of(own, other)
}

/// That share divided by `own`.
#[inline(always)]
fn share_of(own: f32, other: f32) -> f32 {
    own / (own * own + other * other).max(f32::MIN_POSITIVE)
}

/// (n + 1)/2pi (R.L)^n with `scale` = 1 / (n + 1); 0 behind the plane of the lobe. 1 - R.L is taken from the chord, which keeps the digits of
/// narrow lobes.
#[inline(always)]
fn lobe_density(scale: f32, axis: [f32; 3], direction: [f32; 3]) -> f32 {
    let chord = [0, 1, 2].map(|a: usize| axis[a] - direction[a]);
    let drop = 0.5 * f64::from(dot(chord, chord));
    let exponent = 1.0 / f64::from(scale) - 1.0;
    let decay = exponent * drop;
    if drop >= 1.0 || decay > 80.0 {
        return 0.0;
    }
    ((exponent * (-drop).ln_1p()).exp() / (std::f64::consts::TAU * f64::from(scale))) as f32
}

/// R = 2 (N.V) N - V for an eye point: the axes of the specular lobes. V = N where the eye stands on the surface.
#[inline(always)]
fn mirrored(normal: &[Wide; 3], origin: &[Wide; 3], eye: DVec3) -> [Wide; 3] {
    let mut out = [[0.0; LANES]; 3];
    for l in 0..LANES {
        let v = [0, 1, 2].map(|a: usize| (eye[a] - f64::from(origin[a][l])) as f32);
        let n = [normal[0][l], normal[1][l], normal[2][l]];
        let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
        let has_length = largest > 0.0;
        let v = v.map(|c| c / if has_length { largest } else { 1.0 });
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let scale = 1.0 / (if has_length { square } else { 1.0 }).sqrt();
        let v = v.map(|c| c * scale);
        let twice = 2.0 * (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]);
        for a in 0..3 {
            out[a][l] = if has_length {
                twice * n[a] - v[a]
            } else {
                n[a]
            };
        }
    }
    out
}
