//! The light that surfaces send: looked up in a finished bake, or followed on from surface to surface.
//!
//! Surfaces reflect as Lambert's do, as they do in a bake. What is followed on is unbiased: paths end by chance (J.
//! Arvo, D. Kirk, "Particle Transport and Image Synthesis", 1990), and lamps and bright places of the sky are aimed at
//! too.

use crate::gather::Gather;
use crate::sky::Sky;
use ambient::Frame;
use ambient::convention::PROJECTED_HEMISPHERE;
use ambient::sampling::Mixture;
use glam::DVec3;
use rays::{Arrival, Ray, SurfaceHit, SurfacePoint};

/// Surfaces after which paths may end by chance.
const SURE: u32 = 3;

/// Probability at most with which a path goes on then.
const MOST_ON: f64 = 0.95;

impl Gather<'_> {
    /// Radiance that the surface at a hit reflects back along the ray of the unit direction `direction`.
    ///
    /// * `random`: four numbers in 0..1 by label, independent of each other and of the ray: points of one sequence are
    ///   not, however they are scrambled, and surfaces would be chosen by the direction of the first ray.
    pub(crate) fn reflected(
        &self,
        hit: SurfaceHit,
        direction: DVec3,
        random: impl Fn(u32) -> [f64; 4],
    ) -> DVec3 {
        let (mut hit, mut direction) = (hit, direction);
        let (mut sum, mut carried) = (DVec3::ZERO, DVec3::ONE);
        for bounce in 0..self.bounces {
            if let Some(baked) = self.baked {
                if self.is_back(&hit, direction) {
                    return sum;
                }
                // Texels lie on the front; what the other side of a thin surface sends they do not tell.
                let is_front = self.surfaces.shows_front(&hit, -direction);
                if let Some(sent) = baked(&hit).filter(|_| is_front) {
                    return sum + carried * sent;
                }
            }
            let point = self.surfaces.at(&hit, -direction);
            carried *= point.material.albedo;
            let [u0, u1, u2, u3] = random(2 * bounce);
            if bounce >= SURE {
                let on = carried.max_element().min(MOST_ON);
                if random(2 * bounce + 1)[0] >= on {
                    return sum;
                }
                carried /= on;
            }
            if carried == DVec3::ZERO {
                return sum;
            }
            sum += carried * self.aimed(&point, [u2, u3]);
            let frame = Frame::from_normal(point.normal);
            direction = frame.to_world(Mixture::COSINE.sample([u0, u1]));
            if point.geometric.dot(direction) <= 0.0 {
                return sum;
            }
            let density = cosine(&point, direction);
            let (next, tint) = self.met(point.origin, direction);
            carried *= tint;
            let Some(next) = next else {
                return sum + carried * self.sky.shared(direction, density);
            };
            sum += carried * self.emitted(&next, direction, density);
            hit = next;
        }
        sum
    }

    /// True where a ray meets the side of a surface that is not there: its back, where both sides are not drawn.
    pub(crate) fn is_back(&self, hit: &SurfaceHit, direction: DVec3) -> bool {
        let world = self.surfaces.world();
        !world.is_double_sided(hit.instance) && !self.surfaces.shows_front(hit, -direction)
    }

    /// Radiance over pi that arrives on a surface from lights, and from lamps and places of the sky that are aimed at.
    fn aimed(&self, point: &SurfacePoint, u: [f64; 2]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for light in self.lights {
            let arrival = light.at(point.position, u);
            if point.geometric.dot(arrival.toward) > 0.0 {
                sum += self.arriving(point.origin, &arrival) * cosine(point, arrival.toward);
            }
        }
        if let Some(map) = self.sky.drawn() {
            let (toward, radiance) = Sky::draw(map, u, |toward| cosine(point, toward));
            let weight = cosine(point, toward);
            let faces = weight > 0.0 && point.geometric.dot(toward) > 0.0;
            if faces {
                sum += radiance * weight * self.passed(&self.ray(point.origin, toward));
            }
        }
        if !self.lamps.is_empty() {
            let from = point.position;
            let aim = self.at_lamp(from, point.origin, u, |toward| {
                cosine(point, toward) * f64::from(u8::from(point.geometric.dot(toward) > 0.0))
            });
            sum += aim.map_or(DVec3::ZERO, |(toward, radiance)| {
                radiance * cosine(point, toward)
            });
        }
        sum
    }

    /// A point of a lamp that is seen from a place: the direction to it, and its radiance over the densities of both
    /// ways to it.
    ///
    /// * `density`: of the other way, per steradian; nothing is seen where it is 0.
    pub(crate) fn at_lamp(
        &self,
        from: DVec3,
        origin: [f32; 3],
        u: [f64; 2],
        density: impl Fn(DVec3) -> f64,
    ) -> Option<(DVec3, DVec3)> {
        let world = self.surfaces.world();
        let (place, target) = self.lamps.sample(world, u);
        let toward = (target - from).normalize_or_zero();
        let other = density(toward);
        if other == 0.0 || toward == DVec3::ZERO {
            return None;
        }
        let (hit, tint) = self.met(origin, toward);
        let hit = hit?;
        if (hit.instance, hit.triangle) != place {
            return None;
        }
        let aimed = self.lamps.pdf(world, &hit, toward);
        let emission = self.surfaces.emission(&hit) * tint;
        Some((toward, emission / (other + aimed)))
    }

    /// Radiance that a surface sends out by itself along a ray of this density, beside as many that are aimed at lamps.
    pub(crate) fn emitted(&self, hit: &SurfaceHit, direction: DVec3, density: f64) -> DVec3 {
        let emission = match self.lamps.is_empty() {
            true => DVec3::ZERO,
            false => self.surfaces.emission(hit),
        };
        if emission == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let aimed = self.lamps.pdf(self.surfaces.world(), hit, direction);
        emission * (density / (density + aimed))
    }

    /// What of a light passes all that stands before it, 0 for one that does not light.
    pub(crate) fn arriving(&self, origin: [f32; 3], arrival: &Arrival) -> DVec3 {
        let ray = Ray {
            t_max: (arrival.distance as f32).min(self.max_distance),
            ..self.ray(origin, arrival.toward)
        };
        match arrival.irradiance == DVec3::ZERO {
            true => DVec3::ZERO,
            false => arrival.irradiance * self.passed(&ray),
        }
    }

    /// The share of the light of each channel that passes along a ray.
    pub(crate) fn passed(&self, ray: &Ray) -> DVec3 {
        self.surfaces.world().passed(self.backend, ray)
    }

    /// The first surface on a ray, and what panes before it leave of the channels for their mean.
    pub(crate) fn met(&self, origin: [f32; 3], direction: DVec3) -> (Option<SurfaceHit>, DVec3) {
        let ray = self.ray(origin, direction);
        let hit = self.backend.closest(&ray);
        let end = hit.map_or(ray.t_max, |hit| hit.t);
        (hit, self.surfaces.world().tint(self.backend, &ray, end))
    }

    /// A ray that ends where surfaces do not count any more.
    pub(crate) fn ray(&self, origin: [f32; 3], direction: DVec3) -> Ray {
        Ray {
            origin,
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: self.max_distance,
        }
    }
}

/// Density of cosine-weighted directions from a surface, per steradian; it is also what radiance counts for E / π.
fn cosine(point: &SurfacePoint, toward: DVec3) -> f64 {
    point.normal.dot(toward).max(0.0) / PROJECTED_HEMISPHERE
}
