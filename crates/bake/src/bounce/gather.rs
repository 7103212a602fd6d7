//! One gather of a texel: what its surface receives of the light that other surfaces send, or of that of lights.
//!
//! Rays follow the cosine for the irradiance and the lobe for the reflection, and go to the first surface. Half of the
//! rays of the cosine are aimed at bright surfaces instead, where there are some. In the first gather surfaces that
//! shine are aimed at too, by as many rays. All ways of meeting a surface are weighed by the balance heuristic (E.
//! Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995), so that neither a
//! small lamp nor a near one is noisy.

use super::REPLICATES;
use super::kernel::Kernel;
use super::radiosity::Radiosity;
use super::spots::{Aim, Reach, Spots};
use crate::integrate::{Coat, LobeRays};
use crate::options::{Model, Shading, View};
use crate::survey::{Sample, Texel};
use ambient::ggx::{Ggx, alpha_of};
use ambient::sampling::Stream;
use glam::DVec3;
use rays::{Lamps, Light, Ray, RayBackend, emission_at};

/// Rays of a replicate to each of many lights.
const SHADOW_RAYS: u32 = 4;

/// What a texel's replicates have received, linear RGB.
pub(super) type Received = [DVec3; REPLICATES as usize];

/// Everything that one gather reads.
pub(super) struct Gather<'a> {
    pub backend: &'a dyn RayBackend,
    pub radiosity: Radiosity<'a>,
    /// Surfaces that shine; `None` after the first gather.
    pub lamps: Option<&'a Lamps>,
    /// Lights without extent, in the world's coordinates. Where there are some, only their light is gathered.
    pub lights: &'a [Light],
    /// Bright surfaces.
    pub spots: &'a Spots,
    /// It is the last one: its light is shown.
    pub last: bool,
    /// Points of each replicate over the hemisphere.
    pub points: u32,
    pub shading: Shading,
    /// In the world's coordinates.
    pub view: View,
    pub model: Model,
    pub t_max: f32,
}

/// Which of a texel's two integrals.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Integral {
    Irradiance,
    Reflection,
}

/// Which of the points of a texel's replicate.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Points {
    Kernel,
    Lamps,
    Spots,
}

/// How a replicate of a texel meets surfaces.
struct Techniques<'a> {
    lamps: Option<&'a Lamps>,
    aim: &'a Aim,
    /// Rays of the kernel, those aimed at lamps, and those aimed at bright surfaces.
    rays: [f64; 3],
}

/// What the points of a texel see of a light.
#[derive(Clone, Default)]
struct Shadow {
    /// What all of it would bring, where that is known exactly.
    open: DVec3,
    /// The same by the directions that were drawn, and the part of them that nothing hides.
    drawn: DVec3,
    seen: DVec3,
}

impl Shadow {
    /// The seen share of what is exact: rays then tell no more than where shadows are, and their colours where they are
    /// `tinted`.
    fn light(&self, tinted: bool) -> DVec3 {
        match self.open == DVec3::ZERO || self.drawn == DVec3::ZERO {
            true => self.seen,
            false if tinted => {
                self.open * self.seen / self.drawn.max(DVec3::splat(f64::MIN_POSITIVE))
            }
            false => self.open * (self.seen.element_sum() / self.drawn.element_sum()),
        }
    }
}

impl Gather<'_> {
    /// What the texel receives by so many points of each replicate, and how many rays that took. `stream` gives a
    /// replicate's points. `reach` tells how well aimed rays of neighbours met what they were aimed at, and learns.
    pub fn receive(
        &self,
        texel: &Texel,
        integral: Integral,
        count: u32,
        stream: impl Fn(Points, u32) -> Stream,
        reach: &mut Reach,
    ) -> (Received, u64) {
        let mut rays = 0;
        let mirror = self.mirror(texel, integral);
        if !self.lights.is_empty() {
            let each = self.shadow_rays(count);
            let received = std::array::from_fn(|replicate| {
                let stream = stream(Points::Lamps, replicate as u32);
                let mut sums = vec![Shadow::default(); self.lights.len()];
                for point in 0..each {
                    let [u0, u1, v0, v1] = stream.point(point);
                    let (surface, origin) = texel.start([v0, v1]);
                    let kernel = self.kernel(texel, &surface, integral, mirror);
                    for (light, sum) in self.lights.iter().zip(&mut sums) {
                        if integral == Integral::Irradiance {
                            let open = light.open(surface.position, surface.normal);
                            sum.open += open.unwrap_or_default();
                        }
                        let drawn = self.arriving(light, [u0, u1], &kernel, &surface, origin);
                        if let Some((light, passed)) = drawn {
                            rays += 1;
                            sum.drawn += light;
                            sum.seen += light * passed;
                        }
                    }
                }
                let tinted = self.radiosity.world.has_tints();
                sums.iter().map(|sum| sum.light(tinted)).sum::<DVec3>() / f64::from(each)
            });
            return (received, rays);
        }
        // Over an open texel stands nothing that could send light.
        let points = if texel.open { 0 } else { count };
        let aim = match integral {
            Integral::Irradiance if !texel.open => {
                let size = texel.area.sqrt();
                self.spots.aim(texel.position, texel.normal, size, reach)
            }
            _ => Aim::default(),
        };
        let aimed = if aim.is_empty() { 0 } else { points / 2 };
        let lit = if self.lamps.is_some() { points } else { 0 };
        let counts = [points - aimed, lit, aimed];
        let how = Techniques {
            lamps: self.lamps,
            aim: &aim,
            rays: counts.map(f64::from),
        };
        let received = std::array::from_fn(|replicate| {
            let mut sum = DVec3::ZERO;
            for (points, count) in [Points::Kernel, Points::Lamps, Points::Spots]
                .into_iter()
                .zip(counts)
            {
                let stream = stream(points, replicate as u32);
                for point in 0..count {
                    let [u0, u1, v0, v1] = stream.point(point);
                    let (surface, origin) = texel.start([v0, v1]);
                    let kernel = self.kernel(texel, &surface, integral, mirror);
                    let light = match points {
                        Points::Kernel => surface
                            .leaving(self.shading, kernel.sample([u0, u1]))
                            .map(|ray| self.met(&how, &kernel, &surface, origin, ray).0),
                        Points::Lamps => self.lit(&how, &kernel, &surface, origin, [u0, u1]),
                        Points::Spots => {
                            let (spot, ray) = aim.sample([u0, u1]);
                            let counts = kernel.weight(&surface, self.shading, ray).x > 0.0;
                            counts.then(|| {
                                let (light, met) = self.met(&how, &kernel, &surface, origin, ray);
                                self.spots.count(reach, spot, met);
                                light
                            })
                        }
                    };
                    rays += u64::from(light.is_some());
                    sum += light.unwrap_or_default();
                }
            }
            sum
        });
        (received, rays)
    }

    /// What an open texel reflects, by which its lobe is divided.
    fn mirror(&self, texel: &Texel, integral: Integral) -> f64 {
        if (self.model, integral) != (Model::Ggx, Integral::Reflection) {
            return 1.0;
        }
        let view = self.view_from(texel.position, texel.normal);
        let ggx = Ggx::new(alpha_of(texel.material.exponent), texel.normal.dot(view));
        let open = ggx.open();
        open.tinted + open.white
    }

    fn kernel(&self, texel: &Texel, surface: &Sample, integral: Integral, mirror: f64) -> Kernel {
        let normal = surface.normal;
        match integral {
            Integral::Irradiance => Kernel::cosine(normal),
            Integral::Reflection => {
                let view = self.view_from(surface.position, normal);
                if self.model == Model::Ggx {
                    return Kernel::ggx(normal, view, texel.material.exponent, mirror);
                }
                let axis = 2.0 * normal.dot(view) * normal - view;
                Kernel::lobe(
                    axis.try_normalize().unwrap_or(normal),
                    texel.material.exponent,
                )
            }
        }
    }

    fn view_from(&self, position: DVec3, normal: DVec3) -> DVec3 {
        match self.view {
            View::Normal => normal,
            View::Eye(eye) => (eye - position).try_normalize().unwrap_or(normal),
        }
    }

    fn ray(&self, origin: [f32; 3], direction: DVec3) -> Ray {
        Ray {
            origin,
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: self.t_max,
        }
    }

    /// Light along a ray that was drawn from the kernel or aimed at a bright surface, and where it met a surface.
    fn met(
        &self,
        how: &Techniques<'_>,
        kernel: &Kernel,
        surface: &Sample,
        origin: [f32; 3],
        ray: DVec3,
    ) -> (DVec3, Option<DVec3>) {
        let cast = self.ray(origin, ray);
        let Some(hit) = self.backend.closest(&cast) else {
            return (DVec3::ZERO, None);
        };
        let met = DVec3::from(origin.map(f64::from)) + f64::from(hit.t) * ray;
        let own = kernel.weight(surface, self.shading, ray);
        if own.y <= 0.0 {
            return (DVec3::ZERO, Some(met));
        }
        let density = how.rays[0] * own.y + how.rays[2] * how.aim.pdf(ray);
        let world = self.radiosity.world;
        let mut light = self.radiosity.sent(&hit, ray) * (own.x / density);
        let by_lamps = how.lamps.map_or(0.0, |lamps| lamps.pdf(world, &hit, ray));
        if by_lamps > 0.0 {
            light += self.emission(&hit) * (own.x / (density + how.rays[1] * by_lamps));
        }
        (light * world.tint(self.backend, &cast, hit.t), Some(met))
    }

    /// Light along a ray that is aimed at a lamp; `None` where none needs to be cast.
    fn lit(
        &self,
        how: &Techniques<'_>,
        kernel: &Kernel,
        surface: &Sample,
        origin: [f32; 3],
        u: [f64; 2],
    ) -> Option<DVec3> {
        let (world, lamps) = (self.radiosity.world, how.lamps?);
        let (place, target) = lamps.sample(world, u);
        let start = DVec3::from(origin.map(f64::from));
        let ray = (target - start).try_normalize()?;
        let own = kernel.weight(surface, self.shading, ray);
        if own.x == 0.0 {
            return None;
        }
        let cast = self.ray(origin, ray);
        let hit = self.backend.closest(&cast);
        let light = hit.filter(|hit| (hit.instance, hit.triangle) == place);
        Some(light.map_or(DVec3::ZERO, |hit| {
            let density = how.rays[0] * own.y
                + how.rays[1] * lamps.pdf(world, &hit, ray)
                + how.rays[2] * how.aim.pdf(ray);
            let tint = world.tint(self.backend, &cast, hit.t);
            self.emission(&hit) * (own.x / density) * tint
        }))
    }

    /// Rays of a replicate to each light: all points together, but four to each where there are many.
    fn shadow_rays(&self, points: u32) -> u32 {
        let each = points / (self.lights.len().max(1) as u32);
        each.max(SHADOW_RAYS.min(points))
    }

    /// Rays over a texel's lobe for each ray over the hemisphere.
    pub fn lobe_share(&self, texel: &Texel, full: bool) -> f32 {
        let view = self.view_from(texel.position, texel.normal);
        let rays = match full {
            true => LobeRays::Full,
            false => LobeRays::Alone,
        };
        Coat::of(self.model, rays, &texel.material, texel.normal.dot(view)).share
    }

    /// What a light brings by a direction that `u` draws, and what of it passes all that stands before it, be it the
    /// facet itself; `None` where it brings none. Light from below a facet comes through the mirror image of its
    /// direction, as that of the sky does.
    fn arriving(
        &self,
        light: &Light,
        u: [f64; 2],
        kernel: &Kernel,
        surface: &Sample,
        origin: [f32; 3],
    ) -> Option<(DVec3, DVec3)> {
        let arrival = light.at(surface.position, u);
        let light = arrival.irradiance * kernel.toward(surface, arrival.toward);
        if light == DVec3::ZERO {
            return None;
        }
        let passed = |direction| {
            let ray = Ray {
                t_max: self.t_max.min(arrival.distance as f32),
                ..self.ray(origin, direction)
            };
            self.radiosity.world.passed(self.backend, &ray)
        };
        let direction = surface.leaving(self.shading, arrival.toward);
        Some((light, direction.map_or(DVec3::ZERO, passed)))
    }

    fn emission(&self, hit: &rays::SurfaceHit) -> DVec3 {
        emission_at(self.radiosity.world.scene(), hit)
    }
}
