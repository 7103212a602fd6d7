//! Files that gltfpack and gltf-transform have compressed, against what their own decoders make of them.

use super::support::Folder;
use ambake_scene::{Scene, load};
use glam::Vec3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files/compressed")
        .join(name)
}

fn scene(name: &str) -> Scene {
    load(&path(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// The two hold the same, value by value.
fn assert_same(name: &str, a: &Scene, b: &Scene) {
    assert_eq!(a.meshes.len(), b.meshes.len(), "{name}");
    for (a, b) in a.meshes.iter().zip(&b.meshes) {
        assert_eq!(a.positions, b.positions, "{name}");
        assert_eq!(a.normals, b.normals, "{name}");
        assert_eq!(a.uv_sets, b.uv_sets, "{name}");
        assert_eq!(a.triangles, b.triangles, "{name}");
    }
    let places = |scene: &Scene| -> Vec<_> {
        let instances = scene.instances.iter();
        instances
            .map(|i| (i.name.clone(), i.mesh, i.transform))
            .collect()
    };
    assert_eq!(places(a), places(b), "{name}");
}

#[test]
fn compressed_files_are_what_their_makers_decode() {
    for name in [
        "pack",
        "pack_float",
        "transform",
        "draco",
        "draco_sequential",
    ] {
        let packed = scene(&format!("{name}.glb"));
        assert_eq!(packed.meshes.len(), 2, "{name}");
        assert_same(name, &packed, &scene(&format!("{name}.plain.glb")));
    }
    // The later name of the extension holds the same quantised numbers.
    assert_same("pack_khr", &scene("pack_khr.glb"), &scene("pack.glb"));
}

#[test]
fn what_is_kept_of_a_compressed_file_is_plain() {
    for name in ["pack.glb", "pack_khr.glb", "transform.glb", "draco.glb"] {
        let scene = scene(name);
        let document = scene.source.expect("a document");
        let text = document.json.to_string();
        assert!(!text.contains("compression"), "{name}: {text}");
        assert_eq!(document.buffers.len(), 1, "{name}");
        for primitive in document.json["meshes"].as_array().into_iter().flatten() {
            let positions = primitive["primitives"][0]["attributes"]["POSITION"].as_u64();
            let accessor = &document.json["accessors"][positions.expect("positions") as usize];
            let of_mesh = |mesh: &&ambake_scene::Mesh| {
                Some(mesh.positions.len() as u64) == accessor["count"].as_u64()
            };
            let bounds = scene.meshes.iter().filter(of_mesh).map(|mesh| {
                let (low, high) = mesh
                    .positions
                    .iter()
                    .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                        (low.min(*p), high.max(*p))
                    });
                [json!(low.to_array()), json!(high.to_array())]
            });
            let told = [accessor["min"].clone(), accessor["max"].clone()];
            assert!(
                bounds.clone().any(|of| of == told) || name != "draco.glb",
                "{name}: {told:?}, {:?}",
                bounds.collect::<Vec<_>>()
            );
        }
        assert_eq!(
            document.json["buffers"][0]["byteLength"],
            document.buffers[0].len()
        );
        assert!(
            document.json["buffers"]
                .as_array()
                .is_some_and(|b| b.len() == 1)
        );
    }
}

/// A fixture with its JSON changed.
fn edited(name: &str, edit: impl Fn(&mut Value)) -> Vec<u8> {
    let bytes = std::fs::read(path(name)).expect("a fixture");
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    edit(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = bytes[..12].to_vec();
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend(&bytes[20 + length..]);
    let total = out.len() as u32;
    out[8..12].copy_from_slice(&total.to_le_bytes());
    out
}

#[test]
fn damaged_compression_of_what_no_node_places_refuses_nothing() {
    // A copy of the first mesh, whose data are damaged, beside those that are placed.
    let spoiled = |json: &mut Value| {
        let push = |json: &mut Value, key: &str, value: Value| {
            let list = json[key].as_array_mut().expect("a list");
            list.push(value);
            list.len() - 1
        };
        let mut primitive = json["meshes"][0]["primitives"][0].clone();
        let packed = "KHR_draco_mesh_compression";
        let names: Vec<String> = (primitive["attributes"].as_object().expect("attributes"))
            .keys()
            .cloned()
            .collect();
        let places = names.iter().map(|name| format!("/attributes/{name}"));
        for place in places.chain(["/indices".into()]) {
            let number = primitive.pointer(&place).and_then(Value::as_u64).unwrap() as usize;
            let mut accessor = json["accessors"][number].clone();
            if let Some(view) = accessor["bufferView"].as_u64() {
                let mut view = json["bufferViews"][view as usize].clone();
                view["extensions"]["EXT_meshopt_compression"]["byteLength"] = json!(3);
                accessor["bufferView"] = push(json, "bufferViews", view).into();
            }
            *primitive.pointer_mut(&place).unwrap() = push(json, "accessors", accessor).into();
        }
        if let Some(stream) = primitive["extensions"].get_mut(packed) {
            stream["bufferView"] = json!(99);
        }
        push(json, "meshes", json!({ "primitives": [primitive] }));
    };
    for name in ["pack.glb", "draco.glb"] {
        let folder = Folder::new();
        let loaded = folder.load("a.glb", edited(name, spoiled));
        let loaded = loaded.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_same(name, &loaded, &scene(name));
    }
}

#[test]
fn a_missing_buffer_is_named_whether_it_is_compressed_or_not() {
    let folder = Folder::new();
    let missing = |json: &mut Value| json["buffers"][0]["uri"] = json!("house.bin");
    for name in ["pack", "draco"] {
        let line = |file: &str| {
            let loaded = folder.load("a.glb", edited(file, missing)).map(drop);
            loaded.expect_err(file).to_string()
        };
        // The accessor that wants it first is another one in each.
        for file in [format!("{name}.plain.glb"), format!("{name}.glb")] {
            let line = line(&file);
            assert!(
                line.contains("buffer 0: cannot read") && line.contains("house.bin: "),
                "{file}: {line}"
            );
            assert!(!line.contains("export it again"), "{file}: {line}");
        }
    }
}

#[test]
fn damaged_compression_is_refused_in_one_line() {
    let folder = Folder::new();
    let with = |name: &str, message: &str, edit: &dyn Fn(&mut Value)| {
        let line = folder
            .load("a.glb", edited(name, edit))
            .map(drop)
            .expect_err(message)
            .to_string();
        assert!(line.contains(message), "`{message}` is not in: {line}");
        assert!(!line.contains('\n') && line.len() < 600, "{line}");
    };
    let view = |edit: fn(&mut Value)| {
        move |json: &mut Value| {
            edit(&mut json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]);
        }
    };
    let pack = "pack.glb";
    with(
        pack,
        "reach beyond",
        &view(|e| e["byteLength"] = json!(1u64 << 40)),
    );
    with(pack, "reach beyond", &view(|e| e["buffer"] = json!(7)));
    with(pack, "has no count", &view(|e| e["count"] = json!(null)));
    with(
        pack,
        "cannot come of",
        &view(|e| e["count"] = json!(1u64 << 60)),
    );
    with(
        pack,
        "cannot come of",
        &view(|e| e["count"] = json!(1 << 20)),
    );
    with(
        pack,
        "none that the format has",
        &view(|e| e["byteStride"] = json!(0)),
    );
    with(
        pack,
        "none that the format has",
        &view(|e| e["byteStride"] = json!(6)),
    );
    with(
        pack,
        "none that the format has",
        &view(|e| e["mode"] = json!("TEA\nTIME")),
    );
    with(
        pack,
        "none that the format has",
        &view(|e| e["filter"] = json!("MIRROR")),
    );
    with(pack, "are damaged", &view(|e| e["byteLength"] = json!(12)));
    with(pack, "neither a uri nor a binary chunk", &|json| {
        json["bufferViews"][0]
            .as_object_mut()
            .unwrap()
            .remove("extensions");
    });
    let draco = |edit: fn(&mut Value)| {
        move |json: &mut Value| {
            let primitive = &mut json["meshes"][0]["primitives"][0];
            edit(&mut primitive["extensions"]["KHR_draco_mesh_compression"]);
        }
    };
    with(
        "draco.glb",
        "reach beyond",
        &draco(|e| e["bufferView"] = json!(99)),
    );
    with("draco.glb", "are damaged", &|json| {
        json["bufferViews"][0]["byteLength"] = json!(20);
    });
    with(
        "draco.glb",
        "is not in its stream",
        &draco(|e| e["attributes"]["NORMAL"] = json!(40)),
    );
    with(
        "draco.glb",
        "components",
        &draco(|e| e["attributes"]["NORMAL"] = json!(2)),
    );
    with("draco.glb", "no indices", &|json| {
        json["meshes"][0]["primitives"][0]
            .as_object_mut()
            .unwrap()
            .remove("indices");
    });
}

#[test]
fn attributes_of_a_stream_may_share_an_accessor() {
    let folder = Folder::new();
    // As an exporter writes coordinates that it found equal: the stream has both, the file one accessor.
    let shared = edited("draco.glb", |json| {
        let primitive = &mut json["meshes"][0]["primitives"][0];
        primitive["attributes"]["_AGAIN"] = json!(2);
        primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"]["_AGAIN"] = json!(0);
    });
    let found = folder.load("shared.glb", shared).expect("a scene");
    assert_same("shared", &found, &scene("draco.glb"));
}

#[test]
fn a_damaged_stream_takes_nothing_from_a_sound_one_with_the_same_accessors() {
    let folder = Folder::new();
    let spoiled = |is_placed: bool| {
        edited("draco.glb", move |json| {
            let mut mesh = json["meshes"][0].clone();
            let stream = &mut mesh["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
            stream["bufferView"] = json!(99);
            json["meshes"].as_array_mut().unwrap().push(mesh);
            let mesh = json["meshes"].as_array().unwrap().len() - 1;
            if is_placed {
                json["nodes"]
                    .as_array_mut()
                    .unwrap()
                    .push(json!({ "mesh": mesh }));
                let node = json["nodes"].as_array().unwrap().len() - 1;
                json["scenes"][0]["nodes"]
                    .as_array_mut()
                    .unwrap()
                    .push(json!(node));
            }
        })
    };
    let unplaced = folder
        .load("unplaced.glb", spoiled(false))
        .expect("a scene");
    assert_same("unplaced", &unplaced, &scene("draco.glb"));
    let placed = folder.load("placed.glb", spoiled(true));
    let problem = placed.expect_err("a damaged stream").to_string();
    assert!(problem.contains("reach beyond"), "{problem}");
}

#[test]
fn streams_may_share_the_accessor_of_their_indices() {
    let folder = Folder::new();
    // As an exporter writes equal indices of two meshes before it compresses both: each has a stream of its own.
    let shared = edited("draco.glb", |json| {
        let append = |json: &mut Value, key: &str, value: Value| {
            let list = json[key].as_array_mut().unwrap();
            list.push(value);
            list.len() - 1
        };
        let mut mesh = json["meshes"][0].clone();
        let primitive = &mut mesh["primitives"][0];
        let stream = &mut primitive["extensions"]["KHR_draco_mesh_compression"];
        let view = stream["bufferView"].as_u64().unwrap() as usize;
        let view = json["bufferViews"][view].clone();
        stream["bufferView"] = append(json, "bufferViews", view).into();
        for (_, accessor) in primitive["attributes"].as_object_mut().unwrap() {
            let own = json["accessors"][accessor.as_u64().unwrap() as usize].clone();
            *accessor = append(json, "accessors", own).into();
        }
        let mesh = append(json, "meshes", mesh);
        let node = append(json, "nodes", json!({ "mesh": mesh }));
        json["scenes"][0]["nodes"]
            .as_array_mut()
            .unwrap()
            .push(node.into());
    });
    let found = folder.load("streams.glb", shared).expect("a scene");
    assert_eq!(found.meshes.len(), scene("draco.glb").meshes.len() + 1);
    let [first, .., second] = &found.meshes[..] else {
        unreachable!("there are two");
    };
    assert!(!first.triangles.is_empty());
    assert_eq!(first.triangles, second.triangles);
    assert_eq!(first.positions, second.positions);
    assert_eq!(first.normals, second.normals);
}
