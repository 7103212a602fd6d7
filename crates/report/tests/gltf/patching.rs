//! What is changed in a document, and that nothing else is.

use super::rich::rich;
use super::support::{assert_valid, corners, glb, layout, open, write};
use serde_json::{Value, json};
use std::fs;

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
        // The last one is of the white material that a primitive without any gets.
        json!([
            "KHR_materials_variants",
            "VENDOR_unknown",
            "KHR_materials_specular"
        ])
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
    let indices = |k: u32| {
        json!({ "bufferView": 1, "byteOffset": 12 * k, "componentType": 5125, "count": 3,
            "type": "SCALAR" })
    };
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

#[test]
fn textures_in_extensions_of_a_primitive_follow_a_moved_uv_set() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("rich.glb");
    let (mut before, bin) = rich();
    let feature = |set: u32| json!({ "featureCount": 4, "texture": { "index": 0, "texCoord": set, "channels": [0] } });
    let features = |sets: [u32; 2]| json!({ "featureIds": sets.map(feature) });
    let property =
        |set: u32| json!({ "class": "c", "properties": { "p": { "index": 0, "texCoord": set } } });
    let own = &mut before["meshes"][0]["primitives"][0]["extensions"];
    own["EXT_mesh_features"] = features([1, 0]);
    own["EXT_structural_metadata"] = json!({ "propertyTextures": [0, 1] });
    before["extensions"]["EXT_structural_metadata"] =
        json!({ "propertyTextures": [property(0), property(1)] });
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    let atlas = layout(&scene, false, 1);
    let (after, _) = open(&write(&scene, &atlas, dir.path(), "out.glb"));
    let primitive = &after["meshes"][0]["primitives"][0];
    assert_eq!(
        primitive["extensions"]["EXT_mesh_features"],
        features([2, 0])
    );
    assert_eq!(
        after["extensions"]["EXT_structural_metadata"]["propertyTextures"],
        json!([property(0), property(2)])
    );
    assert_eq!(
        primitive["extensions"]["EXT_structural_metadata"]["propertyTextures"],
        json!([0, 1])
    );
}

/// Two squares: `uv_sets` of them have so many sets of coordinates, each with values of its own.
fn squares(uv_sets: [usize; 2]) -> (Value, Vec<u8>) {
    let mut bin: Vec<u8> = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut push = |kind: &str, lanes: usize, values: Vec<f32>| {
        let start = bin.len();
        bin.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bin.len() - start }));
        accessors.push(json!({ "bufferView": accessors.len(), "componentType": 5126, "count": values.len() / lanes,
            "type": kind }));
        accessors.len() - 1
    };
    let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 0.], [1., 1.], [0., 1.]];
    let positions = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
    let positions = push("VEC3", 3, positions);
    let mut meshes = Vec::new();
    for (m, sets) in uv_sets.into_iter().enumerate() {
        let mut attributes = json!({ "POSITION": positions });
        for set in 0..sets {
            let scale = 1.0 / (2 + set + 4 * m) as f32;
            let values = corners.iter().flatten().map(|v| v * scale).collect();
            attributes[format!("TEXCOORD_{set}")] = push("VEC2", 2, values).into();
        }
        meshes.push(json!({ "primitives": [{ "attributes": attributes, "material": 0 }] }));
    }
    accessors[positions]["min"] = json!([0, 0, 0]);
    accessors[positions]["max"] = json!([1, 1, 0]);
    let picture = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVQI12P4//8/AAX+Av7czFnnAAAAAElFTkSuQmCC";
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 1, "translation": [3, 0, 0] }],
        "meshes": meshes, "accessors": accessors, "bufferViews": views,
        "buffers": [{ "byteLength": bin.len() }],
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0,
        "baseColorTexture": { "index": 0, "texCoord": 1 } } }],
        "images": [{ "uri": picture }], "textures": [{ "source": 0 }],
    });
    (document, bin)
}

#[test]
fn what_several_primitives_share_reads_their_moved_sets_under_one_number() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("shared.glb");
    let (mut before, bin) = squares([2, 3]);
    let reads = |set: u32| json!({ "ACME_any": { "foo": [{ "index": 0, "texCoord": set }] } });
    for place in ["", "/nodes/0", "/meshes/1"] {
        before.pointer_mut(place).unwrap()["extensions"] = reads(1);
    }
    before["extensionsUsed"] = json!(["ACME_any"]);
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    let atlas = layout(&scene, false, 1);
    let path = write(&scene, &atlas, dir.path(), "out.glb");
    let (after, _) = open(&path);
    for place in ["", "/nodes/0", "/meshes/1"] {
        let after = &after.pointer(place).unwrap()["extensions"];
        assert_eq!(after, &reads(3), "{place}");
    }
    let again = scene::load(&path).unwrap();
    for (mesh, was) in again.meshes.iter().zip(&scene.meshes) {
        assert_eq!(mesh.uv_sets[3], was.uv_sets[1], "{}", mesh.name);
        assert_eq!(mesh.uv_sets[0], was.uv_sets[0], "{}", mesh.name);
    }
    let textures = after["meshes"].as_array().unwrap().iter().map(|mesh| {
        let material = &mesh["primitives"][0]["material"];
        let material = &after["materials"][material.as_u64().unwrap() as usize];
        material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"].clone()
    });
    let attributes = after["meshes"].as_array().unwrap().iter();
    for (mesh, set) in attributes.zip(textures) {
        // The material has one picture with one set, which is the moved one by either number.
        let attributes = &mesh["primitives"][0]["attributes"];
        let named = &attributes[format!("TEXCOORD_{set}")];
        assert_eq!(named, &attributes["TEXCOORD_3"], "{mesh}");
    }
    assert_valid(&[path]);
    // Nothing shared reads set 1: each primitive's moves behind its own last.
    let (plain, bin) = squares([2, 3]);
    fs::write(&input, glb(&plain, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    let (after, _) = open(&write(&scene, &atlas, dir.path(), "plain.glb"));
    let count = |m: usize| {
        let attributes = &after["meshes"][m]["primitives"][0]["attributes"];
        attributes.as_object().unwrap().len()
    };
    assert_eq!([count(0), count(1)], [4, 5]);
}

/// What a scene is baked without is written without, too, so that what was broken breaks no viewer, and nothing that is
/// appended is taken for what was not there.
#[test]
fn broken_parts_of_a_file_do_not_come_back_in_its_glb() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("broken.glb");
    let (mut before, bin) = squares([2, 3]);
    let primitive = &mut before["meshes"][0]["primitives"][0];
    let (accessors, images) = (6, 1);
    primitive["attributes"]["TANGENT"] = json!(accessors);
    primitive["attributes"]["JOINTS_0"] = json!("x");
    primitive["attributes"]["_OWN"] = json!(99);
    primitive["targets"] = json!([{ "POSITION": 0, "NORMAL": accessors }]);
    primitive["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [0] }] } });
    before["materials"][0]["normalTexture"] = json!({ "index": images });
    before["meshes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "primitives": [{ "attributes": { "POSITION": accessors + 1 } }] }));
    before["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "mesh": 3, "children": [9] }));
    before["images"][0] = json!({ "uri": "data:image/png;base64,AAAA" });
    fs::write(&input, glb(&before, &bin)).unwrap();
    let scene = scene::load(&input).unwrap();
    for split in [false, true] {
        let path = write(&scene, &layout(&scene, split, 1), dir.path(), "out.glb");
        let (after, _) = open(&path);
        let primitive = &after["meshes"][0]["primitives"][0];
        let mut names: Vec<&String> = primitive["attributes"]
            .as_object()
            .unwrap()
            .keys()
            .collect();
        names.sort();
        assert_eq!(
            names,
            ["POSITION", "TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2"]
        );
        let target = primitive["targets"][0].as_object().unwrap();
        assert!(target.len() == 1 && target.contains_key("POSITION"));
        let variants = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
        assert_eq!(variants, &json!([]));
        assert_eq!(after["meshes"][2]["primitives"][0]["attributes"], json!({}));
        assert_eq!(after["nodes"][2], json!({ "children": [] }));
        let materials = after["materials"].as_array().unwrap();
        assert!(materials.iter().all(|m| m.get("normalTexture").is_none()));
        assert_eq!(corners(&scene::load(&path).unwrap()), corners(&scene));
    }
}

#[test]
fn vertex_colours_of_an_obj_come_back_from_its_glb() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("a.obj");
    fs::write(
        &input,
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n",
    )
    .unwrap();
    let before = scene::load(&input).unwrap();
    let path = write(&before, &layout(&before, false, 1), dir.path(), "a.glb");
    let after = scene::load(&path).unwrap();
    assert_eq!(after.meshes[0].colors, before.meshes[0].colors);
    assert_eq!(after.meshes[0].colors[1], glam::Vec3::Y);
    assert_valid(&[path]);
}
