//! The writer patches the document that the scene keeps: the file on disk is not asked again.

use super::rich::rich;
use super::support::{corners, glb, layout, open, picture, pictures, write};
use ambake_report::{Output, Shades, write_gltf};
use atlas::Atlas;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// One triangle and what it reads, over two buffers: the second holds UVs and indices.
fn triangle(first: &str, second: &str) -> Value {
    let view = |buffer: u32, offset: u32, length: u32| {
        json!({ "buffer": buffer, "byteOffset": offset,
            "byteLength": length })
    };
    json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "material": 0, "indices": 2,
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1, "_ZERO": 3 } }] }],
        "materials": [{ "normalTexture": { "index": 1 }, "emissiveTexture": { "index": 2 },
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }, { "source": 1 }, { "source": 2 }],
        "images": [{ "uri": "base.png" }, { "uri": "bumps%20and%20dents.png", "name": "bumps" }, { "uri": "gone.png" }],
        "bufferViews": [view(0, 0, 36), view(1, 0, 24), view(1, 24, 3)],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 3 },
            { "bufferView": 2, "componentType": 5121, "type": "SCALAR", "count": 3 },
            { "componentType": 5126, "type": "SCALAR", "count": 3 },
        ],
        "buffers": [{ "byteLength": 36, "uri": first }, { "byteLength": 27, "uri": second }],
    })
}

/// The triangle's two buffers.
fn buffers() -> [Vec<u8>; 2] {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let positions: Vec<u8> = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let mut rest: Vec<u8> = floats(&[0., 0., 1., 0., 0., 1.]);
    rest.extend([0, 1, 2]);
    [positions, rest]
}

/// Writes the triangle with a buffer in a file, one in the JSON, and its images; returns the scene file.
fn triangle_files(dir: &Path) -> PathBuf {
    let [first, second] = buffers();
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(second)
    );
    fs::write(dir.join("first.bin"), first).unwrap();
    fs::write(dir.join("base.png"), picture()).unwrap();
    fs::write(dir.join("bumps and dents.png"), picture()).unwrap();
    let path = dir.join("triangle.gltf");
    // Some programs begin the text with a byte order mark.
    let text = format!("\u{feff}{}", triangle("first.bin", &uri));
    fs::write(&path, text).unwrap();
    path
}

fn written(scene: &Scene, split: bool) -> Vec<u8> {
    let atlas = layout(scene, split, 1);
    write_gltf(scene, &atlas, Some(&pictures(&atlas)), &Shades::new()).unwrap()
}

fn stored(dir: &Path, bytes: &[u8]) -> PathBuf {
    let mut out = Output::create(dir).unwrap();
    out.stage_bytes("out.glb", bytes).unwrap();
    out.publish().unwrap().remove(0)
}

#[test]
fn a_scene_file_may_change_or_go_once_it_is_loaded() {
    let (container, text) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (json, bin) = rich();
    let glb_file = container.path().join("rich.glb");
    fs::write(&glb_file, glb(&json, &bin)).unwrap();
    for (dir, path) in [(&container, glb_file), (&text, triangle_files(text.path()))] {
        let scene = scene::load(&path).unwrap();
        let both = || [false, true].map(|split| written(&scene, split));
        let expected = both();
        fs::write(&path, "{}").unwrap();
        assert!(both() == expected, "{} was changed", path.display());
        for file in fs::read_dir(dir).unwrap() {
            fs::remove_file(file.unwrap().path()).unwrap();
        }
        assert!(
            both() == expected,
            "{} and all beside is gone",
            path.display()
        );
        for bytes in expected {
            let after = scene::load(&stored(dir.path(), &bytes)).unwrap();
            assert_eq!(corners(&after), corners(&scene), "{}", path.display());
        }
    }
}

#[test]
fn images_are_embedded_whether_a_term_reads_them_or_not() {
    let dir = tempfile::tempdir().unwrap();
    let path = triangle_files(dir.path());
    let scene = scene::load(&path).unwrap();
    assert_eq!(scene.images.len(), 1, "the base colour alone is decoded");
    let (json, bin) = open(&stored(dir.path(), &written(&scene, false)));
    for (image, name) in [(0, Value::Null), (1, json!("bumps"))] {
        let image = &json["images"][image];
        assert_eq!(image["name"], name);
        assert_eq!(image["mimeType"], "image/png");
        assert_eq!(image.get("uri"), None);
        let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let at = view["byteOffset"].as_u64().unwrap() as usize;
        assert!(bin[at..].starts_with(&picture()), "{image} at {at}");
    }
    assert_eq!(json["images"][2], json!({ "uri": "gone.png" }));
}

#[test]
fn buffers_beyond_the_first_and_accessors_without_data_come_through() {
    let dir = tempfile::tempdir().unwrap();
    let scene = scene::load(&triangle_files(dir.path())).unwrap();
    let after = scene::load(&stored(dir.path(), &written(&scene, true))).unwrap();
    let source = after.source.as_ref().unwrap();
    assert_eq!(source.buffers.len(), 1, "all content stands in the first");
    assert_eq!(corners(&after), corners(&scene));
    let attributes = &source.json["meshes"][0]["primitives"][0]["attributes"];
    let zeros = source
        .accessor(attributes["_ZERO"].as_u64().unwrap() as usize)
        .unwrap();
    let zeros: Vec<_> = (0..4).map(|i| zeros.numbers::<1>(i)).collect();
    assert_eq!(zeros, [Some([0.0]), Some([0.0]), Some([0.0]), None]);
}

#[test]
fn a_chunk_of_unknown_type_before_the_binary_one_is_stepped_over() {
    let dir = tempfile::tempdir().unwrap();
    let (json, bin) = rich();
    let plain = glb(&json, &bin);
    let end = plain.len() - bin.len() - 8;
    let mut bytes = plain[..end].to_vec();
    bytes.extend(b"\x04\0\0\0WHAT");
    bytes.extend(b"ever");
    bytes.extend(&plain[end..]);
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    let load = |bytes: &[u8]| {
        let path = dir.path().join("rich.glb");
        fs::write(&path, bytes).unwrap();
        scene::load(&path).unwrap()
    };
    assert!(written(&load(&bytes), true) == written(&load(&plain), true));
}

/// The set is the layout's and stands where it is placed: the file's own accessor serves, or its vertices in new order.
#[test]
fn a_lightmap_set_of_the_file_is_kept_and_nothing_is_added() {
    let vertices = 20_000u32;
    let uvs: Vec<f32> = (0..2 * vertices).map(|i| i as f32 / 65_536.0).collect();
    let mut bin: Vec<u8> = Vec::new();
    for v in 0..vertices {
        let position = [v as f32, (v * v % 7_919) as f32, 0.5];
        bin.extend(position.iter().flat_map(|p| p.to_le_bytes()));
    }
    let at = bin.len();
    bin.extend(uvs.iter().flat_map(|p| p.to_le_bytes()));
    let indices = bin.len();
    bin.extend([7u32, 9_999, 12_345].iter().flat_map(|i| i.to_le_bytes()));
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1 },
        "indices": 2 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
              "min": [0.0, 0.0, 0.5], "max": [19_999.0, 7912.0, 0.5] },
            { "bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5125, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": at },
            { "buffer": 0, "byteOffset": at, "byteLength": indices - at },
            { "buffer": 0, "byteOffset": indices, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": bin.len() }],
    });
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("shared.glb");
    fs::write(&path, glb(&document, &bin)).unwrap();
    let scene = scene::load(&path).unwrap();
    assert_eq!(scene.meshes[0].source_vertices, [7, 9_999, 12_345]);
    let mut atlas = layout(&scene, false, 1);
    let mesh = &mut atlas.meshes[0];
    mesh.uvs = mesh
        .source_vertices
        .iter()
        .map(|&v| scene.meshes[0].uv_sets[1][v as usize])
        .collect();
    let sets = |atlas: &Atlas| {
        let bytes = write_gltf(&scene, atlas, Some(&pictures(atlas)), &Shades::new()).unwrap();
        let (json, _) = open(&stored(dir.path(), &bytes));
        let attributes = json["meshes"][0]["primitives"][0]["attributes"]
            .as_object()
            .unwrap();
        attributes
            .keys()
            .filter(|name| name.starts_with("TEXCOORD"))
            .cloned()
            .collect::<Vec<_>>()
    };
    assert_eq!(sets(&atlas), ["TEXCOORD_0", "TEXCOORD_1"]);
    // One value apart: the file's set moves away.
    atlas.meshes[0].uvs[2].x += f32::EPSILON;
    assert_eq!(sets(&atlas), ["TEXCOORD_0", "TEXCOORD_2", "TEXCOORD_1"]);
}

/// The loader does not know what other programs keep at vertices, so it has not looked at this.
#[test]
fn a_damaged_attribute_that_is_not_loaded_is_left_out() {
    let dir = tempfile::tempdir().unwrap();
    let (mut json, bin) = rich();
    let attributes = &mut json["meshes"][0]["primitives"][0]["attributes"];
    let color = attributes["COLOR_0"].as_u64().unwrap();
    attributes.as_object_mut().unwrap().remove("COLOR_0");
    attributes["_WEAR"] = json!(color);
    json["accessors"][color as usize]["count"] = json!(1_000_000);
    let path = dir.path().join("rich.glb");
    fs::write(&path, glb(&json, &bin)).unwrap();
    let scene = scene::load(&path).unwrap();
    for split in [true, false] {
        let (after, _) = open(&write(
            &scene,
            &layout(&scene, split, 1),
            dir.path(),
            "out.glb",
        ));
        let attributes = &after["meshes"][0]["primitives"][0]["attributes"];
        assert!(attributes.get("POSITION").is_some(), "{attributes}");
        assert_eq!(attributes.get("_WEAR"), None, "split: {split}");
    }
}
