//! Adds a page of light to the layers of a finished page. Every layer that shows light is linear in it.

use crate::page::BakedPage;
use glam::DVec3;
use layers::Layer;
use rayon::prelude::*;

/// Adds `light`, finished, to what `page` shows; `direct` where it comes straight from lights.
pub(super) fn add(page: &mut BakedPage, light: BakedPage, direct: bool) {
    let texels = page.texels();
    let mut planes = std::mem::take(&mut page.planes);
    let facts = |layer: Layer| {
        let found = planes.iter().find(|planes| planes.layer == layer);
        found.map(|planes| planes.values.clone())
    };
    let (albedo, reflectance) = (facts(Layer::Albedo), facts(Layer::Reflectance));
    let rgb = |values: Option<&[f32]>, texel: usize| {
        values.map_or(DVec3::ZERO, |values| {
            DVec3::from([0, 1, 2].map(|c| f64::from(values[c * texels + texel])))
        })
    };
    let (irradiance, reflection) = (
        light.layer(Layer::Irradiance),
        light.layer(Layer::Reflection),
    );
    let base = facts(Layer::Base);
    let ggx = |texel| {
        rgb(base.as_deref(), texel) * rgb(irradiance, texel)
            + rgb(reflectance.as_deref(), texel) * rgb(reflection, texel)
    };
    let lambert = |texel| rgb(albedo.as_deref(), texel) * rgb(irradiance, texel);
    let phong =
        |texel| lambert(texel) + rgb(reflectance.as_deref(), texel) * rgb(reflection, texel);
    let normal = facts(Layer::Normal);
    // What surfaces send counts as even over the hemisphere: it has the irradiance that was gathered, and no side that
    // it comes from more.
    let even = |texel: usize, channel: usize| {
        let axis = match channel / 3 {
            0 => 0.5,
            k => 0.25 * rgb(normal.as_deref(), texel)[k - 1],
        };
        rgb(irradiance, texel)[channel % 3] * axis
    };
    for planes in &mut planes {
        let layer = planes.layer;
        let added = |texel: usize, channel: usize, before: f64| -> f64 {
            let own = || {
                light
                    .layer(layer)
                    .map(|values| values[channel * texels + texel])
            };
            match layer {
                Layer::Irradiance
                | Layer::Reflection
                | Layer::HalfIrradiance
                | Layer::HalfReflection
                | Layer::Rays => before + f64::from(own().unwrap_or(0.0)),
                Layer::StdErrIrradiance | Layer::StdErrReflection => {
                    before.hypot(f64::from(own().unwrap_or(0.0)))
                }
                Layer::Direct if direct => before + rgb(irradiance, texel)[channel],
                Layer::Lambert => before + lambert(texel)[channel],
                Layer::Phong => before + phong(texel)[channel],
                Layer::Ggx => before + ggx(texel)[channel],
                Layer::Sh => before + even(texel, channel),
                Layer::DifferenceLambert => before - lambert(texel)[channel],
                Layer::DifferencePhong => before - phong(texel)[channel],
                _ => before,
            }
        };
        let values = planes.values.par_iter_mut().enumerate();
        values.for_each(|(at, value)| {
            *value = added(at % texels, at / texels, f64::from(*value)) as f32;
        });
    }
    page.planes = planes;
    let counted = |values: &[f32]| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let coverage = light.layer(Layer::Coverage).unwrap_or_default();
    let errors = light.layer(Layer::StdErrIrradiance).unwrap_or_default();
    let seen: Vec<f32> = errors
        .iter()
        .zip(coverage)
        .filter(|(_, coverage)| **coverage > 0.0)
        .map(|(error, _)| *error)
        .collect();
    page.stats.irradiance_squares += counted(&seen);
    let rays = light.layer(Layer::Rays).unwrap_or_default();
    page.stats.rays += rays.iter().map(|rays| *rays as u64).sum::<u64>();
}
