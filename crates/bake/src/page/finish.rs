//! The last steps of a page whose tiles are all finished: denoise, compose, dilate.

use super::compose::{Composition, is_composed};
use super::planes::{BakedPage, LayerPlanes};
use super::stats::ErrorSums;
use crate::choice::Choice;
use crate::denoise::{Field, denoise};
use crate::options::{Denoise, Options};
use crate::plan::Plan;
use atlas::Dilation;
use glam::{DVec3, Vec3};
use layers::Layer;
use rayon::prelude::*;

/// Each term with its standard error and the choice that models it.
const TERMS: [(Layer, Layer, Choice); 3] = [
    (Layer::Diffuse, Layer::StdErrDiffuse, Choice::Diffuse),
    (
        Layer::Visibility,
        Layer::StdErrVisibility,
        Choice::Visibility,
    ),
    (Layer::Specular, Layer::StdErrSpecular, Choice::Specular),
];

/// The layers that are kept while tiles are baked: those asked for, or, where terms are denoised first, the facts from which the asked
/// ones follow afterwards.
pub(super) fn working_layers(options: &Options, plan: &Plan) -> Vec<Layer> {
    let mut layers = vec![Layer::Coverage];
    let mut add = |layer: Layer| {
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    };
    match options.denoise {
        Denoise::Off => options.layers.iter().copied().for_each(add),
        Denoise::Regression => {
            let facts = options.layers.iter().filter(|layer| !is_composed(**layer));
            facts.copied().for_each(&mut add);
            for (term, std_err, choice) in TERMS {
                if plan.models(choice) {
                    add(term);
                    add(std_err);
                }
            }
            let geometry = [Layer::Position, Layer::Normal, Layer::Object];
            geometry.into_iter().for_each(&mut add);
            if options.layers.iter().any(|layer| is_composed(*layer)) {
                [Layer::Albedo, Layer::Reflectance]
                    .into_iter()
                    .for_each(add);
            }
        }
    }
    layers
}

/// Finishes the page.
pub(super) fn finish(page: &mut BakedPage, options: &Options, plan: &Plan) {
    if options.denoise == Denoise::Regression {
        denoise_terms(page, plan);
        count_errors(page);
        compose_asked(page, options);
    }
    fill_gutters(page, options.rings);
    page.finished = true;
}

/// Denoises the terms that the plan models, over the surfaces of the page.
fn denoise_terms(page: &mut BakedPage, plan: &Plan) {
    for (term, std_err, choice) in TERMS {
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
            coverage: plane(Layer::Coverage, 0),
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

/// The planes that models are composed of; `None` for what is not modelled.
struct Facts<'a> {
    coverage: Option<&'a [f32]>,
    diffuse: Option<&'a [f32]>,
    visibility: Option<&'a [f32]>,
    specular: Option<&'a [f32]>,
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
            albedo: three(Layer::Albedo),
            reflectance: three(Layer::Reflectance),
        }
    }

    /// What a covered texel is composed of under a uniform sky; `None` in the void.
    fn at(&self, texel: usize, sky: DVec3) -> Option<Composition> {
        let one = |plane: Option<&[f32]>| plane.map_or(0.0, |plane| f64::from(plane[texel]));
        let rgb = |planes: [Option<&[f32]>; 3]| DVec3::from(planes.map(one));
        (one(self.coverage) > 0.0).then(|| Composition {
            sky,
            visibility: one(self.visibility),
            irradiance: sky * one(self.diffuse),
            reflection: sky * one(self.specular),
            albedo: rgb(self.albedo),
            specular: rgb(self.reflectance),
        })
    }
}

/// Puts the asked layers in place of the facts, under a uniform sky. Facts that were not asked for go as soon as nothing needs them.
fn compose_asked(page: &mut BakedPage, options: &Options) {
    let asked = |layer: Layer| layer == Layer::Coverage || options.layers.contains(&layer);
    let geometry = [Layer::Position, Layer::Normal, Layer::Object];
    page.planes
        .retain(|planes| asked(planes.layer) || !geometry.contains(&planes.layer));
    let sky = options.sky.floor();
    let texels = page.texels();
    let mut composed = Vec::new();
    for &layer in options.layers.iter().filter(|layer| is_composed(**layer)) {
        let facts = Facts::of(page);
        let mut planes = LayerPlanes::void(layer, texels);
        let (red, rest) = planes.values.split_at_mut(texels);
        let (green, blue) = rest.split_at_mut(texels);
        let rgb = red.par_iter_mut().zip(green).zip(blue);
        rgb.enumerate().for_each(|(texel, ((red, green), blue))| {
            if let Some(composition) = facts.at(texel, sky) {
                let value = composition.value(layer).unwrap_or_default().as_vec3();
                (*red, *green, *blue) = (value.x, value.y, value.z);
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

/// Fills so many rings of gutter texels of every layer that dilates, and renews the length of directions there.
fn fill_gutters(page: &mut BakedPage, rings: u32) {
    let texels = page.texels();
    let dilation = Dilation::new(&page.planes[0].values, page.size, rings);
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
