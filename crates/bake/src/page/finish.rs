//! The last steps of a page whose tiles are all finished, in this order: mend, denoise, compose, dilate.

use super::compose::{Composition, is_composed, is_light};
use super::planes::{BakedPage, LayerPlanes};
use super::stats::ErrorSums;
use crate::choice::Choice;
use crate::denoise::{Field, denoise};
use crate::mend::{Mends, Surface};
use crate::options::{Denoise, Options, Sky};
use crate::plan::Plan;
use atlas::{Dilation, RINGS};
use glam::{DVec3, Vec3};
use layers::Layer;
use rayon::prelude::*;

/// A term, its standard error and the choice that models it.
type TermLayers = (Layer, Layer, Choice);

/// What no sky changes.
const SHARES: [TermLayers; 3] = [
    (Layer::Diffuse, Layer::StdErrDiffuse, Choice::Diffuse),
    (
        Layer::Visibility,
        Layer::StdErrVisibility,
        Choice::Visibility,
    ),
    (Layer::Specular, Layer::StdErrSpecular, Choice::Specular),
];

/// The light of a map, which tiles integrate beside the shares.
const LIGHTS: [TermLayers; 2] = [
    (Layer::Irradiance, Layer::StdErrIrradiance, Choice::Diffuse),
    (Layer::Reflection, Layer::StdErrReflection, Choice::Specular),
];

/// The terms that tiles integrate for what was asked.
fn terms(options: &Options, plan: &Plan) -> Vec<TermLayers> {
    let composed = |layer: &Layer| is_composed(*layer) || is_light(*layer);
    let lights: &[TermLayers] = match options.sky.map() {
        Some(_) if options.layers.iter().any(composed) => &LIGHTS,
        _ => &[],
    };
    let modelled = |term: &&TermLayers| plan.models(term.2);
    let terms = SHARES.iter().chain(lights).filter(modelled);
    terms.copied().collect()
}

/// The layers that are kept while tiles are baked: the facts from which the asked layers follow when the page is finished.
pub(super) fn working_layers(options: &Options, plan: &Plan, mends: bool) -> Vec<Layer> {
    let mut layers = vec![Layer::Coverage];
    let mut add = |layer: Layer| {
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    };
    let uniform = options.sky.map().is_none();
    let follows = |layer: Layer| is_composed(layer) || (uniform && is_light(layer));
    let asked = options.layers.iter().copied();
    asked.filter(|&layer| !follows(layer)).for_each(&mut add);
    for (term, std_err, _) in terms(options, plan) {
        add(term);
        if options.denoise != Denoise::Off || options.layers.iter().any(|&layer| is_light(layer)) {
            add(std_err);
        }
    }
    if options.denoise != Denoise::Off || mends {
        let geometry = [Layer::Position, Layer::Normal, Layer::Object];
        geometry.into_iter().for_each(&mut add);
    }
    if mends {
        add(Layer::Validity);
    }
    if options.layers.iter().any(|&layer| is_composed(layer)) {
        add(Layer::Albedo);
        add(Layer::Reflectance);
    }
    layers
}

/// Finishes the page. `mends` says that solids may bury texels of it.
pub(super) fn finish(page: &mut BakedPage, options: &Options, plan: &Plan, mends: bool) {
    if mends {
        mend_terms(page, options, plan);
    }
    if options.denoise == Denoise::Regression {
        denoise_terms(page, plan);
        count_errors(page);
    }
    compose_asked(page, options);
    fill_gutters(page);
    page.finished = true;
}

/// Mends the terms of texels that are buried, wholly or in part.
fn mend_terms(page: &mut BakedPage, options: &Options, plan: &Plan) {
    let plane = |layer: Layer, channel| {
        let missing = || panic!("mending needs the layer {}", layer.name());
        page.channel(layer, channel).unwrap_or_else(missing)
    };
    let three = |layer| [0, 1, 2].map(|channel| plane(layer, channel));
    let mends = Mends::of(&Surface {
        size: page.size as usize,
        coverage: plane(Layer::Coverage, 0),
        validity: plane(Layer::Validity, 0),
        position: three(Layer::Position),
        normal: three(Layer::Normal),
        object: plane(Layer::Object, 0),
    });
    let texels = page.texels();
    for (term, std_err, _) in terms(options, plan) {
        let most = if is_light(term) { f64::MAX } else { 1.0 };
        let planes = page.planes_of(term).par_chunks_mut(texels);
        planes.for_each(|plane| mends.apply(plane, 0.0, most));
        if page.layer(std_err).is_some() {
            mends.apply_to_errors(page.planes_of(std_err));
        }
    }
}

/// Denoises the terms that the plan models, over the surfaces of the page.
fn denoise_terms(page: &mut BakedPage, plan: &Plan) {
    // A texel that cannot be seen says nothing about its neighbours: to the denoiser it is void.
    let mut coverage = page
        .channel(Layer::Coverage, 0)
        .unwrap_or_default()
        .to_vec();
    if let Some(validity) = page.channel(Layer::Validity, 0) {
        let buried = coverage
            .iter_mut()
            .zip(validity)
            .filter(|(_, v)| **v == 0.0);
        buried.for_each(|(coverage, _)| *coverage = 0.0);
    }
    for (term, std_err, choice) in SHARES {
        if !plan.models(choice) {
            continue;
        }
        let plane = |layer: Layer, channel| {
            let missing = || panic!("the denoiser needs the layer {}", layer.name());
            page.channel(layer, channel).unwrap_or_else(missing)
        };
        let three = |layer| [0, 1, 2].map(|channel| plane(layer, channel));
        let field = Field {
            size: page.size as usize,
            coverage: &coverage,
            position: three(Layer::Position),
            normal: three(Layer::Normal),
            object: plane(Layer::Object, 0),
        };
        let found = denoise(&field, plane(term, 0), plane(std_err, 0));
        page.planes_of(term).copy_from_slice(&found.values);
        page.planes_of(std_err).copy_from_slice(&found.std_errs);
    }
}

/// Counts the errors of the page as they stand after denoising.
fn count_errors(page: &mut BakedPage) {
    let mut errors = ErrorSums::default();
    let (coverage, std_errs) = (
        page.layer(Layer::Coverage).unwrap_or_default(),
        page.layer(Layer::StdErrDiffuse).unwrap_or_default(),
    );
    for (texel, (coverage, std_err)) in (0u32..).zip(coverage.iter().zip(std_errs)) {
        if *coverage > 0.0 {
            errors.add(f64::from(*std_err), [texel % page.size, texel / page.size]);
        }
    }
    page.stats.errors = errors;
}

/// The planes that layers are composed of; `None` for what is not modelled.
struct Facts<'a> {
    coverage: Option<&'a [f32]>,
    diffuse: Option<&'a [f32]>,
    visibility: Option<&'a [f32]>,
    specular: Option<&'a [f32]>,
    diffuse_error: Option<&'a [f32]>,
    specular_error: Option<&'a [f32]>,
    irradiance: [Option<&'a [f32]>; 3],
    reflection: [Option<&'a [f32]>; 3],
    albedo: [Option<&'a [f32]>; 3],
    reflectance: [Option<&'a [f32]>; 3],
}

impl<'a> Facts<'a> {
    fn of(page: &'a BakedPage) -> Self {
        let three = |layer| [0, 1, 2].map(|channel| page.channel(layer, channel));
        Self {
            coverage: page.layer(Layer::Coverage),
            diffuse: page.layer(Layer::Diffuse),
            visibility: page.layer(Layer::Visibility),
            specular: page.layer(Layer::Specular),
            diffuse_error: page.layer(Layer::StdErrDiffuse),
            specular_error: page.layer(Layer::StdErrSpecular),
            irradiance: three(Layer::Irradiance),
            reflection: three(Layer::Reflection),
            albedo: three(Layer::Albedo),
            reflectance: three(Layer::Reflectance),
        }
    }

    /// What a covered texel is composed of; `None` in the void.
    fn at(&self, texel: usize, sky: &Sky) -> Option<Composition> {
        let one = |plane: Option<&[f32]>| plane.map_or(0.0, |plane| f64::from(plane[texel]));
        let rgb = |planes: [Option<&[f32]>; 3]| DVec3::from(planes.map(one));
        let mean = sky.mean();
        let [irradiance, reflection] = match sky.map() {
            None => [mean * one(self.diffuse), mean * one(self.specular)],
            Some(_) => [rgb(self.irradiance), rgb(self.reflection)],
        };
        (one(self.coverage) > 0.0).then(|| Composition {
            sky: mean,
            visibility: one(self.visibility),
            irradiance,
            reflection,
            diffuse_error: one(self.diffuse_error),
            specular_error: one(self.specular_error),
            albedo: rgb(self.albedo),
            specular: rgb(self.reflectance),
        })
    }
}

/// Puts the asked layers in place of the facts. Facts that were not asked for go as soon as nothing needs them.
fn compose_asked(page: &mut BakedPage, options: &Options) {
    let asked = |layer: Layer| layer == Layer::Coverage || options.layers.contains(&layer);
    let geometry = [
        Layer::Position,
        Layer::Normal,
        Layer::Object,
        Layer::Validity,
    ];
    page.planes
        .retain(|planes| asked(planes.layer) || !geometry.contains(&planes.layer));
    let texels = page.texels();
    let mut composed = Vec::new();
    for &layer in &options.layers {
        if page.layer(layer).is_some() {
            continue;
        }
        let facts = Facts::of(page);
        let mut planes = LayerPlanes::void(layer, texels);
        planes
            .values
            .par_iter_mut()
            .enumerate()
            .for_each(|(at, value)| {
                if let Some(composition) = facts.at(at % texels, &options.sky) {
                    *value = composition.value(layer)[at / texels] as f32;
                }
            });
        composed.push(planes);
    }
    page.planes.retain(|planes| asked(planes.layer));
    page.planes.append(&mut composed);
    let place = |layer: Layer| match layer {
        Layer::Coverage => 0,
        other => 1 + options.layers.iter().position(|l| *l == other).unwrap_or(0),
    };
    page.planes.sort_by_key(|planes| place(planes.layer));
}

/// Fills the gutter texels of every layer that dilates, and renews the length of directions there.
fn fill_gutters(page: &mut BakedPage) {
    let texels = page.texels();
    let dilation = Dilation::new(&page.planes[0].values, page.size, RINGS);
    page.planes
        .par_iter_mut()
        .filter(|planes| planes.layer.dilates())
        .flat_map(|planes| planes.values.par_chunks_mut(texels))
        .for_each(|plane| {
            dilation.apply(plane);
        });
    for layer in [Layer::Normal, Layer::Geometric, Layer::Bent] {
        let Some(planes) = page.planes.iter_mut().find(|p| p.layer == layer) else {
            continue;
        };
        for &target in dilation.targets() {
            let at = |c: usize| c * texels + target as usize;
            let v = &mut planes.values;
            let unit = Vec3::new(v[at(0)], v[at(1)], v[at(2)]).normalize_or_zero();
            for c in 0..3 {
                v[at(c)] = unit[c];
            }
        }
    }
}
