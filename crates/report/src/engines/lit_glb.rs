//! The scene with its baked light as emission: any viewer of glTF shows it lit, Blender in Eevee and in Cycles, without
//! a lamp, a sky or a node set by hand.
//!
//! Materials that show a page give off the page's `lambert` and reflect nothing. Their alpha stays.

use super::mips::{fill, is_filled};
use super::scene_kind::{Picture, SceneGlb};
use super::{Engine, PageLight};
use crate::preview::{Encoding, encode};
use png::ColorType;
use serde_json::{Map, Value, json};

const SPECULAR: &str = "KHR_materials_specular";
const STRENGTH: &str = "KHR_materials_emissive_strength";

pub const LIT: SceneGlb = SceneGlb {
    suffix: "lit",
    engines: &[Engine::Gltf, Engine::Blender],
    extensions: &[SPECULAR, STRENGTH],
    picture,
    shows,
    beside: &[],
    words: [
        "radiance that leaves the surface, albedo included, as emission on TEXCOORD_1",
        "Open or import it: it is lit as it is, without lamps and sky. \
         Its light is 8-bit sRGB times emissive strength; the float lightmap is STEM.P.lightmap.exr.",
    ],
};

/// RGB, 8 bits, sRGB, divided by the largest value of the page, at least 1.
fn picture(page: &PageLight<'_>) -> Option<Picture> {
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
    Some(Picture { png, strength })
}

/// Gives off the texture and reflects nothing.
fn shows(map: &mut Map<String, Value>, _: usize, texture: u64, strength: f32) {
    map.shift_remove("normalTexture");
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
    // The highlight that ambake would read back.
    let extras = map.get_mut("extras").and_then(Value::as_object_mut);
    extras.and_then(|extras| extras.shift_remove("ambake"));
}
