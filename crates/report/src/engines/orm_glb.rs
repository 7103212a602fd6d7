//! The scene with occlusion, roughness and metalness in one picture (red, green, blue), as game engines keep them:
//! `STEM.orm.glb`.
//!
//! glTF reads both textures of a material at coordinates of their own. They can be one where these are the same, which
//! they are where a bake keeps a file's coordinates. Materials of which that is not true keep two textures.

use super::Engine;
use super::container::{list, parts, whole};
use image::imageops::{FilterType, resize};
use image::{GrayImage, Luma, Rgb, RgbImage};
use png::ColorType;
use scene::GltfDocument;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The engines that get the file, where a material can be packed.
pub const ENGINES: [Engine; 3] = [Engine::Gltf, Engine::Godot, Engine::Unreal];

/// Unit and use, as `bake.json` says them.
pub const WORDS: [&str; 2] = [
    "no light: STEM.glb with occlusion (red), roughness (green) and metalness (blue) in one texture of each material \
     that allows it",
    "Import it in place of STEM.glb. Materials whose metallicRoughnessTexture is read at other coordinates keep two \
     textures.",
];

/// The GLB of a bake with packed textures; `None` where no material can be packed, or `glb` is not one that ambake
/// wrote.
pub fn packed(glb: &[u8]) -> Option<Vec<u8>> {
    let (json, bin) = parts(glb)?;
    let mut document = GltfDocument {
        json,
        buffers: vec![bin],
        absent: Vec::new(),
        images: Vec::new(),
    };
    let mut made: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for m in 0..list(&document.json, "materials").len() {
        let Some(pair) = pair(&document, m) else {
            continue;
        };
        let texture = match made.get(&pair) {
            Some(&texture) => texture,
            None => {
                let Some(texture) = pack(&mut document, pair) else {
                    continue;
                };
                made.insert(pair, texture);
                texture
            }
        };
        let material = &mut document.json["materials"][m];
        material["occlusionTexture"]["index"] = texture.into();
        let surface = &mut material["pbrMetallicRoughness"]["metallicRoughnessTexture"];
        surface["index"] = texture.into();
        surface["texCoord"] = 1.into();
    }
    let bin = document.buffers.remove(0);
    (!made.is_empty()).then(|| whole(&mut document.json, &bin))?
}

/// The textures of occlusion and of metalness and roughness of a material that reads both at the same coordinates.
fn pair(document: &GltfDocument, material: usize) -> Option<[usize; 2]> {
    let json = &list(&document.json, "materials")[material];
    let occlusion = json.get("occlusionTexture")?;
    let surface = json.pointer("/pbrMetallicRoughness/metallicRoughnessTexture")?;
    let plain = occlusion["texCoord"] == 1 && surface.get("extensions").is_none();
    let set = format!("TEXCOORD_{}", surface["texCoord"].as_u64().unwrap_or(0));
    let meshes = list(&document.json, "meshes").iter();
    let primitives = meshes.flat_map(|mesh| list(mesh, "primitives"));
    let mut shown = primitives.filter(|p| p["material"].as_u64() == Some(material as u64));
    let same = |primitive: &Value| {
        let accessor = |set: &str| Some(primitive["attributes"][set].as_u64()? as usize);
        accessor(&set)
            .zip(accessor("TEXCOORD_1"))
            .is_some_and(|(own, lightmap)| agree(document, own, lightmap))
    };
    let index = |texture: &Value| Some(texture["index"].as_u64()? as usize);
    let pair = [index(occlusion)?, index(surface)?];
    (plain && shown.all(same)).then_some(pair)
}

/// Whether two accessors hold the same coordinates, but for their rounding.
fn agree(document: &GltfDocument, a: usize, b: usize) -> bool {
    if a == b {
        return true;
    }
    let (Ok(a), Ok(b)) = (document.accessor(a), document.accessor(b)) else {
        return false;
    };
    let near = |i: usize| {
        let both = a.numbers::<2>(i).zip(b.numbers::<2>(i));
        // 1e-5 is a tenth of a texel of a page of 8192.
        both.is_some_and(|(a, b)| (0..2).all(|k| (a[k] - b[k]).abs() <= 1e-5))
    };
    a.count == b.count && (0..a.count).all(near)
}

/// Adds one picture of two, as large as the larger, and returns its texture.
fn pack(document: &mut GltfDocument, [occlusion, surface]: [usize; 2]) -> Option<usize> {
    let open: GrayImage = {
        let picture = picture(document, occlusion)?;
        let (width, height) = picture.dimensions();
        // Red alone: a grey made of all three would be weighed anew.
        GrayImage::from_fn(width, height, |x, y| Luma([picture[(x, y)].0[0]]))
    };
    let surface = picture(document, surface)?;
    let [width, height] = [
        open.width().max(surface.width()),
        open.height().max(surface.height()),
    ];
    // Bilinear between the middles of texels, as a sampler would; a picture of that size already stays as it is.
    let open = match open.dimensions() == (width, height) {
        true => open,
        false => resize(&open, width, height, FilterType::Triangle),
    };
    let surface = match surface.dimensions() == (width, height) {
        true => surface,
        false => resize(&surface, width, height, FilterType::Triangle),
    };
    let packed = RgbImage::from_fn(width, height, |x, y| {
        let [_, roughness, metalness] = surface[(x, y)].0;
        Rgb([open[(x, y)].0[0], roughness, metalness])
    });
    let png = crate::preview::encode([width, height], ColorType::Rgb, &packed, None);
    let bin = &mut document.buffers[0];
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": png.len() });
    bin.extend(png);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let json = &mut document.json;
    let view = push(json, "bufferViews", view)?;
    let of_occlusion = json["textures"][occlusion].clone();
    let name = of_occlusion["name"].as_str().unwrap_or_default();
    let name = name.strip_suffix("occlusion").unwrap_or(name);
    let name = format!("{name}orm.{view}");
    let image = json!({ "name": name, "mimeType": "image/png", "bufferView": view });
    let image = push(json, "images", image)?;
    // Clamped and without mip levels, as the occlusion: gutters are made for the full size.
    let sampler = of_occlusion["sampler"].clone();
    let texture = json!({ "name": name, "sampler": sampler, "source": image });
    push(json, "textures", texture)
}

/// The picture of a texture, decoded.
fn picture(document: &GltfDocument, texture: usize) -> Option<RgbImage> {
    let source = list(&document.json, "textures").get(texture)?["source"].as_u64()? as usize;
    let view = list(&document.json, "images").get(source)?["bufferView"].as_u64()? as usize;
    let view = list(&document.json, "bufferViews").get(view)?;
    let number = |key: &str| view[key].as_u64().map(|n| n as usize);
    let from = number("byteOffset").unwrap_or(0);
    let bytes = document.buffers[0].get(from..from.checked_add(number("byteLength")?)?)?;
    let read = scene::picture(bytes)?;
    let values = read.pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
    RgbImage::from_raw(read.width, read.height, values.collect())
}

/// Appends to a top-level array and returns the index.
fn push(json: &mut Value, key: &str, value: Value) -> Option<usize> {
    let list = json[key].as_array_mut()?;
    list.push(value);
    Some(list.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::encode;

    /// A GLB of one material whose surface texture has 2 x 2 texels and whose occlusion has one, read at the same
    /// accessor.
    fn glb(edit: impl Fn(&mut Value)) -> Vec<u8> {
        let occlusion = encode([1, 1], ColorType::Rgb, &[51; 3], None);
        let surface = [9, 10, 20, 9, 30, 40, 9, 50, 60, 9, 70, 80];
        let surface = encode([2, 2], ColorType::Rgb, &surface, None);
        let mut bin: Vec<u8> = [0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0]
            .map(f32::to_le_bytes)
            .concat();
        bin.extend(
            [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.9]
                .map(f32::to_le_bytes)
                .concat(),
        );
        let from = bin.len();
        bin.extend(&occlusion);
        bin.extend(&surface);
        let mut json = json!({
            "asset": { "version": "2.0" },
            "buffers": [{}],
            "bufferViews": [
                { "buffer": 0, "byteLength": 24 },
                { "buffer": 0, "byteOffset": 24, "byteLength": 24 },
                { "buffer": 0, "byteOffset": from, "byteLength": occlusion.len() },
                { "buffer": 0, "byteOffset": from + occlusion.len(), "byteLength": surface.len() },
            ],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2" },
                { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
            ],
            "images": [{ "bufferView": 2 }, { "bufferView": 3 }],
            "samplers": [{}],
            "textures": [{ "name": "a.0.occlusion", "source": 0, "sampler": 0 }, { "source": 1 }],
            "materials": [{
                "occlusionTexture": { "index": 0, "texCoord": 1, "strength": 1.0 },
                "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 } },
            }],
            "meshes": [{ "primitives": [{ "material": 0, "attributes": { "TEXCOORD_0": 0, "TEXCOORD_1": 0 } }] }],
        });
        edit(&mut json);
        whole(&mut json, &bin).expect("a container")
    }

    #[test]
    fn one_picture_holds_occlusion_and_the_materials_own_roughness_and_metalness() {
        let made = packed(&glb(|_| ())).expect("the coordinates are the same");
        let (json, bin) = parts(&made).expect("a GLB");
        assert_eq!(bin.len() % 4, 0, "the format wants whole words");
        let material = &json["materials"][0];
        assert_eq!(
            material["occlusionTexture"],
            json!({ "index": 2, "texCoord": 1, "strength": 1.0 })
        );
        let surface = &material["pbrMetallicRoughness"]["metallicRoughnessTexture"];
        assert_eq!(*surface, json!({ "index": 2, "texCoord": 1 }));
        assert_eq!(json["textures"][2]["sampler"], 0);
        let document = GltfDocument {
            json,
            buffers: vec![bin],
            absent: Vec::new(),
            images: Vec::new(),
        };
        let picture = picture(&document, 2).expect("a picture");
        assert_eq!(
            picture.into_raw(),
            [51, 10, 20, 51, 30, 40, 51, 50, 60, 51, 70, 80]
        );
    }

    #[test]
    fn other_coordinates_and_transforms_keep_two_textures() {
        let attributes = "/meshes/0/primitives/0/attributes";
        let surface = "/materials/0/pbrMetallicRoughness/metallicRoughnessTexture";
        let set = |place: &'static str, key: &'static str, value: Value| {
            move |json: &mut Value| {
                json.pointer_mut(place).expect("it is there")[key] = value.clone()
            }
        };
        assert_eq!(packed(&glb(set(attributes, "TEXCOORD_1", json!(1)))), None);
        let transform = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
        assert_eq!(packed(&glb(set(surface, "extensions", transform))), None);
        assert_eq!(packed(&glb(set(surface, "index", json!(7)))), None);
        assert_eq!(packed(b"glTF"), None);
        // The lightmap's own set is the same by its name.
        let own = set(surface, "texCoord", json!(1));
        assert!(packed(&glb(own)).is_some());
    }
}
