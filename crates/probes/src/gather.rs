//! One probe: what arrives at a place.

use crate::Sky;
use crate::estimate::{PARTS, REPLICATES, Replicate, add, coefficients};
use crate::sky::EVEN;
use ambient::harmonics::{self, MOST, basis, matt_rms};
use ambient::sampling::Stream;
use environment::Projection;
use glam::DVec3;
use rays::{Lamps, Light, RayBackend, SurfaceHit, Surfaces};
use std::f64::consts::TAU;

/// The radiance that a surface reflects at a hit, from a finished bake; `None` where it has no texels.
pub type BakedLight<'a> = dyn Fn(&SurfaceHit) -> Option<DVec3> + Sync + 'a;

/// What light is gathered of, and how.
pub struct Gather<'a> {
    /// What rays meet.
    pub surfaces: &'a Surfaces<'a>,
    /// Who casts them.
    pub backend: &'a dyn RayBackend,
    /// The light of rays that meet nothing.
    pub sky: Sky<'a>,
    /// The surfaces that shine by themselves.
    pub lamps: &'a Lamps,
    /// Lights that no ray meets. Their light is in the probe too, and surfaces without baked light reflect it.
    pub lights: &'a [Light],
    /// The light that surfaces reflect; where there is none it is followed on from them.
    pub baked: Option<&'a BakedLight<'a>>,
    /// How often light is reflected before it arrives, at most; 0 leaves out what surfaces reflect, baked or not.
    pub bounces: u32,
    /// Surfaces farther than this do not count; infinite for none.
    pub max_distance: f32,
    /// Rays of a probe in even directions, at least [`LEAST_RAYS`]; as many are aimed at lamps and at what stands out
    /// of the sky, where there are some, and at each light with extent. With a target, the most that a probe takes.
    pub rays: u32,
    /// Standard error of the light E / π at which a probe has rays enough, root mean square over normals and channels;
    /// `None` for [`Self::rays`] everywhere.
    pub target: Option<f64>,
    /// Order of the harmonics, 0..=3.
    pub order: usize,
    /// Distances of surfaces are cut here, in scene units.
    pub reach: f64,
    /// Seed of the sample points.
    pub seed: u64,
}

/// Fewest rays of a probe.
pub const LEAST_RAYS: u32 = 64;

/// Rays that tell how many a target takes. They are no part of the result: what is kept has points of its own, so that
/// nothing is biased by where it stops.
const PILOT: u32 = 256;

/// Rays are asked for beyond what the pilot says, because its error is itself an estimate.
const MARGIN: f64 = 1.3;

/// Texels of a side of the octahedron on which distances lie.
pub const DISTANCE_EDGE: usize = 8;

/// A part of the light of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Of the sky.
    Sky,
    /// Of lights that no ray meets.
    Lights,
    /// Of surfaces, which shine or reflect.
    Surfaces,
}

/// Light that arrives at a place, in coordinates of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Where.
    pub place: DVec3,
    /// Coefficients of the radiance by [`basis`], linear RGB; so many as the order has.
    pub light: Vec<DVec3>,
    /// One standard error of each.
    pub std_err: Vec<DVec3>,
    /// Even rays that it took.
    pub rays: u32,
    /// The light of each [`Part`], which add up to all of it.
    pub parts: [Vec<DVec3>; PARTS],
    /// Share of the directions that meet no back of a surface, 0..=1; 0 in a solid.
    pub validity: f64,
    /// Mean distance of surfaces and the mean of its square, by direction: an octahedron of [`DISTANCE_EDGE`] texels a
    /// side as [`Projection::Octahedral`] lays it out, row by row. What is farther than the reach, or open, counts as
    /// the reach.
    pub distance: Vec<[f32; 2]>,
    /// The nearest surface, in a solid, else the nearest that a ray met from its back: where, and the unit normal on
    /// the far side.
    pub(crate) way_out: Option<(DVec3, DVec3)>,
}

impl Probe {
    /// Standard error of the light E / π: root mean square over normals and channels.
    pub fn error(&self) -> f64 {
        let rms = matt_rms(&self.std_err);
        (rms.dot(rms) / 3.0).sqrt()
    }
}

/// The label of probes among the pages of a bake.
pub(crate) const PAGE: u32 = 0x7072_6f62;

/// Stream labels; those of paths follow.
const EVENLY: u32 = 1;
const SKY: u32 = 2;
const LAMPS: u32 = 3;
const LIGHTS: u32 = 4;
const PATHS: u32 = 16;

impl Gather<'_> {
    /// The light at a place of the world. `number` labels its sample points.
    ///
    /// # Panics
    /// With fewer rays than [`LEAST_RAYS`], or an order above 3.
    pub fn probe(&self, number: u32, place: DVec3) -> Probe {
        assert!(self.rays >= LEAST_RAYS, "{} rays", self.rays);
        let Some(target) = self.target else {
            return self.by_rays(number, place, self.rays, 0);
        };
        let mut found = self.by_rays(number, place, PILOT.min(self.rays), 1);
        for round in 2.. {
            // Where the target was missed the last rays said too little: at least half as many more are taken.
            let least = match round {
                2 => LEAST_RAYS,
                _ => found.rays.saturating_add(found.rays / 2).min(self.rays),
            };
            let needed = MARGIN * f64::from(found.rays) * (found.error() / target).powi(2);
            let rays = (needed.ceil() as u32).clamp(least, self.rays);
            found = self.by_rays(number, place, rays, round);
            if found.error() <= target || rays == self.rays {
                break;
            }
        }
        found
    }

    /// The light by so many rays. Rounds share no points.
    fn by_rays(&self, number: u32, place: DVec3, count: u32, round: u32) -> Probe {
        let terms = harmonics::count(self.order);
        assert!(terms <= MOST, "order {}", self.order);
        let origin = place.as_vec3().to_array();
        let rays = count.div_ceil(REPLICATES as u32);
        let mut seen = Seen::new(self.reach);
        let replicate = |replicate: usize| {
            let stream = |term: u32, of: u32| {
                let label = replicate as u32 + REPLICATES as u32 * of;
                Stream::new(self.seed, PAGE - round, number, term, label)
            };
            self.replicate(place, origin, rays, terms, &mut seen, stream)
        };
        let replicates: Vec<Replicate> = (0..REPLICATES).map(replicate).collect();
        let (mut parts, std_err) = coefficients(&replicates, terms);
        for light in self.lights.iter().filter(|light| !light.has_extent()) {
            let arrival = light.at(place, [0.5; 2]);
            let light = self.arriving(origin, &arrival);
            if light != DVec3::ZERO {
                let lights = &mut parts[Part::Lights as usize];
                add(lights, &basis(arrival.toward)[..terms], light);
            }
        }
        let whole = |k: usize| parts.iter().map(|part| part[k]).sum();
        let solids = self.surfaces.world().solids();
        let near = solids.about(place, place);
        let is_inside = solids.outweigh(&near, |body| solids.depth(body, place, None));
        // Where neither the sky nor any light is seen, surfaces that are drawn from both sides tell the inside of a
        // body from a dark room too: files of many kinds know no others.
        let lit = &parts[Part::Lights as usize];
        let is_shut = !seen.light && lit.iter().all(|value| *value == DVec3::ZERO);
        let kind = if is_shut { Met::Behind } else { Met::Back } as usize;
        let met_backs = f64::from(seen.met[kind]) / f64::from(rays * REPLICATES as u32);
        Probe {
            place,
            light: (0..terms).map(whole).collect(),
            std_err: std_err[..terms].to_vec(),
            rays: rays * REPLICATES as u32,
            parts: parts.map(|part| part[..terms].to_vec()),
            validity: if is_inside { 0.0 } else { 1.0 - met_backs },
            distance: seen.distances(),
            way_out: seen.nearest[if is_inside { Met::Any as usize } else { kind }].map(
                |(hit, direction)| {
                    let far = self.surfaces.at(&hit, direction);
                    (far.position, far.geometric)
                },
            ),
        }
    }

    /// What the rays of one replicate bring.
    fn replicate(
        &self,
        place: DVec3,
        origin: [f32; 3],
        rays: u32,
        terms: usize,
        seen: &mut Seen,
        stream: impl Fn(u32, u32) -> Stream,
    ) -> Replicate {
        let mut found = Replicate::new();
        let share = 1.0 / f64::from(rays);
        let evenly = stream(EVENLY, 0);
        for ray in 0..rays {
            let [u0, u1, ..] = evenly.point(ray);
            let direction = even(u0, u1);
            let basis = &basis(direction)[..terms];
            found.direction(basis);
            let (hit, tint) = self.met(origin, direction);
            match hit {
                None => {
                    seen.light = true;
                    seen.meet(direction, None);
                    let radiance = tint * self.sky.shared(direction, EVEN);
                    found.light(Part::Sky as usize, basis, radiance);
                }
                Some(hit) => {
                    let is_behind = !self.surfaces.shows_front(&hit, -direction);
                    let is_back = is_behind && self.is_back(&hit, direction);
                    seen.meet(direction, Some(hit.t));
                    seen.surface(&hit, direction, [true, is_back, is_behind]);
                    let random = |term| stream(PATHS + term, ray).point(0);
                    let emitted = self.emitted(&hit, direction, EVEN);
                    seen.light |= emitted != DVec3::ZERO;
                    let radiance = tint * (emitted + self.reflected(hit, direction, random));
                    found.light(Part::Surfaces as usize, basis, radiance);
                }
            }
        }
        if let Some(map) = self.sky.drawn() {
            let stream = stream(SKY, 0);
            for ray in 0..rays {
                let [u0, u1, ..] = stream.point(ray);
                let (toward, radiance) = Sky::draw(map, [u0, u1], |_| EVEN);
                let passed = self.passed(&self.ray(origin, toward));
                if passed != DVec3::ZERO {
                    let basis = &basis(toward)[..terms];
                    found.aim(Part::Sky as usize, basis, radiance * passed * share);
                }
            }
        }
        if !self.lamps.is_empty() {
            let stream = stream(LAMPS, 0);
            for ray in 0..rays {
                let [u0, u1, ..] = stream.point(ray);
                if let Some((toward, radiance)) = self.at_lamp(place, origin, [u0, u1], |_| EVEN) {
                    let basis = &basis(toward)[..terms];
                    found.aim(Part::Surfaces as usize, basis, radiance * share);
                }
            }
        }
        let with_extent = self.lights.iter().filter(|light| light.has_extent());
        for (light, label) in with_extent.zip(0..) {
            // Lights past the first share no points with each other: each takes another part of the sequence.
            let stream = stream(LIGHTS, 0);
            for ray in 0..rays {
                let [u0, u1, ..] = stream.point(label * rays + ray);
                let arrival = light.at(place, [u0, u1]);
                let light = self.arriving(origin, &arrival);
                if light != DVec3::ZERO {
                    let basis = &basis(arrival.toward)[..terms];
                    found.aim(Part::Lights as usize, basis, light * share);
                }
            }
        }
        found
    }
}

/// A unit direction, even over the sphere, for a point of the unit square.
pub(crate) fn even(u0: f64, u1: f64) -> DVec3 {
    let z = 1.0 - 2.0 * u0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (y, x) = (TAU * u1).sin_cos();
    DVec3::new(r * x, r * y, z)
}

/// What the even rays of a probe met, but for light.
struct Seen {
    reach: f64,
    /// The directions of the octahedron's texels.
    texels: Vec<[f32; 3]>,
    /// Weight, distance and its square by texel, summed.
    sums: Vec<[f32; 3]>,
    /// True where a ray left the scene or met what shines.
    light: bool,
    /// Rays by [`Met`].
    met: [u32; 3],
    /// The nearest surface by [`Met`], with the direction of the ray.
    nearest: [Option<(SurfaceHit, DVec3)>; 3],
}

/// What a ray met: a surface, its back, or what would be its back if it were not drawn from both sides.
#[derive(Clone, Copy)]
enum Met {
    Any,
    Back,
    Behind,
}

impl Seen {
    fn new(reach: f64) -> Self {
        let size = (DISTANCE_EDGE, DISTANCE_EDGE);
        let direction = |texel: usize| {
            let (x, y) = (texel % DISTANCE_EDGE, texel / DISTANCE_EDGE);
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            let direction = Projection::Octahedral.direction(size, x, y);
            direction.unwrap_or_default().map(|v| v as f32)
        };
        Self {
            reach,
            texels: (0..DISTANCE_EDGE * DISTANCE_EDGE).map(direction).collect(),
            sums: vec![[0.0; 3]; DISTANCE_EDGE * DISTANCE_EDGE],
            light: false,
            met: [0; 3],
            nearest: [None; 3],
        }
    }

    /// Takes in the distance that a ray went. A texel weighs rays by the 64th power of their cosine: a lobe about as
    /// wide as itself.
    fn meet(&mut self, direction: DVec3, distance: Option<f32>) {
        let reach = self.reach as f32;
        let distance = distance.map_or(reach, |distance| distance.min(reach));
        let [x, y, z] = direction.as_vec3().to_array();
        for (sums, texel) in self.sums.iter_mut().zip(&self.texels) {
            let mut weight = (x * texel[0] + y * texel[1] + z * texel[2]).max(0.0);
            for _ in 0..6 {
                weight *= weight;
            }
            sums[0] += weight;
            sums[1] += weight * distance;
            sums[2] += weight * distance * distance;
        }
    }

    /// Takes in a surface that is of these kinds of [`Met`].
    fn surface(&mut self, hit: &SurfaceHit, direction: DVec3, kinds: [bool; 3]) {
        for kind in (0..3).filter(|&kind| kinds[kind]) {
            self.met[kind] += 1;
            let nearest = &mut self.nearest[kind];
            if nearest.is_none_or(|(old, _)| hit.t < old.t) {
                *nearest = Some((*hit, direction));
            }
        }
    }

    fn distances(&self) -> Vec<[f32; 2]> {
        let mean = |[weight, first, second]: &[f32; 3]| match *weight > 0.0 {
            true => [first / weight, second / weight],
            false => [self.reach as f32, (self.reach * self.reach) as f32],
        };
        self.sums.iter().map(mean).collect()
    }
}
