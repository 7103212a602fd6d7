//! `--to vertices`: the diffuse term as vertex colours, held against colours that are known and against the library.

use crate::support::{assert_valid_gltf, bake, files, report, run};
use ambake::{Bake, Layer};
use serde_json::json;
use std::collections::HashMap;
use std::path::Path;

/// Colours of the floor's corners, the last channel alpha, in 8 bits.
const COLORS: [[u8; 4]; 4] = [
    [255, 0, 51, 255],
    [0, 102, 255, 255],
    [204, 204, 0, 255],
    [17, 34, 85, 255],
];

/// x and z of the floor's corners.
const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];

/// One coloured floor twice, in the open and a little below a lid.
fn floors(folder: &Path) -> std::path::PathBuf {
    let floor = CORNERS.map(|[x, z]| [x, 0.0, z]);
    let lid = CORNERS.map(|[x, z]| [0.5 * x, 0.25, z]);
    let bytes = |numbers: &[[f32; 3]; 4]| -> Vec<u8> {
        let numbers = numbers.as_flattened().iter();
        numbers.flat_map(|v| v.to_le_bytes()).collect()
    };
    let indices = [0u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat();
    let bin = [bytes(&floor), bytes(&lid), COLORS.concat(), indices].concat();
    std::fs::write(folder.join("floors.bin"), &bin).expect("written");
    let view = |offset: u32, length: u32| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let corner = |view: u32, min: [f32; 3], max: [f32; 3]| {
        json!({
            "bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3", "min": min, "max": max,
        })
    };
    let file = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": "floors.bin", "byteLength": bin.len() }],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 16), view(112, 12)],
        "accessors": [
            corner(0, [0.0; 3], [1.0, 0.0, 1.0]),
            corner(1, [0.0, 0.25, 0.0], [0.5, 0.25, 1.0]),
            { "bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" },
            { "bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0, "COLOR_0": 2 }, "indices": 3 }] },
            { "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 3 }] },
        ],
        "nodes": [
            { "name": "open", "mesh": 0 },
            { "name": "covered", "mesh": 0, "translation": [100.0, 0.0, 0.0] },
            { "name": "lid", "mesh": 1, "translation": [100.0, 0.0, 0.0] },
        ],
        "scenes": [{ "nodes": [0, 1, 2] }],
    });
    let path = folder.join("floors.gltf");
    std::fs::write(&path, file.to_string()).expect("written");
    path
}

/// The vertex colours of each node by the bits of x and z.
fn colors(path: &Path) -> HashMap<String, HashMap<[u32; 2], [f32; 4]>> {
    let bytes = std::fs::read(path).expect("written");
    let file = gltf::Gltf::from_slice(&bytes).expect("a GLB");
    let bin = file.blob.as_deref().expect("a buffer");
    let node = |node: gltf::Node| {
        let mesh = node.mesh().expect("a mesh");
        let mut own = HashMap::new();
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(bin));
            let places = reader.read_positions().expect("positions");
            let colors = reader.read_colors(0).into_iter();
            let colors = colors.flat_map(|colors| colors.into_rgba_f32());
            own.extend(places.map(|[x, _, z]| [x, z].map(f32::to_bits)).zip(colors));
        }
        (node.name().expect("a name").to_string(), own)
    };
    file.document.nodes().map(node).collect()
}

#[test]
fn vertex_colours_are_the_file_s_own_times_the_diffuse_term_of_each_copy() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = floors(folder.path());
    let flags = ["--size=128", "--rays=64", "--exclude=lid"];
    let (out, _) = bake(&path, &[&flags[..], &["--to=vertices"]].concat());
    let written = out.path().join("floors.vertices.glb");
    assert_valid_gltf(&written);
    assert_eq!(report(out.path())["options"]["to"], "vertices");
    let found = colors(&written);

    let scene = ambake::load(&path).expect("a scene");
    let baked = Bake::new(&scene).size(128).rays(64).exclude("lid");
    let baked = baked.denoise(ambake::Denoise::Off).run(&()).expect("baked");
    let values = baked.vertex_values(Layer::Diffuse).expect("standard");
    let shades_of = |name: &str| {
        let object = values.iter().find(|object| object.name.starts_with(name));
        &object.expect("it took texels").channels[0]
    };
    for (name, is_open) in [("open", true), ("covered", false)] {
        let shades = shades_of(name);
        for (k, corner) in CORNERS.iter().enumerate() {
            let shade = if is_open { 1.0 } else { shades[k] };
            let color = found[name][&corner.map(f32::to_bits)];
            for channel in 0..4 {
                let own = f32::from(COLORS[k][channel]) / 255.0;
                let expected = if channel < 3 { own * shade } else { own };
                assert!(
                    (color[channel] - expected).abs() < 1e-6,
                    "{name} {k}: {color:?}, {expected}"
                );
            }
        }
    }
    // Under the lid is less light than beside it.
    let shades = shades_of("covered");
    assert!(shades[0] < 0.8 * shades[3], "{shades:?}");
}

#[test]
fn a_bake_without_vertices_takes_their_file_away_and_they_need_the_diffuse_term() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = floors(folder.path());
    let out = folder.path().join("out");
    let words = |more: &[&str]| {
        let mut words = vec!["bake".into(), path.clone().into_os_string(), "-o".into()];
        words.push(out.clone().into_os_string());
        words.extend(["--size=64", "--rays=8", "--quiet"].map(Into::into));
        words.extend(more.iter().map(Into::into));
        words
    };
    let name = "floors.vertices.glb".to_string();
    assert!(run(words(&["--to=vertices"])).status.success());
    assert!(files(&out).contains(&name));
    assert!(run(words(&[])).status.success());
    assert!(!files(&out).contains(&name));
    let refused = run(words(&["--to=vertices", "--only=visibility"]));
    assert!(!refused.status.success());
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(
        said.contains("vertices") && said.contains("diffuse"),
        "{said}"
    );
    assert!(!files(&out).contains(&name));
}
