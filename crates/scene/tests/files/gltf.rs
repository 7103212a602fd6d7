//! glTF and GLB.

use super::support::{Document, F32, Folder, U8, U16, U32, push};
use ambake_scene::WarningKind;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec3, Vec2, Vec3};
use serde_json::{Value, json};

#[test]
fn all_index_types_and_none_give_the_same_triangles() {
    let expected = [[0, 1, 2], [0, 2, 3]];
    let order = [0u32, 1, 2, 0, 2, 3];
    for component in [U8, U16, U32] {
        let mut document = Document::square();
        let width = [1, 2, 4][(component as usize - U8 as usize) / 2];
        let bytes: Vec<u8> = order
            .iter()
            .flat_map(|i| i.to_le_bytes()[..width].to_vec())
            .collect();
        let indices = document.accessor(component, "SCALAR", 6, &bytes);
        document.primitive()["indices"] = json!(indices);
        assert_eq!(
            document.load().unwrap().meshes[0].triangles,
            expected,
            "component type {component}"
        );
    }
    assert_eq!(
        Document::triangle().load().unwrap().meshes[0].triangles,
        [[0, 1, 2]]
    );
}

#[test]
fn strips_and_fans_keep_their_orientation() {
    for (mode, expected) in [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[1, 2, 0], [2, 3, 0]])] {
        let mut document = Document::square();
        document.primitive()["mode"] = json!(mode);
        assert_eq!(
            document.load().unwrap().meshes[0].triangles,
            expected,
            "mode {mode}"
        );
    }
    let mut document = Document::square();
    document.primitive()["mode"] = json!(1);
    let error = document.load().unwrap_err().to_string();
    assert!(
        error.contains("no triangle") && error.contains("; a primitive without surface"),
        "{error}"
    );
}

#[test]
fn sparse_normalised_and_interleaved_accessors_are_decoded() {
    let mut document = Document::triangle();
    // Sparse over nothing: zeros but for vertices 1 and 2.
    let indices = document.view(&[1, 2]);
    let values: Vec<u8> = [2.0f32, 0., 0., 0., 2., 0.]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let values = document.view(&values);
    let sparse = json!({ "count": 2, "indices": { "bufferView": indices, "componentType": U8 },
                         "values": { "bufferView": values } });
    let accessor = json!({ "componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse });
    let positions = push(&mut document.json["accessors"], accessor);
    document.primitive()["attributes"]["POSITION"] = json!(positions);
    // Normals as signed bytes and UVs as unsigned shorts, normalised, in one interleaved view of stride 8.
    let vertex = [0u8, 0, 127, 0, 0xff, 0xff, 0, 0];
    let view = document.view(&vertex.repeat(3));
    document.json["bufferViews"][view]["byteStride"] = json!(8);
    let normal = json!({ "bufferView": view, "componentType": 5120, "normalized": true, "type": "VEC3", "count": 3 });
    let uv = json!({ "bufferView": view, "byteOffset": 4, "componentType": U16, "normalized": true, "type": "VEC2",
                     "count": 3 });
    let normal = push(&mut document.json["accessors"], normal);
    let uv = push(&mut document.json["accessors"], uv);
    document.primitive()["attributes"]["NORMAL"] = json!(normal);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    document.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let mesh = document.load().unwrap().meshes.remove(0);
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0]);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    assert_eq!(mesh.uv_sets, [[Vec2::X; 3]]);
}

#[test]
fn transforms_compose_down_the_tree_with_negative_scale_and_matrices() {
    let mut document = Document::triangle();
    let matrix = [
        0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 1., 0., 5., 0., 0., 1.,
    ];
    document.json["nodes"] = json!([
        { "name": "root", "scale": [-1, 2, 3], "translation": [10, 0, 0], "children": [1, 2] },
        { "name": "leaf", "mesh": 0, "matrix": matrix },
        { "mesh": 0, "scale": [1, 0, 1] },
    ]);
    let scene = document.load().unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 1));
    let leaf = &scene.instances[0];
    assert_eq!(
        (leaf.name.as_str(), leaf.node),
        ("leaf / mesh 0 primitive 0", 1)
    );
    // (1, 0, 0) turns to (0, 1, 0), moves to (5, 1, 0), is scaled to (-5, 2, 0) and moves to (5, 2, 0).
    assert_eq!(
        leaf.transform.transform_point3(DVec3::X),
        DVec3::new(5.0, 2.0, 0.0)
    );
    assert_eq!(scene.warned(WarningKind::SingularTransforms), 1);
}

#[test]
fn several_nodes_share_one_mesh_and_gpu_instancing_multiplies_it() {
    let mut document = Document::triangle();
    let places = document.floats("VEC3", &[0., 0., 1., 0., 0., 2.]);
    let turns = document.accessor(5120, "VEC4", 2, &[0, 0, 0, 127, 127, 0, 0, 0]);
    document.json["accessors"][turns]["normalized"] = json!(true);
    let attributes = json!({ "TRANSLATION": places, "ROTATION": turns });
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    document.json["nodes"] =
        json!([{ "mesh": 0, "scale": [2, 2, 2], "extensions": instancing }, { "mesh": 0 }]);
    document.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    document.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = document.load().unwrap();
    let copies: Vec<_> = scene
        .instances
        .iter()
        .map(|i| (i.mesh, i.node, i.copy))
        .collect();
    assert_eq!(copies, [(0, 0, Some(0)), (0, 0, Some(1)), (0, 1, None)]);
    // The second copy is turned by half a turn about x.
    assert_eq!(
        scene.instances[1].transform.transform_point3(DVec3::Y),
        DVec3::new(0.0, -2.0, 4.0)
    );
}

#[test]
fn the_scene_is_the_default_one_else_the_first_else_every_root() {
    let mut document = Document::triangle();
    document.json["nodes"] = json!([{ "mesh": 0, "children": [1] }, { "mesh": 0 }, { "mesh": 0 }]);
    document.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    let instances = |document: &Document| document.load().unwrap().instances.len();
    assert_eq!(instances(&document), 1);
    document.json["scene"] = json!(1);
    assert_eq!(instances(&document), 2);
    document
        .json
        .as_object_mut()
        .unwrap()
        .retain(|key, _| !key.starts_with("scene"));
    assert_eq!(instances(&document), 3);
}

#[test]
fn buffers_come_from_data_uris_and_percent_encoded_files() {
    let (document, folder) = (Document::triangle(), Folder::new());
    let data = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&document.bin)
    );
    assert_eq!(
        folder.load("a.gltf", document.gltf(&data)).unwrap().meshes[0]
            .triangles
            .len(),
        1
    );
    folder.write("my buffer.bin", &document.bin);
    let text = document.gltf("my%20buffer.bin");
    let scene = folder.load("b.gltf", format!("\u{feff}{text}")).unwrap();
    let read = [format!("\u{feff}{text}").as_bytes(), &document.bin].concat();
    assert_eq!(scene.content_hash, blake3::hash(&read).to_hex().to_string());
}

#[test]
fn a_large_shared_vertex_array_is_loaded_only_where_it_is_used() {
    let mut document = Document::triangle();
    let positions: Vec<f32> = (0..30_000).map(|i| ((i * i) % 97) as f32).collect();
    let positions = document.floats("VEC3", &positions);
    let bytes: Vec<u8> = [9000u16, 17, 4000]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let indices = document.accessor(U16, "SCALAR", 3, &bytes);
    document.primitive()["attributes"]["POSITION"] = json!(positions);
    document.primitive()["indices"] = json!(indices);
    let mesh = document.load().unwrap().meshes.remove(0);
    assert_eq!((mesh.positions.len(), mesh.triangles[0]), (3, [2, 0, 1]));
    let vertex =
        |v: u64| Vec3::from_array([0, 1, 2].map(|k| (((3 * v + k) * (3 * v + k)) % 97) as f32));
    assert_eq!(mesh.positions, [vertex(17), vertex(4000), vertex(9000)]);
}

#[test]
fn bad_normals_fall_back_to_the_geometry_and_bad_uvs_to_the_origin() {
    let mut document = Document::triangle();
    let normals = document.floats("VEC3", &[0., 0., 0., f32::NAN, 0., 0., 0., 5., 0.]);
    let uvs = document.floats("VEC2", &[f32::INFINITY, 0., 1., 1., 0.5, 0.5]);
    document.primitive()["attributes"]["NORMAL"] = json!(normals);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    let scene = document.load().unwrap();
    assert_eq!(scene.meshes[0].normals, [Vec3::Z, Vec3::Z, Vec3::Y]);
    assert_eq!(scene.meshes[0].uv_sets[0][0], Vec2::ZERO);
    assert_eq!(
        (
            scene.warned(WarningKind::BadNormals),
            scene.warned(WarningKind::BadUvs)
        ),
        (2, 1)
    );
}

/// What is done to a document, in words and in deed.
type Edit = (&'static str, fn(&mut Document));

#[test]
fn what_a_bake_does_not_read_cannot_have_a_file_refused() {
    let edits: [Edit; 9] = [
        ("an animation channel without a node", |d| {
            d.json["animations"] = json!([{ "samplers": [{ "input": 0, "output": 0 }],
                "channels": [{ "sampler": 0, "target": { "path": "translation" } }] }]);
        }),
        ("KHR_animation_pointer", |d| {
            let pointer = json!({ "KHR_animation_pointer": { "pointer": "/nodes/0/scale" } });
            d.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
            d.json["animations"] = json!([{ "samplers": [{ "input": 0, "output": 0 }],
                "channels": [{ "sampler": 0, "target": { "path": "pointer", "extensions": pointer } }] }]);
        }),
        ("a second scene without nodes", |d| {
            d.json["scenes"] = json!([{ "nodes": [0] }, { "name": "Scene.001" }]);
        }),
        ("a camera of no known kind", |d| {
            d.json["cameras"] = json!([{ "type": "fisheye" }]);
            d.json["nodes"][0]["camera"] = json!(7);
        }),
        ("an attribute with a name of its own", |d| {
            d.primitive()["attributes"]["WEIGHT"] = json!(0);
        }),
        ("a morph target of coordinates", |d| {
            d.primitive()["targets"] = json!([{ "TEXCOORD_0": 0 }]);
        }),
        (
            "an accessor of no known type that only an animation reads",
            |d| {
                push(
                    &mut d.json["accessors"],
                    json!({ "componentType": 5130, "type": "VEC9" }),
                );
            },
        ),
        ("an occlusion texture that is nowhere", |d| {
            d.json["materials"] = json!([{ "occlusionTexture": { "index": 5 } }]);
        }),
        ("a last row that is off by rounding", |d| {
            let matrix = [
                1., 0., 0., 1e-7, 0., 1., 0., 0., 0., 0., 1., -3e-8, 0., 0., 0., 0.9999999,
            ];
            d.json["nodes"][0]["matrix"] = json!(matrix);
        }),
    ];
    for (what, edit) in edits {
        let mut document = Document::triangle();
        edit(&mut document);
        let scene = document.load().unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]], "{what}");
        assert_eq!(
            scene.instances[0].transform,
            glam::DAffine3::IDENTITY,
            "{what}"
        );
    }
}

#[test]
fn a_default_scene_without_nodes_is_empty_and_a_scene_that_is_not_there_is_refused() {
    for (scenes, scene, says) in [
        (json!([{ "nodes": [0] }, {}]), 1, "no triangle"),
        (json!([{ "nodes": [0] }]), 3, "scene 3 does not exist"),
        (
            json!([{ "nodes": [4] }]),
            0,
            "names the node 4, but there are 1",
        ),
    ] {
        let mut document = Document::triangle();
        document.json["scenes"] = scenes;
        document.json["scene"] = json!(scene);
        let error = document.load().unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn hidden_nodes_and_all_below_them_are_absent() {
    let visible = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    let mut document = Document::triangle();
    document.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    document.json["nodes"] = json!([
        { "mesh": 0, "extensions": visible(true), "children": [1, 4] },
        { "mesh": 0, "extensions": visible(false), "children": [2] },
        { "mesh": 0, "extensions": visible(true), "children": [3] },
        { "mesh": 0 },
        { "mesh": 0, "extensions": { "KHR_node_visibility": {} } },
    ]);
    let scene = document.load().unwrap();
    let nodes: Vec<u32> = scene.instances.iter().map(|i| i.node).collect();
    assert_eq!(nodes, [0, 4]);
    document.json["nodes"][0]["extensions"] = visible(false);
    let error = document.load().unwrap_err().to_string();
    assert!(error.contains("hidden"), "{error}");
}

#[test]
fn what_has_an_empty_name_is_called_by_its_number_as_what_has_none() {
    for empty in [json!(""), json!(" \t"), Value::Null] {
        let mut document = Document::triangle();
        document.json["materials"] = json!([{ "name": empty }]);
        document.primitive()["material"] = json!(0);
        document.json["meshes"][0]["name"] = empty.clone();
        document.json["nodes"] =
            json!([{ "name": empty, "mesh": 0 }, { "name": empty, "mesh": 0 }]);
        document.json["scenes"] = json!([{ "nodes": [0, 1] }]);
        let scene = document.load().unwrap();
        let names = scene.instances.iter().map(|of| of.name.as_str());
        let names: Vec<_> = names.chain([scene.materials[0].name.as_str()]).collect();
        assert_eq!(
            names,
            [
                "node 0 / mesh 0 primitive 0",
                "node 1 / mesh 0 primitive 0",
                "material 0"
            ],
            "{empty}"
        );
    }
}

#[test]
fn integers_may_be_written_as_floats() {
    let mut document = Document::triangle();
    let indices = document.accessor(U8, "SCALAR", 3, &[2, 0, 1]);
    document.primitive()["indices"] = json!(indices);
    document.json["scene"] = json!(0);
    document.json["asset"]["extras"] = json!({ "count": 1.0 });
    let plain = document.load().unwrap();
    fn float(value: &mut Value) {
        match value {
            Value::Number(number) => {
                *number = serde_json::Number::from_f64(number.as_f64().unwrap()).unwrap()
            }
            Value::Array(items) => items.iter_mut().for_each(float),
            Value::Object(fields) => fields.iter_mut().for_each(|(_, value)| float(value)),
            _ => {}
        }
    }
    float(&mut document.json);
    assert!(document.json.to_string().contains("\"byteLength\":36.0"));
    let scene = document.load().unwrap();
    assert_eq!(scene.meshes[0].triangles, [[2, 0, 1]]);
    assert_eq!(scene.meshes[0].positions, plain.meshes[0].positions);
    let json = &scene.source.as_ref().unwrap().json;
    assert_eq!(
        json.to_string(),
        plain.source.as_ref().unwrap().json.to_string()
    );
    assert_eq!(json["asset"]["extras"].to_string(), "{\"count\":1.0}");
    document.json["meshes"][0]["primitives"][0]["indices"] = json!(0.5);
    document.load().unwrap_err();
}

#[test]
fn what_no_surface_needs_refuses_no_file() {
    let mut document = Document::triangle();
    // An accessor without data holds zeros: its triangle has no area. A primitive without POSITION has none either.
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 3 });
    let zeros = push(&mut document.json["accessors"], zeros);
    let bare = json!({ "attributes": { "NORMAL": 0 } });
    let primitives = &mut document.json["meshes"][0]["primitives"];
    push(primitives, json!({ "attributes": { "POSITION": zeros } }));
    push(primitives, bare);
    let scene = document.load().unwrap();
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(scene.warned(WarningKind::EmptyMeshes), 2);
    assert_eq!(scene.warned(WarningKind::ZeroAreaTriangles), 1);
}

#[test]
fn a_buffer_that_cannot_be_had_refuses_only_what_reads_it() {
    let document = Document::triangle();
    let data = format!("data:;base64,{}", STANDARD.encode(&document.bin));
    for gone in [
        json!({ "byteLength": 12 }),
        json!({ "byteLength": 12, "uri": "https://a.example/b.bin" }),
        json!({ "byteLength": 12, "uri": "gone.bin" }),
        json!({ "byteLength": 12, "uri": "data:,abc" }),
    ] {
        for place in [0, 1] {
            let mut json = document.json.clone();
            let mut buffers = vec![json!({ "byteLength": document.bin.len(), "uri": data })];
            buffers.insert(place, gone.clone());
            json["buffers"] = json!(buffers);
            json["bufferViews"][0]["buffer"] = json!(1 - place);
            let view = json!({ "buffer": place, "byteLength": 12 });
            let unread = push(&mut json["bufferViews"], view);
            let accessor =
                json!({ "bufferView": unread, "componentType": 5126, "type": "VEC3", "count": 1 });
            let unread = push(&mut json["accessors"], accessor);
            let folder = Folder::new();
            let scene = folder.load("a.gltf", json.to_string()).unwrap();
            assert_eq!(scene.meshes[0].positions[1], Vec3::X);
            // What stays of it for a writer is what the file had, and still no one's bytes.
            let source = scene.source.as_ref().unwrap();
            let kept = source.json["bufferViews"][1]["buffer"].as_u64().unwrap() as usize;
            assert_eq!(source.json["buffers"][kept], gone);
            assert!(source.accessor(unread).is_err() && source.buffers[kept].is_empty());
            json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(unread);
            let error = folder
                .load("a.gltf", json.to_string())
                .unwrap_err()
                .to_string();
            assert!(
                error.contains(&format!("accessor {unread}: buffer {place}: ")),
                "{error}"
            );
        }
    }
}
