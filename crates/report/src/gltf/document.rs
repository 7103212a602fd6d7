//! A glTF document in memory: JSON values, the bytes behind them, and the GLB container.

use super::Reason;
use super::prune::pruned;
use base64::Engine;
use scene::{Elements, GltfDocument};
use serde_json::{Map, Value, json};
use std::io;

/// A document whose buffer 0 grows: new data stands behind what the file holds, until [`Document::prune`] takes out
/// what nothing names.
pub struct Document<'a> {
    pub json: Value,
    /// The file's; `None` where there is none.
    source: Option<&'a GltfDocument>,
    /// What is appended to buffer 0.
    added: Vec<u8>,
    /// The appended bytes are all that the document has: no buffer of the file has content.
    is_whole: bool,
}

/// What a buffer view is for, as its `target`.
#[derive(Clone, Copy)]
pub enum Target {
    None,
    /// Vertex attributes with this stride in bytes.
    Vertices(usize),
    Indices,
}

impl<'a> Document<'a> {
    /// The document of a file, with every image moved into buffer 0.
    pub fn of(source: &'a GltfDocument) -> Result<Document<'a>, Reason> {
        let mut document = Document::new(source.json.clone(), Some(source))?;
        for (i, image) in source.images.iter().enumerate() {
            let Some(image) = image else { continue };
            let view = document.push_view(&image.bytes, Target::None)?;
            let entry = document.entry("images", i)?;
            entry.shift_remove("uri");
            entry.insert("bufferView".into(), view.into());
            entry.insert("mimeType".into(), image.mime_type.as_str().into());
        }
        Ok(document)
    }

    /// A document without a file. `json` names no buffer.
    pub fn empty(json: Value) -> Result<Document<'a>, Reason> {
        Document::new(json, None)
    }

    fn new(json: Value, source: Option<&'a GltfDocument>) -> Result<Document<'a>, Reason> {
        let mut document = Document {
            json,
            source,
            added: Vec::new(),
            is_whole: false,
        };
        if document.buffers().is_empty() {
            document.list("buffers")?.push(json!({ "byteLength": 0 }));
        }
        Ok(document)
    }

    /// The file's buffers.
    fn buffers(&self) -> &'a [Vec<u8>] {
        match self.is_whole {
            true => &[],
            false => self.source.map_or(&[], |source| &source.buffers),
        }
    }

    /// Takes out what nothing names any more, where all that names something is known. Accessors of the file are not
    /// to be opened any more.
    pub fn prune(&mut self) {
        self.align();
        let start = self.buffers().first().map_or(&[][..], Vec::as_slice);
        let first = [start, &self.added].concat();
        let further = self.buffers().iter().skip(1).map(Vec::as_slice);
        let buffers: Vec<&[u8]> = std::iter::once(&first[..]).chain(further).collect();
        if let Some((json, bytes)) = pruned(&self.json, &buffers) {
            (self.json, self.added, self.is_whole) = (json, bytes, true);
        }
    }

    /// An accessor of the file, opened. One that was appended here is not read back.
    pub fn original(&self, accessor: usize) -> Result<Elements<'a>, Reason> {
        let source = self.source.ok_or("the scene came from no glTF file")?;
        source.accessor(accessor)
    }

    /// A top-level array, made where it is absent.
    pub fn list(&mut self, key: &str) -> Result<&mut Vec<Value>, Reason> {
        let root = self
            .json
            .as_object_mut()
            .ok_or("its JSON is not an object")?;
        let list = root.entry(key).or_insert_with(|| json!([]));
        list.as_array_mut()
            .ok_or_else(|| format!("{key} is not an array"))
    }

    /// An element of a top-level array.
    pub fn get(&self, key: &str, index: usize) -> Result<&Value, Reason> {
        self.json
            .get(key)
            .and_then(|list| list.get(index))
            .ok_or_else(|| format!("{key} {index} is absent"))
    }

    /// An element of a top-level array, to be changed.
    pub fn entry(&mut self, key: &str, index: usize) -> Result<&mut Map<String, Value>, Reason> {
        let entry = self
            .list(key)?
            .get_mut(index)
            .and_then(Value::as_object_mut);
        entry.ok_or_else(|| format!("{key} {index} is absent"))
    }

    /// Appends to a top-level array and returns the index.
    pub fn push(&mut self, key: &str, value: Value) -> Result<usize, Reason> {
        let list = self.list(key)?;
        list.push(value);
        Ok(list.len() - 1)
    }

    /// Appends `bytes` to buffer 0 behind a new buffer view, and returns the view's index.
    pub fn push_view(&mut self, bytes: &[u8], target: Target) -> Result<usize, Reason> {
        let offset = self.align();
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        match target {
            Target::None => {}
            Target::Vertices(stride) => {
                view["byteStride"] = stride.into();
                view["target"] = 34962.into();
            }
            Target::Indices => view["target"] = 34963.into(),
        }
        self.added.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Fills buffer 0 with zeros up to a multiple of four, and returns its length.
    fn align(&mut self) -> usize {
        let start = self.buffers().first().map_or(0, Vec::len);
        let length = (start + self.added.len()).next_multiple_of(4);
        self.added.resize(length - start, 0);
        length
    }

    /// Appends triangle indices in the smallest type that holds `vertices`, and returns the accessor.
    pub fn push_indices(
        &mut self,
        triangles: &[[u32; 3]],
        vertices: usize,
    ) -> Result<usize, Reason> {
        let flat = triangles.as_flattened();
        // 65535 itself is the restart value, so 65535 vertices (up to index 65534) are the most for 16 bits.
        let (bytes, kind): (Vec<u8>, u32) = if vertices <= 65_535 {
            (
                flat.iter()
                    .flat_map(|&i| (i as u16).to_le_bytes())
                    .collect(),
                5123,
            )
        } else {
            (flat.iter().flat_map(|i| i.to_le_bytes()).collect(), 5125)
        };
        let view = self.push_view(&bytes, Target::Indices)?;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": kind, "count": flat.len(), "type": "SCALAR" }),
        )
    }

    /// Appends float vectors of `N` components as a vertex attribute, and returns the accessor.
    pub fn push_floats<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        bounds: bool,
    ) -> Result<usize, Reason> {
        let bytes: Vec<u8> = values
            .as_flattened()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = self.push_view(&bytes, Target::Vertices(4 * N))?;
        let mut accessor = json!({
            "bufferView": view, "componentType": 5126, "count": values.len(), "type": format!("VEC{N}"),
        });
        if bounds {
            let fold = |f: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
                (0..N)
                    .map(|c| values.iter().map(|v| v[c]).fold(start, f))
                    .collect()
            };
            accessor["min"] = fold(f32::min, f32::INFINITY).into();
            accessor["max"] = fold(f32::max, f32::NEG_INFINITY).into();
        }
        self.push("accessors", accessor)
    }

    /// Lists an extension among those that the document uses, once.
    pub fn use_extension(&mut self, name: &str) -> Result<(), Reason> {
        let listed = self.json["extensionsUsed"].as_array();
        if !listed.is_some_and(|names| names.iter().any(|known| known == name)) {
            self.push("extensionsUsed", name.into())?;
        }
        Ok(())
    }

    /// Takes `name` off the lists of used and required extensions where no object holds it any more.
    pub fn drop_unused_extension(&mut self, name: &str) {
        fn holds(value: &Value, name: &str) -> bool {
            match value {
                Value::Array(list) => list.iter().any(|v| holds(v, name)),
                Value::Object(map) => {
                    map.get("extensions").is_some_and(|e| e.get(name).is_some())
                        || map.values().any(|v| holds(v, name))
                }
                _ => false,
            }
        }
        if holds(&self.json, name) {
            return;
        }
        let Some(root) = self.json.as_object_mut() else {
            return;
        };
        for key in ["extensionsUsed", "extensionsRequired"] {
            let Some(list) = root.get_mut(key).and_then(Value::as_array_mut) else {
                continue;
            };
            list.retain(|entry| entry != name);
            if list.is_empty() {
                root.shift_remove(key);
            }
        }
    }

    /// The container: buffer 0 as BIN chunk, further buffers as data URIs.
    pub fn into_glb(mut self) -> io::Result<Vec<u8>> {
        let length = self.align();
        let buffer = &mut self.json["buffers"][0];
        buffer["byteLength"] = length.into();
        if let Some(buffer) = buffer.as_object_mut() {
            buffer.shift_remove("uri");
        }
        let start = self.buffers().first().map_or(&[][..], Vec::as_slice);
        let has_content = |(_, bytes): &(usize, &Vec<u8>)| !bytes.is_empty();
        for (i, bytes) in self
            .buffers()
            .iter()
            .enumerate()
            .skip(1)
            .filter(has_content)
        {
            let text = base64::engine::general_purpose::STANDARD.encode(bytes);
            let uri = format!("data:application/octet-stream;base64,{text}");
            self.json["buffers"][i]["uri"] = uri.into();
        }
        let mut text = serde_json::to_vec(&self.json)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + length;
        let Ok(total) = u32::try_from(total) else {
            let message = format!("a GLB of {total} bytes is over the format's 4 GiB");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        };
        let mut file = Vec::with_capacity(total as usize);
        file.extend_from_slice(b"glTF");
        for word in [2, total, text.len() as u32] {
            file.extend_from_slice(&word.to_le_bytes());
        }
        file.extend_from_slice(b"JSON");
        file.extend_from_slice(&text);
        file.extend_from_slice(&(length as u32).to_le_bytes());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(start);
        file.extend_from_slice(&self.added);
        Ok(file)
    }
}
