//! Layers for any view: which order they hold, and what the planner says of it.

use super::reflects;
use crate::options::{Effort, Model, Options};
use ambient::any_view::{self, Lobe, ORDERS, order_for};
use ambient::ggx::alpha_of;
use layers::Layer;
use scene::{MaterialModel, Scene};

/// What the numbers for any view are expected to be off by, root mean square over all views of the narrowest lobe in
/// use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnyViewErrors {
    /// Exponent of that lobe; none where no material reflects specularly.
    pub exponent: Option<f64>,
    /// Hemisphere rays a texel, the most of a bake with a target.
    pub rays: u32,
    /// What orders 4 and 8 leave beside walls and under lids.
    pub truncation: [f64; 2],
    /// The noise of the order that is held.
    pub noise: f64,
}

impl Options {
    /// The same with the order that `any-view` holds: the lowest that leaves less of the narrowest lobe in use than
    /// noise does. Beside `any-view.8` it is the first 15 of those numbers, and `any-view.4` is always 15.
    pub fn with_order(mut self, scene: &Scene) -> Self {
        let has = |layer| self.layers.contains(&layer);
        let free = has(Layer::AnyView) && !has(Layer::AnyView4) && !has(Layer::AnyView8);
        let needs = |n| order_for(self.model.lobe(n), rays(&self)) == ORDERS[1];
        let held = match free && exponent(scene, &self).is_some_and(needs) {
            true => Layer::AnyView8,
            false => Layer::AnyView,
        };
        let mut layers: Vec<Layer> = Vec::new();
        for layer in std::mem::take(&mut self.layers) {
            let layer = match layer {
                Layer::AnyView | Layer::AnyView4 => held,
                other => other,
            };
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        }
        self.layers = layers;
        self
    }

    /// What the numbers for any view are expected to be off by; none where no such layer is asked for.
    pub fn any_view_errors(&self, scene: &Scene) -> Option<AnyViewErrors> {
        let order = self.any_view()?;
        let (exponent, rays) = (exponent(scene, self), rays(self));
        let lobe = exponent.map(|n| self.model.lobe(n));
        let of = |by: &dyn Fn(Lobe) -> f64| lobe.map_or(0.0, by);
        Some(AnyViewErrors {
            exponent,
            rays,
            truncation: ORDERS.map(|order| of(&|lobe| any_view::truncation(order, lobe))),
            noise: of(&|lobe| any_view::expected_noise(order, lobe, rays)),
        })
    }
}

/// The rest of the sentence about the visibility; empty where no such layer is asked for.
pub(super) fn words(scene: &Scene, options: &Options) -> String {
    let (Some(order), Some(errors)) = (options.any_view(), options.any_view_errors(scene)) else {
        return String::new();
    };
    let why = match errors.exponent {
        None => "no material reflects specularly".into(),
        Some(n) => {
            let [four, eight] = errors.truncation;
            let (noise, rays) = (errors.noise, errors.rays);
            let narrowest = match options.model {
                Model::Phong => format!("n = {n:.0}"),
                Model::Ggx => format!("roughness {:.2}", alpha_of(n).sqrt()),
            };
            format!(
                "for the narrowest lobe, {narrowest}, 15 numbers leave about {four:.3} and 45 about {eight:.3}, beside noise of {noise:.3} at {rays} rays"
            )
        }
    };
    let numbers = any_view::count(order);
    format!(", and the same rays give {numbers} numbers a texel for any view: {why}")
}

/// Hemisphere rays a texel.
fn rays(options: &Options) -> u32 {
    match options.effort {
        Effort::Rays(rays) => rays,
        Effort::Target { max_rays, .. } => max_rays,
    }
}

/// Exponent of the narrowest lobe in use.
fn exponent(scene: &Scene, options: &Options) -> Option<f64> {
    options.overrides.exponent.or_else(|| narrowest(scene))
}

/// Largest exponent of the materials in use that reflect specularly.
fn narrowest(scene: &Scene) -> Option<f64> {
    let used = scene
        .meshes
        .iter()
        .map(|mesh| &scene.materials[mesh.material as usize].surface);
    let exponents = used
        .filter(|surface| reflects(surface))
        .map(|surface| match surface {
            MaterialModel::Phong { exponent, .. } => *exponent,
            MaterialModel::MetallicRoughness {
                base,
                metallic,
                roughness,
                dielectric,
                ..
            } => scene::phong_from_metallic_roughness(*base, *metallic, *roughness, *dielectric).2,
            MaterialModel::SpecularGlossiness {
                diffuse,
                specular,
                glossiness,
                ..
            } => scene::phong_from_specular_glossiness(*diffuse, *specular, *glossiness).2,
        });
    exponents.max_by(f64::total_cmp)
}
