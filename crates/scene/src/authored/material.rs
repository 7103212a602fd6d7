//! The materials that a program hands over, under the same rules as a file's.

use super::{AlphaMode, Material, MetallicRoughness, Texture, named, place};
use crate::input::Input;
use crate::material::{MAX_EXPONENT, conserving};
use crate::validate::{Parts, clamped};
use crate::{
    Alpha, Error, Image, MaterialModel, NormalMap, Packed, PackedImage, TextureRef, WarningKind,
};
use glam::Vec3;

/// The material as the scene has it, its pictures among the scene's.
pub(super) fn built(
    input: &mut Input,
    parts: &mut Parts,
    number: usize,
    given: Material,
) -> Result<crate::Material, Error> {
    let place = place("material", number, &given.name);
    let name = named(&given.name, || format!("material {number}"));
    let mut changed = 0;
    let mut color = |color: [f32; 3], high: f32, fallback: f32| {
        Vec3::from_array(color.map(|v| clamped(v, 0.0, high, fallback, &mut changed)))
    };
    let albedo = color(given.albedo, 1.0, 1.0);
    let specular = color(given.specular, 1.0, 0.0);
    let emission = color(given.emission, f32::MAX, 0.0);
    let factor = clamped(given.alpha, 0.0, 1.0, 1.0, &mut changed);
    let cutoff = match given.alpha_mode {
        AlphaMode::Mask { cutoff } => clamped(cutoff, 0.0, f32::MAX, 0.5, &mut changed),
        AlphaMode::Opaque | AlphaMode::Blend => 0.0,
    };
    let exponent = match given.exponent {
        n if n.is_nan() => 0.0,
        n => n.clamp(0.0, MAX_EXPONENT),
    };
    changed += u64::from(exponent != given.exponent);
    let metal = given.metallic_roughness.map(|of| MetallicRoughness {
        metallic: clamped(of.metallic, 0.0, 1.0, 1.0, &mut changed),
        roughness: clamped(of.roughness, 0.0, 1.0, 1.0, &mut changed),
        dielectric: of
            .dielectric
            .map(|v| clamped(v, 0.0, 1.0, 0.04, &mut changed)),
        texture: of.texture,
    });
    let message = "factors out of range are clamped";
    input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        changed,
        message,
    );

    let mut texture = |what: &str, texture: Option<Texture>| {
        let image = texture.map(|texture| image(texture, what, &name));
        let image = image.transpose().map_err(|p| input.invalid(&*place, p))?;
        Ok::<_, Error>(image.map(|image| {
            parts.images.push(image);
            TextureRef::new(parts.images.len() as u32 - 1)
        }))
    };
    let map = texture("texture", given.albedo_texture)?;
    let emission_map = match emission == Vec3::ZERO {
        // Without light the picture stays dark.
        true => None,
        false => texture("emission texture", given.emission_texture)?,
    };
    let surface = match metal {
        None => {
            let [albedo, specular] = conserving(input, &place, [albedo, specular]);
            MaterialModel::Phong {
                albedo,
                albedo_map: map.clone(),
                specular,
                exponent,
            }
        }
        Some(metal) => MaterialModel::MetallicRoughness {
            base: albedo,
            base_map: map.clone(),
            metallic: f64::from(metal.metallic),
            roughness: f64::from(metal.roughness),
            metallic_roughness_map: texture("metallic-roughness texture", metal.texture)?,
            dielectric: Vec3::from_array(metal.dielectric),
        },
    };
    let normal_map = match given.normal_texture {
        None => None,
        Some(texture) => {
            let image = image(texture, "normal texture", &name);
            let image = image.map_err(|problem| input.invalid(&*place, problem))?;
            parts.packed_images.push(PackedImage {
                name: image.name.clone(),
                content: Packed::Pixels(image),
                file: input.path.clone(),
            });
            Some(NormalMap {
                texture: TextureRef::new(parts.packed_images.len() as u32 - 1),
                scale: match given.normal_scale.is_finite() {
                    true => given.normal_scale,
                    false => 1.0,
                },
                heights: false,
            })
        }
    };
    Ok(crate::Material {
        name,
        alpha: match given.alpha_mode {
            AlphaMode::Opaque => Alpha::Opaque,
            AlphaMode::Mask { .. } => Alpha::Mask {
                cutoff,
                factor,
                map,
            },
            AlphaMode::Blend => Alpha::Blend { factor, map },
        },
        surface,
        ambient: None,
        emission,
        emission_map,
        transmission: None,
        normal_map,
        double_sided: given.double_sided,
    })
}

fn image(texture: Texture, what: &str, name: &str) -> Result<Image, String> {
    let Texture {
        width,
        height,
        pixels,
    } = texture;
    if pixels.is_empty() || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(format!(
            "its {what} has {} pixels, but {width} x {height} are announced; give as many, at least one",
            pixels.len()
        ));
    }
    Ok(Image {
        name: name.into(),
        width,
        height,
        pixels,
    })
}
