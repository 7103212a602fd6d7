//! Terms to layers: facts of a texel, and the models that follow from them with albedo, specular reflectance and sky.

use crate::integrate::Terms;
use ambient::models;
use glam::DVec3;
use layers::Layer;
use rays::PhongMaterial;

/// What the models of a texel are composed of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Composition {
    /// Mean radiance of the sky.
    pub sky: DVec3,
    pub visibility: f64,
    pub irradiance: DVec3,
    pub reflection: DVec3,
    /// Diffuse reflectance.
    pub albedo: DVec3,
    /// Specular reflectance.
    pub specular: DVec3,
}

impl Composition {
    /// The value of a layer that is composed; `None` for the facts themselves.
    pub fn value(&self, layer: Layer) -> Option<DVec3> {
        let traditional = || models::traditional(self.sky, self.albedo, self.visibility);
        let lambert = || models::lambert(self.irradiance, self.albedo);
        let phong = || {
            let (irradiance, reflection) = (self.irradiance, self.reflection);
            models::phong(irradiance, reflection, self.albedo, self.specular)
        };
        Some(match layer {
            Layer::Irradiance => self.irradiance,
            Layer::Reflection => self.reflection,
            Layer::Traditional => traditional(),
            Layer::Lambert => lambert(),
            Layer::Phong => phong(),
            Layer::DifferenceLambert => traditional() - lambert(),
            Layer::DifferencePhong => traditional() - phong(),
            _ => return None,
        })
    }
}

/// True for layers that follow from terms and reflectances.
pub(crate) fn is_composed(layer: Layer) -> bool {
    matches!(
        layer,
        Layer::Irradiance
            | Layer::Reflection
            | Layer::Traditional
            | Layer::Lambert
            | Layer::Phong
            | Layer::DifferenceLambert
            | Layer::DifferencePhong
    )
}

/// Everything known about one baked texel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BakedTexel {
    /// `y * size + x` on its page.
    pub index: u32,
    /// Fraction of its square inside charts.
    pub coverage: f32,
    /// Object with the largest share.
    pub object: u32,
    pub terms: Terms,
    /// Mean over the footprint.
    pub material: PhongMaterial,
    /// Mean world position.
    pub position: DVec3,
    /// Mean shading normal.
    pub normal: DVec3,
    /// Mean geometric normal.
    pub geometric: DVec3,
    /// Share of the footprint that does not see back faces first.
    pub validity: f64,
}

impl BakedTexel {
    /// The values of a layer, as many as the layer has channels. `sky` is the mean radiance of the sky.
    pub fn values(&self, layer: Layer, sky: DVec3) -> [f32; 3] {
        let (terms, material) = (&self.terms, &self.material);
        let composition = Composition {
            sky,
            visibility: terms.visibility.value,
            irradiance: terms.irradiance.value,
            reflection: terms.reflection.value,
            albedo: material.albedo,
            specular: material.specular,
        };
        if let Some(rgb) = composition.value(layer) {
            return rgb.as_vec3().to_array();
        }
        let one = |value: f64| [value as f32, 0.0, 0.0];
        let three = |value: DVec3| value.as_vec3().to_array();
        match layer {
            Layer::Coverage => [self.coverage, 0.0, 0.0],
            Layer::Visibility => one(terms.visibility.value),
            Layer::Diffuse => one(terms.diffuse.value),
            Layer::Specular => one(terms.specular.value),
            Layer::StdErrDiffuse => one(terms.diffuse.std_err),
            Layer::StdErrVisibility => one(terms.visibility.std_err),
            Layer::StdErrSpecular => one(terms.specular.std_err),
            Layer::StdErrIrradiance => one(terms.irradiance.std_err),
            Layer::StdErrReflection => one(terms.reflection.std_err),
            Layer::Rays => one(terms.rays as f64),
            Layer::Position => three(self.position),
            Layer::Normal => three(self.normal),
            Layer::Geometric => three(self.geometric),
            Layer::Bent => three(terms.bent.normalize_or_zero()),
            Layer::Exponent => one(material.exponent),
            Layer::Object => one(f64::from(self.object)),
            Layer::Validity => one(self.validity),
            Layer::Albedo => three(material.albedo),
            Layer::Reflectance => three(material.specular),
            other => unreachable!("layer {} is neither a fact nor composed", other.name()),
        }
    }
}
