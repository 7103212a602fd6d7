//! The scene with the copies of a mesh as instances: `STEM.instanced.glb`.
//!
//! In `STEM.glb` every object is a node with lightmap coordinates of its own. The layout of a mesh is the same for all
//! its copies, so their coordinates differ by a rectangle alone. Here nodes that stand beside one another and differ in
//! nothing else become one node with `EXT_mesh_gpu_instancing`. Its attribute `_LIGHTMAP_RECT` holds the rectangle of
//! each copy: the lightmap is read at `TEXCOORD_1 * rect.xy + rect.zw`.

mod compact;
mod group;

use super::Engine;
use super::container::{list, parts, whole};
use group::{Group, groups};
use scene::GltfDocument;
use serde_json::{Value, json};
use std::collections::HashSet;

/// The engines that get the file, where a mesh has copies.
pub const ENGINES: [Engine; 2] = [Engine::Gltf, Engine::Three];

/// Unit and use, as `bake.json` says them.
pub const WORDS: [&str; 2] = [
    "no light: STEM.glb with the copies of a mesh by EXT_mesh_gpu_instancing, their rectangles on the page as the \
     attribute _LIGHTMAP_RECT",
    "Load it in place of STEM.glb where a scene has many copies; read the lightmap of a copy at TEXCOORD_1 x rect.xy \
     + rect.zw. Objects that are no copies have their coordinates as in STEM.glb.",
];

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The attribute that holds scale and offset of a copy's coordinates.
const RECT: &str = "_LIGHTMAP_RECT";

/// Extensions that name neither nodes nor parts of the buffer; of a file with others no instances are made.
const HARMLESS: [&str; 4] = [
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_xmp_json_ld",
    INSTANCING,
];
const HARMLESS_KINDS: [&str; 3] = ["KHR_materials_", "KHR_texture_", "EXT_texture_"];

/// The GLB of a bake with instances; `None` where no mesh has copies, an extension may speak of nodes, or `glb` is not
/// one that ambake wrote.
pub fn instanced(glb: &[u8]) -> Option<Vec<u8>> {
    let (json, bin) = parts(glb)?;
    let harmless = |name: &Value| {
        let name = name.as_str().unwrap_or_default();
        HARMLESS.contains(&name) || HARMLESS_KINDS.iter().any(|kind| name.starts_with(kind))
    };
    let one_buffer = list(&json, "buffers").len() == 1;
    if !one_buffer || !list(&json, "extensionsUsed").iter().all(harmless) {
        return None;
    }
    let mut document = GltfDocument {
        json,
        buffers: vec![bin],
        absent: Vec::new(),
        images: Vec::new(),
    };
    let found = groups(&document)?;
    if found.is_empty() {
        return None;
    }
    let before = compact::used(&mut document.json);
    let mut gone = HashSet::new();
    for group in &found {
        let nodes = write(&mut document, group)?;
        let copies: HashSet<u64> = group.copies.iter().map(|copy| copy.node as u64).collect();
        let members = document.json.pointer_mut(&group.list)?.as_array_mut()?;
        let is_copy = |n: &Value| n.as_u64().is_some_and(|n| copies.contains(&n));
        let at = members.iter().position(is_copy)?;
        members.splice(at..=at, nodes);
        members.retain(|n| !is_copy(n));
        gone.extend(group.copies.iter().map(|copy| copy.node));
    }
    for key in ["extensionsUsed", "extensionsRequired"] {
        let root = document.json.as_object_mut()?;
        let names = root
            .entry(key)
            .or_insert_with(|| json!([]))
            .as_array_mut()?;
        if !names.contains(&json!(INSTANCING)) {
            names.push(INSTANCING.into());
        }
    }
    let bin = document.buffers.remove(0);
    let bin = compact::without(&mut document.json, &bin, gone, before)?;
    whole(&mut document.json, &bin)
}

/// Adds a node for each primitive of a group's mesh, for each has rectangles of its own, and returns their numbers.
fn write(document: &mut GltfDocument, group: &Group) -> Option<Vec<Value>> {
    let mut attributes = json!({});
    for (key, semantic, rest) in [
        ("translation", "TRANSLATION", &[0.0; 3][..]),
        ("rotation", "ROTATION", &[0.0, 0.0, 0.0, 1.0]),
        ("scale", "SCALE", &[1.0; 3]),
    ] {
        let nodes = list(&document.json, "nodes");
        let own = |copy: &group::Copy| nodes[copy.node].get(key).and_then(Value::as_array).cloned();
        let values: Vec<Option<Vec<Value>>> = group.copies.iter().map(own).collect();
        if semantic != "TRANSLATION" && values.iter().all(Option::is_none) {
            continue;
        }
        let numbers = values.into_iter().flat_map(|value| match value {
            Some(value) => value
                .iter()
                .map(|v| v.as_f64().unwrap_or(0.0) as f32)
                .collect(),
            None => rest.to_vec(),
        });
        let numbers: Vec<f32> = numbers.collect();
        attributes[semantic] = push(document, &numbers, rest.len())?.into();
    }
    let first = &list(&document.json, "nodes")[group.copies[0].node];
    let name = first.get("name").cloned();
    let mesh = list(&document.json, "meshes")
        .get(first["mesh"].as_u64()? as usize)?
        .clone();
    let mut nodes = Vec::new();
    for (p, primitive) in list(&mesh, "primitives").iter().enumerate() {
        let rects: Vec<f32> = group.copies.iter().flat_map(|copy| copy.rects[p]).collect();
        let mut attributes = attributes.clone();
        attributes[RECT] = push(document, &rects, 4)?.into();
        let mut own = mesh.clone();
        own["primitives"] = json!([primitive]);
        let mut node = json!({ "extensions": { INSTANCING: { "attributes": attributes } } });
        node["mesh"] = append(&mut document.json, "meshes", own)?.into();
        if let Some(name) = &name {
            node["name"] = name.clone();
        }
        nodes.push(append(&mut document.json, "nodes", node)?.into());
    }
    Some(nodes)
}

/// Adds an accessor of vectors of `lanes` floats.
fn push(document: &mut GltfDocument, numbers: &[f32], lanes: usize) -> Option<usize> {
    let bin = document.buffers.first_mut()?;
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": 4 * numbers.len() });
    bin.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    let view = append(&mut document.json, "bufferViews", view)?;
    let accessor = json!({
        "bufferView": view, "componentType": 5126, "count": numbers.len() / lanes, "type": format!("VEC{lanes}"),
    });
    append(&mut document.json, "accessors", accessor)
}

fn append(json: &mut Value, key: &str, item: Value) -> Option<usize> {
    let items = json.get_mut(key)?.as_array_mut()?;
    items.push(item);
    Some(items.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three quads under one parent that share positions, one of another shape of coordinates, and one that an
    /// animation moves.
    fn scene() -> Vec<u8> {
        let mut json = json!({
            "asset": { "version": "2.0" }, "buffers": [{}], "scenes": [{ "nodes": [0, 6, 7] }],
            "nodes": [
                { "children": [1, 2, 3, 4, 5] },
                { "mesh": 0, "name": "a", "translation": [1, 0, 0] },
                { "mesh": 1, "name": "b", "scale": [2, 2, 2] },
                { "mesh": 2, "name": "c" },
                { "mesh": 3, "name": "bent" },
                { "mesh": 4, "name": "moves" },
                { "mesh": 5, "name": "alone" },
                { "mesh": 5, "name": "mirrored", "scale": [1, -1, 1] },
            ],
            "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 5, "path": "translation" } }],
            "samplers": [{ "input": 0, "output": 0 }] }],
            "meshes": [], "accessors": [], "bufferViews": [],
        });
        let mut bin = Vec::new();
        let base = [[0.0f32, 0.0], [0.25, 0.0], [0.25, 0.5], [0.0, 0.5]];
        let moved = |s: f32, o: f32| base.map(|[u, v]| [u * s + o, v * s]);
        let bent = [[0.0, 0.0], [0.25, 0.0], [0.25, 0.5], [0.1, 0.5]];
        for uvs in [
            [[9.0, 9.0]; 4],
            base,
            moved(1.0, 0.25),
            moved(0.5, 0.5),
            bent,
            base,
            base,
        ] {
            let at = bin.len();
            bin.extend(uvs.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
            let n = append(
                &mut json,
                "bufferViews",
                json!({ "buffer": 0, "byteOffset": at, "byteLength": 32 }),
            );
            let own = append(
                &mut json,
                "accessors",
                json!({ "bufferView": n, "componentType": 5126, "count": 4, "type": "VEC2" }),
            );
            if own != Some(0) {
                let attributes = json!({ "POSITION": 0, "TEXCOORD_0": own, "TEXCOORD_1": own });
                let material = u32::from(own == Some(6));
                let primitive = json!({ "attributes": attributes, "material": material });
                append(
                    &mut json,
                    "meshes",
                    json!({ "name": format!("m{own:?}"), "primitives": [primitive] }),
                );
            }
        }
        whole(&mut json, &bin).expect("a container")
    }

    #[test]
    fn copies_become_one_node_with_their_rectangles() {
        let (json, bin) = parts(&instanced(&scene()).expect("copies")).expect("a GLB");
        let nodes = list(&json, "nodes");
        let names: Vec<&str> = nodes
            .iter()
            .filter_map(|node| node["name"].as_str())
            .collect();
        assert_eq!(names, ["bent", "moves", "alone", "mirrored", "a"]);
        assert_eq!(
            nodes[0]["children"],
            json!([5, 1, 2]),
            "in the place of the first"
        );
        assert_eq!(json["scenes"][0]["nodes"], json!([0, 3, 4]));
        assert_eq!(json["animations"][0]["channels"][0]["target"]["node"], 2);
        assert_eq!(
            list(&json, "meshes").len(),
            4,
            "one for the copies, and three"
        );
        // Shared positions, four meshes' coordinates, translation, scale, rectangles.
        assert_eq!(list(&json, "accessors").len(), 8);
        assert_eq!(bin.len(), 5 * 32 + 3 * (12 + 12 + 16));
        let document = GltfDocument {
            json,
            buffers: vec![bin],
            absent: Vec::new(),
            images: Vec::new(),
        };
        let attributes = &list(&document.json, "nodes")[5]["extensions"][INSTANCING]["attributes"];
        let accessor = |key: &str| {
            document
                .accessor(attributes[key].as_u64().expect("one") as usize)
                .expect("whole")
        };
        assert!(attributes.get("ROTATION").is_none(), "nobody turns");
        let moves = [0, 1, 2].map(|i| accessor("TRANSLATION").numbers::<3>(i).expect("one"));
        assert_eq!(moves, [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
        let rects = [0, 1, 2].map(|i| accessor(RECT).numbers::<4>(i).expect("one"));
        assert_eq!(
            rects,
            [
                [1.0, 1.0, 0.0, 0.0],
                [1.0, 1.0, 0.25, 0.0],
                [0.5, 0.5, 0.5, 0.0]
            ]
        );
        assert_eq!(document.json["extensionsRequired"], json!([INSTANCING]));
    }

    #[test]
    fn without_copies_or_with_an_extension_that_may_name_nodes_there_is_no_file() {
        let (mut json, bin) = parts(&scene()).expect("a GLB");
        json["extensionsUsed"] = json!(["KHR_materials_specular", "MSFT_lod"]);
        assert!(instanced(&whole(&mut json, &bin).expect("a GLB")).is_none());
        json["extensionsUsed"] = json!([]);
        json["nodes"][0]["children"] = json!([1, 4]);
        json["scenes"][0]["nodes"] = json!([0, 2, 7]);
        assert!(instanced(&whole(&mut json, &bin).expect("a GLB")).is_none());
        assert!(instanced(b"glTF").is_none());
    }
}
