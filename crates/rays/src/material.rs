//! The Phong parameters of a surface at a point: factors times maps, metallic-roughness mapped to Phong.

use glam::{DVec2, DVec3, Vec2, Vec3};
use scene::{Mesh, Scene, Surface};

/// Parameters of the Phong model, of a point or averaged over an area.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PhongMaterial {
    /// Linear RGB.
    pub albedo: DVec3,
    /// Linear RGB.
    pub specular: DVec3,
    /// Lobe exponent.
    pub exponent: f64,
}

/// Material values that replace those of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Overrides {
    /// Diffuse reflectance, linear RGB.
    pub albedo: Option<[f32; 3]>,
    /// Specular reflectance, linear RGB.
    pub specular: Option<[f32; 3]>,
    /// Lobe exponent, 0..=1e6.
    pub exponent: Option<f64>,
}

impl Overrides {
    /// The material with what is overridden.
    pub fn applied(&self, material: PhongMaterial) -> PhongMaterial {
        let rgb = |rgb: [f32; 3]| Vec3::from(rgb).as_dvec3();
        PhongMaterial {
            albedo: self.albedo.map_or(material.albedo, rgb),
            specular: self.specular.map_or(material.specular, rgb),
            exponent: self.exponent.unwrap_or(material.exponent),
        }
    }
}

/// True where the material varies over a surface.
pub fn is_mapped(surface: &Surface) -> bool {
    match surface {
        Surface::Phong { albedo_map, .. } => albedo_map.is_some(),
        Surface::MetallicRoughness {
            base_map,
            metallic_roughness_map,
            ..
        } => base_map.is_some() || metallic_roughness_map.is_some(),
    }
}

/// The Phong parameters at a surface point.
///
/// * `weights`: of the triangle's corners; they add up to 1.
pub fn material_at(
    scene: &Scene,
    instance: u32,
    triangle: u32,
    weights: [f64; 3],
) -> PhongMaterial {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    let uv = |set: u32| uv_at(mesh, triangle, weights, set);
    match &scene.materials[mesh.material as usize].surface {
        Surface::Phong {
            albedo,
            albedo_map,
            specular,
            exponent,
        } => {
            let tint = albedo_map
                .as_ref()
                .map_or(Vec3::ONE, |map| scene.color(map, uv(map.uv_set)));
            PhongMaterial {
                albedo: (*albedo * tint).as_dvec3(),
                specular: specular.as_dvec3(),
                exponent: *exponent,
            }
        }
        Surface::MetallicRoughness {
            base,
            base_map,
            metallic,
            roughness,
            metallic_roughness_map,
            dielectric,
        } => {
            let base = *base
                * base_map
                    .as_ref()
                    .map_or(Vec3::ONE, |map| scene.color(map, uv(map.uv_set)));
            let (mut metallic, mut roughness) = (*metallic, *roughness);
            if let Some(map) = metallic_roughness_map {
                let texel = scene.linear_texel(map, uv(map.uv_set));
                metallic *= f64::from(texel.z);
                roughness *= f64::from(texel.y);
            }
            let (albedo, specular, exponent) =
                scene::phong_from_metallic_roughness(base, metallic, roughness, *dielectric);
            PhongMaterial {
                albedo: albedo.as_dvec3(),
                specular: specular.as_dvec3(),
                exponent,
            }
        }
    }
}

/// Radiance that a surface sends out by itself at a point, linear RGB.
///
/// * `weights`: of the triangle's corners; they add up to 1.
pub fn emission_at(scene: &Scene, instance: u32, triangle: u32, weights: [f64; 3]) -> DVec3 {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    let material = &scene.materials[mesh.material as usize];
    let picture = material.emission_map.as_ref().map_or(Vec3::ONE, |map| {
        scene.color(map, uv_at(mesh, triangle, weights, map.uv_set))
    });
    (material.emission * picture).as_dvec3()
}

/// Radiance of a material with the mean of its picture.
pub(crate) fn mean_emission(scene: &Scene, material: u32) -> DVec3 {
    let material = &scene.materials[material as usize];
    let picture = material.emission_map.as_ref();
    let picture = picture.map_or(Vec3::ONE, |map| scene.mean_color(map));
    (material.emission * picture).as_dvec3()
}

/// The coordinates of a set at a point of a mesh; 0 where it has no such set.
fn uv_at(mesh: &Mesh, triangle: u32, weights: [f64; 3], set: u32) -> Vec2 {
    let Some(uvs) = mesh.uv_sets.get(set as usize) else {
        return Vec2::ZERO;
    };
    let mut sum = DVec2::ZERO;
    for (corner, weight) in mesh.triangles[triangle as usize].iter().zip(weights) {
        sum += uvs[*corner as usize].as_dvec2() * weight;
    }
    sum.as_vec2()
}
