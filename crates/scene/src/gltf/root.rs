//! The JSON of a glTF file, typed and validated: what is refused before anything is read from it.

use super::conformance;
use crate::Error;
use crate::source::{Input, short};
use gltf::json::accessor::Accessor;
use gltf::json::validation::{Error as Finding, Validate};
use gltf::json::{Path as JsonPath, Root};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

/// The properties of glTF that are integers, and lists of them.
#[rustfmt::skip]
const INTEGERS: &[&str] = &[
    "buffer", "bufferView", "byteLength", "byteOffset", "byteStride", "camera", "children", "componentType", "count", "index", "indices",
    "input", "inverseBindMatrices", "joints", "light", "magFilter", "material", "mesh", "minFilter", "mode", "node", "nodes", "output",
    "sampler", "scene", "skeleton", "skin", "source", "target", "texCoord", "wrapS", "wrapT",
];

/// Brings integers that are written as `1.0` or `10e-1`, which JSON does not tell apart, to one form.
pub(super) fn write_integers_as_such(json: &mut Value) {
    match json {
        Value::Array(items) => items.iter_mut().for_each(write_integers_as_such),
        Value::Object(fields) => {
            for (key, value) in fields.iter_mut().filter(|(key, _)| *key != "extras") {
                match value {
                    Value::Object(attributes) if key == "attributes" => {
                        attributes.values_mut().for_each(as_integer)
                    }
                    Value::Number(_) if INTEGERS.contains(&key.as_str()) => as_integer(value),
                    Value::Array(items) if INTEGERS.contains(&key.as_str()) => {
                        items.iter_mut().for_each(as_integer)
                    }
                    _ => {}
                }
                write_integers_as_such(value);
            }
        }
        _ => {}
    }
}

fn as_integer(value: &mut Value) {
    /// Up to here every integer is a 64-bit float.
    const MOST: f64 = 9_007_199_254_740_992.0;
    let float = value.as_f64().filter(|_| value.is_f64());
    if let Some(float) = float.filter(|f| f.fract() == 0.0 && (0.0..=MOST).contains(f)) {
        *value = (float as u64).into();
    }
}

/// The typed and validated document: of each element what a bake reads. Nothing else can have a file refused:
/// animations, cameras, skins and other scenes may be as they like.
pub(super) fn parsed(input: &Input, json: &Value) -> Result<Root, Error> {
    let version = json.pointer("/asset/version").and_then(Value::as_str);
    let version = version.ok_or_else(|| {
        let problem = "its `asset` names no version of glTF; export the file again";
        input.invalid("JSON", problem)
    })?;
    if !version.starts_with("2.") {
        return Err(old(input, &short(version)));
    }
    let view = ["buffer", "byteLength", "extensions"];
    let image = ["bufferView", "mimeType", "name", "uri"];
    let node = [
        "children",
        "extensions",
        "matrix",
        "mesh",
        "name",
        "rotation",
        "scale",
        "translation",
    ];
    let mut root = Root {
        accessors: unread_accessors(list(input, json, "accessors")?.len()),
        buffer_views: typed(input, json, "bufferViews", |item| picked(item, &view))?,
        buffers: typed(input, json, "buffers", |item| {
            picked(item, &["byteLength", "uri"])
        })?,
        images: typed(input, json, "images", |item| picked(item, &image))?,
        materials: typed(input, json, "materials", |item| {
            without(item, "occlusionTexture")
        })?,
        meshes: typed(input, json, "meshes", mesh)?,
        nodes: typed(input, json, "nodes", |item| picked(item, &node))?,
        samplers: typed(input, json, "samplers", |item| without(item, "minFilter"))?,
        textures: typed(input, json, "textures", Value::clone)?,
        extensions_required: typed(input, json, "extensionsRequired", Value::clone)?,
        ..Root::default()
    };
    root.asset.version = version.into();
    if let Some(name) = root
        .extensions_required
        .iter()
        .find(|name| !conformance::is_supported(name))
    {
        return Err(unsupported(input, name));
    }
    // The crate's own validation indexes with POSITION before it has looked at the range.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(bad) = primitive
                .attributes
                .values()
                .find(|index| index.value() >= root.accessors.len())
            {
                let problem = format!(
                    "accessor {bad} of {}; the file is corrupt",
                    root.accessors.len()
                );
                return Err(input.invalid(format!("mesh {m} primitive {p}"), problem));
            }
        }
    }
    let mut findings = Vec::new();
    root.validate(&root, JsonPath::new, &mut |path, finding| {
        let path = path().to_string();
        // Bounds of POSITION are not used. Accessors without a view, primitives without POSITION and required
        // extensions are judged elsewhere.
        let others = ["min", "max", "bufferView", "[\"POSITION\"]"];
        let other = others.iter().any(|end| path.ends_with(end));
        let elsewhere = matches!(finding, Finding::Missing | Finding::Invalid) && other;
        if !elsewhere && !matches!(finding, Finding::Unsupported) {
            findings.push(format!("{path}: {}", finding.to_string().to_lowercase()));
        }
    });
    match findings.as_slice() {
        [] => Ok(root),
        [first] => Err(input.invalid("JSON", format!("{first}; export the file again"))),
        [first, rest @ ..] => Err(input.invalid(
            "JSON",
            format!("{first} (and {} more); export the file again", rest.len()),
        )),
    }
}

/// A list of the document, empty where there is none.
fn list<'a>(input: &Input, json: &'a Value, key: &str) -> Result<&'a [Value], Error> {
    match json.get(key) {
        None => Ok(&[]),
        Some(Value::Array(items)) => Ok(items),
        Some(_) => Err(input.invalid("JSON", format!("`{key}` is no list; export the file again"))),
    }
}

/// The elements of a list, each typed from what `read` takes of it.
fn typed<T: DeserializeOwned>(
    input: &Input,
    json: &Value,
    key: &str,
    read: impl Fn(&Value) -> Value,
) -> Result<Vec<T>, Error> {
    let item = |(i, item): (usize, &Value)| {
        serde_json::from_value(read(item)).map_err(|e| {
            let problem = format!("{}; export the file again", short(&e.to_string()));
            input.invalid(format!("{key} {i}"), problem)
        })
    };
    list(input, json, key)?
        .iter()
        .enumerate()
        .map(item)
        .collect()
}

/// An object with some of its fields; anything else as it is.
fn filtered(item: &Value, keep: impl Fn(&str) -> bool) -> Value {
    let Value::Object(fields) = item else {
        return item.clone();
    };
    let kept = fields.iter().filter(|(key, _)| keep(key));
    Value::Object(Map::from_iter(kept.map(|(k, v)| (k.clone(), v.clone()))))
}

fn picked(item: &Value, keys: &[&str]) -> Value {
    filtered(item, |key| keys.contains(&key))
}

fn without(item: &Value, unread: &str) -> Value {
    filtered(item, |key| key != unread)
}

/// A mesh with the attributes that are read, and of each morph target that it is there.
fn mesh(item: &Value) -> Value {
    let mut mesh = picked(item, &["name", "primitives"]);
    for primitive in mesh["primitives"].as_array_mut().into_iter().flatten() {
        if let Some(attributes) = primitive.get_mut("attributes") {
            *attributes = filtered(attributes, is_read);
        }
        if let Some(Value::Array(targets)) = primitive.get_mut("targets") {
            targets.fill(json!({}));
        }
    }
    mesh
}

fn is_read(attribute: &str) -> bool {
    let set = attribute.strip_prefix("TEXCOORD_");
    matches!(attribute, "POSITION" | "NORMAL" | "TANGENT" | "COLOR_0")
        || set.is_some_and(|set| set.parse::<u32>().is_ok())
}

/// As many accessors as the document has, so that references to them can be checked. What is in them is judged where
/// one is opened.
fn unread_accessors(count: usize) -> Vec<Accessor> {
    let any = json!({ "componentType": 5126, "count": 1, "type": "SCALAR" });
    serde_json::from_value(any).map_or_else(|_| Vec::new(), |any: Accessor| vec![any; count])
}

fn old(input: &Input, version: &str) -> Error {
    let problem = format!(
        "glTF version {version} is not read; convert it to 2.0 with `npx gltf-pipeline -i IN -o OUT`"
    );
    input.invalid("JSON", problem)
}

/// The error for an extension that this loader cannot do without and does not implement.
fn unsupported(input: &Input, extension: &str) -> Error {
    Error::Extension {
        path: input.path.clone(),
        extension: short(extension),
    }
}
