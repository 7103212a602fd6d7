//! The table against its page, and each of its rows against a file that has the property.

use super::*;
use serde_json::json;
use std::fmt::Write;

/// The two tables as Markdown.
fn tables() -> String {
    let mut text = String::new();
    for (head, rows) in [("core", CORE), ("extension", EXTENSIONS)] {
        let _ = write!(text, "| {head} | | how | counted as |\n|---|---|---|---|\n");
        for row in rows {
            let support = match row.support {
                Honoured => "honoured",
                Harmless => "harmless",
                Approximated => "approximated",
                NotRead => "not read",
            };
            let needed = if row.needed {
                "; refused where it is required"
            } else {
                ""
            };
            let kind = row
                .warning
                .map_or(String::new(), |kind| format!("`{kind}`"));
            let _ = writeln!(
                text,
                "| {} | {support} | {}{needed} | {kind} |",
                row.name, row.note
            );
        }
        text.push('\n');
    }
    text
}

#[test]
fn the_page_on_gltf_has_this_table() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/gltf.md");
    let page = std::fs::read_to_string(page).unwrap();
    let tables = tables();
    assert!(page.contains(&tables), "docs/gltf.md lacks:\n{tables}");
}

#[test]
fn what_is_not_read_is_counted_and_what_is_harmless_is_not() {
    for row in CORE.iter().chain(EXTENSIONS) {
        match row.support {
            NotRead => assert!(row.warning.is_some(), "{}", row.name),
            Honoured | Harmless => assert!(row.warning.is_none(), "{}", row.name),
            Approximated => assert!(!row.note.is_empty(), "{}", row.name),
        }
        assert!(
            row.support == Honoured || row.warning.is_none() || !row.note.is_empty(),
            "{}",
            row.name
        );
    }
    let mut names: Vec<&str> = EXTENSIONS.iter().map(|row| row.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), EXTENSIONS.len());
}

/// A triangle of one material, edited.
fn loaded(edit: impl FnOnce(&mut Value)) -> Result<crate::Scene, crate::Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let corners = [0.0f32, 0., 0., 1., 0., 0., 0., 1., 0.];
    let bin: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(folder.path().join("a.bin"), bin).unwrap();
    let mut json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 36, "uri": "a.bin" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2" },
        ],
        "materials": [{ "name": "m", "pbrMetallicRoughness": { "metallicFactor": 0 } }],
        "meshes": [{ "name": "m", "primitives": [
            { "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 },
        ] }],
        "nodes": [{ "name": "n", "mesh": 0 }],
        "images": [{ "uri": "data:," }],
        "textures": [{ "source": 0 }],
        "scenes": [{ "nodes": [0] }],
    });
    edit(&mut json);
    std::fs::write(&path, json.to_string()).unwrap();
    crate::load(&path)
}

/// Required, with this content in a place of the document.
fn extended(name: &str, at: &str, content: Value) -> Result<crate::Scene, crate::Error> {
    loaded(|json| {
        json["extensionsRequired"] = json!([name]);
        json.pointer_mut(at).unwrap()["extensions"] = json!({ name: content });
    })
}

#[test]
fn every_property_of_the_core_is_counted_or_silent_as_its_row_says() {
    // One for each row: a pointer, and what is put there.
    let points = json!([{ "attributes": { "POSITION": 0 } }, { "attributes": { "POSITION": 0 }, "mode": 0 }]);
    let samples = [
        ("/accessors/0/byteOffset", json!(0)),
        ("/accessors/0/min", json!([5, 5, 5])),
        ("/animations", json!([{ "channels": [], "samplers": [] }])),
        ("/asset/version", json!("2.1")),
        ("/asset/minVersion", json!("2.0")),
        ("/buffers/0/name", json!("b")),
        ("/bufferViews/0/byteStride", json!(12)),
        ("/bufferViews/0/target", json!(34962)),
        ("/cameras", json!([{}])),
        ("/extensionsUsed", json!(["KHR_xmp"])),
        ("/nodes/0/extras", json!({ "a": 1 })),
        ("/images", json!([{ "uri": "gone.png" }])),
        ("/images", json!([{ "mimeType": "image/x-odd" }])),
        ("/materials/0/alphaMode", json!("BLEND")),
        ("/materials/0/doubleSided", json!(true)),
        ("/materials/0/emissiveFactor", json!([1, 1, 1])),
        ("/materials/0/normalTexture", json!({ "index": 0 })),
        ("/materials/0/occlusionTexture", json!({ "index": 0 })),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            json!([1, 0, 0, 1]),
        ),
        (
            "/materials/0/pbrMetallicRoughness/roughnessFactor",
            json!(0.5),
        ),
        ("/meshes/0/primitives/0/attributes/COLOR_0", json!(0)),
        ("/meshes/0/primitives/0/attributes/_OWN", json!(0)),
        (
            "/meshes/0/primitives",
            json!([{ "attributes": { "POSITION": 0 } }]),
        ),
        ("/meshes/0/primitives/0/mode", json!(5)),
        ("/meshes/0/primitives", points),
        ("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }])),
        ("/nodes/0/translation", json!([1, 2, 3])),
        ("/nodes/0/skin", json!(0)),
        ("/samplers", json!([{ "wrapS": 33071 }])),
        ("/samplers", json!([{ "minFilter": 9728 }])),
        ("/scene", json!(0)),
        ("/textures", json!([{}, {}])),
    ];
    assert_eq!(samples.len(), CORE.len());
    for (row, (at, value)) in CORE.iter().zip(samples) {
        let scene = loaded(|json| {
            let (parent, key) = at.rsplit_once('/').unwrap();
            json.pointer_mut(parent).unwrap()[key] = value;
        });
        let scene = scene.unwrap_or_else(|e| panic!("{}: {e}", row.name));
        let kinds: Vec<WarningKind> = scene.warnings.iter().map(|w| w.kind).collect();
        assert_eq!(kinds, row.warning.as_slice(), "{} at {at}", row.name);
    }
}

#[test]
fn every_extension_is_counted_or_silent_as_its_row_says_wherever_it_stands() {
    let places = [
        "",
        "/nodes/0",
        "/meshes/0",
        "/meshes/0/primitives/0",
        "/materials/0",
        "/textures/0",
        "/scenes/0",
    ];
    for row in EXTENSIONS {
        // These read what they hold where it stands.
        let own = match row.name {
            "EXT_mesh_gpu_instancing" | "KHR_draco_mesh_compression" => continue,
            name => name,
        };
        for at in places {
            let content = |amount: f64| match row.amount {
                Some(name) => json!({ name: amount }),
                None => json!({}),
            };
            if row.amount.is_some() {
                let scene = extended(own, at, content(0.0)).unwrap();
                assert_eq!(scene.warned(Ignored), 0, "{own} at {at} of nothing");
            }
            let scene = extended(own, at, content(0.5));
            if row.needed {
                let error = scene.unwrap_err().to_string();
                assert!(error.contains(own), "{error}");
                continue;
            }
            let scene = scene.unwrap_or_else(|e| panic!("{own} at {at}: {e}"));
            let counted = u64::from(row.warning == Some(Ignored));
            assert_eq!(
                scene.warned(Ignored),
                counted,
                "{own} at {at}: {:?}",
                scene.warnings
            );
            let places: Vec<&str> = scene.warnings.iter().map(|w| w.place.as_str()).collect();
            match (counted, at) {
                (0, _) => {}
                (_, "") => assert_eq!(places, ["the file"]),
                (_, "/nodes/0") => assert_eq!(places, ["node `n`"]),
                (_, "/textures/0") => assert_eq!(places, ["texture 0"]),
                (_, "/scenes/0") => assert_eq!(places, ["scene 0"]),
                (_, "/materials/0") => assert_eq!(places, ["material `m`"]),
                _ => assert_eq!(places, ["mesh `m`"]),
            }
        }
    }
    let error = extended("ACME_unheard_of", "/nodes/0", Value::Null).unwrap_err();
    assert!(error.to_string().contains("ACME_unheard_of"), "{error}");
}
