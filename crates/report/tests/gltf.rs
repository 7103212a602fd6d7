//! The written GLB: validated by Khronos' validator, loaded again, compared with the input.

mod common;

use ambake_report::{Layer, Output, Page, occlusion_png, write_gltf};
use atlas::{Atlas, Audit, MeshLayout, Placement, UvSource};
use common::skip;
use glam::Vec2;
use scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A layout that splits every triangle off (or keeps the vertices), each object in a cell of its own, with every third
/// triangle on a second page where `pages` is 2.
fn layout(scene: &Scene, split: bool, pages: u32) -> Atlas {
    let mesh = |mesh: &scene::Mesh| {
        let corners = mesh.triangles.as_flattened();
        let vertices = mesh.positions.len() as u32;
        let place = |i: u32| Vec2::new((i % 97) as f32 / 97.0, (i / 97 % 89) as f32 / 89.0);
        let count = if split {
            corners.len() as u32
        } else {
            vertices
        };
        let own: Vec<u32> = (0..count).collect();
        MeshLayout {
            source_vertices: if split { corners.to_vec() } else { own.clone() },
            uvs: own.iter().map(|&i| place(i)).collect(),
            triangles: if split {
                own.as_chunks().0.to_vec()
            } else {
                mesh.triangles.clone()
            },
            triangle_pages: match pages {
                1 => Vec::new(),
                _ => (0..mesh.triangles.len())
                    .map(|t| u16::from(t % 3 == 2))
                    .collect(),
            },
        }
    };
    let cells = (scene.instances.len() as f32).sqrt().ceil();
    let placement = |i: usize| Placement {
        page: 0,
        scale: [1.0 / cells; 2],
        offset: [
            (i as f32 % cells).floor() / cells,
            (i as f32 / cells).floor() / cells,
        ],
    };
    Atlas {
        page_size: 8,
        page_count: pages,
        meshes: scene.meshes.iter().map(mesh).collect(),
        placements: (0..scene.instances.len()).map(placement).collect(),
        source: UvSource::Unwrapped,
        audit: Audit::default(),
        density: 1.0,
        chart_count: 1,
        notes: Vec::new(),
    }
}

/// One picture a page.
fn pictures(atlas: &Atlas) -> Vec<Vec<u8>> {
    let values = (0..64).map(|i| i as f32 / 63.0).collect();
    let page = Page {
        size: 8,
        layers: vec![Layer::scalar("diffuse", values)],
    };
    (0..atlas.page_count)
        .map(|_| occlusion_png(&page).unwrap())
        .collect()
}

fn write(scene: &Scene, atlas: &Atlas, dir: &Path, name: &str) -> PathBuf {
    let bytes = write_gltf(scene, atlas, &pictures(atlas)).unwrap();
    let mut out = Output::create(dir).unwrap();
    out.stage_bytes(name, &bytes).unwrap();
    out.publish().unwrap().remove(0)
}

/// The number of errors that Khronos' validator finds in all; `None` where it is not installed.
fn validate(files: &[PathBuf]) -> Option<Vec<Value>> {
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/tools/validate-gltf.mjs"
    );
    let run = match Command::new("node").arg(script).args(files).output() {
        Ok(run) if run.status.code() != Some(77) => run,
        _ => {
            skip("node or its module gltf-validator is absent (npm install in tests/tools)");
            return None;
        }
    };
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(!text.is_empty(), "{}", String::from_utf8_lossy(&run.stderr));
    Some(
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
    )
}

fn assert_valid(files: &[PathBuf]) {
    for line in validate(files).into_iter().flatten() {
        assert_eq!(line["errors"], 0, "{line:#}");
        println!("{} warnings {}", line["file"], line["warnings"]);
    }
}

/// The chunks of a GLB.
fn open(path: &Path) -> (Value, Vec<u8>) {
    let source = scene::gltf_source(path).unwrap();
    (source.json, source.buffers.into_iter().next().unwrap())
}

fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    for word in [
        2,
        28 + text.len() as u32 + bin.len() as u32,
        text.len() as u32,
        0x4E4F_534A,
    ] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(text);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// A scene with everything that is easily lost: two nodes that share a mesh, an instanced node, a second UV set that a
/// texture reads, a strip, lines, a camera, an animation, a morph target, extras, an unknown extension, variants, and
/// an old occlusion texture with a transform.
fn rich() -> (Value, Vec<u8>) {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |bytes: Vec<u8>, kind: u32, count: usize, shape: &str, extra: Value| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        bin.extend(bytes);
        let mut accessor = json!({ "bufferView": views.len() - 1, "componentType": kind, "count": count, "type": shape });
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
    let picture = occlusion_png(&Page {
        size: 1,
        layers: vec![Layer::scalar("diffuse", vec![1.0])],
    })
    .unwrap();
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

#[test]
fn everything_the_input_held_is_still_there() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("rich.glb");
    let (before, bin) = rich();
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    assert_eq!(scene.instances.len(), 4, "a, b and two copies");
    let path = write(
        &scene,
        &layout(&scene, true, 2),
        &dir.path().join("out"),
        "rich.glb",
    );
    let (after, _) = open(&path);
    for key in ["asset", "extensions", "cameras", "animations", "scenes"] {
        assert_eq!(after[key], before[key], "{key}");
    }
    for (key, list) in before.as_object().unwrap() {
        if let (Some(old), "accessors" | "bufferViews" | "textures" | "images") =
            (list.as_array(), key.as_str())
        {
            assert_eq!(
                after[key].as_array().unwrap()[..old.len()],
                old[..],
                "{key}"
            );
        }
    }
    assert_eq!(
        after["extensionsUsed"],
        json!(["KHR_materials_variants", "VENDOR_unknown"])
    );
    assert_eq!(after["extensionsRequired"], Value::Null);
    assert_eq!(after["nodes"][0], before["nodes"][0]);
    assert_eq!(
        after["nodes"][2],
        json!({ "name": "many", "translation": [5, 0, 0], "children": [4, 5] })
    );
    assert_eq!(after["nodes"][5]["translation"], json!([0.0, 0.0, 6.0]));

    // Each of the four users has its own mesh, each triangle primitive one part a page.
    let meshes: Vec<u64> = [0, 1, 4, 5]
        .map(|n: usize| after["nodes"][n]["mesh"].as_u64().unwrap())
        .into();
    assert_eq!(meshes, [0, 2, 1, 3]);
    assert_eq!(after["meshes"][0]["weights"], json!([0.5]));
    // Lines stay as they were, but the material they share is not painted over.
    let lines = &after["meshes"][1]["primitives"]
        .as_array()
        .unwrap()
        .last()
        .unwrap()
        .clone();
    assert_eq!(lines, &before["meshes"][1]["primitives"][1]);
    assert_eq!(after["materials"][1], before["materials"][1]);
    assert_valid(&[path]);
}

#[test]
fn materials_show_their_page_and_follow_moved_uv_sets() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("rich.glb");
    let (before, bin) = rich();
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    let (after, _) = open(&write(
        &scene,
        &layout(&scene, false, 1),
        dir.path(),
        "out.glb",
    ));
    let primitive = &after["meshes"][0]["primitives"][0];
    // Vertices in the file's order: the accessors themselves are kept.
    for key in ["POSITION", "TEXCOORD_0", "COLOR_0"] {
        assert_eq!(
            primitive["attributes"][key],
            before["meshes"][0]["primitives"][0]["attributes"][key]
        );
    }
    assert_eq!(
        primitive["indices"],
        before["meshes"][0]["primitives"][0]["indices"]
    );
    assert_eq!(
        primitive["attributes"]["TEXCOORD_2"],
        before["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"]
    );
    let material = &after["materials"][primitive["material"].as_u64().unwrap() as usize];
    assert_eq!(
        material["normalTexture"],
        json!({ "index": 0, "texCoord": 2, "scale": 0.5 })
    );
    assert_eq!(
        material["occlusionTexture"],
        json!({ "index": 1, "texCoord": 1, "strength": 1.0 })
    );
    assert_eq!(after["textures"][1]["name"], "rich.0.occlusion");
    let variants = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
    assert_eq!(variants[0]["material"], primitive["material"]);
    let wet = &after["materials"][variants[1]["material"].as_u64().unwrap() as usize];
    assert_eq!(
        (&wet["extras"]["note"], &wet["occlusionTexture"]["index"]),
        (&json!("kept"), &json!(1))
    );
}

#[test]
fn split_vertices_carry_every_attribute_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("rich.glb");
    let (before, bin) = rich();
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    let atlas = layout(&scene, true, 1);
    let (after, out) = open(&write(&scene, &atlas, dir.path(), "out.glb"));
    let attributes = &after["meshes"][0]["primitives"][0]["attributes"];
    let elements = |semantic: &str, size: usize| -> Vec<Vec<u8>> {
        let accessor = &after["accessors"][attributes[semantic].as_u64().unwrap() as usize];
        let view = &after["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let (at, stride) = (
            view["byteOffset"].as_u64().unwrap(),
            view["byteStride"].as_u64().unwrap(),
        );
        let element = |i: u64| out[(at + i * stride) as usize..][..size].to_vec();
        (0..accessor["count"].as_u64().unwrap())
            .map(element)
            .collect()
    };
    let source = [0u8, 1, 2, 2, 1, 3];
    let colors: Vec<Vec<u8>> = source
        .iter()
        .map(|&v| (4 * v..4 * v + 4).collect())
        .collect();
    assert_eq!(elements("COLOR_0", 4), colors);
    let corners = [[0, 0], [255, 0], [0, 255], [255, 255]];
    let second: Vec<Vec<u8>> = source
        .iter()
        .map(|&v| corners[v as usize].to_vec())
        .collect();
    assert_eq!(elements("TEXCOORD_2", 2), second);
    let lightmap: Vec<f32> = elements("TEXCOORD_1", 8)
        .concat()
        .as_chunks()
        .0
        .iter()
        .map(|&b| f32::from_le_bytes(b))
        .collect();
    let expected: Vec<f32> = atlas.meshes[0]
        .uvs
        .iter()
        .flat_map(|uv| [uv.x * 0.5, uv.y * 0.5])
        .collect();
    assert_eq!(lightmap, expected);
    let target = after["meshes"][0]["primitives"][0]["targets"][0]["POSITION"]
        .as_u64()
        .unwrap() as usize;
    assert_eq!(after["accessors"][target]["count"], 6);
    assert_eq!(after["accessors"][target]["max"], json!([1.0, 1.0, 0.0]));
}

#[test]
fn real_models_are_valid_and_load_again() {
    let models = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/models"
    ));
    if !models.is_dir() {
        return skip("../shared/models is not here");
    }
    let dir = tempfile::tempdir().unwrap();
    let mut written = Vec::new();
    for (name, split, pages) in [
        ("boeing_787/scene.gltf", true, 2),
        ("flight_helmet/FlightHelmet.gltf", false, 1),
        ("oak_small_alphamask.glb", true, 1),
        ("suzi.glb", true, 1),
        ("cornell_box/CornellBox.glb", false, 2),
        ("game_level_zdm2.glb", false, 1),
        ("spot.obj", true, 2),
        ("gazebo/gazebo.obj", false, 1),
    ] {
        let before = scene::load(&models.join(name)).unwrap();
        let file = format!("{}.glb", written.len());
        let path = write(&before, &layout(&before, split, pages), dir.path(), &file);
        // The same triangles in the same places, whatever the layout did to vertices and pages.
        let after = scene::load(&path).unwrap();
        assert_eq!(corners(&after), corners(&before), "{name}");
        assert!(
            after.meshes.iter().all(|mesh| mesh.uv_sets.len() >= 2),
            "{name}"
        );
        written.push(path);
    }
    assert_valid(&written);
}

#[test]
fn lamps_of_an_obj_scene_keep_their_radiance() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let lamps = "newmtl strong\nKe 6 3 1.5\nnewmtl weak\nKe 0.25 1 0\nnewmtl dark\nKe 0 0 0\n";
    fs::write(at("lamps.mtl"), lamps).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let faces = ["strong", "weak", "dark"].map(|name| format!("usemtl {name}\nf 1 2 3\n"));
    let text = format!("mtllib lamps.mtl\n{corners}{}", faces.concat());
    fs::write(at("lamps.obj"), text).unwrap();
    let before = scene::load(&at("lamps.obj")).unwrap();
    let path = write(&before, &layout(&before, false, 1), dir.path(), "lamps.glb");
    let after = scene::load(&path).unwrap();
    let radiances = |scene: &Scene| {
        let of = |mesh: &scene::Mesh| scene.materials[mesh.material as usize].emission.to_array();
        scene.meshes.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(
        radiances(&before),
        [[6.0, 3.0, 1.5], [0.25, 1.0, 0.0], [0.0; 3]]
    );
    assert_eq!(radiances(&after), radiances(&before));
    let (json, _) = open(&path);
    assert_eq!(
        json["extensionsUsed"],
        json!(["KHR_materials_emissive_strength"])
    );
    assert_eq!(json["materials"][1].get("extensions"), None);
    assert_valid(&[path]);
}

/// World positions of all triangles' corners, in an order that does not depend on the objects' order.
fn corners(scene: &Scene) -> Vec<[u64; 9]> {
    let mut all = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for triangle in &mesh.triangles {
            let points = triangle.map(|v| {
                instance
                    .transform
                    .transform_point3(mesh.positions[v as usize].as_dvec3())
            });
            let bits: Vec<u64> = points
                .iter()
                .flat_map(|p| p.to_array())
                .map(f64::to_bits)
                .collect();
            all.push(bits.try_into().unwrap());
        }
    }
    all.sort_unstable();
    all
}

/// Two triangles far apart in one array of 20,000 vertices, each a primitive: the loader keeps three vertices of each.
#[test]
fn primitives_that_share_a_large_array_are_written() {
    let corners_of = [[7u32, 9_999, 12_345], [3, 15_000, 19_999]];
    let vertices = 20_000u32;
    let mut bin = Vec::new();
    for v in 0..vertices {
        for value in [v as f32, (v * v % 7_919) as f32, 0.5] {
            bin.extend(value.to_le_bytes());
        }
    }
    let at = bin.len();
    for index in corners_of.as_flattened() {
        bin.extend(index.to_le_bytes());
    }
    let indices = |k: u32| json!({ "bufferView": 1, "byteOffset": 12 * k, "componentType": 5125, "count": 3, "type": "SCALAR" });
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0 }, "indices": 1 },
            { "attributes": { "POSITION": 0 }, "indices": 2 },
        ] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
              "min": [0.0, 0.0, 0.5], "max": [19_999.0, 7912.0, 0.5] },
            indices(0),
            indices(1),
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": at, "target": 34962 },
            { "buffer": 0, "byteOffset": at, "byteLength": 24, "target": 34963 },
        ],
        "buffers": [{ "byteLength": bin.len() }],
    });
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("shared.glb");
    fs::write(&input, glb(&document, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    assert_eq!(scene.meshes[1].source_vertices, corners_of[1]);
    let mut written = Vec::new();
    for (split, name) in [(true, "split.glb"), (false, "whole.glb")] {
        let path = write(&scene, &layout(&scene, split, 1), dir.path(), name);
        assert_eq!(
            corners(&scene::load(&path).unwrap()),
            corners(&scene),
            "{name}"
        );
        written.push(path);
    }
    assert_valid(&written);
}
