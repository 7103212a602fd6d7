//! GLB files that carry the scene with its light, so that a reader of glTF shows it without a step by hand.
//!
//! They are made from the bake's own GLB, of which only the materials change: in each, the picture of the occlusion
//! gives its place to one of light, and the materials that showed the one show the other.

use super::container::{list, parts, whole};
use super::godot::GODOT;
use super::lightmap_glb::LIGHTMAP;
use super::lit_glb::LIT;
use super::scene_kind::{Picture, SceneGlb};
use super::{Engine, LightmapReport, PageLight};
use super::{instanced, orm_glb};
use crate::{Error, Output};
use serde_json::{Map, Value, json};
use std::path::Path;

const KINDS: [&SceneGlb; 3] = [&LIT, &LIGHTMAP, &GODOT];

/// The pictures of a bake's pages for the files that its engines get.
#[derive(Default)]
pub struct ScenePictures {
    of: Vec<(&'static SceneGlb, Vec<Picture>)>,
    /// Those of the scene's GLB in another form that the engines want.
    forms: Vec<&'static Form>,
}

/// The scene's GLB in another form, without light.
struct Form {
    suffix: &'static str,
    engines: &'static [Engine],
    /// `None` where the scene has nothing that would be other.
    made: fn(&[u8]) -> Option<Vec<u8>>,
    words: [&'static str; 2],
}

const FORMS: [Form; 2] = [
    Form {
        suffix: "orm",
        engines: &orm_glb::ENGINES,
        made: orm_glb::packed,
        words: orm_glb::WORDS,
    },
    Form {
        suffix: "instanced",
        engines: &instanced::ENGINES,
        made: instanced::instanced,
        words: instanced::WORDS,
    },
];

/// The names of the files that `engines` get.
pub fn scene_files(stem: &str, engines: &[Engine]) -> Vec<String> {
    let kinds = kinds(engines).flat_map(|kind| {
        let beside = kind
            .beside
            .iter()
            .map(|beside| format!("{stem}.{}", beside.ending));
        std::iter::once(kind.file(stem)).chain(beside)
    });
    let forms = forms(engines).map(|form| file(stem, form.suffix));
    kinds.chain(forms).collect()
}

impl ScenePictures {
    /// Of no page as yet.
    pub fn new(engines: &[Engine]) -> Self {
        let of = kinds(engines).map(|kind| (kind, Vec::new()));
        Self {
            of: of.collect(),
            forms: forms(engines).collect(),
        }
    }

    /// Adds those of a page; pages come in order. A kind for which the page lacks a layer is not made.
    pub fn add(&mut self, page: &PageLight<'_>) {
        self.of.retain_mut(|(kind, pictures)| {
            let made = (kind.picture)(page);
            pictures.extend(made);
            pictures.len() == page.page as usize + 1
        });
    }

    /// True where no file needs the scene's GLB.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty() && self.forms.is_empty()
    }

    /// Stages the files, made from the scene's GLB, and returns what `bake.json` says of them.
    ///
    /// # Errors
    /// `glb` is not one that ambake wrote, or a file cannot be staged.
    pub fn stage(
        &self,
        output: &mut Output,
        stem: &str,
        glb: &[u8],
        engines: &[Engine],
    ) -> Result<Vec<LightmapReport>, Error> {
        let mut entries = Vec::new();
        let path = output.dir().join(format!("{stem}.glb"));
        for (kind, pictures) in &self.of {
            output.stage_bytes(&kind.file(stem), &repaint(glb, pictures, kind, &path)?)?;
            for beside in kind.beside {
                let name = format!("{stem}.{}", beside.ending);
                output.stage_bytes(&name, (beside.text)(stem).as_bytes())?;
            }
            let wanting = engines.iter().filter(|e| kind.engines.contains(e));
            entries.extend(wanting.map(|engine| entry(*engine, kind.file(stem), kind.words)));
        }
        for form in &self.forms {
            let Some(made) = (form.made)(glb) else {
                continue;
            };
            let name = file(stem, form.suffix);
            output.stage_bytes(&name, &made)?;
            let wanting = engines.iter().filter(|e| form.engines.contains(e));
            entries.extend(wanting.map(|engine| entry(*engine, name.clone(), form.words)));
        }
        Ok(entries)
    }
}

fn forms(engines: &[Engine]) -> impl Iterator<Item = &'static Form> {
    let wanted = |form: &&Form| form.engines.iter().any(|engine| engines.contains(engine));
    FORMS.iter().filter(wanted)
}

fn file(stem: &str, suffix: &str) -> String {
    format!("{stem}.{suffix}.glb")
}

/// What `bake.json` says of a file that an engine loads as it is.
fn entry(engine: Engine, file: String, words: [&str; 2]) -> LightmapReport {
    let [unit, how] = words.map(str::to_owned);
    LightmapReport {
        engine: engine.name().into(),
        file,
        compression: None,
        unit,
        scale: 1.0,
        how,
    }
}

impl SceneGlb {
    fn file(&self, stem: &str) -> String {
        file(stem, self.suffix)
    }
}

fn kinds(engines: &[Engine]) -> impl Iterator<Item = &'static SceneGlb> {
    KINDS
        .into_iter()
        .filter(|kind| kind.engines.iter().any(|engine| engines.contains(engine)))
}

/// The GLB of a bake with one picture a page in place of the occlusion.
///
/// # Errors
/// [`Error::Read`] with the name `name` where `glb` is not a GLB that ambake wrote.
fn repaint(
    glb: &[u8],
    pictures: &[Picture],
    kind: &SceneGlb,
    name: &Path,
) -> Result<Vec<u8>, Error> {
    let broken = || Error::read(name, "it is not the GLB of this bake; bake again");
    let (mut json, mut bin) = parts(glb).ok_or_else(broken)?;
    let pages: Vec<Option<usize>> = list(&json, "textures").iter().map(page_of).collect();
    for (texture, page) in pages.iter().enumerate() {
        let Some(picture) = page.and_then(|page| pictures.get(page)) else {
            continue;
        };
        let image = replace(&mut json, &mut bin, texture, &picture.png).ok_or_else(broken)?;
        for (key, i) in [("textures", texture), ("images", image)] {
            let named = json[key].get_mut(i).ok_or_else(broken)?;
            let stem = named["name"].as_str().unwrap_or_default();
            let stem = stem.strip_suffix(OCCLUSION).unwrap_or(stem);
            named["name"] = format!("{stem}{}", kind.suffix).into();
        }
    }
    for material in json["materials"].as_array_mut().into_iter().flatten() {
        let shows = material
            .pointer("/occlusionTexture/index")
            .and_then(Value::as_u64);
        let page = shows.and_then(|texture| *pages.get(texture as usize)?);
        let picture = page.and_then(|page| Some((page, pictures.get(page)?)));
        if let (Some(texture), Some((page, picture))) = (shows, picture) {
            let map = material.as_object_mut().ok_or_else(broken)?;
            map.shift_remove("occlusionTexture");
            (kind.shows)(map, page, texture, picture.strength);
        }
    }
    let root = json.as_object_mut().ok_or_else(broken)?;
    for name in kind.extensions {
        let used = root.entry("extensionsUsed").or_insert_with(|| json!([]));
        let used = used.as_array_mut().filter(|u| !u.contains(&json!(name)));
        used.into_iter().for_each(|used| used.push(json!(name)));
    }
    whole(&mut json, &bin).ok_or_else(broken)
}

const OCCLUSION: &str = "occlusion";

/// The page whose occlusion a texture holds: ambake calls it `STEM.P.occlusion`.
fn page_of(texture: &Value) -> Option<usize> {
    let name = texture["name"].as_str()?.strip_suffix(OCCLUSION)?;
    name.strip_suffix('.')?.rsplit('.').next()?.parse().ok()
}

/// Puts a picture in the place of a texture's, whose bytes leave the buffer, and returns the image.
fn replace(json: &mut Value, bin: &mut Vec<u8>, texture: usize, png: &[u8]) -> Option<usize> {
    let source = list(json, "textures").get(texture)?["source"].as_u64()?;
    let image = list(json, "images").get(source as usize)?;
    let own = image["bufferView"].as_u64()? as usize;
    let number = |key: &str| list(json, "bufferViews").get(own)?[key].as_u64();
    let (at, length) = (number("byteOffset")?, number("byteLength")?);
    let end = u64::min(
        at.checked_add(length)?.next_multiple_of(4),
        bin.len() as u64,
    );
    bin.drain(usize::try_from(at).ok().filter(|at| *at < end as usize)?..end as usize);
    for view in json["bufferViews"].as_array_mut()? {
        // An extension that compresses a view has a place of its own.
        let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
        let inner = extensions.into_iter().flat_map(Map::values_mut);
        inner.for_each(|place| move_back(place, end, end - at));
        move_back(view, end, end - at);
    }
    json["bufferViews"][own]["byteOffset"] = bin.len().into();
    json["bufferViews"][own]["byteLength"] = png.len().into();
    bin.extend(png);
    bin.resize(bin.len().next_multiple_of(4), 0);
    Some(source as usize)
}

/// Moves what stands in buffer 0 from `end` on toward the start.
fn move_back(place: &mut Value, end: u64, by: u64) {
    let Some(offset) = place["byteOffset"].as_u64().filter(|offset| *offset >= end) else {
        return;
    };
    if place["buffer"] == 0 {
        place["byteOffset"] = (offset - by).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_takes_the_place_of_another_and_all_else_keeps_its_bytes() {
        let mut json = json!({
            "buffers": [{ "byteLength": 20 }],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 4 },
                { "buffer": 0, "byteOffset": 4, "byteLength": 5 },
                { "buffer": 1, "byteOffset": 12, "byteLength": 8,
                  "extensions": { "EXT_meshopt_compression": { "buffer": 0, "byteOffset": 16, "byteLength": 4 } } },
                { "buffer": 0, "byteOffset": 12, "byteLength": 4 },
            ],
            "images": [{ "name": "a.room.0.occlusion", "bufferView": 1 }],
            "textures": [{ "name": "a.room.0.occlusion", "source": 0 }],
            "materials": [
                { "occlusionTexture": { "index": 0, "texCoord": 1 } },
                { "name": "unlit" },
            ],
        });
        let bin: Vec<u8> = (0..20).collect();
        let glb = whole(&mut json, &bin).expect("a container");
        let picture = Picture {
            png: vec![200; 9],
            strength: 2.0,
        };
        let made = repaint(&glb, &[picture], &LIGHTMAP, Path::new("a.glb")).expect("a GLB");
        let (json, bin) = parts(&made).expect("a GLB");
        let expected: Vec<u8> = [
            &[0, 1, 2, 3][..],
            &[12, 13, 14, 15, 16, 17, 18, 19],
            &[200; 9],
        ]
        .concat();
        assert_eq!(bin[..21], expected);
        let places = ["/1/byteOffset", "/2/byteOffset", "/3/byteOffset"]
            .map(|place| json["bufferViews"].pointer(place).and_then(Value::as_u64));
        assert_eq!(places, [Some(12), Some(12), Some(4)]);
        let inner = &json["bufferViews"][2]["extensions"]["EXT_meshopt_compression"];
        assert_eq!(inner["byteOffset"], 8);
        assert_eq!(json["buffers"][0]["byteLength"], 24);
        assert_eq!(json["images"][0]["name"], "a.room.0.lightmap");
        let material = json["materials"][0].clone();
        assert!(material.get("occlusionTexture").is_none());
        let moz = &material["extensions"]["MOZ_lightmap"];
        assert_eq!((&moz["index"], &moz["texCoord"]), (&json!(0), &json!(1)));
        assert!((moz["intensity"].as_f64().unwrap() - std::f64::consts::TAU).abs() < 1e-6);
        assert_eq!(json["materials"][1], json!({ "name": "unlit" }));
        assert_eq!(json["extensionsUsed"], json!(["MOZ_lightmap"]));
        assert!(repaint(b"glTF", &[], &LIGHTMAP, Path::new("a.glb")).is_err());
    }
}
