//! Broken files: each gives one line that names the file, the place and the trouble.

use super::support::{Document, Folder, U8};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// The message, checked for its form.
fn refused(result: Result<ambake_scene::Scene, ambake_scene::Error>, needle: &str) {
    let message = result.expect_err(needle).to_string();
    assert!(message.contains(needle), "`{needle}` is not in: {message}");
    assert!(!message.contains('\n') && message.len() < 600, "{message}");
}

fn edited(needle: &str, edit: impl FnOnce(&mut Document)) {
    let mut document = Document::triangle();
    edit(&mut document);
    let loaded = document.load();
    // The same program writes the same again.
    let advised = loaded.as_ref().err().map(ToString::to_string);
    assert!(
        !advised
            .unwrap_or_default()
            .contains("export the file again")
    );
    refused(loaded, needle);
}

#[test]
fn files_of_other_formats_and_under_other_names_are_told_what_they_are() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345678\n";
    let page = "\n<!DOCTYPE html>\n<html><body>Not found</body></html>";
    let gltf = r#"{"asset": {"version": "2.0"}}"#;
    let folder = Folder::new();
    for (name, content, words) in [
        // What a clone without Git LFS holds.
        ("a.obj", pointer, &["Git LFS pointer", "git lfs pull"][..]),
        ("a.gltf", pointer, &["Git LFS pointer", "git lfs pull"]),
        ("a.glb", pointer, &["Git LFS pointer", "git lfs pull"]),
        ("a.fbx", pointer, &["Git LFS pointer", "git lfs pull"]),
        ("a.obj", page, &["web page"]),
        ("a.glb", page, &["web page"]),
        // Other formats, under their own names and under ours.
        ("a.fbx", "Kaydara FBX Binary  \0", &["FBX", "export glTF"]),
        ("a.glb", "Kaydara FBX Binary  \0", &["FBX", "export glTF"]),
        ("a.obj", "; FBX 7.4.0 project file", &["FBX", "export glTF"]),
        ("a.blend", "BLENDER-v300", &["Blender", "export glTF"]),
        ("a.blend", "\u{1f}", &["Blender", "export glTF"]),
        ("a.ply", "ply\nformat ascii 1.0\n", &["PLY", "export glTF"]),
        ("a.stl", "solid x\n", &["not read", "export glTF"]),
        (
            "a.dae",
            "<?xml version=\"1.0\"?><COLLADA/>",
            &["COLLADA", "export glTF"],
        ),
        ("a.usdz", "PK\u{3}\u{4}", &["USD", "export glTF"]),
        ("a.zip", "PK\u{3}\u{4}", &["ZIP archive", "unpack it"]),
        (
            "a.skp",
            "SketchUp",
            &["neither OBJ nor glTF", "export glTF"],
        ),
        ("a.mtl", "newmtl a\n", &["materials", ".obj"]),
        // Only what is ours helps by another name.
        (
            "a.txt",
            "# a\nv 0 0 0\n",
            &["OBJ by its content", "rename it to .obj"],
        ),
        (
            "a.json",
            gltf,
            &["glTF by its content", "rename it to .gltf"],
        ),
        (
            "a.glb",
            gltf,
            &["glTF by its content", "rename it to .gltf"],
        ),
        (
            "a.obj",
            gltf,
            &["glTF by its content", "rename it to .gltf"],
        ),
    ] {
        for word in words {
            refused(folder.load(name, content), word);
        }
        let said = folder.load(name, content).expect_err(name).to_string();
        let renames = said.contains("rename");
        assert_eq!(renames, words.concat().contains("rename"), "{said}");
        assert!(said.contains(name), "{said}");
    }
    refused(folder.load("a.obj", [0x1f, 0x8b, 8, 8]), "unpack it");

    // Files that a scene names.
    folder.write("b.bin", pointer);
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "b.bin", "byteLength": 36}],
    });
    refused(
        folder.load("b.gltf", document.to_string()),
        "b.bin is a Git LFS pointer",
    );
    folder.write("b.mtl", pointer);
    let text = "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let scene = folder.load("b.obj", text).expect("a triangle");
    let told = scene
        .warnings
        .iter()
        .any(|of| of.message.contains("git lfs pull"));
    assert!(told, "{:?}", scene.warnings);
}

#[test]
fn files_that_are_none() {
    let folder = Folder::new();
    let path = folder.write("a.obj", "");
    refused(
        ambake_scene::load(path.parent().unwrap()),
        "is not a regular file",
    );
    refused(ambake_scene::load(&path), "is empty");
    refused(
        ambake_scene::load(&path.with_file_name("gone.obj")),
        "cannot read",
    );
    refused(folder.load("a.glb", "v 0 0 0"), "starts with `glTF`");
    refused(folder.load("a.gltf", "{}"), "asset");
    refused(
        folder.load("a.gltf", r#"{"asset":{"version":"1.0"},"meshes":{}}"#),
        "version 1.0",
    );
    refused(
        folder.load("a.obj", [0u8, 1, 2, 3].repeat(99)),
        "binary data",
    );
    refused(folder.load("a.obj", "# nothing\n"), "no triangle");
    refused(
        folder.load("a.obj", "v 1 1 1\nv 1 1 1\nf 1 2 1\n"),
        "; faces without an area are dropped",
    );
}

#[test]
fn truncated_glbs() {
    let glb = Document::triangle().glb();
    for length in [5, 11, 13, 19, 40, glb.len() - 1] {
        refused(Folder::new().load("a.glb", &glb[..length]), "truncated");
    }
    let mut old = glb.clone();
    old[4] = 1;
    refused(Folder::new().load("a.glb", old), "GLB version 1");
}

#[test]
fn a_damaged_glb_is_named_by_chunk_and_byte() {
    let glb = Document::triangle().glb();
    let json = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]);
    let at = 20 + json as usize;
    for (word, value, needle) in [
        (12, json + 999, "GLB chunk at byte 12: "),
        (at, 37, &format!("GLB chunk at byte {at}: ") as &str),
        (8, glb.len() as u32 + 4, "GLB header: "),
    ] {
        let mut damaged = glb.clone();
        damaged[word..word + 4].copy_from_slice(&value.to_le_bytes());
        refused(Folder::new().load("a.glb", &damaged), needle);
        refused(Folder::new().load("a.glb", &damaged), "is truncated");
    }
    let mut damaged = glb;
    damaged[16..20].copy_from_slice(b"TEXT");
    let needle = "GLB chunk at byte 12: the first chunk is not JSON";
    refused(Folder::new().load("a.glb", damaged), needle);
}

#[test]
fn references_and_ranges() {
    edited("accessor 9", |d| {
        d.primitive()["attributes"]["POSITION"] = json!(9)
    });
    edited("vertices [0, 1, 3]", |d| {
        let indices = d.accessor(U8, "SCALAR", 3, &[0, 1, 3]);
        d.primitive()["indices"] = json!(indices);
    });
    edited("do not fit", |d| {
        d.json["accessors"][0]["count"] = json!(4_000_000_000u64)
    });
    edited("do not fit", |d| {
        d.json["accessors"][0]["count"] = json!(u64::MAX)
    });
    edited("do not fit", |d| {
        d.json["accessors"][0]["byteOffset"] = json!(u64::MAX)
    });
    edited("reaches beyond", |d| {
        d.json["bufferViews"][0]["byteLength"] = json!(1u64 << 40)
    });
    edited("reaches beyond", |d| {
        d.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX)
    });
    edited("elements without data", |d| {
        let (indices, values) = (d.view(&[0]), d.view(&[0; 12]));
        let sparse = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": U8 },
                             "values": { "bufferView": values } });
        d.json["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000u64,
                                         "sparse": sparse });
    });
    edited("no triangle", |d| {
        d.json["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 3 });
    });
    edited(
        "node 0: its mesh is 7, but there are 1, numbered from 0",
        |d| d.json["nodes"][0]["mesh"] = json!(7),
    );
    edited("its mode is 17, and must be 4, 5 or 6", |d| {
        d.primitive()["mode"] = json!(17)
    });
    edited("its primitives are \"none\", and must be a list", |d| {
        d.json["meshes"][0]["primitives"] = json!("none")
    });
    edited("byteOffset is \"far\", and must be a whole number", |d| {
        d.json["accessors"][0]["byteOffset"] = json!("far")
    });
    edited("POSITION is -1", |d| {
        d.primitive()["attributes"]["POSITION"] = json!(-1)
    });
    edited("componentType is 9999, and must be", |d| {
        d.json["accessors"][0]["componentType"] = json!(9999)
    });
    edited("its type is absent, and must be", |d| {
        let accessor = d.json["accessors"][0].as_object_mut().unwrap();
        accessor.remove("type");
    });
    edited("indices is {}", |d| d.primitive()["indices"] = json!({}));
    edited("its type is SCALAR, and must be VEC3", |d| {
        d.json["accessors"][0]["type"] = json!("SCALAR")
    });
    edited("not unsigned integers", |d| {
        let indices = d.floats("SCALAR", &[0., 1., 2.]);
        d.primitive()["indices"] = json!(indices);
    });
}

#[test]
fn nodes_and_values() {
    edited("reached twice", |d| {
        d.json["nodes"] = json!([{ "mesh": 0, "children": [0] }])
    });
    edited("reached twice", |d| {
        d.json["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]);
    });
    edited(
        "node 0: the last row of its matrix, its numbers 4, 8, 12 and 16, is 0.5 0 0 1, and must be 0 0 0 1",
        |d| {
            d.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        },
    );
    edited("its matrix is [1,0,0], and must be 16 numbers", |d| {
        d.json["nodes"][0]["matrix"] = json!([1, 0, 0])
    });
    edited(
        "its translation is [\"1\",0,0], and must be 3 numbers",
        |d| d.json["nodes"][0]["translation"] = json!(["1", 0, 0]),
    );
    edited(
        "it names the child 3, but there are 1 nodes, numbered from 0; correct its children",
        |d| d.json["nodes"][0]["children"] = json!([3]),
    );
    edited("scene 3 does not exist, of 1; take the line", |d| {
        d.json["scene"] = json!(3)
    });
    edited("without length; write 0, 0, 0, 1", |d| {
        d.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0])
    });
    edited("puts the mesh beyond", |d| {
        d.json["nodes"][0]["scale"] = json!([1e30, 1, 1])
    });
    edited("not finite", |d| {
        d.bin[0..4].copy_from_slice(&f32::NAN.to_le_bytes())
    });
    edited("not finite", |d| {
        d.bin[0..4].copy_from_slice(&1e30f32.to_le_bytes())
    });
    edited("no triangle", |d| d.json["nodes"] = json!([{}]));
    edited("no triangle", |d| {
        d.json["accessors"][0]["count"] = json!(2)
    });
}

#[test]
fn required_extensions_are_named_with_the_cure() {
    edited("ACME_unheard_of", |d| {
        d.json["extensionsRequired"] = json!(["ACME_unheard_of"])
    });
    edited("export the file without it", |d| {
        d.json["extensionsRequired"] = json!(["ACME_unheard_of"])
    });
}

#[test]
fn buffers() {
    let (document, folder) = (Document::triangle(), Folder::new());
    refused(folder.load("a.gltf", document.gltf("gone.bin")), "gone.bin");
    refused(
        folder.load("a.gltf", document.gltf("data:,abc")),
        "36 bytes are announced, 3 are there",
    );
    // What lies behind the announced length is not the buffer's, though the bytes are there.
    let mut short = Document::triangle();
    let whole = format!("data:;base64,{}", STANDARD.encode(&short.bin));
    short.bin.truncate(24);
    refused(
        folder.load("a.gltf", short.gltf(&whole)),
        "reaches beyond the 24 bytes of buffer 0",
    );
    refused(
        folder.load("a.gltf", document.gltf("data:;base64,?")),
        "not base64",
    );
    refused(
        folder.load("a.gltf", document.gltf("https://a.example/b.bin")),
        "not a local file",
    );
    refused(
        folder.load("a.gltf", document.gltf(".")),
        "not a regular file",
    );
}

#[test]
fn obj_lines_are_named() {
    let folder = Folder::new();
    let bad = |line: &str, needle: &str| {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\nf 1 2 3\n");
        refused(folder.load("a.obj", &text), needle);
        refused(folder.load("a.obj", &text), "line 4");
    };
    bad("f 1 2 4", "v 4, but 3 stand before it");
    bad("f 0 1 2", "v 0");
    bad("f 1 2 -4", "v -4");
    bad("f 1 2 99999999999999999999", "is not an index");
    bad("f 1 2 9223372036854775807", "stand before it");
    bad("f 1 2 3/1/1/1", "more than three");
    bad("f 1 2 /1", "names no vertex");
    bad("v 1 2", "3 numbers are needed");
    bad("v 1 2 three", "`three` is not a number");
    refused(
        folder.load("b.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        "not finite",
    );
    refused(
        folder.load(
            "b.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/2 2/1 3/1\n",
        ),
        "vt 2, but 1 stand",
    );
}
