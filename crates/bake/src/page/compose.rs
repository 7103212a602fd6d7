//! Terms to layers: facts of a texel, and the models that follow from them with albedo, specular reflectance and sky.

use crate::integrate::{Coat, Terms};
use crate::survey::Texel;
use ambient::models;
use glam::DVec3;
use layers::Layer;

/// What the layers of a texel are composed of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Composition {
    /// Mean radiance of the sky.
    pub sky: DVec3,
    pub visibility: f64,
    pub irradiance: DVec3,
    pub reflection: DVec3,
    /// Standard errors of the diffuse and the specular term.
    pub diffuse_error: f64,
    pub specular_error: f64,
    /// k_a of the traditional model.
    pub ambient: DVec3,
    /// Diffuse reflectance.
    pub albedo: DVec3,
    /// Specular reflectance.
    pub specular: DVec3,
    /// Diffuse reflectance under the coat of the microfacet model.
    pub base: DVec3,
    /// The specular term of an open texel.
    pub open_specular: f64,
}

impl Composition {
    /// The channels of a layer; only the first counts where the layer has one.
    pub fn value(&self, layer: Layer) -> DVec3 {
        let traditional = || models::traditional(self.sky, self.ambient, self.visibility);
        let lambert = || models::lambert(self.irradiance, self.albedo);
        let phong = || {
            let (irradiance, reflection) = (self.irradiance, self.reflection);
            models::phong(irradiance, reflection, self.albedo, self.specular)
        };
        let uniform = |std_err| DVec3::splat(self.sky.element_sum() / 3.0 * std_err);
        match layer {
            Layer::Irradiance => self.irradiance,
            Layer::Reflection => self.reflection,
            Layer::StdErrIrradiance => uniform(self.diffuse_error),
            Layer::StdErrReflection => uniform(self.specular_error),
            Layer::Traditional => traditional(),
            Layer::TraditionalClosed => {
                // Under microfacets the coat takes from the base what it reflects.
                let matte = if self.base == DVec3::ZERO {
                    self.albedo
                } else {
                    self.base
                };
                models::traditional(
                    self.sky,
                    matte + self.specular * self.open_specular,
                    self.visibility,
                )
            }
            Layer::Lambert => lambert(),
            Layer::Phong => phong(),
            Layer::Ggx => {
                let (irradiance, reflection) = (self.irradiance, self.reflection);
                models::phong(irradiance, reflection, self.base, self.specular)
            }
            Layer::DifferenceLambert => traditional() - lambert(),
            Layer::DifferencePhong => traditional() - phong(),
            // The light of lights is added to the finished page.
            Layer::Direct => DVec3::ZERO,
            fact => unreachable!("layer {} is a fact", fact.name()),
        }
    }
}

/// True for layers that follow from light and reflectances.
pub(crate) fn is_composed(layer: Layer) -> bool {
    matches!(
        layer,
        Layer::Traditional
            | Layer::TraditionalClosed
            | Layer::Lambert
            | Layer::Phong
            | Layer::Ggx
            | Layer::DifferenceLambert
            | Layer::DifferencePhong
            | Layer::Direct
    )
}

/// True for layers that follow from the shares under a uniform sky, and that tiles integrate under a map.
pub(crate) fn is_light(layer: Layer) -> bool {
    matches!(
        layer,
        Layer::Irradiance | Layer::Reflection | Layer::StdErrIrradiance | Layer::StdErrReflection
    )
}

/// Everything known about one baked texel.
pub(crate) struct BakedTexel<'a> {
    pub texel: &'a Texel,
    pub terms: &'a Terms,
    pub coat: &'a Coat,
    /// k_a of the traditional model.
    pub ambient: DVec3,
    /// Share of what can be seen that something seals.
    pub sealed: f32,
    /// The specular term of an open texel with this material and view; 0 where it does not reflect specularly.
    pub open_specular: f64,
}

impl BakedTexel<'_> {
    /// The values of a fact, as many as the layer has channels.
    pub fn values(&self, layer: Layer) -> [f32; 3] {
        let (texel, terms) = (self.texel, self.terms);
        let one = |value: f64| [value as f32, 0.0, 0.0];
        let three = |value: DVec3| value.as_vec3().to_array();
        match layer {
            Layer::Coverage => [texel.coverage, 0.0, 0.0],
            Layer::Visibility => one(terms.visibility.value),
            Layer::Diffuse => one(terms.diffuse.value),
            Layer::Specular => one(terms.specular.value),
            Layer::Irradiance => three(terms.irradiance.value),
            Layer::Reflection => three(terms.reflection.value),
            Layer::StdErrDiffuse => one(terms.diffuse.std_err),
            Layer::StdErrVisibility => one(terms.visibility.std_err),
            Layer::StdErrSpecular => one(terms.specular.std_err),
            Layer::StdErrIrradiance => one(terms.irradiance.std_err),
            Layer::StdErrReflection => one(terms.reflection.std_err),
            Layer::Rays => one(terms.rays as f64),
            Layer::Position => three(texel.position),
            Layer::Normal => three(texel.normal),
            Layer::Geometric => three(texel.geometric),
            Layer::Exponent => one(texel.material.exponent),
            Layer::Object => one(f64::from(texel.object)),
            Layer::Validity => [texel.seen.share, 0.0, 0.0],
            Layer::Sealed => [self.sealed, 0.0, 0.0],
            Layer::OpenSpecular => one(self.open_specular),
            Layer::White => one(terms.white),
            Layer::Tint => three(self.coat.tint),
            Layer::StdErrAnyView => one(terms.any_view.as_ref().map_or(0.0, |any| any.std_err)),
            // Their channels are read from the terms.
            Layer::AnyView | Layer::AnyView4 | Layer::AnyView8 => [0.0; 3],
            layer if super::directional::holds(layer) => [0.0; 3],
            Layer::HalfDiffuse => one(terms.halves.diffuse),
            Layer::HalfVisibility => one(terms.halves.visibility),
            Layer::HalfSpecular => one(terms.halves.specular),
            Layer::HalfIrradiance => three(terms.halves.irradiance),
            Layer::HalfReflection => three(terms.halves.reflection),
            Layer::Albedo => three(texel.material.albedo),
            Layer::Reflectance => three(self.coat.specular),
            Layer::Base => three(self.coat.base),
            Layer::Ambient => three(self.ambient),
            composed => unreachable!("layer {} is no fact", composed.name()),
        }
    }
}
