//! `--filter regression`: the integrated terms of a finished page, each filtered over its surfaces, and what follows from them.

mod field;
mod fit;
mod regression;
mod window;

use crate::integrate::Terms;
use crate::page::{BakedPage, BakedTexel};
use crate::plan::{Choice, Plan};
use field::Field;
use glam::DVec3;
use layers::Layer;
use rays::PhongMaterial;
use regression::regress;

/// Layers that the filter reads or writes, asked for or not.
pub(crate) const NEEDED: [Layer; 11] = [
    Layer::Diffuse,
    Layer::Visibility,
    Layer::Specular,
    Layer::Error,
    Layer::ErrorVisibility,
    Layer::ErrorSpecular,
    Layer::Position,
    Layer::Normal,
    Layer::Object,
    Layer::Albedo,
    Layer::Reflectance,
];

/// Each term with its error and the choice that models it.
const TERMS: [(Layer, Layer, Choice); 3] = [
    (Layer::Diffuse, Layer::Error, Choice::Diffuse),
    (
        Layer::Visibility,
        Layer::ErrorVisibility,
        Choice::Visibility,
    ),
    (Layer::Specular, Layer::ErrorSpecular, Choice::Specular),
];

/// Layers that follow from the terms.
const COMPOSED: [Layer; 7] = [
    Layer::Irradiance,
    Layer::Reflection,
    Layer::Traditional,
    Layer::Lambert,
    Layer::Phong,
    Layer::DifferenceLambert,
    Layer::DifferencePhong,
];

/// Filters the terms of a page whose tiles are all finished, and composes the models anew under a uniform sky.
pub(crate) fn filter(page: &mut BakedPage, plan: &Plan, sky: DVec3) {
    let coverage = page.channel(Layer::Coverage, 0).to_vec();
    for (term, error, choice) in TERMS {
        if !plan.models(choice) {
            continue;
        }
        let three = |layer| [0, 1, 2].map(|channel| page.channel(layer, channel));
        let field = Field {
            size: page.size as usize,
            coverage: &coverage,
            position: three(Layer::Position),
            normal: three(Layer::Normal),
            object: page.channel(Layer::Object, 0),
        };
        let found = regress(&field, page.channel(term, 0), page.channel(error, 0));
        page.channel_mut(term, 0).copy_from_slice(&found.value);
        page.channel_mut(error, 0).copy_from_slice(&found.error);
    }
    compose(page, &coverage, sky);
    state_errors(page, &coverage);
}

/// Composes the models of every covered texel from its terms.
fn compose(page: &mut BakedPage, coverage: &[f32], sky: DVec3) {
    let covered = (0..coverage.len()).filter(|&texel| coverage[texel] > 0.0);
    for texel in covered {
        let one = |layer| f64::from(page.channel(layer, 0)[texel]);
        let rgb = |layer| {
            DVec3::from([0, 1, 2].map(|channel| f64::from(page.channel(layer, channel)[texel])))
        };
        let baked = BakedTexel {
            terms: Terms {
                visibility: one(Layer::Visibility),
                diffuse: one(Layer::Diffuse),
                specular: one(Layer::Specular),
                ..Terms::default()
            }
            .lit(sky),
            material: PhongMaterial {
                albedo: rgb(Layer::Albedo),
                specular: rgb(Layer::Reflectance),
                exponent: 0.0,
            },
            ..BakedTexel::default()
        };
        for plane in &mut page.planes {
            if COMPOSED.contains(&plane.layer) {
                plane.values[texel] = baked.values(plane.layer, sky)[plane.channel];
            }
        }
    }
}

/// Counts the errors of the page anew.
fn state_errors(page: &mut BakedPage, coverage: &[f32]) {
    let mut stats = page.stats;
    stats.forget_errors();
    let size = page.size;
    for (texel, &error) in page.channel(Layer::Error, 0).iter().enumerate() {
        if coverage[texel] > 0.0 {
            let texel = texel as u32;
            stats.add_error(f64::from(error), [texel % size, texel / size]);
        }
    }
    page.stats = stats;
}
