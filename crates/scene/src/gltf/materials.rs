//! glTF materials and the images they read.

use super::accessor::Data;
use super::phong::{Phong, phong};
use crate::image::{Failure, Pixels, TOO_LARGE, content, decode};
use crate::material::conserving;
use crate::source::{Input, Uri, short, uri};
use crate::validate::{Parts, clamped};
use crate::{
    Alpha, Error, Image, Material, NormalMap, PackedImage, Surface, TextureRef, Transmission,
    WarningKind, Wrap,
};
use glam::Vec3;
use gltf::json::material::{AlphaMode, Material as Json};
use gltf::json::texture::{Info, MagFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use rayon::prelude::*;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Converts all materials, in file order, and decodes the images that they read. The image files behind URIs go to
/// `files`, by image number.
pub(super) fn load(
    input: &mut Input,
    data: &Data,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<(), Error> {
    let numbers = images(input, data, parts, files)?;
    let packed = packed_images(input, data, parts, files)?;
    let primitives = data.root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let used: BTreeSet<usize> = primitives
        .filter_map(|primitive| primitive.material.map(|index| index.value()))
        .collect();
    for (i, json) in data.root.materials.iter().enumerate() {
        let name = json.name.clone().unwrap_or_else(|| format!("material {i}"));
        let normal_map = normal_map(input, data, json, &name, &packed)?;
        let pbr = &json.pbr_metallic_roughness;
        let is_metal = pbr.metallic_factor.0 >= 1.0
            && pbr.metallic_roughness_texture.is_none()
            && extension(json, SPECULAR_GLOSSINESS).is_none();
        // The typed material has the default in either case.
        let given =
            data.document.json["materials"][i].pointer("/pbrMetallicRoughness/metallicFactor");
        input.warn(
            WarningKind::BlackMetals,
            format!("material `{name}`"),
            u64::from(is_metal && used.contains(&i)),
            if given.is_some() {
                "all metal by its metallicFactor, so its albedo and `lambert` are black; give it a metallicFactor of 0 (Metallic 0 in \
                 Blender) unless it is one"
            } else {
                "all metal, as glTF has it where no metallicFactor is given, so its albedo and `lambert` are black; give it a metallicFactor \
                 of 0 (Metallic 0 in Blender) unless it is one"
            },
        );
        let place = format!("material `{name}`");
        let made = Material {
            normal_map,
            ..material(input, data, json, name, &numbers)
        };
        let [red, green, blue, _] = pbr.base_color_factor.0;
        let [least, most] = [red.min(green).min(blue), red.max(green).max(blue)];
        let is_tinted = most - least > TINTED * most;
        input.warn(
            WarningKind::GreyTransmission,
            place,
            u64::from(is_tinted && made.transmission.is_some() && used.contains(&i)),
            "light that passes it gets no tint: all channels pass by the mean of its colour",
        );
        parts.materials.push(made);
    }
    Ok(())
}

/// What an extension of a material holds; `None` where it has not that extension.
fn extension<'a>(json: &'a Json, name: &str) -> Option<&'a Value> {
    json.extensions.as_ref()?.others.get(name)
}

/// The texture that an extension names under a key, if it can be read as one.
fn named(extension: Option<&Value>, key: &str) -> Option<Info> {
    serde_json::from_value(extension?.get(key)?.clone()).ok()
}

/// Three or more numbers that an extension holds under a key, or `or`.
fn factors<const N: usize>(extension: &Value, key: &str, or: [f32; N]) -> [f32; N] {
    let found = extension.get(key).cloned();
    found
        .and_then(|value| serde_json::from_value::<Vec<f32>>(value).ok())
        .and_then(|values| values.try_into().ok())
        .unwrap_or(or)
}

/// A number that an extension holds under a key, or `or`.
fn factor(extension: &Value, key: &str, or: f32) -> f32 {
    let found = extension.get(key).and_then(Value::as_f64);
    found.map_or(or, |value| value as f32)
}

const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
/// Channels of a colour that differ by more than this share are a tint.
const TINTED: f32 = 0.02;

const TRANSMISSION: &str = "KHR_materials_transmission";

/// The textures of a material that are decoded: of its surface, its emission and what it lets through.
fn infos(json: &Json) -> Vec<Info> {
    let pbr = &json.pbr_metallic_roughness;
    let glossy = extension(json, SPECULAR_GLOSSINESS);
    let surface = match glossy {
        Some(_) => ["diffuseTexture", "specularGlossinessTexture"].map(|key| named(glossy, key)),
        None => [
            pbr.base_color_texture.clone(),
            pbr.metallic_roughness_texture.clone(),
        ],
    };
    // A factor of 0 keeps its texture dark.
    let shines = json.emissive_factor.0.iter().any(|e| *e > 0.0);
    let emissive = json.emissive_texture.clone().filter(|_| shines);
    let transmission = named(extension(json, TRANSMISSION), "transmissionTexture");
    surface
        .into_iter()
        .chain([emissive, transmission])
        .flatten()
        .collect()
}

fn material(
    input: &mut Input,
    data: &Data,
    json: &Json,
    name: String,
    images: &HashMap<usize, u32>,
) -> Material {
    let place = format!("material `{name}`");
    let pbr = &json.pbr_metallic_roughness;
    let mut changed = 0;
    let mut unit = |value: f32| clamped(value, 0.0, 1.0, 1.0, &mut changed);
    let glossy = extension(json, SPECULAR_GLOSSINESS);
    let base = match glossy {
        Some(glossy) => factors(glossy, "diffuseFactor", [1.0; 4]),
        None => pbr.base_color_factor.0,
    };
    let [r, g, b, opacity] = base.map(&mut unit);
    let gloss = glossy.map(|glossy| {
        let specular = factors(glossy, "specularFactor", [1.0; 3]).map(&mut unit);
        (
            Vec3::from_array(specular),
            unit(factor(glossy, "glossinessFactor", 1.0)),
        )
    });
    let transmitted = extension(json, TRANSMISSION);
    let transmitted = transmitted.map_or(0.0, |t| unit(factor(t, "transmissionFactor", 0.0)));
    let metallic = unit(pbr.metallic_factor.0) as f64;
    let roughness = unit(pbr.roughness_factor.0) as f64;

    let extensions = json.extensions.as_ref();
    let ior = extensions
        .and_then(|e| e.ior.as_ref())
        .map_or(1.5, |e| e.ior.0);
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let factor = specular.map_or(1.0, |s| unit(s.specular_factor.0));
    let tint = specular.map_or([1.0; 3], |s| s.specular_color_factor.0);
    let tint = Vec3::from_array(tint.map(|t| clamped(t, 0.0, f32::MAX, 1.0, &mut changed)));
    let ior = clamped(ior, 0.0, f32::MAX, 1.5, &mut changed) as f64;
    // Fresnel at normal view, then KHR_materials_specular: the tint is clamped before the factor weakens it.
    let normal_view = ((ior - 1.0) / (ior + 1.0)).powi(2) as f32;
    let dielectric = (normal_view * tint).min(Vec3::ONE) * factor;
    let strength = extensions
        .and_then(|e| e.others.get("KHR_materials_emissive_strength"))
        .and_then(|e| e.get("emissiveStrength"))
        .and_then(Value::as_f64)
        .map_or(1.0, |strength| {
            clamped(strength as f32, 0.0, f32::MAX, 1.0, &mut changed)
        });
    let emission = Vec3::from_array(json.emissive_factor.0)
        .map(|e| clamped(e * strength, 0.0, f32::MAX, 0.0, &mut changed));
    input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        changed,
        "factors out of range are clamped",
    );

    let maps = specular.map_or(0, |s| {
        s.specular_texture.is_some() as u64 + s.specular_color_texture.is_some() as u64
    });
    input.warn(
        WarningKind::UnreadTextures,
        place.as_str(),
        maps,
        "textures of KHR_materials_specular are not read",
    );
    input.warn(
        WarningKind::IgnoredNormalMaps,
        place.as_str(),
        json.normal_texture.is_some() as u64,
        "normalTexture is left out, the mesh's normals stand alone; --normal-maps takes it in",
    );
    let picture = |info: Option<Info>| info.and_then(|info| texture(data, &info, images));
    let base_map = match glossy {
        Some(_) => picture(named(glossy, "diffuseTexture")),
        None => picture(pbr.base_color_texture.clone()),
    };
    let alpha = match json.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => Alpha::Mask {
            cutoff: json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
            factor: opacity,
            map: base_map.clone(),
        },
        Checked::Valid(AlphaMode::Blend) => Alpha::Blend {
            factor: opacity,
            map: base_map.clone(),
        },
        _ => Alpha::Opaque,
    };
    let metallic_roughness_map = picture(pbr.metallic_roughness_texture.clone());
    let base = Vec3::new(r, g, b);
    let matt = dielectric == Vec3::ZERO && metallic == 0.0 && metallic_roughness_map.is_none();
    let surface = match (gloss, phong(json).filter(|_| matt)) {
        (Some((specular, glossiness)), _) => Surface::SpecularGlossiness {
            diffuse: base,
            diffuse_map: base_map,
            specular,
            glossiness: glossiness.into(),
            specular_glossiness_map: picture(named(glossy, "specularGlossinessTexture")),
        },
        (None, Some(Phong { specular, exponent })) => {
            let [albedo, specular] = conserving(input, &place, [base, specular]);
            Surface::Phong {
                albedo,
                albedo_map: base_map,
                specular,
                exponent,
            }
        }
        (None, None) => Surface::MetallicRoughness {
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
        emission_map: json
            .emissive_texture
            .as_ref()
            .filter(|_| emission != Vec3::ZERO)
            .and_then(|info| texture(data, info, images)),
        alpha,
        transmission: (transmitted > 0.0).then(|| Transmission {
            factor: transmitted,
            map: picture(named(extension(json, TRANSMISSION), "transmissionTexture")),
        }),
        normal_map: None,
        double_sided: json.double_sided,
    }
}

/// The normal map of a material; `None` where it has none or its image was not loaded.
fn normal_map(
    input: &Input,
    data: &Data,
    json: &Json,
    name: &str,
    images: &HashMap<usize, u32>,
) -> Result<Option<NormalMap>, Error> {
    let Some(normal) = &json.normal_texture else {
        return Ok(None);
    };
    // The parser reads the transform of every other texture; here it leaves it as JSON.
    let info = serde_json::to_value(normal).and_then(serde_json::from_value::<Info>);
    let info = info.map_err(|e| {
        let problem = format!("normalTexture: {e}; export the file again");
        input.invalid(format!("material `{}`", short(name)), problem)
    })?;
    Ok(texture(data, &info, images).map(|texture| NormalMap {
        texture,
        scale: if normal.scale.is_finite() {
            normal.scale
        } else {
            1.0
        },
        heights: false,
    }))
}

/// Reads the images of normal maps, undecoded and the same one once; returns glTF image number to packed image number.
fn packed_images(
    input: &mut Input,
    data: &Data,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<HashMap<usize, u32>, Error> {
    let mut numbers = HashMap::new();
    let mut known = HashMap::new();
    for json in &data.root.materials {
        let index = json.normal_texture.as_ref().map(|normal| normal.index);
        // A texture without a source has it in an extension, in a format that is not read.
        let source = index
            .and_then(|index| data.root.get(index))
            .map(|texture| source_of(data, texture))
            .filter(|&source| source < data.root.images.len() && !numbers.contains_key(&source));
        let Some(source) = source else {
            continue;
        };
        if let Some((name, bytes)) = encoded(input, data, source)? {
            let number = *known.entry(content(&bytes, &name)).or_insert_with(|| {
                parts.packed_images.push(PackedImage {
                    name,
                    bytes: bytes.to_vec(),
                    file: input.path.clone(),
                });
                parts.packed_images.len() as u32 - 1
            });
            numbers.insert(source, number);
            if let Cow::Owned(bytes) = bytes {
                files.insert(source, bytes);
            }
        }
    }
    Ok(numbers)
}

/// The number of a texture's image: the core's, else one in a format that only an extension may name and that is
/// decoded here.
fn source_of(data: &Data, texture: &gltf::json::Texture) -> usize {
    let own = texture.source.value();
    let webp = || {
        let others = &texture.extensions.as_ref()?.others;
        others.get("EXT_texture_webp")?.get("source")?.as_u64()
    };
    match own < data.root.images.len() {
        true => own,
        false => webp().map_or(own, |source| source as usize),
    }
}

/// The format in which an extension names a texture's image.
fn named_format(texture: &gltf::json::Texture) -> &'static str {
    let others = texture.extensions.as_ref().map(|e| &e.others);
    let has = |name: &str| others.is_some_and(|others| others.contains_key(name));
    match () {
        () if has("KHR_texture_basisu") => "a format (KTX2, by KHR_texture_basisu)",
        () if has("EXT_texture_avif") => "a format (AVIF, by EXT_texture_avif)",
        () if has("MSFT_texture_dds") => "a format (DDS, by MSFT_texture_dds)",
        () => "a format",
    }
}

/// A texture use; `None` where its image was not loaded.
fn texture(data: &Data, info: &Info, images: &HashMap<usize, u32>) -> Option<TextureRef> {
    let texture = data.root.get(info.index)?;
    let image = *images.get(&source_of(data, texture))?;
    let sampler = texture.sampler.and_then(|sampler| data.root.get(sampler));
    let wrap = |mode: Option<Checked<WrappingMode>>| match mode {
        Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::Clamp,
        Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let nearest = |s: &Sampler| matches!(s.mag_filter, Some(Checked::Valid(MagFilter::Nearest)));
    let moved = info
        .extensions
        .as_ref()
        .and_then(|e| e.texture_transform.as_ref());
    let transform = moved.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |t| {
        // Counter-clockwise as the picture is seen, where v grows down: the matrix printed in the extension's text has
        // the other sign, its sample model and the engines have this one (KhronosGroup/glTF issue 1563).
        let (sin, cos) = (t.rotation.0 as f64).sin_cos();
        let ([sx, sy], [ox, oy]) = (t.scale.0.map(f64::from), t.offset.0);
        [
            [(cos * sx) as f32, (sin * sy) as f32, ox],
            [(-sin * sx) as f32, (cos * sy) as f32, oy],
        ]
    });
    let finite = transform.iter().flatten().all(|x| x.is_finite());
    Some(TextureRef {
        image,
        uv_set: moved.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord),
        wrap: [
            wrap(sampler.map(|s| s.wrap_s)),
            wrap(sampler.map(|s| s.wrap_t)),
        ],
        linear: !sampler.is_some_and(nearest),
        transform: if finite {
            transform
        } else {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        },
    })
}

/// Decodes the images that base colours, metallic-roughness and emission read; returns glTF image number to scene image
/// number.
fn images(
    input: &mut Input,
    data: &Data,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<HashMap<usize, u32>, Error> {
    let mut wanted: Vec<(usize, Encoded)> = Vec::new();
    let mut seen = vec![false; data.root.images.len()];
    for (m, material) in data.root.materials.iter().enumerate() {
        for info in infos(material) {
            // A texture without a source has it in an extension: KTX2, AVIF or the like.
            let texture = data.root.get(info.index);
            let source = texture.map_or(usize::MAX, |texture| source_of(data, texture));
            let Some(seen) = seen.get_mut(source) else {
                let format = texture.map_or("a format", named_format);
                let message = format!(
                    "a texture is in {format} that is not read, the factor stands alone; convert it to PNG"
                );
                let place = format!("texture {} of material {m}", info.index);
                input.warn(WarningKind::UnreadTextures, place, 1, message);
                continue;
            };
            if !std::mem::replace(seen, true)
                && let Some(image) = encoded(input, data, source)?
            {
                wanted.push((source, image));
            }
        }
    }
    let (mut pictures, which) = decoded(input, &wanted)?;
    let mut known = vec![None; pictures.len()];
    let mut numbers = HashMap::new();
    for ((source, (name, bytes)), which) in wanted.into_iter().zip(which) {
        if let Cow::Owned(bytes) = bytes {
            files.insert(source, bytes);
        }
        let place = image_place(source, &name);
        match &mut pictures[which] {
            Ok(picture) => {
                let number = *known[which].get_or_insert_with(|| {
                    parts.images.push(Image {
                        name,
                        width: picture.width,
                        height: picture.height,
                        pixels: std::mem::take(&mut picture.pixels),
                    });
                    parts.images.len() as u32 - 1
                });
                numbers.insert(source, number);
            }
            Err(Failure::Unsupported(format)) => {
                input.warn(
                    WarningKind::UnreadTextures,
                    place,
                    1,
                    format!("{format} is not read; convert the image to PNG"),
                );
            }
            Err(Failure::Broken(problem)) => {
                return Err(input.invalid(
                    place,
                    format!("{}; repair or remove the image", short(problem)),
                ));
            }
            Err(Failure::TooLarge) => return Err(input.invalid(place, TOO_LARGE)),
        }
    }
    Ok(numbers)
}

/// Decodes images, the same one once; returns the pictures, and which of them each image is.
///
/// # Errors
/// Together they would take too much memory.
fn decoded(
    input: &mut Input,
    wanted: &[(usize, Encoded)],
) -> Result<(Vec<Decoded>, Vec<usize>), Error> {
    let mut known = HashMap::new();
    let (mut distinct, mut which) = (Vec::new(), Vec::with_capacity(wanted.len()));
    for (source, (name, bytes)) in wanted {
        let next = distinct.len();
        let picture = *known.entry(content(bytes, name)).or_insert(next);
        if picture == next {
            let taken = input.pictures.take(bytes, name);
            taken.map_err(|problem| input.invalid(image_place(*source, name), problem))?;
            distinct.push((bytes, name));
        }
        which.push(picture);
    }
    let pictures = distinct.par_iter();
    let pictures = pictures.map(|(bytes, name)| decode(bytes, name)).collect();
    Ok((pictures, which))
}

/// A picture, or why there is none.
type Decoded = Result<Pixels, Failure>;

/// What messages call an image.
fn image_place(number: usize, name: &str) -> String {
    format!("image {number} `{}`", short(name))
}

/// Name and file bytes of an image.
type Encoded<'a> = (String, Cow<'a, [u8]>);

/// The file of an image; `None`, with a warning, where its file is absent.
fn encoded<'a>(
    input: &mut Input,
    data: &'a Data,
    number: usize,
) -> Result<Option<Encoded<'a>>, Error> {
    let place = format!("image {number}");
    let Some(json) = data.root.images.get(number) else {
        return Ok(None);
    };
    let name = json.name.clone().unwrap_or_else(|| place.clone());
    if let Some(view) = json.buffer_view {
        let bytes = data
            .view(view)
            .map_err(|problem| input.invalid(place, problem))?
            .0;
        return Ok(Some((name, Cow::Borrowed(bytes))));
    }
    let Some(text) = &json.uri else {
        return Err(input.invalid(
            place,
            "it has neither a uri nor a bufferView; export the file again",
        ));
    };
    match uri(text).map_err(|problem| input.invalid(place.as_str(), problem))? {
        Uri::Data(bytes) => Ok(Some((name, Cow::Owned(bytes)))),
        Uri::File(file) => {
            let path = input.located(&input.path.clone(), &file);
            if !path.is_file() {
                let message = "it is absent; the factor stands alone";
                let place = format!("texture `{}`", path.display());
                input.warn(WarningKind::MissingTextures, place, 1, message);
                return Ok(None);
            }
            Ok(Some((
                json.name.clone().unwrap_or(file),
                Cow::Owned(input.read(&path, 0)?),
            )))
        }
    }
}
