//! Materials that show a page: `occlusionTexture` lives on the material, so each is cloned for each page it is on.

use super::Reason;
use super::document::{Document, Target};
use super::places::index;
use scene::Scene;
use serde_json::{Map, Value, json};
use std::collections::{HashMap, HashSet};

const SPECULAR: &str = "KHR_materials_specular";

/// How a primitive uses a material.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Uses {
    /// Index in the file; `None` for glTF's default material.
    pub original: Option<usize>,
    /// Where the primitive's own `TEXCOORD_1` went, so that textures which read it are led there.
    pub moved: Option<u64>,
}

/// The materials of the file and the clones made so far.
pub struct Materials<'a> {
    originals: Vec<Value>,
    /// Originals whose slot is taken: by a primitive that stays as it is, or by the first clone.
    taken: HashSet<usize>,
    clones: HashMap<(Uses, u32), usize>,
    textures: HashMap<u32, usize>,
    /// One picture a page; without pictures materials keep what they have.
    occlusion: Option<&'a [Vec<u8>]>,
    stem: String,
}

impl<'a> Materials<'a> {
    /// `untouched` tells whether the primitive (mesh, primitive) of the file stays as it is.
    pub fn new(
        document: &mut Document,
        scene: &Scene,
        occlusion: Option<&'a [Vec<u8>]>,
        untouched: impl Fn(usize, usize) -> bool,
    ) -> Result<Materials<'a>, Reason> {
        let mut taken = HashSet::new();
        for (m, mesh) in document.list("meshes")?.iter_mut().enumerate() {
            let primitives = mesh.get_mut("primitives").and_then(Value::as_array_mut);
            for (p, primitive) in primitives.into_iter().flatten().enumerate() {
                if !untouched(m, p) {
                    continue;
                }
                taken.extend(index(primitive, "material"));
                if let Some(extensions) = primitive
                    .get_mut("extensions")
                    .and_then(Value::as_object_mut)
                {
                    each_variant(extensions, |material| {
                        taken.insert(material);
                        Ok(material)
                    })?;
                }
            }
        }
        let originals = document
            .json
            .get("materials")
            .and_then(Value::as_array)
            .cloned()
            .unwrap_or_default();
        let stem = scene
            .path
            .file_stem()
            .map(|s| s.to_string_lossy().into_owned())
            .unwrap_or_default();
        Ok(Materials {
            originals,
            taken,
            clones: HashMap::new(),
            textures: HashMap::new(),
            occlusion,
            stem,
        })
    }

    /// The material that is `uses.original` with the occlusion of `page`, where there are pictures. The first takes the
    /// original's own place.
    pub fn get(
        &mut self,
        document: &mut Document,
        mut uses: Uses,
        page: u32,
    ) -> Result<usize, Reason> {
        let mut material = match uses.original {
            Some(i) => self
                .originals
                .get(i)
                .ok_or_else(|| format!("material {i} is absent"))?
                .clone(),
            None => matt(),
        };
        let map = material
            .as_object_mut()
            .ok_or("a material is not an object")?;
        let page = match self.occlusion {
            Some(_) => page,
            None => 0, // all pages look alike
        };
        if self.occlusion.is_some() {
            map.shift_remove("occlusionTexture");
        }
        match uses.moved {
            Some(to) if redirect(map, to) => {}
            _ => uses.moved = None, // no texture reads the set: the clone serves other primitives as well
        }
        if let Some(&clone) = self.clones.get(&(uses, page)) {
            return Ok(clone);
        }
        if let Some(pictures) = self.occlusion {
            let texture = self.texture(document, &pictures[page as usize], page)?;
            map.insert(
                "occlusionTexture".into(),
                json!({ "index": texture, "texCoord": 1, "strength": 1.0 }),
            );
        }
        let slot = match uses.original {
            Some(i) if self.taken.insert(i) => {
                document.list("materials")?[i] = material;
                i
            }
            _ => document.push("materials", material)?,
        };
        if uses.original.is_none() {
            document.use_extension(SPECULAR)?;
        }
        self.clones.insert((uses, page), slot);
        Ok(slot)
    }

    /// The texture of a page: its picture embedded, clamped, without mip levels (gutters are made for the full size).
    fn texture(
        &mut self,
        document: &mut Document,
        picture: &[u8],
        page: u32,
    ) -> Result<usize, Reason> {
        if let Some(&texture) = self.textures.get(&page) {
            return Ok(texture);
        }
        let view = document.push_view(picture, Target::None)?;
        let name = format!("{}.{page}.occlusion", self.stem);
        let image = document.push(
            "images",
            json!({ "name": name, "mimeType": "image/png", "bufferView": view }),
        )?;
        let sampler = document.push(
            "samplers",
            json!({ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }),
        )?;
        let texture = document.push(
            "textures",
            json!({ "name": name, "sampler": sampler, "source": image }),
        )?;
        self.textures.insert(page, texture);
        Ok(texture)
    }
}

/// The material that a primitive without one gets: white and matt, as the bake takes it. glTF's own default is a rough
/// metal, which a lightmap and occlusion leave black.
fn matt() -> Value {
    json!({
        "name": "default",
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        "extensions": { SPECULAR: { "specularFactor": 0.0 } },
    })
}

/// Leads every texture of a material, or of the extensions of anything, that reads UV set 1 to the set `to`; true
/// where there was one. A texture names its set by the key `texCoord`, in the core, in any extension, and in
/// `KHR_texture_transform`, which overrides it.
pub fn redirect(map: &mut Map<String, Value>, to: u64) -> bool {
    let mut found = false;
    for (key, value) in map {
        match value {
            Value::Number(set) if key == "texCoord" && set.as_u64() == Some(1) => {
                *value = to.into();
                found = true;
            }
            Value::Object(inner) if key != "extras" => found |= redirect(inner, to),
            Value::Array(list) if key != "extras" => {
                for inner in list.iter_mut().filter_map(Value::as_object_mut) {
                    found |= redirect(inner, to);
                }
            }
            _ => {}
        }
    }
    found
}

/// Replaces each material that `KHR_materials_variants` names among a primitive's extensions.
pub fn each_variant(
    extensions: &mut Map<String, Value>,
    mut replace: impl FnMut(usize) -> Result<usize, Reason>,
) -> Result<(), Reason> {
    let mappings = extensions
        .get_mut("KHR_materials_variants")
        .and_then(|v| v.get_mut("mappings"));
    for mapping in mappings.and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(material) = index(mapping, "material") {
            mapping["material"] = replace(material)?.into();
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_in_extensions_are_led_to_the_moved_set() {
        let mut material = json!({
            "normalTexture": { "index": 0 },
            "emissiveTexture": { "index": 0, "texCoord": 1 },
            "extras": { "texCoord": 1 },
            "extensions": { "VENDOR_list": [{ "map": { "index": 0, "texCoord": 1,
                "extensions": { "KHR_texture_transform": { "texCoord": 1, "scale": [2, 2] } } } }] },
        });
        assert!(redirect(material.as_object_mut().unwrap(), 3));
        let expected = json!({
            "normalTexture": { "index": 0 },
            "emissiveTexture": { "index": 0, "texCoord": 3 },
            "extras": { "texCoord": 1 },
            "extensions": { "VENDOR_list": [{ "map": { "index": 0, "texCoord": 3,
                "extensions": { "KHR_texture_transform": { "texCoord": 3, "scale": [2, 2] } } } }] },
        });
        assert_eq!(material, expected);
        assert!(!redirect(material.as_object_mut().unwrap(), 2));
    }
}
