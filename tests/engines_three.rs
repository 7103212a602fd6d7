//! What three.js shows of a bake.

use crate::engines::{named_oddly, text};
use crate::support::{bake, node, report, run_well, scene, skip};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// What three.js in Chromium makes of a bake's files, beside the program's own picture of the same view; `None` with a
/// printed line where a tool is absent.
fn in_three(folder: &Path, scene: &Path, [eye, look, fov]: [&str; 3]) -> Option<Value> {
    let picture = folder.join("view.exr");
    let eye_flag = format!("--eye={eye}");
    let look_flag = format!("--look={look}");
    run_well([
        "render",
        text(scene),
        "--bake",
        text(folder),
        "-o",
        text(&picture),
        "--model=lambert",
        &eye_flag,
        &look_flag,
        "--fov-deg",
        fov,
        "--size=120x90",
        "--samples=1",
        "--background=0,0,0.5",
        "--quiet",
    ]);
    let stem = scene.file_stem().expect("a stem");
    let (folder, picture) = (folder.as_os_str(), picture.as_os_str());
    let args = [
        folder,
        stem,
        picture,
        eye.as_ref(),
        look.as_ref(),
        fov.as_ref(),
    ];
    node("three.mjs", &args)
        .map_err(|reason| skip(&reason))
        .ok()
}

/// three.js reads a mantissa of RGBE as a share of 255, not 256, so that its picture is 0.4 % brighter.
const LOADERS: [(&str, f64); 4] = [("exr", 0.0), ("ktx2", 0.0), ("moz", 0.0), ("hdr", 1.0)];

#[test]
fn a_white_furnace_is_white_in_three_js() {
    let plane = scene("plane.obj");
    let (folder, _) = bake(&plane, &["--size=32", "--rays=4", "--for", "three"]);
    let Some(seen) = in_three(folder.path(), &plane, ["0.3,2,0.4", "0,0,0", "30"]) else {
        return;
    };
    assert_eq!(seen["errors"], json!([]));
    for (loader, brighter) in LOADERS {
        for c in 0..3 {
            let white = seen[loader]["middle"][c].as_f64().expect("a number");
            assert!(
                (white - 1.0).abs() * 255.0 <= 1.0 + 0.01 * brighter,
                "{loader}: {white}"
            );
        }
    }
}

#[test]
fn three_js_shows_the_picture_that_ambake_renders() {
    let (_folder, room) = named_oddly("instances_twin.obj");
    let options = [
        "--size=64",
        "--density=10",
        "--gutter=4",
        "--mips=1",
        "--rays=16",
        "--sky=0.9,0.6,0.3",
        "--for=three",
    ];
    let (folder, _) = bake(&room, &options);
    let pages = report(folder.path())["pages"].as_array().map(Vec::len);
    assert!(pages > Some(1), "{pages:?} pages");
    let Some(seen) = in_three(folder.path(), &room, ["6,5,8", "0,0.5,0", "40"]) else {
        return;
    };
    assert_eq!(seen["errors"], json!([]));
    // Without mip levels both look up the same texels; RGBE is brighter, and a mip level is a blur.
    assert_alike(
        &seen,
        200,
        [("exr", 0.5), ("moz", 0.7), ("hdr", 2.0), ("ktx2", 2.0)],
    );
    assert_eq!(seen["ktx2"]["levels"], 2);
}

#[test]
fn three_js_shows_compressed_lightmaps_within_two_of_255() {
    let room = scene("instances_twin.obj");
    let options = [
        "--size=128",
        "--mips=1",
        "--align=4",
        "--rays=64",
        "--sky=0.9,0.6,0.3",
        "--for=three",
        "--compress",
    ];
    let (folder, _) = bake(&room, &options);
    let Some(seen) = in_three(folder.path(), &room, ["6,5,8", "0,0.5,0", "40"]) else {
        return;
    };
    assert_eq!(seen["errors"], json!([]));
    assert_alike(&seen, 200, [("bc6h.dds", 2.0)]);
    assert_eq!(seen["bc6h.dds"]["levels"], 2);
}

/// The coat of glTF takes light from what is below it, in each reader another share: the GLB of an OBJ scene has none.
#[test]
fn a_glossy_material_shows_its_albedo_times_the_light_in_three_js() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let room = folder.path().join("bronze.obj");
    let text = fs::read_to_string(scene("plane.obj")).expect("the scene");
    let text = format!("mtllib bronze.mtl\nusemtl bronze\n{text}");
    fs::write(&room, text).expect("written");
    let library = "newmtl bronze\nKd 0.26 0.17 0.09\nKs 0.46 0.36 0.22\nNs 30\n";
    fs::write(folder.path().join("bronze.mtl"), library).expect("written");
    let (folder, _) = bake(&room, &["--size=32", "--rays=4", "--for=three"]);
    let Some(seen) = in_three(folder.path(), &room, ["0.3,2,0.4", "0,0,0", "30"]) else {
        return;
    };
    for (loader, _) in LOADERS {
        for (c, albedo) in [0.26, 0.17, 0.09].into_iter().enumerate() {
            let shown = seen[loader]["middle"][c].as_f64().expect("a number");
            assert!(
                (shown - albedo).abs() * 255.0 <= 1.0,
                "{loader}: {shown}, not {albedo}"
            );
        }
    }
}

/// Asserts that pictures by each loader compare more pixels than these, and leave at most so much of 255 on the mean.
fn assert_alike<const N: usize>(seen: &Value, pixels: u64, loaders: [(&str, f64); N]) {
    for (loader, most) in loaders {
        let told = &seen[loader];
        assert!(told["pixels"].as_u64() > Some(pixels), "{told}");
        let mean = told["mean"].as_f64().expect("a number");
        assert!(mean <= most, "{loader}: {mean} of 255 on the mean");
    }
}

/// Writes a floor, and a bent sheet of which one node places three copies by `EXT_mesh_gpu_instancing`.
fn write_instanced(path: &Path) {
    let floor = [
        [-3.0, 0.0, 3.0],
        [3.0, 0.0, 3.0],
        [3.0, 0.0, -3.0],
        [-3.0, 0.0, -3.0],
    ];
    let sheet = [
        [-0.6, 0.1, 0.4],
        [0.6, 0.1, 0.4],
        [0.6, 0.1, -0.4],
        [-0.6, 0.1, -0.4],
        [0.6, 1.2, -0.4],
        [-0.6, 1.2, -0.4],
    ];
    let moves = [[-1.6, 0.0, 0.8], [0.2, 0.0, -0.9], [1.7, 0.3, 0.9]];
    let turns = [
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.6, 0.0, 0.8],
        [0.0, -0.28, 0.0, 0.96],
    ];
    let scales = [[1.0, 1.0, 1.0], [1.3, 1.6, 0.8], [0.7, 0.9, 1.2]];
    let mut bin = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut add = |bytes: Vec<u8>, kind: &str, component: u32, count: usize| {
        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind,
            "min": [-3, 0, -3], "max": [3, 2, 3],
        }));
        if kind != "VEC3" {
            let last = accessors
                .last_mut()
                .and_then(Value::as_object_mut)
                .expect("one");
            last.retain(|key, _| !["min", "max"].contains(&key.as_str()));
        }
        bin.extend(bytes);
        bin.resize(bin.len().next_multiple_of(4), 0);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let shorts = |values: &[u16]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let floor = add(floats(floor.as_flattened()), "VEC3", 5126, 4);
    let ground = add(shorts(&[0, 1, 2, 0, 2, 3]), "SCALAR", 5123, 6);
    let sheet = add(floats(sheet.as_flattened()), "VEC3", 5126, 6);
    let faces = add(
        shorts(&[0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5]),
        "SCALAR",
        5123,
        12,
    );
    let moves = add(floats(moves.as_flattened()), "VEC3", 5126, 3);
    let turns = add(floats(turns.as_flattened()), "VEC4", 5126, 3);
    let scales = add(floats(scales.as_flattened()), "VEC3", 5126, 3);
    let attributes = json!({ "TRANSLATION": moves, "ROTATION": turns, "SCALE": scales });
    let gltf = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_materials_specular"],
        "extensionsRequired": ["EXT_mesh_gpu_instancing"],
        "nodes": [
            { "name": "floor", "mesh": 0 },
            { "name": "sheets", "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } },
        ],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": floor }, "indices": ground, "material": 0 }] },
            { "primitives": [{ "attributes": { "POSITION": sheet }, "indices": faces, "material": 0 }] },
        ],
        "materials": [{
            "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorFactor": [0.8, 0.7, 0.6, 1] }, "doubleSided": true,
            "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
        }],
        "bufferViews": views, "accessors": accessors,
        "buffers": [{ "uri": "copies.bin", "byteLength": bin.len() }],
    });
    fs::write(path, gltf.to_string()).expect("a file");
    fs::write(path.with_file_name("copies.bin"), bin).expect("a file");
}

#[test]
fn copies_of_an_instanced_mesh_have_light_of_their_own_in_three_js() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("copies.gltf");
    write_instanced(&path);
    let (folder, _) = bake(
        &path,
        &[
            "--size=128",
            "--rays=64",
            "--sky=0.9,0.8,0.7",
            "--for=three",
        ],
    );
    let report = report(folder.path());
    let objects = report["layout"]["objects"].as_array().map(Vec::len);
    assert_eq!(
        (report["pages"].as_array().map(Vec::len), objects),
        (Some(1), Some(4))
    );
    let Some(seen) = in_three(folder.path(), &path, ["1,6,7", "0,0.3,0", "42"]) else {
        return;
    };
    assert_eq!(seen["errors"], json!([]));
    assert_alike(
        &seen,
        3_000,
        [("exr", 0.5), ("moz", 0.7), ("hdr", 2.0), ("ktx2", 0.7)],
    );
    // As one node with a rectangle for each copy: the same light, by two meshes in place of four.
    assert_alike(&seen, 3_000, [("copies", 0.5)]);
    assert_eq!(
        (&seen["exr"]["drawn"], &seen["copies"]["drawn"]),
        (&json!(4), &json!(2))
    );
}
