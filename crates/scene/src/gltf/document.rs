//! The glTF document behind a scene, with everything in it that the scene does not use: a writer patches it and loses
//! nothing, whatever has become of the file meanwhile.

use super::root::unsupported;
use crate::Error;
use crate::source::{Input, Uri, beside, file, media_type, uri};
use gltf::json::Root;
use serde_json::Value;
use std::collections::BTreeMap;

/// A glTF file in its raw parts. They are as [`crate::load`] read them; the file is not opened again.
#[derive(Debug, Clone)]
pub struct GltfDocument {
    /// The JSON, keys in the file's order. A data URI whose content stands in `buffers` or `images` ends after its
    /// comma, so that no byte is held twice.
    pub json: Value,
    /// The bytes of each of the JSON's `buffers`, each exactly `byteLength` long.
    pub buffers: Vec<Vec<u8>>,
    /// For each of the JSON's `images` the content behind its `uri`. `None` where it lies in a buffer view, or where
    /// its file is absent or of no known kind.
    pub images: Vec<Option<EncodedImage>>,
}

/// An image file's bytes, not decoded.
#[derive(Debug, Clone)]
pub struct EncodedImage {
    /// Media type such as `image/png`.
    pub mime_type: String,
    /// The whole file.
    pub bytes: Vec<u8>,
}

impl GltfDocument {
    /// The document with its buffers read, without its images. `bin` is the binary chunk of a GLB file.
    ///
    /// # Errors
    /// A buffer is absent or shorter than the JSON says.
    pub(super) fn open(
        input: &mut Input,
        root: &Root,
        mut json: Value,
        mut bin: Option<Vec<u8>>,
    ) -> Result<GltfDocument, Error> {
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (i, buffer) in root.buffers.iter().enumerate() {
            let place = format!("buffer {i}");
            let mut bytes = match &buffer.uri {
                Some(text) => {
                    match uri(text).map_err(|problem| input.invalid(place.as_str(), problem))? {
                        Uri::Data(bytes) => bytes,
                        Uri::File(name) => input.read(&beside(&input.path, &name))?,
                    }
                }
                None => match bin.take().filter(|_| i == 0) {
                    Some(bin) => bin,
                    None => return Err(no_content(input, root, place)),
                },
            };
            let announced = buffer.byte_length.0;
            if (bytes.len() as u64) < announced {
                let problem = format!(
                    "{announced} bytes are announced, {} are there; the file is truncated, copy or export it again",
                    bytes.len()
                );
                return Err(input.invalid(place, problem));
            }
            bytes.truncate(announced as usize);
            bytes.shrink_to_fit();
            buffers.push(bytes);
        }
        entries(&mut json, "buffers").for_each(cut_data_uri);
        Ok(GltfDocument {
            json,
            buffers,
            images: Vec::new(),
        })
    }

    /// Takes up the image files behind the JSON's URIs. `read` holds those that materials have read, by image number.
    /// The others have no influence on a bake, so they are not part of its hash, and one that cannot be read stays a
    /// URI.
    pub(super) fn take_images(&mut self, input: &mut Input, mut read: BTreeMap<usize, Vec<u8>>) {
        let image = |(i, image): (usize, &mut Value)| {
            let text = image.get("uri")?.as_str()?;
            let bytes = match read.remove(&i) {
                Some(bytes) => bytes,
                None => match uri(text).ok()? {
                    Uri::Data(bytes) => bytes,
                    Uri::File(name) => {
                        let path = beside(&input.path, &name);
                        let bytes = file(&path).ok()?;
                        input.files.push(path);
                        bytes
                    }
                },
            };
            let own = image.get("mimeType").and_then(Value::as_str);
            let mime_type = own.or_else(|| sniff(&bytes)).or_else(|| media_type(text))?;
            let mime_type = mime_type.to_owned();
            cut_data_uri(image);
            Some(EncodedImage { mime_type, bytes })
        };
        self.images = entries(&mut self.json, "images")
            .enumerate()
            .map(image)
            .collect();
    }
}

/// The error for a buffer that names no content.
fn no_content(input: &Input, root: &Root, place: String) -> Error {
    let packed = |name: &&String| name.ends_with("_meshopt_compression");
    match root.extensions_used.iter().find(packed) {
        Some(name) => unsupported(input, name),
        None => input.invalid(
            place,
            "it has neither a uri nor a binary chunk; export the file again",
        ),
    }
}

/// The elements of a top-level array.
fn entries<'a>(json: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    let list = json.get_mut(key).and_then(Value::as_array_mut);
    list.into_iter().flatten()
}

/// Cuts the data URI of a buffer or image off after its comma.
fn cut_data_uri(entry: &mut Value) {
    if let Some(Value::String(text)) = entry.get_mut("uri")
        && text.starts_with("data:")
        && let Some(comma) = text.find(',')
    {
        text.truncate(comma + 1);
        text.shrink_to_fit();
    }
}

/// Media type by the first bytes.
fn sniff(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        [b'D', b'D', b'S', b' ', ..] => Some("image/vnd-ms.dds"),
        _ if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Some("image/webp"),
        _ => None,
    }
}
