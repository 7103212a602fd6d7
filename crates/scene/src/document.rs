//! The glTF document behind a scene, with everything in it that the scene does not use: a writer patches it and loses
//! nothing, whatever has become of the file meanwhile.

use serde_json::Value;

/// A glTF file in its raw parts. They are as `load` read them; the file is not opened again.
#[derive(Debug, Clone)]
pub struct GltfDocument {
    /// The JSON, keys in the file's order. A data URI whose content stands in `buffers` or `images` ends after its
    /// comma, so that no byte is held twice.
    pub json: Value,
    /// The bytes of each of the JSON's `buffers`, each exactly `byteLength` long. Compressed geometry is decoded.
    pub buffers: Vec<Vec<u8>>,
    /// Why a buffer has no bytes though the JSON announces some; nothing that a bake reads lies in it. Shorter where
    /// the rest have theirs.
    pub absent: Vec<Option<String>>,
    /// For each of the JSON's `images` the content behind its `uri`. `None` where it lies in a buffer view, where its
    /// file is absent or nothing uses it, and where its bytes are not those of a picture: that stays a URI.
    pub images: Vec<Option<EncodedImage>>,
}

/// An image file's bytes, not decoded.
#[derive(Debug, Clone)]
pub struct EncodedImage {
    /// Media type by its first bytes, such as `image/png`.
    pub mime_type: String,
    /// The whole file.
    pub bytes: Vec<u8>,
}
