//! Checks of ranges and of what excludes what.

use super::{Options, Pages};
use crate::error::Error;
use crate::scene::Scene;
use crate::sky::{MAX_RADIANCE, Sky};
use ::bake::{AmbientCoefficient, Bounces, Denoise, Effort, Model};
use glam::DVec3;
use layers::Layer;
use rays::{Cone, Light};

impl Options {
    /// Checks ranges and what excludes what.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let fail = |name, problem: &str| Err(Error::option(name, problem));
        let positive = |value: Option<f64>| value.is_none_or(|v| v > 0.0 && v.is_finite());
        let within = |most: f32| move |v: &f32| (0.0..=most).contains(v);
        let colour = |rgb: Option<[f32; 3]>| rgb.is_none_or(|rgb| rgb.iter().all(within(1e6)));
        if !(1..=16_384).contains(&self.size) {
            return fail("size", "must be between 1 and 16384");
        }
        if !positive(self.density) {
            return fail("density", "must be above 0");
        }
        if self.even_density && self.density.is_some() {
            return fail("density", "is either a number or even");
        }
        if !self.density_of.iter().all(|(_, d)| positive(Some(*d))) {
            return fail("density-of", "each density must be above 0");
        }
        if self.seen_from_within && !self.seen_from.is_empty() {
            return fail("seen-from", "is either auto or places");
        }
        if !self.seen_from.iter().flatten().all(|v| v.is_finite()) {
            return fail("seen-from", "each coordinate must be finite");
        }
        if self.pages == Pages::Most(0) {
            return fail("pages", "must be auto or at least 1");
        }
        if self.gutter > 128 {
            return fail("gutter", "must be at most 128");
        }
        if self.mips > 6 {
            return fail("mips", "must be at most 6");
        }
        if !self.size.is_multiple_of(1 << self.mips) {
            let whole = 1 << self.mips;
            let problem = format!(
                "{} halve a page so often, so its size must be a multiple of {whole}",
                self.mips
            );
            return fail("mips", &problem);
        }
        if !(1..=16).contains(&self.align) {
            return fail("align", "must be between 1 and 16");
        }
        if !self.under.is_none_or(|d| d.is_finite() && d >= 0.0) {
            return fail("under", "must be at least 0");
        }
        if !positive(self.max_distance.map(f64::from)) {
            return fail("max-distance", "must be above 0");
        }
        match self.effort {
            Effort::Rays(rays) if !(1..=16_777_216).contains(&rays) => {
                return fail("rays", "must be between 1 and 16777216");
            }
            Effort::Target { error, .. } if !(error > 0.0 && error < 1.0) => {
                return fail("target-error", "must be above 0 and below 1");
            }
            Effort::Target { relative, .. } if !(0.0..1.0).contains(&relative) => {
                return fail("target-relative", "must be at least 0 and below 1");
            }
            Effort::Target { max_rays, .. } if !(16..=16_777_216).contains(&max_rays) => {
                return fail("max-rays", "must be between 16 and 16777216");
            }
            _ => {}
        }
        if !self.exponent.is_none_or(|n| (0.0..=1e6).contains(&n)) {
            return fail("exponent", "must be between 0 and 1e6");
        }
        let ambient = match self.ambient_coefficient {
            AmbientCoefficient::Rgb(rgb) => Some(rgb),
            _ => None,
        };
        if !colour(ambient) {
            return fail("ambient_coefficient", "each channel must be from 0 to 1e6");
        }
        if !colour(self.albedo) {
            return fail("albedo", "each channel must be from 0 to 1e6");
        }
        if !colour(self.specular) {
            return fail("specular", "each channel must be from 0 to 1e6");
        }
        check_sky(&self.sky)?;
        let sends = |rgb: [f32; 3]| self.bounces == Bounces::Off || rgb.iter().all(within(1.0));
        if !self.albedo.is_none_or(sends) {
            let problem = "each channel must be from 0 to 1 with --bounces: no surface sends on more light than \
                           it receives";
            return fail("albedo", problem);
        }
        check_lights(&self.lights)?;
        if self.compress {
            let checked = report::check_compressed(&self.engines, self.size);
            checked.map_err(|problem| Error::option("compress", problem))?;
        }
        if self.vertices && !self.layers.contains(&Layer::Diffuse) {
            return fail(
                "to",
                "vertices take the layer `diffuse`, which was not asked for",
            );
        }
        let asks = |layers: &[Layer]| self.layers.iter().any(|layer| layers.contains(layer));
        if self.model == Some(Model::Phong) && asks(&[Layer::Ggx, Layer::Base]) {
            return fail("layers", "`ggx` and `base` need --model ggx");
        }
        if self.model == Some(Model::Ggx) && asks(&[Layer::DifferencePhong]) {
            return fail("layers", "`difference.phong` needs --model phong");
        }
        let denoises = self.denoises() == Denoise::Regression;
        if denoises && matches!(self.effort, Effort::Rays(1)) {
            let problem = "compares two halves of the rays: ask for 2 rays or more";
            return fail("--denoise regression", problem);
        }
        if self.denoises() == Denoise::Oidn {
            // A picture of one colour tells whether the library works before an hour is spent on rays.
            let tried = oidn::load().and_then(|it| it.denoise(&[[0.5; 3]; 256], [16, 16], 1));
            if let Err(error) = tried {
                return fail("--denoise oidn", &error.to_string());
            }
        }
        Ok(())
    }
}

/// Light of the sky that no sum of samples overflows.
pub(crate) fn check_sky(sky: &Sky) -> Result<(), Error> {
    let within = |v: &f32| (0.0..=MAX_RADIANCE).contains(v);
    if !sky.largest().iter().all(within) {
        return Err(Error::option("sky", "each channel must be from 0 to 1e12"));
    }
    Ok(())
}

/// Surfaces that give off no more light than can be gathered.
pub(crate) fn check_lamps(scene: &Scene) -> Result<(), Error> {
    let brightest = |material: &::scene::Material| material.emission.max_element();
    let mut materials = scene.materials.iter();
    match materials.find(|material| brightest(material) > MAX_RADIANCE) {
        None => Ok(()),
        Some(material) => Err(Error::Emission {
            scene: scene.path.display().to_string(),
            material: material.name.clone(),
            value: brightest(material),
        }),
    }
}

/// Lights whose numbers can all be used.
pub(crate) fn check_lights(lights: &[Light]) -> Result<(), Error> {
    if !lights.iter().all(is_light) {
        let problem = "each light needs a direction or a place, a size where it has one, and a strength from 0 to 1e12";
        return Err(Error::option(
            "--sun, --point, --sphere, --rect and --lights",
            problem,
        ));
    }
    Ok(())
}

/// True where all numbers of a light can be used.
fn is_light(light: &Light) -> bool {
    let within = |strength: &DVec3| {
        let channels = strength.to_array();
        channels
            .iter()
            .all(|v| (0.0..=f64::from(MAX_RADIANCE)).contains(v))
    };
    match light {
        Light::Distant { toward, irradiance } => toward.is_normalized() && within(irradiance),
        Light::Point {
            position,
            intensity,
            cone,
            range,
        } => {
            let is_cone = |cone: &Cone| {
                cone.axis.is_normalized() && cone.cosines.iter().all(|c| c.is_finite())
            };
            position.is_finite()
                && within(intensity)
                && cone.as_ref().is_none_or(is_cone)
                && *range > 0.0
        }
        Light::Sphere {
            position,
            radius,
            radiance,
        } => position.is_finite() && radius.is_finite() && *radius > 0.0 && within(radiance),
        Light::Rect {
            corner,
            sides: [a, b],
            radiance,
        } => {
            let area = a.cross(*b).length();
            corner.is_finite() && area.is_finite() && area > 0.0 && within(radiance)
        }
    }
}
