//! The scene with its baked light as emission: any viewer of glTF shows it lit, Blender in Eevee and in Cycles, without a lamp, a sky
//! or a node set by hand.
//!
//! It is made from the bake's own GLB, of which only the materials change: those that show a page give off the page's `lambert` and
//! reflect nothing. Their alpha stays.

use super::PageLight;
use super::mips::{fill, is_filled};
use crate::Error;
use crate::preview::{Encoding, encode};
use png::ColorType;
use serde_json::{Map, Value, json};
use std::path::Path;

const SPECULAR: &str = "KHR_materials_specular";
const STRENGTH: &str = "KHR_materials_emissive_strength";

/// The light that leaves the surfaces of one page, as glTF holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct LitPicture {
    /// RGB, 8 bits, sRGB, divided by `strength`.
    png: Vec<u8>,
    /// Largest value of the page, at least 1.
    strength: f32,
}

impl LitPicture {
    /// The picture of a page; `None` where it has no layer `lambert`.
    pub fn of(page: &PageLight<'_>) -> Option<Self> {
        let lit = page.lit.as_ref()?;
        let texel = |i: usize| [0, 1, 2].map(|c: usize| lit[c][i].max(0.0));
        let mut pixels: Vec<[f32; 3]> = (0..page.coverage.len()).map(texel).collect();
        let filled = is_filled(&page.coverage, page.size, page.rings);
        fill(&mut pixels, page.size, &filled);
        let strength = pixels.iter().flatten().fold(1.0f32, |a, &b| a.max(b));
        let bytes: Vec<u8> = pixels
            .iter()
            .flatten()
            .map(|v| Encoding::Srgb.byte(v / strength))
            .collect();
        let png = encode([page.size; 2], ColorType::Rgb, &bytes, None);
        Some(Self { png, strength })
    }
}

/// The GLB of a bake with one picture a page as the emission of its materials.
///
/// # Errors
/// [`Error::Read`] with the name `name` where `glb` is not a GLB that ambake wrote.
pub fn lit_glb(glb: &[u8], pictures: &[LitPicture], name: &Path) -> Result<Vec<u8>, Error> {
    let broken = || Error::read(name, "it is not the GLB of this bake; bake again");
    let (mut json, mut bin) = parts(glb).ok_or_else(broken)?;
    let pages: Vec<Option<usize>> = list(&json, "textures")
        .iter()
        .map(|texture| page_of(&json, texture))
        .collect();
    let mut textures: Vec<Option<usize>> = vec![None; pictures.len()];
    let mut materials = list(&json, "materials").to_vec();
    for material in &mut materials {
        let shows = material
            .pointer("/occlusionTexture/index")
            .and_then(Value::as_u64);
        let page = shows.and_then(|texture| *pages.get(texture as usize)?);
        let Some((page, picture)) = page.and_then(|page| Some((page, pictures.get(page)?))) else {
            continue;
        };
        let texture = match textures[page] {
            Some(texture) => texture,
            None => {
                let sampler =
                    list(&json, "textures")[shows.unwrap_or(0) as usize]["sampler"].clone();
                let made = add_picture(&mut json, &mut bin, picture, sampler).ok_or_else(broken)?;
                *textures[page].insert(made)
            }
        };
        let map = material.as_object_mut().ok_or_else(broken)?;
        shine(map, texture, picture.strength);
    }
    json["materials"] = materials.into();
    if let Some(root) = json.as_object_mut() {
        let used = root.entry("extensionsUsed").or_insert_with(|| json!([]));
        for name in [SPECULAR, STRENGTH] {
            if let Some(used) = used
                .as_array_mut()
                .filter(|used| !used.contains(&name.into()))
            {
                used.push(name.into());
            }
        }
    }
    whole(&mut json, &bin).ok_or_else(broken)
}

/// Makes a material give off a texture on the lightmap's coordinates and reflect nothing.
fn shine(map: &mut Map<String, Value>, texture: usize, strength: f32) {
    for key in ["normalTexture", "occlusionTexture"] {
        map.shift_remove(key);
    }
    let pbr = map
        .entry("pbrMetallicRoughness")
        .or_insert_with(|| json!({}));
    let alpha = pbr
        .pointer("/baseColorFactor/3")
        .cloned()
        .unwrap_or(json!(1.0));
    if let Some(pbr) = pbr.as_object_mut() {
        pbr.shift_remove("metallicRoughnessTexture");
        pbr.insert("baseColorFactor".into(), json!([0.0, 0.0, 0.0, alpha]));
        pbr.insert("metallicFactor".into(), json!(0.0));
        pbr.insert("roughnessFactor".into(), json!(1.0));
    }
    map.insert("emissiveFactor".into(), json!([1.0, 1.0, 1.0]));
    let emission = json!({ "index": texture, "texCoord": 1 });
    map.insert("emissiveTexture".into(), emission);
    let extensions =
        json!({ SPECULAR: { "specularFactor": 0.0 }, STRENGTH: { "emissiveStrength": strength } });
    map.insert("extensions".into(), extensions);
}

/// Appends a picture and a texture of it, and returns the texture.
fn add_picture(
    json: &mut Value,
    bin: &mut Vec<u8>,
    picture: &LitPicture,
    sampler: Value,
) -> Option<usize> {
    let mut push = |key: &str, value: Value| {
        let list = json.get_mut(key)?.as_array_mut()?;
        list.push(value);
        Some(list.len() - 1)
    };
    let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": picture.png.len() });
    let view = push("bufferViews", view)?;
    let image = push(
        "images",
        json!({ "mimeType": "image/png", "bufferView": view }),
    )?;
    let texture = push("textures", json!({ "sampler": sampler, "source": image }))?;
    bin.extend(&picture.png);
    bin.resize(bin.len().next_multiple_of(4), 0);
    Some(texture)
}

/// The page whose occlusion a texture holds: ambake calls it `STEM.P.occlusion`.
fn page_of(json: &Value, texture: &Value) -> Option<usize> {
    let image = list(json, "images").get(texture["source"].as_u64()? as usize)?;
    let name = image["name"].as_str()?.strip_suffix(".occlusion")?;
    name.rsplit('.').next()?.parse().ok()
}

fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json[key].as_array().map_or(&[], Vec::as_slice)
}

/// JSON and BIN chunk of a GLB.
fn parts(glb: &[u8]) -> Option<(Value, Vec<u8>)> {
    let number =
        |at: usize| Some(u32::from_le_bytes(glb.get(at..at + 4)?.try_into().ok()?) as usize);
    let text_end = 20usize.checked_add(number(12)?)?;
    if !glb.starts_with(b"glTF") || glb.get(16..20)? != b"JSON" {
        return None;
    }
    let json = serde_json::from_slice(glb.get(20..text_end)?).ok()?;
    let end = (text_end + 8).checked_add(number(text_end)?)?;
    Some((json, glb.get(text_end + 8..end)?.to_vec()))
}

/// The container again; `None` past the format's 4 GiB.
fn whole(json: &mut Value, bin: &[u8]) -> Option<Vec<u8>> {
    json["buffers"][0]["byteLength"] = bin.len().into();
    let mut text = serde_json::to_vec(json).ok()?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = u32::try_from(28 + text.len() + bin.len()).ok()?;
    let mut file = b"glTF".to_vec();
    file.extend(
        [2, total, text.len() as u32]
            .iter()
            .flat_map(|n| n.to_le_bytes()),
    );
    file.extend(b"JSON");
    file.extend(text);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bin);
    Some(file)
}
