//! Terms to layers: the three models with albedo, specular reflectance and sky, written into the planes of a page.

use crate::integrate::Terms;
use ambient::models;
use glam::DVec3;
use layers::Layer;
use rays::PhongMaterial;

/// Everything known about one baked texel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BakedTexel {
    /// `y * size + x` on its page.
    pub index: u32,
    /// Fraction of its square inside charts.
    pub coverage: f32,
    /// Object with the largest share.
    pub object: u32,
    /// Integrated terms.
    pub terms: Terms,
    /// Mean material.
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
        let PhongMaterial {
            albedo,
            specular,
            exponent,
        } = self.material;
        let Terms {
            visibility,
            diffuse,
            specular: lobe,
            bent,
            errors,
            irradiance,
            reflection,
            light_errors,
            rays,
        } = self.terms;
        let one = |value: f64| [value as f32, 0.0, 0.0];
        let traditional = || models::traditional(sky, albedo, visibility);
        let lambert = || models::lambert(irradiance, albedo);
        let phong = || models::phong(irradiance, reflection, albedo, specular);
        match layer {
            Layer::Coverage => [self.coverage, 0.0, 0.0],
            Layer::Visibility => one(visibility),
            Layer::Diffuse => one(diffuse),
            Layer::Specular => one(lobe),
            Layer::Traditional => traditional().as_vec3().to_array(),
            Layer::Lambert => lambert().as_vec3().to_array(),
            Layer::Phong => phong().as_vec3().to_array(),
            Layer::Error => one(errors[0]),
            Layer::ErrorVisibility => one(errors[1]),
            Layer::ErrorSpecular => one(errors[2]),
            Layer::Albedo => albedo.as_vec3().to_array(),
            Layer::Reflectance => specular.as_vec3().to_array(),
            Layer::Irradiance => irradiance.as_vec3().to_array(),
            Layer::Reflection => reflection.as_vec3().to_array(),
            Layer::ErrorIrradiance => one(light_errors[0]),
            Layer::ErrorReflection => one(light_errors[1]),
            Layer::Rays => one(rays as f64),
            Layer::Position => self.position.as_vec3().to_array(),
            Layer::Normal => self.normal.as_vec3().to_array(),
            Layer::Geometric => self.geometric.as_vec3().to_array(),
            Layer::Bent => bent.normalize_or_zero().as_vec3().to_array(),
            Layer::Exponent => one(exponent),
            Layer::Object => one(f64::from(self.object)),
            Layer::Validity => one(self.validity),
            Layer::DifferenceLambert => (traditional() - lambert()).as_vec3().to_array(),
            Layer::DifferencePhong => (traditional() - phong()).as_vec3().to_array(),
        }
    }
}
