//! Builds small glTF, GLB and OBJ files for the tests.

use ambake_scene::{Error, Scene};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A folder that is removed at the end of the test.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        // A new file each time: truncating an old one makes some file systems wait for the disk.
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    pub fn load(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, Error> {
        ambake_scene::load(&self.write(name, bytes))
    }
}

/// A glTF document that grows: the JSON, and one buffer.
pub struct Document {
    pub json: Value,
    pub bin: Vec<u8>,
}

pub const F32: u32 = 5126;
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;

impl Document {
    /// One triangle with one node in one scene.
    pub fn triangle() -> Document {
        let mut document = Document::empty();
        let positions = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        document.json["meshes"] =
            json!([{ "primitives": [{ "attributes": { "POSITION": positions } }] }]);
        document.json["nodes"] = json!([{ "mesh": 0 }]);
        document.json["scenes"] = json!([{ "nodes": [0] }]);
        document
    }

    /// A unit square of four vertices in the xy plane, counter-clockwise, with no indices yet.
    pub fn square() -> Document {
        let mut document = Document::triangle();
        let positions = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        document.primitive()["attributes"]["POSITION"] = json!(positions);
        document
    }

    fn empty() -> Document {
        let json = json!({ "asset": { "version": "2.0" }, "bufferViews": [], "accessors": [] });
        Document {
            json,
            bin: Vec::new(),
        }
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Sets the materials, with a copy of the one primitive for each: what no mesh has is not read.
    pub fn wear(&mut self, materials: Value) {
        let count = materials.as_array().unwrap().len();
        let mut primitive = self.primitive().clone();
        let mut worn = |material: usize| {
            primitive["material"] = json!(material);
            primitive.clone()
        };
        self.json["meshes"][0]["primitives"] = (0..count).map(&mut worn).collect();
        self.json["materials"] = materials;
    }

    /// A buffer view of its own for some bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend_from_slice(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        push(&mut self.json["accessors"], accessor)
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let lanes = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(F32, kind, values.len() / lanes, &bytes)
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let length = (12 + 8 + text.len() + 8 + bin.len()) as u32;
        let chunk = |kind: &[u8], body: &[u8]| {
            [&(body.len() as u32).to_le_bytes()[..], kind, body].concat()
        };
        let header = [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
        [header, chunk(b"JSON", &text), chunk(b"BIN\0", &bin)].concat()
    }

    /// The JSON alone, its buffer behind `uri`.
    pub fn gltf(&self, uri: &str) -> String {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bin.len(), "uri": uri }]);
        json.to_string()
    }

    pub fn load(&self) -> Result<Scene, Error> {
        Folder::new().load("scene.glb", self.glb())
    }
}

/// Appends to a JSON array and returns the place.
pub fn push(array: &mut Value, value: Value) -> usize {
    let array = array.as_array_mut().unwrap();
    array.push(value);
    array.len() - 1
}

/// A PNG of one row of RGBA pixels.
pub fn png(pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_raw(pixels.len() as u32, 1, pixels.concat()).unwrap();
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}
