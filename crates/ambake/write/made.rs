//! What else is made of finished pages: the light of engines, and the scene as a GLB.

use crate::error::Error;
use crate::job::Job;
use crate::vertices::Fit;
use ::bake::BakedPage;
use layers::Layer;
use report::{LightSource, PageLight, Shades};
use std::borrow::Cow;

/// What engine files are made of: the same numbers that an export reads from the page's file.
pub(super) fn page_light<'a>(job: &Job, page: &'a BakedPage) -> Result<PageLight<'a>, Error> {
    let options = job.options();
    let plane = |layer: Layer, channel| page.channel(layer, channel).map(Cow::Borrowed);
    let layer = |layer: Layer| {
        let missing = || report::Error::MissingLayer {
            layer: layer.name().into(),
        };
        plane(layer, 0).ok_or_else(missing)
    };
    let light = match [0, 1, 2].map(|c| plane(Layer::Irradiance, c)) {
        [Some(r), Some(g), Some(b)] => Some([r, g, b]),
        _ => None,
    };
    let source = match options.sky.light {
        environment::Sky::Uniform(sky) if !options.light_varies() => LightSource::Uniform(sky),
        _ => LightSource::Irradiance,
    };
    let diffuse = layer(Layer::Diffuse)?;
    Ok(PageLight {
        page: page.page,
        size: page.size,
        rings: job.baker_options().rings,
        mips: options.mips,
        coverage: layer(Layer::Coverage)?,
        light: source.light(light, &diffuse)?,
        lit: match [0, 1, 2].map(|c| plane(Layer::Lambert, c)) {
            [Some(r), Some(g), Some(b)] => Some([r, g, b]),
            _ => None,
        },
        sh: page.layer(Layer::Sh).map(|values| {
            let planes = values.chunks(page.texels());
            planes.map(Cow::Borrowed).collect()
        }),
        diffuse,
    })
}

/// The scene with its lightmap coordinates and, where there are pictures of it, the diffuse term.
pub(super) fn glb(job: &Job, pictures: Option<&[Vec<u8>]>) -> Result<Vec<u8>, Error> {
    let none = Shades::new();
    Ok(report::write_gltf(
        job.scene(),
        job.atlas(),
        pictures,
        &none,
    )?)
}

/// The scene with a layer of one channel as vertex colours.
pub(super) fn vertex_glb(job: &Job, fit: Fit<'_>) -> Result<Vec<u8>, Error> {
    let shades = fit.solved().into_iter();
    let shades = shades.map(|(instance, channels)| (instance, channels.concat()));
    Ok(report::write_gltf(
        job.scene(),
        job.atlas(),
        None,
        &shades.collect(),
    )?)
}
