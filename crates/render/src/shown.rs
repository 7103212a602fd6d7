//! What a sample of a picture shows: surfaces that let light through, laid over one another, and what is behind them
//! all. T. Porter, T. Duff, "Compositing Digital Images" (1984).

use crate::direct::camera_ray;
use crate::{Direct, Sample};
use glam::{DVec3, Vec3};
use rays::{Stops, SurfaceHit};

/// Of what is no more of a sample than this, what lies behind it is not looked for.
const FAINTEST: f32 = 1.0 / 1024.0;

/// A surface that a sample shows.
pub(crate) struct Layer {
    pub hit: SurfaceHit,
    /// The share of the sample that it makes up: what the ones before it leave, times what it stops.
    pub share: f32,
    /// What the ones before it leave of the channels for their mean.
    pub tint: Vec3,
}

impl Layer {
    /// What its radiance counts in each channel.
    fn weight(&self) -> DVec3 {
        f64::from(self.share) * self.tint.as_dvec3()
    }
}

/// What a sample shows.
pub(crate) struct Layers {
    /// Surfaces, front to back.
    pub seen: Vec<Layer>,
    /// The share of the sample that shows what is beyond all surfaces, 0..=1.
    left: f32,
    /// What all of them leave of the channels for their mean.
    tint: Vec3,
}

impl Layers {
    fn add(&mut self, hit: SurfaceHit, share: f32) {
        let tint = self.tint;
        if share > 0.0 {
            self.seen.push(Layer { hit, share, tint });
        }
        self.left -= share;
    }
}

impl Direct<'_> {
    /// The radiance that reaches the eye of a sample where the surfaces that it shows send out what `leaving` tells.
    pub(crate) fn through(&self, sample: &Sample, leaving: impl Fn(&SurfaceHit) -> DVec3) -> DVec3 {
        let layers = self.layers(sample);
        let light = |layer: &Layer| layer.weight() * leaving(&layer.hit);
        let sum: DVec3 = layers.seen.iter().map(light).sum();
        match layers.left > 0.0 {
            true => sum + f64::from(layers.left) * layers.tint.as_dvec3() * self.behind(sample),
            false => sum,
        }
    }

    /// What a sample that meets nothing shows.
    pub fn behind(&self, sample: &Sample) -> DVec3 {
        let sky = || self.sky.seen(sample.direction.to_array()).into();
        self.background.unwrap_or_else(sky)
    }

    /// The share of a sample that shows surfaces, not the background, 0..=1.
    pub fn coverage(&self, sample: &Sample) -> f32 {
        1.0 - self.layers(sample).left
    }

    /// The surfaces that a sample shows, front to back. Nothing is left to chance.
    pub(crate) fn layers(&self, sample: &Sample) -> Layers {
        let mut ray = camera_ray(sample);
        let last = self.backend.closest_that(&ray, Stops::All);
        let end = last.map_or(f32::INFINITY, |hit| hit.t);
        let mut layers = Layers {
            seen: Vec::new(),
            left: 1.0,
            tint: Vec3::ONE,
        };
        let has_panes = self.surfaces.world().has_panes();
        while has_panes && layers.left > FAINTEST {
            let next = self.backend.closest_that(&ray, Stops::Any);
            let Some(hit) = next.filter(|hit| hit.t < end) else {
                break;
            };
            layers.add(hit, layers.left * self.surfaces.stopped(&hit));
            layers.tint *= self.surfaces.tint(&hit);
            ray.t_min = hit.t;
        }
        if layers.left > FAINTEST {
            if let Some(last) = last {
                layers.add(last, layers.left);
            }
        } else if let Some(last) = layers.seen.last_mut() {
            last.share += std::mem::take(&mut layers.left);
        }
        layers
    }
}
