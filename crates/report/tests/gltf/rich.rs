//! A document that holds everything that is easily lost.

use ambake_report::occlusion_png;
use serde_json::{Value, json};

/// A scene with everything that is easily lost: two nodes that share a mesh, an instanced node, a second UV set that a
/// texture reads, a strip, lines, a camera, an animation, a morph target, extras, an unknown extension, variants, and
/// an old occlusion texture with a transform.
pub fn rich() -> (Value, Vec<u8>) {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |bytes: Vec<u8>, kind: u32, count: usize, shape: &str, extra: Value| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        bin.extend(bytes);
        let mut accessor = json!({ "bufferView": views.len() - 1, "componentType": kind, "count": count,
            "type": shape });
        accessor
            .as_object_mut()
            .unwrap()
            .extend(extra.as_object().unwrap().clone());
        accessors.push(accessor);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let square = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let bounds = json!({ "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0] });
    let position = add(square.clone(), 5126, 4, "VEC3", bounds.clone());
    let uv0 = add(
        floats(&[0., 0., 1., 0., 0., 1., 1., 1.]),
        5126,
        4,
        "VEC2",
        json!({}),
    );
    let uv1 = add(
        vec![0, 0, 9, 9, 255, 0, 9, 9, 0, 255, 9, 9, 255, 255, 9, 9],
        5121,
        4,
        "VEC2",
        json!({ "normalized": true }),
    );
    let color = add(
        (0..16).collect(),
        5121,
        4,
        "VEC4",
        json!({ "normalized": true }),
    );
    let indices = add(
        [0u16, 1, 2, 2, 1, 3]
            .iter()
            .flat_map(|i| i.to_le_bytes())
            .collect(),
        5123,
        6,
        "SCALAR",
        json!({}),
    );
    let target = add(square.clone(), 5126, 4, "VEC3", bounds);
    let moves = add(
        floats(&[0., 0., 3., 0., 0., 6.]),
        5126,
        2,
        "VEC3",
        json!({}),
    );
    let times = add(
        floats(&[0., 1.]),
        5126,
        2,
        "SCALAR",
        json!({ "min": [0.0], "max": [1.0] }),
    );
    let weights = add(floats(&[0., 1.]), 5126, 2, "SCALAR", json!({}));
    // Bytes of a two-component colour set are four apart: the view needs its stride.
    views[uv1]["byteStride"] = 4.into();
    let picture = occlusion_png(1, &[1.0]);
    bin.resize(bin.len().next_multiple_of(4), 0);
    views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": picture.len() }));
    bin.extend(picture);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let image_view = views.len() - 1;
    let json = json!({
        "asset": { "version": "2.0", "extras": { "who": "somebody" } },
        "extensionsUsed":
            ["EXT_mesh_gpu_instancing", "KHR_materials_variants", "KHR_texture_transform", "VENDOR_unknown"],
        "extensionsRequired": ["EXT_mesh_gpu_instancing"],
        "extensions": {
            "KHR_materials_variants": { "variants": [{ "name": "dry" }, { "name": "wet" }] },
            "VENDOR_unknown": { "depth": [1, 2, { "x": null }] },
        },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2, 3] }],
        "nodes": [
            { "name": "a", "mesh": 0, "extras": { "keep": true } },
            { "name": "b", "mesh": 0, "translation": [0, 0, 1] },
            { "name": "many", "mesh": 1, "translation": [5, 0, 0],
              "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": moves } } } },
            { "name": "eye", "camera": 0 },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }],
        "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": times, "output": weights }] }],
        "meshes": [
            { "name": "square", "weights": [0.5], "primitives": [
                { "attributes": { "POSITION": position, "TEXCOORD_0": uv0, "TEXCOORD_1": uv1, "COLOR_0": color },
                  "indices": indices, "material": 0, "targets": [{ "POSITION": target }],
                  "extensions": { "KHR_materials_variants": { "mappings": [
                      { "material": 0, "variants": [0] }, { "material": 1, "variants": [1] }] } } },
            ] },
            { "name": "mixed", "primitives": [
                { "attributes": { "POSITION": position }, "mode": 5 },
                { "attributes": { "POSITION": position }, "mode": 1, "material": 1 },
            ] },
        ],
        "materials": [
            { "name": "detailed", "normalTexture": { "index": 0, "texCoord": 1, "scale": 0.5 },
              "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
              "occlusionTexture": { "index": 0, "strength": 0.5,
                  "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } } },
            { "name": "plain", "extras": { "note": "kept" } },
        ],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": image_view, "mimeType": "image/png" }],
        "bufferViews": views,
        "accessors": accessors,
        "buffers": [{ "byteLength": bin.len() }],
    });
    (json, bin)
}
