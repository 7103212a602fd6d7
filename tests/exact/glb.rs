//! A written GLB as a receiver: the faces of one named node in world space, with its lightmap coordinates.

use super::mesh::{Face, Mesh};
use glam::{DVec2, DVec3};
use serde_json::Value;
use std::path::Path;

/// The triangles of the first node whose name starts with `name` in the GLB at `path`; the node must not be moved.
/// UVs are TEXCOORD_1, the set that a bake writes.
pub fn receiver(path: &Path, name: &str) -> Mesh {
    let bytes = std::fs::read(path).expect("the GLB is there");
    let word =
        |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!(&bytes[..4], b"glTF");
    let json_end = 20 + word(12);
    let json: Value = serde_json::from_slice(&bytes[20..json_end]).expect("the JSON chunk is JSON");
    let binary = &bytes[json_end + 8..json_end + 8 + word(json_end)];
    let named = |node: &&Value| {
        node["name"].as_str().is_some_and(|n| n.starts_with(name)) && node["mesh"].is_u64()
    };
    let nodes = json["nodes"].as_array().expect("nodes");
    let node = nodes
        .iter()
        .find(named)
        .unwrap_or_else(|| panic!("no {name} in {nodes:?}"));
    for key in ["matrix", "translation", "rotation", "scale"] {
        assert!(node[key].is_null(), "{name} is moved: {node}");
    }
    let primitive = &json["meshes"][index(&node["mesh"])]["primitives"][0];
    let numbers = |accessor: &Value, width: usize| -> Vec<Vec<f64>> {
        let accessor = &json["accessors"][index(accessor)];
        let view = &json["bufferViews"][index(&accessor["bufferView"])];
        let (size, read): (usize, fn(&[u8]) -> f64) = match accessor["componentType"].as_u64() {
            Some(5126) => (4, |b| {
                f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            }),
            Some(5125) => (4, |b| {
                f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            }),
            Some(5123) => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]]))),
            Some(5121) => (1, |b| f64::from(b[0])),
            other => panic!("component type {other:?}"),
        };
        let start = index_or_0(&view["byteOffset"]) + index_or_0(&accessor["byteOffset"]);
        let stride = view["byteStride"]
            .as_u64()
            .map_or(size * width, |s| s as usize);
        let row = |i: usize| {
            (0..width)
                .map(|k| read(&binary[start + i * stride + k * size..]))
                .collect()
        };
        (0..index(&accessor["count"])).map(row).collect()
    };
    let positions = numbers(&primitive["attributes"]["POSITION"], 3);
    let uvs = numbers(&primitive["attributes"]["TEXCOORD_1"], 2);
    let indices: Vec<usize> = numbers(&primitive["indices"], 1)
        .iter()
        .map(|row| row[0] as usize)
        .collect();
    let face = |corners: &[usize]| Face {
        object: "receiver".into(),
        points: corners
            .iter()
            .map(|&i| DVec3::from_slice(&positions[i]))
            .collect(),
        ids: corners.to_vec(),
        uvs: corners
            .iter()
            .map(|&i| DVec2::from_slice(&uvs[i]))
            .collect(),
        normals: Vec::new(),
    };
    Mesh::new(indices.chunks_exact(3).map(face).collect())
}

fn index(value: &Value) -> usize {
    value
        .as_u64()
        .unwrap_or_else(|| panic!("{value} is no index")) as usize
}

fn index_or_0(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}
