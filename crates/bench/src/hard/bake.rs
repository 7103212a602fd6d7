//! Bakes a case: one page of the receiver, with the layers that are judged.

use super::error::Error;
use super::setup::Setup;
use crate::Subject;
use bake::{
    BakedPage, Buried, Choice, Denoise, Effort, Options, Plan, PointSet, Seams, Shading, View,
};
use layers::Layer;
use rays::{BackendKind, Overrides};
use std::sync::Arc;

/// Rays a texel; the mean over the page has 256 times as many.
pub(super) const RAYS: u32 = 1024;

/// The page of a case on one backend.
pub(super) fn bake(setup: &Setup, case: &str, kind: BackendKind) -> Result<BakedPage, Error> {
    let (scene, atlas) = setup.scene();
    let mut layers = vec![Layer::Visibility, Layer::Diffuse];
    layers.extend([Layer::StdErrVisibility, Layer::StdErrDiffuse]);
    if setup.exponent.is_some() {
        layers.extend([Layer::Specular, Layer::StdErrSpecular]);
    }
    let options = Options {
        effort: Effort::Rays(RAYS),
        points: PointSet::default(),
        footprint: bake::Footprint::Texel,
        denoise: Denoise::Off,
        seams: Seams::Off,
        seed: 0,
        sky: bake::Sky::Uniform([1.0; 3]),
        draw_sky: true,
        view: setup
            .view
            .map_or(View::Normal, |v| View::Eye(setup.centre() + v * 1e6)),
        shading: Shading::Exact,
        buried: Buried::default(),
        under: None,
        max_distance: None,
        bounces: Default::default(),
        lights: Vec::new(),
        model: Default::default(),
        layers,
        rings: atlas::RINGS,
        normal_maps: false,
        full_highlights: true,
        ambient: Default::default(),
        overrides: Overrides {
            exponent: setup.exponent,
            ..Overrides::default()
        },
        switched_off: vec![Choice::Open],
    };
    let fail = |source| Error::Bake {
        case: case.into(),
        source,
    };
    let (plan, world) = Plan::of(&Arc::new(scene), &options).map_err(fail)?;
    let backend = rays::build(kind, &world, 0).map_err(fail)?;
    let subject = Subject {
        world: &world,
        plan: &plan,
        atlas: &atlas,
    };
    Ok(subject.bake(backend.as_ref(), &options))
}

/// The values of a judged layer.
///
/// # Panics
/// Where the layer was not asked for: a bug of the caller.
pub(super) fn plane(page: &BakedPage, layer: Layer) -> &[f32] {
    let plane = page.planes.iter().find(|plane| plane.layer == layer);
    &plane.expect("every judged layer is asked for").values
}
