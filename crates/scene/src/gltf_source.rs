//! The raw parts of a glTF file, for the writer that patches its JSON.
//!
//! [`crate::load`] turns a file into a `Scene` and forgets what it does not need. The writer must keep all of it, so it
//! asks here for the JSON as it stands, the bytes of every buffer and of every image that is not in a buffer.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A glTF file in its raw parts.
#[derive(Debug, Clone)]
pub struct GltfSource {
    /// The JSON, keys in the file's order.
    pub json: Value,
    /// The bytes of each of the JSON's `buffers`, each exactly `byteLength` long.
    pub buffers: Vec<Vec<u8>>,
    /// For each of the JSON's `images` the content behind its `uri`. `None` where it lies in a buffer view, or where
    /// its file is absent or of no known kind (the loader has counted that as a warning).
    pub images: Vec<Option<ImageSource>>,
}

/// An image file's bytes.
#[derive(Debug, Clone)]
pub struct ImageSource {
    /// Media type such as `image/png`.
    pub mime_type: String,
    /// The whole file.
    pub bytes: Vec<u8>,
}

/// A glTF file that cannot be read again.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {reason}", path.display())]
pub struct SourceError {
    /// The glTF file.
    pub path: PathBuf,
    /// What is wrong and where.
    pub reason: String,
}

/// The raw parts of the glTF or GLB file at `path`.
///
/// # Errors
/// [`SourceError`] for an absent or truncated file, text that is not JSON, or a buffer that is absent or too short.
pub fn gltf_source(path: &Path) -> Result<GltfSource, SourceError> {
    let fail = |reason: String| SourceError {
        path: path.to_owned(),
        reason,
    };
    let bytes = fs::read(path).map_err(|e| fail(e.to_string()))?;
    let (text, chunk) = if bytes.starts_with(b"glTF") {
        split_glb(&bytes).map_err(fail)?
    } else {
        (&bytes[..], None)
    };
    let json: Value =
        serde_json::from_slice(text).map_err(|e| fail(format!("its JSON is damaged: {e}")))?;
    let base = path.parent().unwrap_or(Path::new(""));
    let entries = |key: &str| {
        json.get(key)
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice)
    };
    let mut buffers = Vec::new();
    for (i, buffer) in entries("buffers").iter().enumerate() {
        let uri = buffer.get("uri").and_then(Value::as_str);
        let mut data = match (uri, chunk) {
            (Some(uri), _) => {
                fetch(base, uri)
                    .map_err(|e| fail(format!("buffer {i}: {e}")))?
                    .1
            }
            (None, Some(chunk)) if i == 0 => chunk.to_vec(),
            (None, _) => return Err(fail(format!("buffer {i} has no uri"))),
        };
        let length = buffer
            .get("byteLength")
            .and_then(Value::as_u64)
            .unwrap_or(0);
        if (data.len() as u64) < length {
            return Err(fail(format!(
                "buffer {i} holds {} bytes of {length}",
                data.len()
            )));
        }
        data.truncate(length as usize);
        buffers.push(data);
    }
    let image = |image: &Value| {
        let (declared, bytes) = fetch(base, image.get("uri")?.as_str()?).ok()?;
        let own = image
            .get("mimeType")
            .and_then(Value::as_str)
            .map(String::from);
        let mime_type = own
            .or_else(|| sniff(&bytes).map(String::from))
            .or(declared)?;
        Some(ImageSource { mime_type, bytes })
    };
    let images = entries("images").iter().map(image).collect();
    Ok(GltfSource {
        json,
        buffers,
        images,
    })
}

/// JSON and BIN chunk of a GLB file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let chunk = |at: usize, kind: u32| -> Result<Option<&[u8]>, String> {
        let (Some(length), Some(found)) = (word(at), word(at + 4)) else {
            return Ok(None);
        };
        if found != kind {
            return Ok(None);
        }
        let start = at + 8;
        let data = bytes.get(start..start + length as usize);
        data.map(Some)
            .ok_or_else(|| format!("it ends within the chunk at byte {at}"))
    };
    const JSON: u32 = 0x4E4F_534A;
    const BIN: u32 = 0x004E_4942;
    let text = chunk(12, JSON)?.ok_or("it has no JSON chunk")?;
    let next = 20 + text.len().next_multiple_of(4);
    Ok((text, chunk(next, BIN)?))
}

/// Media type (of a data URI) and content behind a URI relative to `base`.
fn fetch(base: &Path, uri: &str) -> Result<(Option<String>, Vec<u8>), String> {
    let Some(data) = uri.strip_prefix("data:") else {
        let path = base.join(String::from_utf8_lossy(&percent_decode(uri)).as_ref());
        return fs::read(&path)
            .map(|bytes| (None, bytes))
            .map_err(|e| format!("{}: {e}", path.display()));
    };
    let (head, body) = data.split_once(',').ok_or("its data URI has no comma")?;
    let mime = head
        .split(';')
        .next()
        .filter(|mime| !mime.is_empty())
        .map(String::from);
    if !head.ends_with(";base64") {
        return Ok((mime, percent_decode(body)));
    }
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let bytes = GeneralPurpose::new(&STANDARD, config)
        .decode(body)
        .map_err(|e| format!("its data URI: {e}"))?;
    Ok((mime, bytes))
}

/// `text` with every `%20` and its like turned into the byte it stands for.
fn percent_decode(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let pair = bytes
            .get(at + 1..at + 3)
            .and_then(|hex| std::str::from_utf8(hex).ok());
        match pair
            .filter(|_| bytes[at] == b'%')
            .and_then(|hex| u8::from_str_radix(hex, 16).ok())
        {
            Some(byte) => {
                out.push(byte);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    out
}

/// Media type by the first bytes.
fn sniff(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        [b'D', b'D', b'S', b' ', ..] => Some("image/vnd-ms.dds"),
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => Some("image/webp"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_decoded() {
        assert_eq!(percent_decode("a%20b%2Fc%zz%"), b"a b/c%zz%");
        let (mime, bytes) = fetch(Path::new(""), "data:image/png;base64,AAEC").unwrap();
        assert_eq!(
            (mime.as_deref(), bytes.as_slice()),
            (Some("image/png"), &[0, 1, 2][..])
        );
        assert_eq!(fetch(Path::new(""), "data:;base64,AAE").unwrap().1, [0, 1]);
        assert_eq!(fetch(Path::new(""), "data:,a%20b").unwrap().1, b"a b");
    }

    #[test]
    fn a_cut_glb_is_an_error() {
        let mut glb = b"glTF\x02\0\0\0\x1c\0\0\0\x08\0\0\0JSON{}      ".to_vec();
        assert_eq!(split_glb(&glb).unwrap(), (&b"{}      "[..], None));
        glb.truncate(24);
        assert!(split_glb(&glb).is_err());
    }
}
