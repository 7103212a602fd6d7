//! One gather of a texel: what its surface receives of the light that other surfaces send.
//!
//! Rays follow the cosine for the irradiance and the lobe for the reflection, and go to the first surface. In the first gather surfaces
//! that shine are aimed at too, by as many rays, and both ways of meeting them are weighed by the balance heuristic (E. Veach,
//! L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995), so that neither a small lamp nor a near one is noisy.

use super::REPLICATES;
use super::kernel::Kernel;
use super::radiosity::Radiosity;
use crate::options::{Model, Shading, View};
use crate::survey::{Sample, Texel};
use ambient::ggx::{Ggx, alpha_of};
use ambient::sampling::Stream;
use glam::DVec3;
use rays::{Lamps, Ray, RayBackend, emission_at};

/// What a texel's replicates have received, linear RGB.
pub(super) type Received = [DVec3; REPLICATES as usize];

/// Everything that one gather reads.
pub(super) struct Gather<'a> {
    pub backend: &'a dyn RayBackend,
    pub radiosity: Radiosity<'a>,
    /// Surfaces that shine; `None` after the first gather.
    pub lamps: Option<&'a Lamps>,
    /// Points of each replicate.
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

impl Gather<'_> {
    /// What the texel receives, and how many rays that took. `stream` gives a replicate's points: first those of the kernel, then those of lamps.
    pub fn receive(
        &self,
        texel: &Texel,
        integral: Integral,
        stream: impl Fn(bool, u32) -> Stream,
    ) -> (Received, u64) {
        let mut rays = 0;
        // What an open texel reflects, by which its lobe is divided.
        let mirror = match (self.model, integral) {
            (Model::Ggx, Integral::Reflection) => {
                let view = self.view_from(texel.position, texel.normal);
                let ggx = Ggx::new(alpha_of(texel.material.exponent), texel.normal.dot(view));
                let open = ggx.open();
                open.tinted + open.white
            }
            _ => 1.0,
        };
        let received = std::array::from_fn(|replicate| {
            let own = stream(false, replicate as u32);
            let aimed = stream(true, replicate as u32);
            let mut sum = DVec3::ZERO;
            for point in 0..self.points {
                let [u0, u1, v0, v1] = own.point(point);
                let (surface, origin) = texel.start([v0, v1]);
                let kernel = self.kernel(texel, &surface, integral, mirror);
                let direction = kernel.sample([u0, u1]);
                if let Some(ray) = surface.leaving(self.shading, direction) {
                    rays += 1;
                    sum += self.met(&kernel, &surface, origin, ray);
                }
                if let Some(lamps) = self.lamps {
                    let [u0, u1, v0, v1] = aimed.point(point);
                    let (surface, origin) = texel.start([v0, v1]);
                    let kernel = self.kernel(texel, &surface, integral, mirror);
                    if let Some(light) = self.aimed(lamps, &kernel, &surface, origin, [u0, u1]) {
                        rays += 1;
                        sum += light;
                    }
                }
            }
            sum / f64::from(self.points)
        });
        (received, rays)
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

    /// Light along a ray that was drawn from the kernel.
    fn met(&self, kernel: &Kernel, surface: &Sample, origin: [f32; 3], ray: DVec3) -> DVec3 {
        let Some(hit) = self.backend.closest(&self.ray(origin, ray)) else {
            return DVec3::ZERO;
        };
        let sent = self.radiosity.sent(&hit, ray);
        let world = self.radiosity.world;
        let by_lamps = self.lamps.map_or(0.0, |lamps| lamps.pdf(world, &hit, ray));
        let own = kernel.weight(surface, self.shading, ray);
        if own.y <= 0.0 {
            return DVec3::ZERO;
        }
        let sent = sent * (own.x / own.y);
        if by_lamps == 0.0 {
            return sent;
        }
        sent + self.emission(&hit) * (own.x / (own.y + by_lamps))
    }

    /// Light along a ray that is aimed at a lamp; `None` where none needs to be cast.
    fn aimed(
        &self,
        lamps: &Lamps,
        kernel: &Kernel,
        surface: &Sample,
        origin: [f32; 3],
        u: [f64; 2],
    ) -> Option<DVec3> {
        let world = self.radiosity.world;
        let (place, target) = lamps.sample(world, u);
        let start = DVec3::from(origin.map(f64::from));
        let ray = (target - start).try_normalize()?;
        let own = kernel.weight(surface, self.shading, ray);
        if own.x == 0.0 {
            return None;
        }
        let hit = self.backend.closest(&self.ray(origin, ray));
        let light = hit.filter(|hit| (hit.instance, hit.triangle) == place);
        Some(light.map_or(DVec3::ZERO, |hit| {
            let by_lamps = lamps.pdf(world, &hit, ray);
            self.emission(&hit) * (own.x / (own.y + by_lamps))
        }))
    }

    fn emission(&self, hit: &rays::SurfaceHit) -> DVec3 {
        let [b, c] = hit.barycentric.map(f64::from);
        let scene = self.radiosity.world.scene();
        emission_at(scene, hit.instance, hit.triangle, [1.0 - b - c, b, c])
    }
}
