//! What both decoders do to a document: read the bytes that something names, lay decoded ones down, take extensions
//! away.

use crate::GltfDocument;
use crate::gltf::accessor::number;
use serde_json::{Value, json};

impl GltfDocument {
    /// Which buffers only hold the place of compressed views.
    pub(super) fn placeholders(&self) -> Vec<bool> {
        let is_one = |(i, json): (usize, &Value)| {
            let announced = number(json, "byteLength") != Some(0);
            announced && self.buffers[i].is_empty() && !matches!(self.absent.get(i), Some(Some(_)))
        };
        list(&self.json, "buffers")
            .iter()
            .enumerate()
            .map(is_one)
            .collect()
    }

    /// Lays bytes behind the first buffer, from a multiple of four on, and returns where.
    pub(super) fn append(&mut self, bytes: &[u8]) -> usize {
        if self.buffers.is_empty() {
            self.buffers.push(Vec::new());
            self.json["buffers"] = json!([{}]);
        }
        let buffer = &mut self.buffers[0];
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let start = buffer.len();
        buffer.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = buffer.len().into();
        start
    }

    /// Why what an object with `buffer` names cannot be decoded: its buffer is not there, or else a `problem` of what
    /// the buffer holds.
    pub(super) fn loss(&self, json: Option<&Value>, problem: &str) -> String {
        let buffer = json.and_then(|json| number(json, "buffer"));
        match buffer.and_then(|buffer| self.absent.get(buffer)) {
            Some(Some(reason)) => reason.clone(),
            _ => format!("{problem}; the file is corrupt, export it again"),
        }
    }

    /// Adds a buffer of which the content cannot be had, for a reason: only what reads it fails.
    pub(super) fn append_absent(&mut self, reason: String) -> usize {
        // What is decoded lies behind the first.
        self.append(&[]);
        self.absent.resize(self.buffers.len(), None);
        self.absent.push(Some(reason));
        self.buffers.push(Vec::new());
        if let Some(buffers) = self.json["buffers"].as_array_mut() {
            buffers.push(json!({ "byteLength": 1 }));
        }
        self.buffers.len() - 1
    }

    /// The bytes that an object with `buffer`, `byteOffset` and `byteLength` names.
    pub(super) fn named_bytes(&self, json: &Value) -> Option<&[u8]> {
        let from = number(json, "byteOffset").unwrap_or(0);
        let to = from.checked_add(number(json, "byteLength")?)?;
        self.buffers.get(number(json, "buffer")?)?.get(from..to)
    }

    /// Takes a name out of the lists of used and of required extensions.
    pub(super) fn forget_extension(&mut self, name: &str) {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let Some(names) = self.json.get_mut(key).and_then(Value::as_array_mut) else {
                continue;
            };
            names.retain(|other| other != name);
            if names.is_empty()
                && let Some(json) = self.json.as_object_mut()
            {
                json.shift_remove(key);
            }
        }
    }
}

/// The elements of an array under `key`; none where there is no such array.
pub(super) fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key)
        .and_then(Value::as_array)
        .map_or(&[], Vec::as_slice)
}

/// Takes an extension from a JSON object, and the object of extensions where it was the last.
pub(super) fn take_extension(json: &mut Value, name: &str) -> Option<Value> {
    let extensions = json.get_mut("extensions")?.as_object_mut()?;
    let taken = extensions.shift_remove(name);
    if extensions.is_empty()
        && let Some(json) = json.as_object_mut()
    {
        json.shift_remove("extensions");
    }
    taken
}
