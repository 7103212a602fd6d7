//! Broken glTF and GLB files, each one mutation away from a sound one.

use super::{Case, refuse_all};
use crate::support::{bake, report};
use serde_json::{Value, json};

/// One triangle: indices (6 bytes, padded to 8), then three positions, in one buffer.
fn binary() -> Vec<u8> {
    let mut bytes: Vec<u8> = [0u16, 1, 2, 0]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    bytes.extend(
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes
}

fn sound() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": 3, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 6},
            {"buffer": 0, "byteOffset": 8, "byteLength": 36}],
        "buffers": [{"byteLength": 44}],
    })
}

/// A GLB of these two chunks.
fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).expect("JSON");
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let total = 12 + 8 + text.len() + 8 + binary.len();
    for number in [2u32, total as u32, text.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

/// The sound file with the value at a JSON pointer replaced (or added to an object).
fn with(pointer: &str, value: Value) -> Vec<u8> {
    glb(&replaced(pointer, value), &binary())
}

fn replaced(pointer: &str, value: Value) -> Value {
    let mut json = sound();
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = json.pointer_mut(parent).expect("the parent is there");
    match parent {
        Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value,
        other => other[key] = value,
    }
    json
}

/// The sound file with bytes of its buffer replaced.
fn with_bytes(at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut buffer = binary();
    buffer[at..at + bytes.len()].copy_from_slice(bytes);
    glb(&sound(), &buffer)
}

/// A .gltf whose buffer is `uri`.
fn with_uri(uri: &str) -> Vec<u8> {
    serde_json::to_vec(&replaced(
        "/buffers/0",
        json!({"byteLength": 44, "uri": uri}),
    ))
    .expect("JSON")
}

#[test]
fn the_file_all_cases_start_from_is_sound() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("sound.glb");
    std::fs::write(&path, glb(&sound(), &binary())).expect("the folder is writable");
    let (_out, page) = bake(&path, &["--size", "32", "--rays", "4"]);
    assert!(page.plane("coverage").iter().sum::<f32>() > 1.0);
}

#[test]
fn broken_glb_containers_are_refused() {
    let whole = glb(&sound(), &binary());
    let patched = |at: usize, bytes: &[u8]| {
        let mut copy = whole.clone();
        copy[at..at + bytes.len()].copy_from_slice(bytes);
        copy
    };
    let binary_first = {
        let mut bytes = b"glTF".to_vec();
        bytes.extend([2u32, 12 + 8 + 4, 4].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(b"BIN\0\0\0\0\0");
        bytes
    };
    refuse_all(&[
        Case::scene("no byte at all", "empty.glb", []),
        Case::scene("cut in the header", "cut_header.glb", &whole[..8]),
        Case::scene("cut after the header", "cut_after_header.glb", &whole[..12]),
        Case::scene("cut in the JSON chunk", "cut_json.glb", &whole[..60]),
        Case::scene(
            "cut in the BIN chunk",
            "cut_bin.glb",
            &whole[..whole.len() - 7],
        ),
        Case::scene(
            "cut at the BIN chunk's header",
            "cut_bin_header.glb",
            &whole[..whole.len() - 48],
        ),
        Case::scene("wrong magic", "magic.glb", patched(0, b"glXX")),
        Case::scene("version 1", "version.glb", patched(4, &1u32.to_le_bytes())),
        Case::scene(
            "JSON chunk longer than the file",
            "long_chunk.glb",
            patched(12, &0x7fff_fff0u32.to_le_bytes()),
        ),
        Case::scene(
            "total length of 4 GB",
            "long_total.glb",
            patched(8, &u32::MAX.to_le_bytes()),
        ),
        Case::scene("no JSON chunk", "no_json.glb", binary_first),
        Case::scene("JSON with a stray byte", "stray.glb", patched(20, b"?")),
        Case::scene(
            "not UTF-8 in the JSON",
            "latin.glb",
            patched(22, &[0xff, 0xfe]),
        ),
    ]);
}

#[test]
fn broken_gltf_documents_are_refused() {
    let mut no_scene = Case::scene(
        "a buffer file that is not there",
        "absent_buffer.gltf",
        with_uri("nowhere.bin"),
    );
    no_scene.names = "nowhere.bin";
    let mut short = Case::scene(
        "a buffer file that is too short",
        "short_buffer.gltf",
        with_uri("short.bin"),
    );
    short.files.push(("short.bin", vec![0; 20]));
    short.names = "short";
    let huge =
        json!({"bufferView": 1, "componentType": 5126, "count": 4_000_000_000u32, "type": "VEC3"});
    let positions = |kind: &str, component: u32, count: u32| {
        json!({"bufferView": 1, "componentType": component,
            "count": count, "type": kind})
    };
    refuse_all(&[
        no_scene,
        short,
        Case::scene(
            "JSON that ends early",
            "early.gltf",
            *b"{\"asset\": {\"version\": \"2.0\"",
        ),
        Case::scene(
            "not UTF-8",
            "latin.gltf",
            *b"{\"asset\": {\"version\": \"2.0\", \"generator\": \"\xff\xfe\"}}",
        ),
        Case::scene("no asset", "no_asset.gltf", *b"{}"),
        Case::scene(
            "no mesh",
            "no_mesh.gltf",
            *b"{\"asset\": {\"version\": \"2.0\"}}",
        ),
        Case::scene(
            "bad base64",
            "base64.gltf",
            with_uri("data:application/octet-stream;base64,@@@@"),
        ),
        Case::scene(
            "base64 that is too short",
            "short64.gltf",
            with_uri("data:application/octet-stream;base64,AAAA"),
        ),
        Case::scene(
            "a URI that is none",
            "scheme.gltf",
            with_uri("https://example.invalid/scene.bin"),
        ),
        Case::scene(
            "version 3.0",
            "version.glb",
            with("/asset", json!({"version": "3.0", "minVersion": "3.0"})),
        ),
        Case::scene(
            "no primitive",
            "no_primitive.glb",
            with("/meshes/0/primitives", json!([])),
        ),
        Case::scene(
            "no positions",
            "no_positions.glb",
            with("/meshes/0/primitives/0/attributes", json!({})),
        ),
        Case::scene(
            "no position in the accessor",
            "none.glb",
            with("/accessors/1/count", json!(0)),
        ),
        Case::scene(
            "an accessor beyond its view",
            "beyond_view.glb",
            with("/accessors/1/count", json!(4)),
        ),
        Case::scene(
            "an accessor offset beyond its view",
            "offset.glb",
            with("/accessors/1/byteOffset", json!(4096)),
        ),
        Case::scene(
            "a view beyond its buffer",
            "beyond_buffer.glb",
            with("/bufferViews/1/byteLength", json!(4096)),
        ),
        Case::scene(
            "a view that starts beyond its buffer",
            "view_start.glb",
            with("/bufferViews/1/byteOffset", json!(u32::MAX)),
        ),
        Case::scene(
            "a buffer longer than the BIN chunk",
            "buffer_length.glb",
            with("/buffers/0/byteLength", json!(1u64 << 40)),
        ),
        Case::scene(
            "four thousand million vertices",
            "huge.glb",
            with("/accessors/1", huge),
        ),
        Case::scene(
            "positions of two numbers",
            "vec2.glb",
            with("/accessors/1", positions("VEC2", 5126, 3)),
        ),
        Case::scene(
            "positions of bytes",
            "bytes.glb",
            with("/accessors/1", positions("VEC3", 5121, 3)),
        ),
        Case::scene(
            "an unknown component type",
            "component.glb",
            with("/accessors/1", positions("VEC3", 9999, 3)),
        ),
        Case::scene(
            "floating indices",
            "float_indices.glb",
            with("/accessors/0/componentType", json!(5126)),
        ),
        Case::scene(
            "an accessor that is not there",
            "no_accessor.glb",
            with("/meshes/0/primitives/0/indices", json!(77)),
        ),
        Case::scene(
            "a view that is not there",
            "no_view.glb",
            with("/accessors/1/bufferView", json!(77)),
        ),
        Case::scene(
            "a mesh that is not there",
            "no_such_mesh.glb",
            with("/nodes/0", json!({"mesh": 77})),
        ),
        Case::scene(
            "a node that is its own child",
            "cycle.glb",
            with("/nodes/0", json!({"mesh": 0, "children": [0]})),
        ),
        Case::scene(
            "nodes in a ring",
            "ring.glb",
            with(
                "/nodes",
                json!([{"mesh": 0, "children": [1]}, {"children": [0]}]),
            ),
        ),
        Case::scene(
            "a child that is not there",
            "no_child.glb",
            with("/nodes/0", json!({"mesh": 0, "children": [9]})),
        ),
        Case::scene(
            "an index out of range",
            "index.glb",
            with_bytes(4, &7u16.to_le_bytes()),
        ),
        Case::scene(
            "a position that is not a number",
            "nan.glb",
            with_bytes(8, &f32::NAN.to_le_bytes()),
        ),
        Case::scene(
            "an infinite position",
            "infinite.glb",
            with_bytes(20, &f32::INFINITY.to_le_bytes()),
        ),
        Case::scene(
            "only a triangle without area",
            "flat.glb",
            with_bytes(20, &[0; 4]),
        ),
    ]);
}

#[test]
fn required_extensions_that_are_unknown_are_named() {
    let case = |what, file, name: &'static str| {
        let mut json = sound();
        json["extensionsUsed"] = json!([name]);
        json["extensionsRequired"] = json!([name]);
        let mut case = Case::scene(what, file, glb(&json, &binary()));
        case.names = name;
        case
    };
    refuse_all(&[case(
        "an unheard-of extension is required",
        "unheard.glb",
        "ACME_unheard_of",
    )]);
}

/// The sound file with a material whose texture is this PNG.
fn textured(png: &[u8]) -> Vec<u8> {
    let mut json = sound();
    let mut bytes = binary();
    let view = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": png.len()});
    bytes.extend(png);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    json["bufferViews"]
        .as_array_mut()
        .expect("views")
        .push(view);
    json["images"] = json!([{"bufferView": 2, "mimeType": "image/png"}]);
    json["textures"] = json!([{"source": 0}]);
    json["materials"] =
        json!([{"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb(&json, &bytes)
}

/// The CRC-32 of a PNG chunk.
fn check_sum(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 };
        }
    }
    !sum
}

#[test]
fn broken_images_are_told_of_and_those_beyond_the_limits_refused() {
    let sound = std::fs::read(crate::support::scene("masked_card.png")).expect("the PNG is there");
    // The size stands at byte 16 of the file, in the header chunk, whose check sum covers bytes 12 to 29.
    let sized = |width: u32, height: u32| {
        let mut copy = sound.clone();
        copy[16..20].copy_from_slice(&width.to_be_bytes());
        copy[20..24].copy_from_slice(&height.to_be_bytes());
        let sum = check_sum(&copy[12..29]);
        copy[29..33].copy_from_slice(&sum.to_be_bytes());
        copy
    };
    assert_eq!(sized(2, 2), sound);
    refuse_all(&[Case::scene(
        "an image of a million edges",
        "wide.glb",
        textured(&sized(1 << 20, 1 << 20)),
    )]);
    let folder = tempfile::tempdir().expect("a temporary directory");
    for (what, png) in [
        ("no width", &sized(0, 2)[..]),
        ("the end of the file in it", &sound[..50]),
        ("no byte", &b""[..]),
        ("words", &b"this is no picture at all"[..]),
    ] {
        let path = folder.path().join("lost.glb");
        std::fs::write(&path, textured(png)).expect("the folder is writable");
        let (out, _) = bake(&path, &["--size", "32", "--rays", "4"]);
        let warnings = report(out.path())["warnings"].clone();
        let kinds: Vec<_> = warnings
            .as_array()
            .expect("warnings")
            .iter()
            .map(|w| &w["kind"])
            .collect();
        assert!(
            kinds.contains(&&json!("missing-textures")),
            "{what}: {warnings}"
        );
    }
}
