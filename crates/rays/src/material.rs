//! The Phong parameters of a surface at a point: factors times maps, metallic-roughness mapped to Phong.

use crate::backend::SurfaceHit;
use glam::{DVec2, DVec3, Vec2, Vec3};
use scene::{Alpha, Instance, Material, MaterialModel, Mesh, Scene, TextureRef};

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

/// True where the material varies over the surface of an instance.
pub fn is_mapped(scene: &Scene, instance: u32) -> bool {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    let material = &scene.materials[mesh.material as usize];
    let transmission = material
        .transmission
        .as_ref()
        .is_some_and(|t| t.map.is_some());
    !mesh.colors.is_empty() || transmission || material.surface.textures().next().is_some()
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
    let point = SurfaceAt::of(scene, mesh, triangle, weights);
    let (albedo, specular, exponent) = match &point.material.surface {
        MaterialModel::Phong {
            specular, exponent, ..
        } => (point.base, *specular, *exponent),
        MaterialModel::MetallicRoughness { dielectric, .. } => {
            let [roughness, metallic] = point.roughness_and_metallic();
            scene::phong_from_metallic_roughness(point.base, metallic, roughness, *dielectric)
        }
        MaterialModel::SpecularGlossiness {
            specular,
            glossiness,
            specular_glossiness_map,
            ..
        } => {
            let map = specular_glossiness_map.as_ref();
            let gloss = map.map_or(1.0, |map| scene.alpha(map, point.uv(map)));
            let glossiness = glossiness * f64::from(gloss);
            let specular = *specular * point.color(map);
            scene::phong_from_specular_glossiness(point.base, specular, glossiness)
        }
    };
    PhongMaterial {
        albedo: albedo.as_dvec3() * f64::from(1.0 - point.transmission()),
        specular: specular.as_dvec3(),
        exponent,
    }
}

/// The share of the light that goes straight through a surface at a point where alpha stops it, 0..=1, and its tint.
pub(crate) fn transmitted(
    scene: &Scene,
    mesh: &Mesh,
    triangle: u32,
    weights: [f64; 3],
) -> (f32, Vec3) {
    let point = SurfaceAt::of(scene, mesh, triangle, weights);
    (point.transmission(), point.base)
}

/// The base colour of a surface: its factor and its texture.
pub(crate) fn base_of(surface: &MaterialModel) -> (Vec3, &Option<TextureRef>) {
    match surface {
        MaterialModel::Phong {
            albedo, albedo_map, ..
        } => (*albedo, albedo_map),
        MaterialModel::MetallicRoughness { base, base_map, .. } => (*base, base_map),
        MaterialModel::SpecularGlossiness {
            diffuse,
            diffuse_map,
            ..
        } => (*diffuse, diffuse_map),
    }
}

/// A point of a mesh, and its base colour.
struct SurfaceAt<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    material: &'a Material,
    triangle: u32,
    weights: [f64; 3],
    /// Factor times texture times vertex colour, linear.
    base: Vec3,
}

impl<'a> SurfaceAt<'a> {
    fn of(scene: &'a Scene, mesh: &'a Mesh, triangle: u32, weights: [f64; 3]) -> Self {
        let material = &scene.materials[mesh.material as usize];
        let mut point = Self {
            scene,
            mesh,
            material,
            triangle,
            weights,
            base: Vec3::ONE,
        };
        let (factor, map) = base_of(&material.surface);
        point.base = factor * point.color(map.as_ref()) * vertex_color(mesh, triangle, weights);
        point
    }

    fn uv(&self, map: &TextureRef) -> Vec2 {
        uv_at(self.mesh, self.triangle, self.weights, map.uv_set)
    }

    /// White without a map.
    fn color(&self, map: Option<&TextureRef>) -> Vec3 {
        map.map_or(Vec3::ONE, |map| self.scene.color(map, self.uv(map)))
    }

    /// Red, green and blue of data; 1 without a map.
    fn data(&self, map: Option<&TextureRef>) -> Vec3 {
        map.map_or(Vec3::ONE, |map| self.scene.linear_texel(map, self.uv(map)))
    }

    fn roughness_and_metallic(&self) -> [f64; 2] {
        match &self.material.surface {
            MaterialModel::MetallicRoughness {
                metallic,
                roughness,
                metallic_roughness_map,
                ..
            } => {
                let texel = self.data(metallic_roughness_map.as_ref());
                [
                    roughness * f64::from(texel.y),
                    metallic * f64::from(texel.z),
                ]
            }
            _ => [1.0, 0.0],
        }
    }

    /// The share that the surface does not scatter but lets through, before its tint, 0..=1.
    fn transmission(&self) -> f32 {
        let Some(transmission) = &self.material.transmission else {
            return 0.0;
        };
        let [_, metallic] = self.roughness_and_metallic();
        let share = transmission.factor * self.data(transmission.map.as_ref()).x;
        share * (1.0 - metallic as f32)
    }
}

/// The mean of the corners' colours by their weights; white where the mesh has none.
fn vertex_color(mesh: &Mesh, triangle: u32, weights: [f64; 3]) -> Vec3 {
    if mesh.colors.is_empty() {
        return Vec3::ONE;
    }
    let corners = mesh.triangles[triangle as usize].map(|corner| mesh.colors[corner as usize]);
    let mut sum = DVec3::ZERO;
    for (color, weight) in corners.iter().zip(weights) {
        sum += color.as_dvec3() * weight;
    }
    sum.as_vec3()
}

/// Radiance that the surface at a hit sends out by itself toward the side from which it was met, linear RGB: nothing at
/// the back of a material that is not double-sided.
pub fn emission_at(scene: &Scene, hit: &SurfaceHit) -> DVec3 {
    let mesh = &scene.meshes[scene.instances[hit.instance as usize].mesh as usize];
    let material = &scene.materials[mesh.material as usize];
    if !hit.front && !material.double_sided {
        return DVec3::ZERO;
    }
    let [b, c] = hit.barycentric.map(f64::from);
    let weights = [1.0 - b - c, b, c];
    let picture = material.emission_map.as_ref().map_or(Vec3::ONE, |map| {
        scene.color(map, uv_at(mesh, hit.triangle, weights, map.uv_set))
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

/// True where a surface that blocks light lets a share of it pass: no cut-out, which stops or lets through.
pub(crate) fn has_panes(scene: &Scene) -> bool {
    scene.instances.iter().any(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        let is_blend = matches!(material.alpha, Alpha::Blend { .. });
        instance.casts && (is_blend || material.transmission.is_some())
    })
}

/// True where a surface that blocks light lets some of it pass with a tint.
pub(crate) fn has_tints(scene: &Scene) -> bool {
    let is_grey = |color: &Vec3| color.x == color.y && color.y == color.z;
    let is_tinted = |instance: &Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        let (factor, map) = base_of(&material.surface);
        let has_color = |image: u32| {
            let mut pixels = scene.images[image as usize].pixels.iter();
            pixels.any(|[r, g, b, _]| r != g || g != b)
        };
        instance.casts
            && material.transmission.is_some()
            && (!is_grey(&factor)
                || !mesh.colors.iter().all(is_grey)
                || map.as_ref().is_some_and(|map| has_color(map.image)))
    };
    scene.instances.iter().any(is_tinted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use scene::{Image, Transmission, Wrap};

    /// At the middle of the edge from the first corner of triangle 0 to its second.
    const MIDDLE: [f64; 3] = [0.5, 0.5, 0.0];

    fn square(surface: MaterialModel) -> Scene {
        let mut scene = fixture::scene(vec![fixture::square(0.0)]);
        scene.materials[0].surface = surface;
        scene
    }

    fn dielectric(base: Vec3, metallic: f64) -> MaterialModel {
        MaterialModel::MetallicRoughness {
            base,
            base_map: None,
            metallic,
            roughness: 1.0,
            metallic_roughness_map: None,
            dielectric: Vec3::ZERO,
        }
    }

    /// One pixel.
    fn plain(scene: &mut Scene, pixel: [u8; 4]) -> Option<TextureRef> {
        scene.images.push(Image {
            name: "plain".into(),
            width: 1,
            height: 1,
            pixels: vec![pixel],
        });
        Some(TextureRef {
            wrap: [Wrap::Clamp; 2],
            ..TextureRef::new(scene.images.len() as u32 - 1)
        })
    }

    #[test]
    fn vertex_colours_multiply_the_base_colour_between_the_corners() {
        let mut scene = square(dielectric(Vec3::new(0.5, 1.0, 1.0), 0.0));
        assert!(!is_mapped(&scene, 0));
        scene.meshes[0].colors = vec![Vec3::X, Vec3::ONE, Vec3::ZERO, Vec3::ZERO];
        assert!(is_mapped(&scene, 0));
        let found = material_at(&scene, 0, 0, MIDDLE).albedo;
        assert_eq!(found, DVec3::new(0.5, 0.5, 0.5));
    }

    #[test]
    fn a_specular_glossiness_surface_has_what_its_coat_leaves_and_the_exponent_of_its_gloss() {
        let mut scene = square(MaterialModel::SpecularGlossiness {
            diffuse: Vec3::new(0.5, 1.0, 0.25),
            diffuse_map: None,
            specular: Vec3::new(0.5, 0.25, 0.0),
            glossiness: 1.0,
            specular_glossiness_map: None,
        });
        let map = plain(&mut scene, [255, 255, 255, 51]);
        if let MaterialModel::SpecularGlossiness {
            specular_glossiness_map,
            ..
        } = &mut scene.materials[0].surface
        {
            *specular_glossiness_map = map;
        }
        let found = material_at(&scene, 0, 0, MIDDLE);
        // Half of the light is left by the coat's largest channel.
        assert_eq!(found.albedo, DVec3::new(0.25, 0.5, 0.125));
        assert_eq!(found.specular, DVec3::new(0.5, 0.25, 0.0));
        // Gloss 51/255, roughness 0.8: (1 / 0.8^4 - 1) / 2.
        assert!(
            (found.exponent - 0.720_703_125).abs() < 1e-6,
            "{}",
            found.exponent
        );
    }

    #[test]
    fn what_is_transmitted_is_not_scattered_and_a_metal_transmits_nothing() {
        for (metallic, through) in [(0.0, 0.5), (1.0, 0.0)] {
            let mut scene = square(dielectric(Vec3::new(1.0, 0.5, 0.0), metallic));
            // Red is the share: 127.5 would be half.
            let map = plain(&mut scene, [255, 0, 0, 0]);
            scene.materials[0].transmission = Some(Transmission { factor: 0.5, map });
            let albedo = material_at(&scene, 0, 0, MIDDLE).albedo;
            let left = (1.0 - metallic) * (1.0 - through);
            assert_eq!(albedo, DVec3::new(1.0, 0.5, 0.0) * left, "{metallic}");
            let (share, tint) = transmitted(&scene, &scene.meshes[0], 0, MIDDLE);
            assert_eq!(f64::from(share), through, "{metallic}");
            assert_eq!(tint, Vec3::new(1.0, 0.5, 0.0));
        }
    }

    #[test]
    fn the_back_of_a_single_sided_lamp_is_dark() {
        let mut scene = square(dielectric(Vec3::ONE, 0.0));
        scene.materials[0].emission = Vec3::new(3.0, 2.0, 1.0);
        for (double_sided, front, shines) in [
            (true, true, 1.0),
            (true, false, 1.0),
            (false, true, 1.0),
            (false, false, 0.0),
        ] {
            scene.materials[0].double_sided = double_sided;
            let hit = SurfaceHit {
                t: 1.0,
                instance: 0,
                triangle: 0,
                barycentric: [0.25, 0.25],
                front,
            };
            assert_eq!(
                emission_at(&scene, &hit),
                DVec3::new(3.0, 2.0, 1.0) * shines,
                "{double_sided} {front}"
            );
        }
    }
}
