//! glTF materials and the images they read.

use super::images::{images, packed_images};
use super::names::own_name;
use super::phong::{Phong, phong};
use super::reader::Reader;
use crate::GltfDocument;
use crate::input::Input;
use crate::material::conserving;
use crate::source::NORMALS_STAND;
use crate::types::UNMOVED;
use crate::validate::{Parts, clamped};
use crate::{
    Alpha, Error, Material, MaterialModel, NormalMap, TextureRef, Transmission, WarningKind, Wrap,
};
use glam::Vec3;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Converts the materials that meshes have, in file order, and decodes the images that they read; the others are
/// untinted. The image files behind URIs go to `files`, by image number.
pub(super) fn load(
    input: &mut Input,
    document: &GltfDocument,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<(), Error> {
    let used: BTreeSet<u32> = parts.meshes.iter().map(|mesh| mesh.material).collect();
    for (i, json) in document.list("materials").iter().enumerate() {
        let is_used = used.contains(&(i as u32));
        let name = own_name(json).map_or_else(|| format!("material {i}"), str::to_owned);
        parts.materials.push(match is_used {
            true => material(input, document, i, json, name),
            false => Material::untinted(&name),
        });
    }
    images(input, document, parts, files)?;
    packed_images(input, document, parts, files)
}

const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
/// Channels of a colour that differ by more than this share are a tint.
const TINTED: f32 = 0.02;

const TRANSMISSION: &str = "KHR_materials_transmission";

/// Material `number`. Its textures name images by their numbers in the file until those are decoded.
fn material(
    input: &mut Input,
    document: &GltfDocument,
    number: usize,
    json: &Value,
    name: String,
) -> Material {
    let place = format!("material `{name}`");
    let mut reader = Reader {
        input,
        place: &place,
    };
    reader.text(json, "name");
    let picture = |reader: &mut Reader, holder: &Value, key: &str| {
        texture(reader, document, number, holder, key)
    };
    let mut changed = 0;
    let mut unit = |value: f32| clamped(value, 0.0, 1.0, 1.0, &mut changed);
    let pbr = reader.object(json, "pbrMetallicRoughness");
    let extensions = reader.object(json, "extensions");
    let glossy = reader.object(extensions, SPECULAR_GLOSSINESS);
    let is_glossy = glossy.is_object();
    let pbr_base = reader.numbers(pbr, "baseColorFactor", [1.0; 4]);
    let base = match is_glossy {
        true => reader.numbers(glossy, "diffuseFactor", [1.0; 4]),
        false => pbr_base,
    };
    let [r, g, b, opacity] = base.map(&mut unit);
    let gloss = is_glossy.then(|| {
        let specular = reader.numbers(glossy, "specularFactor", [1.0; 3]);
        let glossiness = reader.number(glossy, "glossinessFactor", 1.0);
        (Vec3::from_array(specular.map(&mut unit)), unit(glossiness))
    });
    let transmission = reader.object(extensions, TRANSMISSION);
    let transmitted = unit(reader.number(transmission, "transmissionFactor", 0.0));
    let all_metal = reader.number(pbr, "metallicFactor", 1.0);
    let metallic = unit(all_metal) as f64;
    let roughness = unit(reader.number(pbr, "roughnessFactor", 1.0)) as f64;

    let ior = reader.object(extensions, "KHR_materials_ior");
    let ior = reader.number(ior, "ior", 1.5);
    let specular = reader.object(extensions, "KHR_materials_specular");
    let factor = unit(reader.number(specular, "specularFactor", 1.0));
    let tint = reader.numbers(specular, "specularColorFactor", [1.0; 3]);
    let tint = Vec3::from_array(tint.map(|t| clamped(t, 0.0, f32::MAX, 1.0, &mut changed)));
    let ior = clamped(ior, 0.0, f32::MAX, 1.5, &mut changed) as f64;
    // Fresnel at normal view, then KHR_materials_specular: the tint is clamped before the factor weakens it.
    let normal_view = ((ior - 1.0) / (ior + 1.0)).powi(2) as f32;
    let dielectric = (normal_view * tint).min(Vec3::ONE) * factor;
    let strength = reader.object(extensions, "KHR_materials_emissive_strength");
    let strength = reader.number(strength, "emissiveStrength", 1.0);
    let strength = clamped(strength, 0.0, f32::MAX, 1.0, &mut changed);
    let emission = Vec3::from_array(reader.numbers(json, "emissiveFactor", [0.0; 3]))
        .map(|e| clamped(e * strength, 0.0, f32::MAX, 0.0, &mut changed));
    reader.input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        changed,
        "factors out of range are clamped",
    );

    let maps = ["specularTexture", "specularColorTexture"];
    let maps = maps.iter().filter(|key| specular.get(key).is_some());
    reader.input.warn(
        WarningKind::UnreadTextures,
        place.as_str(),
        maps.count() as u64,
        "textures of KHR_materials_specular are not read",
    );
    let normal = reader.object(json, "normalTexture");
    let normal_map = picture(&mut reader, json, "normalTexture").map(|texture| NormalMap {
        texture,
        scale: Some(reader.number(normal, "scale", 1.0))
            .filter(|scale| scale.is_finite())
            .unwrap_or(1.0),
        heights: false,
    });
    let base_map = match is_glossy {
        true => picture(&mut reader, glossy, "diffuseTexture"),
        false => picture(&mut reader, pbr, "baseColorTexture"),
    };
    let cutoff = reader.number(json, "alphaCutoff", 0.5);
    let alpha_mode = reader.read(json, "alphaMode", |mode| {
        let modes = ["OPAQUE", "MASK", "BLEND"];
        modes.into_iter().find(|known| mode == known)
    });
    let alpha = match alpha_mode {
        Some("MASK") => Alpha::Mask {
            cutoff,
            factor: opacity,
            map: base_map.clone(),
        },
        Some("BLEND") => Alpha::Blend {
            factor: opacity,
            map: base_map.clone(),
        },
        _ => Alpha::Opaque,
    };
    let metallic_roughness_map = match is_glossy {
        true => None,
        false => picture(&mut reader, pbr, "metallicRoughnessTexture"),
    };
    // What the file says, whether it can be had or not.
    let says_metal = pbr.get("metallicRoughnessTexture").is_some();
    let is_metal = all_metal >= 1.0 && !says_metal && !is_glossy;
    reader.input.warn(
        WarningKind::BlackMetals,
        place.as_str(),
        is_metal.into(),
        if pbr.get("metallicFactor").is_some() {
            "all metal by its metallicFactor, so its albedo and `lambert` are black; give it a metallicFactor of 0 \
             (Metallic 0 in Blender) unless it is one"
        } else {
            "all metal, as glTF has it where no metallicFactor is given, so its albedo and `lambert` are black; give \
             it a metallicFactor of 0 (Metallic 0 in Blender) unless it is one"
        },
    );
    // What a coat reflects does not reach what it covers: that is black under a mirror, as a metal is.
    let coat = gloss.map_or(dielectric, |(specular, _)| specular);
    let is_mirror = coat.max_element() >= 1.0 && !is_metal;
    let says_coat = glossy.get("specularGlossinessTexture").is_some();
    reader.input.warn(
        WarningKind::BlackMetals,
        place.as_str(),
        u64::from(is_mirror && !says_coat),
        match (is_glossy, glossy.get("specularFactor").is_some()) {
            (true, false) => {
                "without a specularFactor it is 1, 1, 1 by KHR_materials_pbrSpecularGlossiness: a mirror, so its \
                 albedo and `lambert` are black; give it a specularFactor of 0.04, 0.04, 0.04 unless it is one"
            }
            (true, true) => {
                "a mirror by its specularFactor, which is 1 in a channel, so its albedo and `lambert` are black; \
                 give it a specularFactor of 0.04, 0.04, 0.04 unless it is one"
            }
            (false, _) => {
                "a mirror by KHR_materials_ior and KHR_materials_specular, so its albedo and `lambert` are black; \
                 give it an ior of 1.5 unless it is one"
            }
        },
    );
    let transmission = (transmitted > 0.0).then(|| Transmission {
        factor: transmitted,
        map: picture(&mut reader, transmission, "transmissionTexture"),
    });
    let [red, green, blue, _] = pbr_base;
    let [least, most] = [red.min(green).min(blue), red.max(green).max(blue)];
    let is_tinted = most - least > TINTED * most;
    reader.input.warn(
        WarningKind::GreyTransmission,
        place.as_str(),
        u64::from(is_tinted && transmission.is_some()),
        "a bake gives light of the sky that passes it no tint, but the mean of its colour in all channels; lamps \
         shine through it in colour",
    );
    // A factor of 0 keeps its texture dark.
    let emission_map = match emission == Vec3::ZERO {
        true => None,
        false => picture(&mut reader, json, "emissiveTexture"),
    };
    let double_sided = reader.is_set(json, "doubleSided");
    let base = Vec3::new(r, g, b);
    let matt = dielectric == Vec3::ZERO && metallic == 0.0 && metallic_roughness_map.is_none();
    let surface = match (gloss, phong(json).filter(|_| matt)) {
        (Some((specular, glossiness)), _) => MaterialModel::SpecularGlossiness {
            diffuse: base,
            diffuse_map: base_map,
            specular,
            glossiness: glossiness.into(),
            specular_glossiness_map: picture(&mut reader, glossy, "specularGlossinessTexture"),
        },
        (None, Some(Phong { specular, exponent })) => {
            let [albedo, specular] = conserving(input, &place, [base, specular]);
            MaterialModel::Phong {
                albedo,
                albedo_map: base_map,
                specular,
                exponent,
            }
        }
        (None, None) => MaterialModel::MetallicRoughness {
            base,
            base_map,
            metallic,
            roughness,
            metallic_roughness_map,
            dielectric,
        },
    };
    Material {
        name,
        surface,
        ambient: None,
        emission,
        emission_map,
        alpha,
        transmission,
        normal_map,
        double_sided,
    }
}

/// The texture under a key of material `material`, its image by the number in the file; `None` where there is none that
/// is read.
fn texture(
    reader: &mut Reader,
    document: &GltfDocument,
    material: usize,
    holder: &Value,
    key: &str,
) -> Option<TextureRef> {
    let info = reader.object(holder, key);
    let number = reader.index(info, "index")?;
    let instead = match key {
        "normalTexture" => NORMALS_STAND,
        _ => "the factor stands alone",
    };
    let gone = |reader: &mut Reader, what: &str| {
        let place = format!("texture {number} of material {material}");
        let problem = format!("{what} is not in the file");
        reader.input.warn_of_picture(place, &problem, instead);
    };
    let Some(texture) = document.list("textures").get(number) else {
        gone(reader, "it");
        return None;
    };
    let images = document.list("images").len();
    let own = reader.index(texture, "source");
    // The core's, else one in a format that only an extension may name and that is decoded here.
    let webp = texture.pointer("/extensions/EXT_texture_webp");
    let webp = webp.and_then(|webp| reader.index(webp, "source"));
    let Some(image) = [own, webp].into_iter().flatten().find(|&n| n < images) else {
        if own.or(webp).is_some() {
            gone(reader, "its picture");
            return None;
        }
        let message = format!(
            "a texture is in {} that is not read, {instead}; convert it to PNG",
            named_format(texture)
        );
        let place = format!("texture {number} of material {material}");
        reader
            .input
            .warn(WarningKind::UnreadTextures, place, 1, message);
        return None;
    };
    let extensions = reader.object(info, "extensions");
    let moved = reader.object(extensions, "KHR_texture_transform");
    // Counter-clockwise as the picture is seen, where v grows down: the matrix printed in the extension's text has the
    // other sign, its sample model and the engines have this one (KhronosGroup/glTF issue 1563).
    let (sin, cos) = f64::from(reader.number(moved, "rotation", 0.0)).sin_cos();
    let [sx, sy] = reader.numbers(moved, "scale", [1.0; 2]).map(f64::from);
    let [ox, oy] = reader.numbers(moved, "offset", [0.0; 2]);
    let transform = [
        [(cos * sx) as f32, (sin * sy) as f32, ox],
        [(-sin * sx) as f32, (cos * sy) as f32, oy],
    ];
    let finite = transform.iter().flatten().all(|x| x.is_finite());
    let own_set = reader.index(info, "texCoord").unwrap_or(0);
    let set = reader.index(moved, "texCoord").unwrap_or(own_set);
    let sampler = reader.index(texture, "sampler").and_then(|sampler| {
        let found = document.list("samplers").get(sampler);
        if found.is_none() {
            let problem = format!("sampler {sampler} is not in the file");
            reader.broken(problem, "the texture repeats");
        }
        found
    });
    let sampler = sampler.unwrap_or(&Value::Null);
    let mut wrap = |key| {
        let known = |mode: &Value| match mode.as_u64()? {
            33071 => Some(Wrap::Clamp),
            33648 => Some(Wrap::Mirror),
            10497 => Some(Wrap::Repeat),
            _ => None,
        };
        reader.read(sampler, key, known).unwrap_or(Wrap::Repeat)
    };
    let wrap = [wrap("wrapS"), wrap("wrapT")];
    let linear = |filter: &Value| match filter.as_u64()? {
        9728 => Some(false),
        9729 => Some(true),
        _ => None,
    };
    Some(TextureRef {
        image: image as u32,
        uv_set: u32::try_from(set).unwrap_or(u32::MAX),
        wrap,
        linear: reader.read(sampler, "magFilter", linear).unwrap_or(true),
        transform: if finite && moved.is_object() {
            transform
        } else {
            UNMOVED
        },
    })
}

/// The format in which an extension names a texture's image.
fn named_format(texture: &Value) -> &'static str {
    let extensions = texture.get("extensions");
    let has = |name: &str| extensions.is_some_and(|extensions| extensions.get(name).is_some());
    match () {
        () if has("KHR_texture_basisu") => "a format (KTX2, by KHR_texture_basisu)",
        () if has("EXT_texture_avif") => "a format (AVIF, by EXT_texture_avif)",
        () if has("MSFT_texture_dds") => "a format (DDS, by MSFT_texture_dds)",
        () => "a format",
    }
}
