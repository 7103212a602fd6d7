//! glTF and GLB.

use super::support::{Document, F32, Folder, U8, U16, U32, png, push};
use ambake_scene::{Alpha, Surface, Warning, WarningKind};
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
fn materials_follow_the_file_and_a_primitive_without_one_is_untinted() {
    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0.; 6]);
    let image = document.view(&png(&[[255, 255, 255, 0], [255, 255, 255, 255]]));
    document.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    document.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    document.json["textures"] =
        json!([{ "source": 0, "sampler": 0 }, { "extensions": { "KHR_texture_basisu": {} } }]);
    let turned = json!({ "KHR_texture_transform": { "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3],
                         "offset": [0.5, 1], "texCoord": 1 } });
    document.json["materials"] = json!([
        {},
        { "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 3, 0.75], "baseColorTexture":
            { "index": 0, "extensions": turned } }, "extensions": { "KHR_materials_ior": { "ior": 2 },
            "KHR_materials_specular": { "specularFactor": 0.5 }, "KHR_materials_sheen": { "sheenColorFactor": [0, 1, 0] } } },
        { "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 } }, "normalTexture": { "index": 0 } },
    ]);
    let positions = document.primitive()["attributes"]["POSITION"].clone();
    let primitive = |material: Option<u32>, sets: usize| {
        let mut primitive = json!({ "attributes": { "POSITION": positions } });
        (0..sets).for_each(|n| primitive["attributes"][format!("TEXCOORD_{n}")] = json!(uvs));
        material
            .into_iter()
            .for_each(|m| primitive["material"] = json!(m));
        primitive
    };
    let primitives = [
        primitive(Some(1), 2),
        primitive(None, 0),
        primitive(Some(0), 0),
        primitive(Some(1), 1),
        primitive(Some(2), 1),
    ];
    document.json["meshes"] = json!([{ "name": "m", "primitives": primitives }]);
    let scene = document.load().unwrap();

    let Surface::MetallicRoughness {
        metallic,
        roughness,
        base,
        ..
    } = scene.materials[0].surface
    else {
        panic!()
    };
    assert_eq!((metallic, roughness, base), (1.0, 1.0, Vec3::ONE));
    let tinted = &scene.materials[scene.meshes[0].material as usize];
    let Surface::MetallicRoughness {
        base,
        base_map: Some(map),
        dielectric,
        ..
    } = &tinted.surface
    else {
        panic!()
    };
    assert_eq!(*base, Vec3::new(0.5, 1.0, 1.0));
    assert_eq!(*dielectric, Vec3::splat((1.0f64 / 9.0) as f32 * 0.5));
    assert_eq!(
        (map.uv_set, map.linear, map.wrap),
        (
            1,
            false,
            [ambake_scene::Wrap::Clamp, ambake_scene::Wrap::Mirror]
        )
    );
    // A quarter turn counter-clockwise in a picture whose v grows down: u goes to -v, v to u.
    let expected = [[0.0, 3.0, 0.5], [-2.0, 0.0, 1.0]];
    let close = map
        .transform
        .iter()
        .flatten()
        .zip(expected.iter().flatten())
        .all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close, "{:?}", map.transform);
    assert!(matches!(
        tinted.alpha,
        Alpha::Blend {
            factor: 0.75,
            map: Some(_)
        }
    ));

    let untinted = &scene.materials[scene.meshes[1].material as usize];
    assert!(matches!(
        untinted.surface,
        Surface::Phong {
            albedo: Vec3::ONE,
            specular: Vec3::ZERO,
            ..
        }
    ));
    // The fourth primitive has one UV set, its texture reads the second: it gets the material without texture.
    let reduced = &scene.materials[scene.meshes[3].material as usize];
    assert!(matches!(
        reduced.surface,
        Surface::MetallicRoughness { base_map: None, .. }
    ));
    let kinds = [
        WarningKind::UnreadTextures,
        WarningKind::IgnoredExtensions,
        WarningKind::ClampedFactors,
        WarningKind::TexturesWithoutUvs,
        WarningKind::IgnoredNormalMaps,
    ];
    assert_eq!(kinds.map(|kind| scene.warned(kind)), [1, 1, 1, 2, 1]);
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

/// A triangle whose base colour is texture 0.
fn textured(textures: Value, images: impl FnOnce(&mut Document) -> Value) -> Document {
    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0.; 6]);
    document.json["images"] = images(&mut document);
    document.json["textures"] = textures;
    document.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }]);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    document.primitive()["material"] = json!(0);
    document
}

#[test]
fn webp_is_decoded_where_its_extension_alone_names_it() {
    let mut webp = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut webp)
        .encode(&[10, 20, 30, 255], 1, 1, image::ExtendedColorType::Rgba8)
        .unwrap();
    let textures = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    let mut document = textured(textures, |document| {
        let view = document.view(&webp);
        json!([{ "bufferView": view, "mimeType": "image/webp" }])
    });
    document.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    document.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let scene = document.load().unwrap();
    assert_eq!(scene.images[0].pixels, [[10, 20, 30, 255]]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn textures_that_are_not_read_are_warned_of_and_the_scene_is_loaded() {
    for (extension, format) in [
        ("KHR_texture_basisu", "KTX2"),
        ("EXT_texture_avif", "AVIF"),
        ("MSFT_texture_dds", "DDS"),
    ] {
        let textures = json!([{ "extensions": { extension: { "source": 0 } } }]);
        let mut document = textured(textures, |_| json!([{ "uri": "gone.bin" }]));
        document.json["extensionsUsed"] = json!([extension]);
        document.json["extensionsRequired"] = json!([extension]);
        let scene = document.load().unwrap();
        let unread = |w: &&Warning| w.kind == WarningKind::UnreadTextures;
        let warning = scene.warnings.iter().find(unread).expect(extension);
        assert!(warning.message.contains(format), "{}", warning.message);
        // Its number is no part of the message, so that all such textures are told of in one line.
        assert_eq!(warning.place, "texture 0 of material 0");
        assert!(!warning.message.contains("texture 0"));
        assert!(scene.images.is_empty());
    }
}

#[test]
fn metals_by_omission_are_named_where_they_are_used() {
    let metals = |pbr: Value, used: usize| {
        let mut document = textured(json!([{ "source": 0 }]), |document| {
            let view = document.view(&png(&[[255; 4]]));
            json!([{ "bufferView": view, "mimeType": "image/png" }])
        });
        document.json["materials"] = json!([
            { "name": "two words %", "pbrMetallicRoughness": pbr },
            { "pbrMetallicRoughness": { "metallicFactor": 0 } }
        ]);
        document.primitive()["material"] = json!(used);
        document.load().unwrap().warnings
    };
    for black in [
        json!({}),
        json!({ "metallicFactor": 1, "roughnessFactor": 0.3 }),
    ] {
        let warnings = metals(black.clone(), 0);
        let [warning] = &warnings[..] else {
            panic!("{black}: {warnings:?}")
        };
        assert_eq!(warning.kind, WarningKind::BlackMetals);
        assert_eq!(warning.place, "material `two words %`");
        assert!(warning.message.contains("metallicFactor"), "{warning:?}");
        assert!(metals(black, 1).is_empty(), "nothing wears it");
    }
    let mapped = json!({ "metallicRoughnessTexture": { "index": 0 } });
    for other in [mapped, json!({ "metallicFactor": 0.99 })] {
        assert!(metals(other.clone(), 0).is_empty(), "{other}");
    }
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
fn vertex_colours_of_every_type_multiply_base_colour_and_alpha() {
    // Shares of 255: a corner of each.
    let codes = [[255u8, 0, 51, 255], [0, 255, 102, 0], [51, 51, 255, 51]];
    let shares = codes.map(|c| c.map(|c| f32::from(c) / 255.0));
    for lanes in [3, 4] {
        let of = |corner: usize| codes[corner][..lanes].to_vec();
        let bytes: Vec<Vec<u8>> = (0..3).map(of).collect();
        for (component, normalized) in [
            (U8, true),
            (U8, false),
            (U16, true),
            (U16, false),
            (F32, false),
        ] {
            let mut document = Document::triangle();
            let encoded = |code: &u8| match component {
                U8 => vec![*code],
                U16 => (u16::from(*code) * 257).to_le_bytes().to_vec(),
                _ => (f32::from(*code) / 255.0).to_le_bytes().to_vec(),
            };
            // Vertices begin on multiples of four.
            let vertex = |corner: &Vec<u8>| {
                let mut bytes: Vec<u8> = corner.iter().flat_map(encoded).collect();
                bytes.resize(bytes.len().next_multiple_of(4), 0);
                bytes
            };
            let data: Vec<u8> = bytes.iter().flat_map(vertex).collect();
            let color = document.accessor(
                component,
                if lanes == 3 { "VEC3" } else { "VEC4" },
                3,
                &data,
            );
            document.json["accessors"][color]["normalized"] = json!(normalized);
            let view = document.json["accessors"][color]["bufferView"]
                .as_u64()
                .unwrap() as usize;
            document.json["bufferViews"][view]["byteStride"] = json!(data.len() / 3);
            document.primitive()["attributes"]["COLOR_0"] = json!(color);
            let mesh = document.load().unwrap().meshes.remove(0);
            let expected = shares.map(|[r, g, b, _]| Vec3::new(r, g, b));
            assert_eq!(mesh.colors, expected, "{lanes} x {component}");
            let alphas: &[f32] = if lanes == 3 {
                &[]
            } else {
                &shares.map(|c| c[3])
            };
            assert_eq!(mesh.alphas, alphas, "{lanes} x {component}");
        }
    }
    let mut white = Document::triangle();
    let color = white.floats("VEC4", &[1.0; 12]);
    white.primitive()["attributes"]["COLOR_0"] = json!(color);
    let mesh = white.load().unwrap().meshes.remove(0);
    assert!(mesh.colors.is_empty() && mesh.alphas.is_empty());
}

#[test]
fn specular_glossiness_and_transmission_are_read_with_their_textures() {
    let mut document = textured(json!([{ "source": 0 }]), |document| {
        let view = document.view(&png(&[[255, 255, 255, 128]]));
        json!([{ "bufferView": view, "mimeType": "image/png" }])
    });
    let texture = json!({ "index": 0 });
    document.wear(json!([
        { "alphaMode": "MASK", "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 1, 0.75], "diffuseTexture": texture, "specularFactor": [0.25, 0.5, 0],
            "glossinessFactor": 0.5, "specularGlossinessTexture": texture } } },
        { "alphaMode": "BLEND", "extensions": { "KHR_materials_pbrSpecularGlossiness": {} } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_transmission": {
            "transmissionFactor": 0.75, "transmissionTexture": texture } } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_transmission": {} } },
    ]));
    let scene = document.load().unwrap();
    // The second is a mirror.
    let warned = scene.warnings.iter().map(|w| (w.kind, w.place.as_str()));
    assert_eq!(
        warned.collect::<Vec<_>>(),
        [(WarningKind::BlackMetals, "material `material 1`")]
    );
    let Surface::SpecularGlossiness {
        diffuse,
        diffuse_map: Some(_),
        specular,
        glossiness,
        specular_glossiness_map: Some(_),
    } = &scene.materials[0].surface
    else {
        panic!("{:?}", scene.materials[0].surface)
    };
    assert_eq!(
        (*diffuse, *specular, *glossiness),
        (Vec3::new(0.5, 0.25, 1.0), Vec3::new(0.25, 0.5, 0.0), 0.5)
    );
    assert!(matches!(
        scene.materials[0].alpha,
        Alpha::Mask {
            factor: 0.75,
            map: Some(_),
            cutoff: 0.5
        }
    ));
    let Surface::SpecularGlossiness {
        diffuse,
        specular,
        glossiness,
        ..
    } = scene.materials[1].surface
    else {
        panic!()
    };
    assert_eq!(
        (diffuse, specular, glossiness),
        (Vec3::ONE, Vec3::ONE, 1.0),
        "the defaults of its text"
    );
    assert!(
        scene.materials[2]
            .transmission
            .as_ref()
            .is_some_and(|t| t.factor == 0.75 && t.map.is_some())
    );
    assert!(!scene.materials[2].is_opaque());
    assert!(scene.materials[3].is_opaque(), "a factor of 0");
    document.json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 0, 0, 1]);
    document.json["meshes"][0]["primitives"][0]["material"] = json!(2);
    let scene = document.load().unwrap();
    assert_eq!(
        scene.warned(WarningKind::GreyTransmission),
        1,
        "{:?}",
        scene.warnings
    );
}

#[test]
fn black_metals_are_told_of_by_what_the_file_says() {
    for (pbr, says) in [
        (json!({}), "where no metallicFactor is given"),
        (
            json!({ "metallicFactor": 1 }),
            "all metal by its metallicFactor",
        ),
    ] {
        let mut document = Document::triangle();
        document.json["materials"] = json!([{ "pbrMetallicRoughness": pbr }]);
        document.primitive()["material"] = json!(0);
        let warnings = document.load().unwrap().warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(warnings[0].kind, WarningKind::BlackMetals);
        assert!(
            warnings[0].message.contains(says),
            "{}",
            warnings[0].message
        );
    }
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
fn mirrors_are_told_of_as_metals_with_what_makes_them_other() {
    let warnings = |material: &Value| {
        let mut document = Document::triangle();
        document.json["materials"] = json!([material]);
        document.primitive()["material"] = json!(0);
        document.load().unwrap().warnings
    };
    let glossy = |of: Value| json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": of } });
    let with_ior = |metallic: f64, ior: f64| {
        json!({ "pbrMetallicRoughness": { "metallicFactor": metallic },
                "extensions": { "KHR_materials_ior": { "ior": ior } } })
    };
    let diffuse = [0.6, 0.5, 0.4, 1.0];
    for (mirror, says, cure) in [
        (
            glossy(json!({ "diffuseFactor": diffuse })),
            "without a specularFactor",
            "specularFactor of 0.04",
        ),
        (
            glossy(json!({ "specularFactor": [0.2, 1.0, 0.0] })),
            "by its specularFactor",
            "specularFactor of 0.04",
        ),
        (with_ior(0.0, 0.0), "by KHR_materials_ior", "an ior of 1.5"),
    ] {
        let warnings = warnings(&mirror);
        let kinds: Vec<_> = warnings.iter().map(|warning| warning.kind).collect();
        assert_eq!(kinds, [WarningKind::BlackMetals], "{warnings:?}");
        let message = &warnings[0].message;
        assert!(
            message.contains(says) && message.contains(cure),
            "{message}"
        );
    }
    for other in [
        glossy(json!({ "specularFactor": [0.04, 0.04, 0.04] })),
        with_ior(0.0, 1.5),
    ] {
        assert!(warnings(&other).is_empty(), "{other}");
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
