//! The glTF document that a scene keeps for the writer.

use super::support::{Document, Folder, png};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// A triangle whose base colour reads image 0 of those given.
fn with_images(images: Value) -> Document {
    let mut document = Document::triangle();
    document.json["textures"] = json!([{ "source": 0 }]);
    document.wear(json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]));
    document.json["images"] = images;
    document
}

#[test]
fn buffers_are_as_long_as_announced_and_the_json_keeps_its_order() {
    let (mut document, folder) = (Document::triangle(), Folder::new());
    document.json["VENDOR"] = json!({ "z": 1, "a": [0.1, { "y": null, "b": 2 }] });
    folder.write("a.bin", [&document.bin[..], b"padding"].concat());
    let text = document.gltf("a.bin");
    let source = folder.load("a.gltf", &text).unwrap().source.unwrap();
    assert_eq!(source.json.to_string(), text);
    assert_eq!(source.buffers, [&document.bin[..]]);
    document.bin.push(7);
    let source = document.load().unwrap().source.unwrap();
    assert_eq!(
        source.buffers,
        [document.bin],
        "a chunk's padding is left out"
    );
    let obj = folder.load("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(obj.unwrap().source.is_none());
}

#[test]
fn every_picture_behind_a_uri_is_kept_with_the_media_type_of_its_bytes() {
    let (file, folder) = (png(&[[1, 2, 3, 4]]), Folder::new());
    folder.write("a b.png", &file);
    let data = |media: &str| format!("data:{media};base64,{}", STANDARD.encode(&file));
    let odd = "data:image/x-odd,odd";
    let document = with_images(json!([
        { "uri": "a%20b.png" },
        { "uri": data("image/x-wrong") },
        { "uri": data(""), "mimeType": "image/x-own" },
        { "uri": odd },
        { "uri": "data:,unknown" },
        { "uri": "gone.png" },
        { "uri": "https://a.example/b.png" },
        { "bufferView": 0, "mimeType": "image/png" },
    ]));
    let buffer = format!("data:;base64,{}", STANDARD.encode(&document.bin));
    let scene = folder.load("a.gltf", document.gltf(&buffer)).unwrap();
    let source = scene.source.unwrap();
    let kept: Vec<_> = source
        .images
        .iter()
        .map(|image| image.as_ref().map(|i| (i.mime_type.as_str(), &i.bytes[..])))
        .collect();
    let expected = [
        Some(("image/png", &file[..])),
        Some(("image/png", &file)),
        Some(("image/png", &file)),
        None,
        None,
        None,
        None,
        None,
    ];
    assert_eq!(kept, expected);
    // A content that is held decoded is not held as text too; a URI that leads nowhere stays whole.
    let uri = |list: &str, i: usize| source.json[list][i]["uri"].as_str().unwrap().to_owned();
    assert_eq!(uri("buffers", 0), "data:;base64,");
    assert_eq!(uri("images", 1), "data:image/x-wrong;base64,");
    assert_eq!(uri("images", 3), odd);
    assert_eq!(uri("images", 4), "data:,unknown");
    assert_eq!(uri("images", 6), "https://a.example/b.png");
}

#[test]
fn an_image_that_no_term_reads_is_not_part_of_the_hash() {
    let folder = Folder::new();
    let mut document = with_images(json!([{ "uri": "read.png" }, { "uri": "unread.png" }]));
    document.json["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    let hash = |read: u8, unread: u8| {
        folder.write("read.png", png(&[[read; 4]]));
        folder.write("unread.png", png(&[[unread; 4]]));
        folder.write("a.bin", &document.bin);
        let scene = folder.load("a.gltf", document.gltf("a.bin")).unwrap();
        let source = scene.source.unwrap();
        assert_eq!(
            source.images[1].as_ref().unwrap().bytes,
            png(&[[unread; 4]])
        );
        scene.content_hash
    };
    assert_eq!(hash(1, 2), hash(1, 3));
    assert_ne!(hash(1, 2), hash(3, 2));
}
