//! The layers of a page that were asked for, in place of the facts from which they follow.

use super::compose::Composition;
use super::planes::{BakedPage, LayerPlanes};
use crate::options::{Model, Options, Sky};
use glam::DVec3;
use layers::Layer;
use rayon::prelude::*;

/// Texels that one thread composes at a time.
const COMPOSED: usize = 1 << 14;

/// The planes that layers are composed of; `None` for what is not modelled.
struct Facts<'a> {
    diffuse: Option<&'a [f32]>,
    visibility: Option<&'a [f32]>,
    specular: Option<&'a [f32]>,
    diffuse_error: Option<&'a [f32]>,
    specular_error: Option<&'a [f32]>,
    irradiance: [Option<&'a [f32]>; 3],
    reflection: [Option<&'a [f32]>; 3],
    albedo: [Option<&'a [f32]>; 3],
    ambient: [Option<&'a [f32]>; 3],
    reflectance: [Option<&'a [f32]>; 3],
    base: [Option<&'a [f32]>; 3],
    open_specular: Option<&'a [f32]>,
    white: Option<&'a [f32]>,
    tint: [Option<&'a [f32]>; 3],
}

impl<'a> Facts<'a> {
    fn of(page: &'a BakedPage) -> Self {
        let three = |layer| [0, 1, 2].map(|channel| page.channel(layer, channel));
        Self {
            diffuse: page.layer(Layer::Diffuse),
            visibility: page.layer(Layer::Visibility),
            specular: page.layer(Layer::Specular),
            diffuse_error: page.layer(Layer::StdErrDiffuse),
            specular_error: page.layer(Layer::StdErrSpecular),
            irradiance: three(Layer::Irradiance),
            reflection: three(Layer::Reflection),
            albedo: three(Layer::Albedo),
            ambient: three(Layer::Ambient),
            reflectance: three(Layer::Reflectance),
            base: three(Layer::Base),
            open_specular: page.layer(Layer::OpenSpecular),
            white: page.layer(Layer::White),
            tint: three(Layer::Tint),
        }
    }

    /// What a texel is composed of.
    fn at(&self, texel: usize, sky: &Sky, model: Model) -> Composition {
        let one = |plane: Option<&[f32]>| plane.map_or(0.0, |plane| f64::from(plane[texel]));
        let rgb = |planes: [Option<&[f32]>; 3]| DVec3::from(planes.map(one));
        let mean = DVec3::from(sky.mean());
        let [irradiance, reflection] = match sky.map() {
            None if model == Model::Ggx => {
                let (open, white, tint) = (one(self.specular), one(self.white), rgb(self.tint));
                let lobe = tint * open + (DVec3::ONE - tint) * white;
                [mean * one(self.diffuse), mean * lobe]
            }
            None => [mean * one(self.diffuse), mean * one(self.specular)],
            Some(_) => [rgb(self.irradiance), rgb(self.reflection)],
        };
        Composition {
            sky: mean,
            visibility: one(self.visibility),
            irradiance,
            reflection,
            diffuse_error: one(self.diffuse_error),
            specular_error: one(self.specular_error),
            albedo: rgb(self.albedo),
            // What has no plane of its own is the albedo.
            ambient: rgb(match self.ambient[0] {
                Some(_) => self.ambient,
                None => self.albedo,
            }),
            specular: rgb(self.reflectance),
            base: rgb(self.base),
            open_specular: one(self.open_specular),
        }
    }
}

/// True for what says which texels are of one surface.
pub(super) fn is_place(layer: Layer) -> bool {
    matches!(layer, Layer::Position | Layer::Normal | Layer::Object)
}

/// Drops facts that nothing needs any more, but for those that were asked for: a plane of a large page takes as much as
/// its scene.
pub(super) fn drop_unasked(page: &mut BakedPage, options: &Options, done: impl Fn(Layer) -> bool) {
    let kept = options.kept();
    let asked = |layer: Layer| layer == Layer::Coverage || kept.contains(&layer);
    page.planes
        .retain(|planes| asked(planes.layer) || !done(planes.layer));
}

/// Puts the asked layers in place of the facts.
pub(super) fn compose_asked(page: &mut BakedPage, options: &Options) {
    drop_unasked(page, options, |layer| {
        is_place(layer) || layer == Layer::Validity
    });
    let kept = options.kept();
    let texels = page.texels();
    let mut composed = Vec::new();
    for &layer in &kept {
        if page.layer(layer).is_some() {
            continue;
        }
        let facts = Facts::of(page);
        let mut planes = LayerPlanes::void(layer, texels);
        // All channels of a texel together: it is composed once.
        let mut parts: Vec<Vec<&mut [f32]>> = Vec::new();
        parts.resize_with(texels.div_ceil(COMPOSED), Vec::new);
        for plane in planes.values.chunks_mut(texels) {
            let own = parts.iter_mut().zip(plane.chunks_mut(COMPOSED));
            own.for_each(|(part, values)| part.push(values));
        }
        let parts = parts.into_par_iter().enumerate();
        parts.for_each(|(part, mut channels)| {
            let first = part * COMPOSED;
            for at in 0..COMPOSED.min(texels - first) {
                let facts = facts.at(first + at, &options.sky, options.model);
                let values = facts.value(layer);
                for (channel, plane) in channels.iter_mut().enumerate() {
                    plane[at] = values[channel] as f32;
                }
            }
        });
        composed.push(planes);
    }
    drop_unasked(page, options, |_| true);
    page.planes.append(&mut composed);
    let place = |layer: Layer| match layer {
        Layer::Coverage => 0,
        other => 1 + kept.iter().position(|l| *l == other).unwrap_or(0),
    };
    page.planes.sort_by_key(|planes| place(planes.layer));
}
