//! Light through tinted panes, channel by channel.
//!
//! A ray passes a pane, or is stopped, with all its channels, by the mean of what its tint leaves of them (see
//! `alpha_test.rs`). In scenes with tinted panes this is right for the mean of the channels alone. Two things are told
//! here for each of them: what arrives of a light, exactly and without chance ([`World::passed`]), and by how much the
//! light of a ray that was let pass by chance is more or less than its mean ([`World::tint`]).

use crate::backend::{Ray, RayBackend, Stops, SurfaceHit};
use crate::world::World;
use glam::{DVec3, Vec3};

impl World {
    /// The share of the light of each channel that passes along a ray, 0..=1: what the surfaces on it let pass, one
    /// times the other, in scenes with tinted panes; all or nothing, by [`RayBackend::occluded`], in others.
    pub fn passed(&self, backend: &dyn RayBackend, ray: &Ray) -> DVec3 {
        match self.has_tints() {
            true => self.product(backend, *ray, |passing| passing),
            false if backend.occluded(ray) => DVec3::ZERO,
            false => DVec3::ONE,
        }
    }

    /// What the light of a ray that nothing has stopped before its end counts in each channel: what the panes on it
    /// leave of that for what they leave of the mean of the channels.
    ///
    /// * `end`: in lengths of the ray's direction, where it met a surface.
    pub fn tint(&self, backend: &dyn RayBackend, ray: &Ray, end: f32) -> DVec3 {
        if !self.has_tints() {
            return DVec3::ONE;
        }
        let t_max = end.next_down();
        self.product(backend, Ray { t_max, ..*ray }, relative)
    }

    /// The product over the surfaces on a ray of something that follows from what each lets pass.
    fn product(&self, backend: &dyn RayBackend, mut ray: Ray, of: impl Fn(Vec3) -> Vec3) -> DVec3 {
        let mut left = DVec3::ONE;
        while let Some(hit) = backend.closest_that(&ray, Stops::Any) {
            left *= of(self.passing(&hit)).as_dvec3();
            ray.t_min = hit.t;
            if left == DVec3::ZERO {
                break;
            }
        }
        left
    }

    /// The share of the light of each channel that the surface at a hit lets pass, 0..=1.
    pub(crate) fn passing(&self, hit: &SurfaceHit) -> Vec3 {
        let alpha = self.part(hit.instance).1.alpha.as_ref();
        alpha.map_or(Vec3::ZERO, |alpha| {
            alpha.passing(hit.triangle, hit.barycentric)
        })
    }
}

/// The channels of a share over their mean.
pub(crate) fn relative(passing: Vec3) -> Vec3 {
    match passing.element_sum() {
        sum if sum > 0.0 => passing * (3.0 / sum),
        _ => Vec3::ONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::TreeKind;
    use crate::build::{BackendKind, build, has_embree};
    use crate::fixture::{scene, square, world};
    use scene::{Alpha, MaterialModel, Transmission};

    /// Squares one above another, each with a tint, its alpha and the share of the rest that it transmits; and the
    /// libraries over them.
    fn panes(of: &[(Vec3, f32, f32)]) -> (World, Vec<Box<dyn RayBackend>>) {
        let mut scene = scene((0..of.len()).map(|k| square(1.0 + k as f32)).collect());
        let plain = scene.materials.remove(0);
        for (number, &(albedo, alpha, factor)) in of.iter().enumerate() {
            scene.meshes[number].material = number as u32;
            let mut material = plain.clone();
            material.surface = MaterialModel::Phong {
                albedo,
                albedo_map: None,
                specular: Vec3::ZERO,
                exponent: 0.0,
            };
            material.alpha = Alpha::Blend {
                factor: alpha,
                map: None,
            };
            material.transmission = Some(Transmission { factor, map: None });
            scene.materials.push(material);
        }
        let world = world(scene);
        let mut kinds = vec![BackendKind::Obvhs(TreeKind::default())];
        kinds.extend(has_embree().then_some(BackendKind::Embree));
        let backends = kinds.into_iter().map(|kind| build(kind, &world, 1));
        let backends = backends
            .map(|backend| backend.expect("a backend"))
            .collect();
        (world, backends)
    }

    fn upward(x: f32, t_max: f32) -> Ray {
        Ray {
            origin: [x, 0.1, 0.0],
            direction: [0.0, 0.0, 1.0],
            t_min: 0.0,
            t_max,
        }
    }

    const RED: Vec3 = Vec3::new(1.0, 0.25, 0.0);
    const GREEN: Vec3 = Vec3::new(0.5, 1.0, 1.0);

    #[test]
    fn light_passes_panes_channel_by_channel_in_every_library() {
        let (world, backends) = panes(&[(RED, 1.0, 1.0), (GREEN, 0.5, 0.5), (Vec3::ONE, 1.0, 0.0)]);
        // What alpha leaves, and half of what it stops by the tint: 1 - (1 - GREEN/2)/2.
        let second = DVec3::new(0.625, 0.75, 0.75);
        for backend in backends {
            let passed = |ray| world.passed(backend.as_ref(), &ray);
            assert_eq!(passed(upward(1.5, f32::INFINITY)), DVec3::ONE, "beside");
            assert_eq!(passed(upward(0.3, 0.5)), DVec3::ONE, "below");
            assert_eq!(passed(upward(0.3, 1.5)), RED.as_dvec3());
            assert_eq!(passed(upward(0.3, 2.5)), RED.as_dvec3() * second);
            assert_eq!(passed(upward(0.3, 3.5)), DVec3::ZERO, "all is stopped");
        }
    }

    #[test]
    fn rays_that_pass_by_chance_bring_the_share_of_each_channel() {
        let (world, backends) = panes(&[(RED, 1.0, 1.0), (GREEN, 0.5, 0.5)]);
        const RAYS: u32 = 40_000;
        for backend in backends {
            let mut sum = DVec3::ZERO;
            for k in 0..RAYS {
                let ray = upward(0.5 * k as f32 / RAYS as f32, f32::INFINITY);
                if !backend.occluded(&ray) {
                    sum += world.tint(backend.as_ref(), &ray, ray.t_max);
                }
            }
            let (mean, exact) = (sum / f64::from(RAYS), DVec3::new(0.625, 0.1875, 0.0));
            // Red counts 2.12 in the 0.295 of the rays that pass: three standard errors are 0.0145.
            assert!(mean.abs_diff_eq(exact, 0.0145), "{mean} for {exact}");
        }
    }

    #[test]
    fn light_of_grey_panes_is_left_to_chance() {
        let (world, backends) = panes(&[(Vec3::splat(0.5), 1.0, 1.0)]);
        assert!(!world.has_tints());
        for backend in backends {
            for ray in (0..100).map(|k| upward(0.01 * k as f32, f32::INFINITY)) {
                let open = f64::from(u8::from(!backend.occluded(&ray)));
                assert_eq!(world.passed(backend.as_ref(), &ray), DVec3::splat(open));
                assert_eq!(world.tint(backend.as_ref(), &ray, ray.t_max), DVec3::ONE);
            }
        }
    }
}
