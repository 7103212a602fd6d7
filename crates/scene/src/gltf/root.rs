//! The JSON of a glTF file before anything is read from it: what it requires, and its outer shape.
//!
//! Nothing else is judged here. What a bake reads is judged where it is read; the rest may be as it likes.

use super::conformance;
use crate::input::{Input, short};
use crate::{Error, WarningKind};
use serde_json::{Value, json};

/// The properties of glTF that are integers, and lists of them.
#[rustfmt::skip]
const INTEGERS: &[&str] = &[
    "buffer", "bufferView", "byteLength", "byteOffset", "byteStride", "camera", "children", "componentType", "count",
    "index", "indices", "input", "inverseBindMatrices", "joints", "light", "magFilter", "material", "mesh", "minFilter",
    "mode", "node", "nodes", "output", "sampler", "scene", "skeleton", "skin", "source", "target", "texCoord",
    "wrapS", "wrapT",
];

/// The lists of a document whose elements are objects.
const LISTS: &[&str] = &[
    "accessors",
    "animations",
    "bufferViews",
    "buffers",
    "cameras",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scenes",
    "skins",
    "textures",
];

/// What a reference in a list of the document names, by the list and the key. Only core properties: an extension may
/// mean something else by the same word.
const REFERENCES: &[(&str, &str, &str)] = &[
    ("accessors", "bufferView", "bufferViews"),
    ("animations", "input", "accessors"),
    ("animations", "node", "nodes"),
    ("animations", "output", "accessors"),
    ("images", "bufferView", "bufferViews"),
    ("materials", "index", "textures"),
    ("meshes", "attributes", "accessors"),
    ("meshes", "indices", "accessors"),
    ("meshes", "material", "materials"),
    ("meshes", "targets", "accessors"),
    ("nodes", "camera", "cameras"),
    ("nodes", "children", "nodes"),
    ("nodes", "mesh", "meshes"),
    ("nodes", "skin", "skins"),
    ("scenes", "nodes", "nodes"),
    ("skins", "inverseBindMatrices", "accessors"),
    ("skins", "skeleton", "nodes"),
    ("textures", "sampler", "samplers"),
    ("textures", "source", "images"),
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

/// Judges the version and the required extensions.
pub(super) fn check(input: &Input, json: &Value) -> Result<(), Error> {
    let version = json.pointer("/asset/version").and_then(Value::as_str);
    let version = version.ok_or_else(|| {
        let problem = "its `asset` names no version of glTF; write `\"asset\": {\"version\": \"2.0\"}` if it is one \
                       of glTF 2";
        input.invalid("JSON", problem)
    })?;
    if !version.starts_with("2.") {
        return Err(old(input, &short(version)));
    }
    let required = json.get("extensionsRequired").and_then(Value::as_array);
    let mut required = required.into_iter().flatten().filter_map(Value::as_str);
    match required.find(|name| !conformance::is_supported(name)) {
        Some(name) => Err(unsupported(input, name)),
        None => Ok(()),
    }
}

/// Takes out lists that are none, and empties elements that are no objects: nothing can be read from them.
pub(super) fn make_lists(input: &mut Input, json: &mut Value) {
    let Some(root) = json.as_object_mut() else {
        return;
    };
    let mut broken = |place: &str| {
        let message = "it is not what the format has there and counts as absent";
        input.warn(WarningKind::BrokenParts, place, 1, message);
    };
    let names = ["extensionsRequired", "extensionsUsed"];
    for &key in LISTS.iter().chain(&names) {
        match root.get_mut(key) {
            None => {}
            Some(Value::Array(items)) if LISTS.contains(&key) => {
                for (i, item) in items
                    .iter_mut()
                    .enumerate()
                    .filter(|(_, item)| !item.is_object())
                {
                    broken(&format!("{key} {i}"));
                    *item = json!({});
                }
            }
            Some(Value::Array(_)) => {}
            Some(_) => {
                broken(&format!("`{key}`"));
                root.shift_remove(key);
            }
        }
    }
}

/// Takes out references to what is not there, which nothing that is baked can have: what a writer appends would be
/// taken for it.
pub(super) fn drop_dangling(json: &mut Value) {
    for &(list, key, named) in REFERENCES {
        let count = json
            .get(named)
            .and_then(Value::as_array)
            .map_or(0, Vec::len) as u64;
        if let Some(list) = json.get_mut(list) {
            drop_beyond(list, key, count);
        }
    }
}

/// Takes out the references under `key` to elements from `count` on. False where `value` is of no use without one: a
/// texture's use, and a variant's material.
fn drop_beyond(value: &mut Value, key: &str, count: u64) -> bool {
    let mut of_use = true;
    match value {
        Value::Array(items) => items.retain_mut(|item| drop_beyond(item, key, count)),
        Value::Object(fields) => {
            let is_variant = fields.contains_key("variants");
            fields.retain(|name, value| match name.as_str() {
                "extras" | "KHR_draco_mesh_compression" => true,
                name if name != key => drop_beyond(value, key, count),
                _ => {
                    let stays = keeps(value, count);
                    of_use &= stays || !(key == "index" || is_variant);
                    stays
                }
            });
        }
        _ => {}
    }
    of_use
}

/// Whether a reference is to an element before `count`; those of a list or of a map are judged one by one.
fn keeps(value: &mut Value, count: u64) -> bool {
    match value {
        Value::Array(items) => items.retain_mut(|item| keeps(item, count)),
        Value::Object(fields) => fields.retain(|_, value| keeps(value, count)),
        other => return other.as_u64().is_none_or(|number| number < count),
    }
    true
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
