//! How the glTF document behind a scene is read.

use super::accessor::{number, shown};
use crate::input::{Input, short};
use crate::source::{Uri, uri};
use crate::{EncodedImage, Error, GltfDocument};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashSet};

impl GltfDocument {
    /// The document with its buffers read, without its images. `bin` is the binary chunk of a GLB file. A buffer that
    /// only holds the place of compressed views is empty, and so is one whose content cannot be had: only what reads it
    /// fails.
    ///
    /// # Errors
    /// A buffer lies where the scene may not have files read.
    pub(super) fn open(
        input: &mut Input,
        mut json: Value,
        mut bin: Option<Vec<u8>>,
    ) -> Result<GltfDocument, Error> {
        let (mut buffers, mut absent) = (Vec::new(), Vec::new());
        let listed = json.get("buffers").and_then(Value::as_array);
        for (i, buffer) in listed.into_iter().flatten().enumerate() {
            let has_uri = buffer.get("uri").is_some();
            let chunk = bin.take().filter(|_| i == 0 && !has_uri);
            let (bytes, reason) = match content(input, buffer, chunk) {
                Ok(bytes) => (bytes, None),
                Err(error @ Error::Outside { .. }) => return Err(error),
                Err(_) if !has_uri && holds_a_place(&json, i) => (Vec::new(), None),
                Err(Error::Invalid { path, problem, .. }) if path == input.path => {
                    (Vec::new(), Some(format!("buffer {i}: {problem}")))
                }
                Err(error) => (Vec::new(), Some(format!("buffer {i}: {error}"))),
            };
            buffers.push(bytes);
            absent.push(reason);
        }
        let read = entries(&mut json, "buffers").zip(&absent);
        read.filter(|(_, absent)| absent.is_none())
            .for_each(|(buffer, _)| cut_data_uri(buffer));
        if let Some(reason) = absent.first_mut().and_then(Option::take) {
            move_first_buffer(&mut json);
            buffers.push(Vec::new());
            absent.push(Some(reason));
        }
        Ok(GltfDocument {
            json,
            buffers,
            absent,
            images: Vec::new(),
        })
    }

    /// Takes up the image files behind the JSON's URIs. `read` holds those that materials have read, by image number.
    /// The others have no influence on a bake, so they are not part of its hash, and one that cannot be read stays a
    /// URI. So does what is no picture, whatever the JSON calls it: a scene must not carry other files away.
    ///
    /// # Errors
    /// A picture lies where the scene may not have files read.
    pub(super) fn take_images(
        &mut self,
        input: &mut Input,
        mut read: BTreeMap<usize, Vec<u8>>,
    ) -> Result<(), Error> {
        let used = used_images(&self.json);
        let mut image = |(i, image): (usize, &mut Value)| -> Result<_, Error> {
            let content = image.get("uri").and_then(Value::as_str).map(uri);
            let bytes = match (read.remove(&i), content) {
                (Some(bytes), _) | (None, Some(Ok(Uri::Data(bytes)))) => bytes,
                (None, Some(Ok(Uri::File(name)))) if used.contains(&i) => {
                    let path = input.located(&input.path.clone(), &name);
                    match input.read_unhashed(&path, 0) {
                        Ok(bytes) => {
                            input.files.push(path);
                            bytes
                        }
                        Err(error @ Error::Outside { .. }) => return Err(error),
                        Err(_) => return Ok(None),
                    }
                }
                _ => return Ok(None),
            };
            Ok(sniff(&bytes).map(|mime_type| {
                cut_data_uri(image);
                let mime_type = mime_type.to_owned();
                EncodedImage { mime_type, bytes }
            }))
        };
        let images = entries(&mut self.json, "images").enumerate();
        self.images = images.map(&mut image).collect::<Result<_, _>>()?;
        Ok(())
    }
}

/// The bytes of a buffer, of which `chunk` are those of a GLB file.
fn content(input: &mut Input, buffer: &Value, chunk: Option<Vec<u8>>) -> Result<Vec<u8>, Error> {
    let invalid = |input: &Input, problem: String| input.invalid("buffer", problem);
    let announced = buffer.get("byteLength").and_then(Value::as_u64);
    let announced = announced.ok_or_else(|| {
        let said = shown(buffer, "byteLength");
        let problem = format!("its byteLength is {said}, and must be the number of its bytes");
        invalid(input, problem)
    })?;
    let mut bytes = match (buffer.get("uri"), chunk) {
        (Some(text), _) => match uri_of(text).map_err(|problem| invalid(input, problem))? {
            Uri::Data(bytes) => bytes,
            Uri::File(name) => {
                let path = input.located(&input.path.clone(), &name);
                input.read(&path, announced)?
            }
        },
        (None, Some(chunk)) => chunk,
        (None, None) => {
            let problem = "it has neither a uri nor a binary chunk; its uri must name the file that holds its bytes";
            return Err(invalid(input, problem.into()));
        }
    };
    if (bytes.len() as u64) < announced {
        let there = bytes.len();
        let problem = format!(
            "{announced} bytes are announced, {there} are there; the file is truncated, copy or export it again"
        );
        return Err(invalid(input, problem));
    }
    bytes.truncate(announced as usize);
    bytes.shrink_to_fit();
    Ok(bytes)
}

/// Puts an empty buffer before all others, for bytes that are laid behind the first one, and what was there last.
fn move_first_buffer(json: &mut Value) {
    let Some(buffers) = json.get_mut("buffers").and_then(Value::as_array_mut) else {
        return;
    };
    let last = buffers.len();
    buffers.push(json!({ "byteLength": 0 }));
    buffers.swap(0, last);
    renumber(json, |buffer| if buffer == 0 { last } else { buffer });
}

/// Gives the buffers that views and their extensions name new numbers.
pub(super) fn renumber(json: &mut Value, to: impl Fn(usize) -> usize) {
    let one = |named: &mut Value| {
        if let Some(buffer) = number(named, "buffer") {
            named["buffer"] = to(buffer).into();
        }
    };
    for view in entries(json, "bufferViews") {
        one(view);
        let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
        let extensions = extensions.into_iter().flatten();
        extensions.for_each(|(_, extension)| one(extension));
    }
}

/// What the value of a `uri` points at.
///
/// # Errors
/// A sentence.
pub(super) fn uri_of(value: &Value) -> Result<Uri, String> {
    let text = value.as_str().ok_or_else(|| {
        let said = short(&value.to_string());
        format!("its uri is {said}, and must be the name of a file or a data URI, in quotes")
    });
    uri(text?)
}

/// Whether a buffer has no content of its own, because all views of it are compressed by meshopt.
fn holds_a_place(json: &Value, buffer: usize) -> bool {
    let packed = |view: &Value| {
        let extensions = view.get("extensions").and_then(Value::as_object);
        let mut names = extensions.into_iter().flat_map(|e| e.keys());
        names.any(|name| name.ends_with("_meshopt_compression"))
    };
    let views = json.get("bufferViews").and_then(Value::as_array);
    let mut views = views.into_iter().flatten();
    views.any(|view| number(view, "buffer") == Some(buffer) && packed(view))
}

/// The images that a texture, an extension of one, or an extension of the whole document names.
fn used_images(json: &Value) -> HashSet<usize> {
    fn numbers(value: &Value, found: &mut HashSet<usize>) {
        match value {
            Value::Number(number) => found.extend(number.as_u64().map(|n| n as usize)),
            Value::Array(list) => list.iter().for_each(|v| numbers(v, found)),
            Value::Object(map) => map.values().for_each(|v| numbers(v, found)),
            _ => {}
        }
    }
    let mut used = HashSet::new();
    for texture in json
        .get("textures")
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
    {
        for key in ["source", "extensions"] {
            numbers(texture.get(key).unwrap_or(&Value::Null), &mut used);
        }
    }
    let of_document = json.get("extensions").unwrap_or(&Value::Null);
    numbers(
        of_document
            .get("EXT_lights_image_based")
            .unwrap_or(&Value::Null),
        &mut used,
    );
    used
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
        // The length of its second header, and one plane.
        [b'B', b'M', ..]
            if matches!(
                bytes.get(14..28),
                Some([12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0, .., 1, 0])
            ) =>
        {
            Some("image/bmp")
        }
        _ if bytes.get(4..12) == Some(b"ftypavif") => Some("image/avif"),
        _ if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Some("image/webp"),
        _ => None,
    }
}
