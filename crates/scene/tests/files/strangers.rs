//! What a scene file from a stranger may have read: files of its own folder, and of those only what is used.

use super::support::{Document, Folder, png};
use ambake_scene::{Error, Files, load, load_with};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder with a secret beside the folder of the scene.
struct Place {
    _all: tempfile::TempDir,
    own: PathBuf,
    secret: PathBuf,
}

fn place() -> Place {
    let all = tempfile::tempdir().unwrap();
    let (own, secret) = (all.path().join("own"), all.path().join("secret.png"));
    fs::create_dir_all(own.join("deep")).unwrap();
    fs::write(&secret, png(&[[1, 2, 3, 4]])).unwrap();
    Place {
        _all: all,
        own,
        secret,
    }
}

/// A triangle whose textures read images 0 to n - 1, of which base colour reads the first.
fn textured(images: Value, textures: Value) -> Document {
    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    document.primitive()["material"] = json!(0);
    document.json["images"] = images;
    document.json["textures"] = textures;
    document.json["materials"] =
        json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    document
}

fn written(place: &Place, document: &Document) -> PathBuf {
    let path = place.own.join("a.glb");
    fs::write(&path, document.glb()).unwrap();
    path
}

fn is_outside(path: &Path) {
    match load(path) {
        Err(error @ Error::Outside { .. }) => {
            let line = error.to_string();
            assert!(
                line.contains("--allow-outside") && line.contains("a."),
                "{line}"
            );
        }
        other => panic!("{other:?}"),
    }
    load_with(path, Files::Anywhere).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn pictures_outside_of_the_folder_are_refused_by_every_road() {
    let place = place();
    let absolute = place.secret.display().to_string();
    for uri in [
        "../secret.png".to_owned(),
        "%2e%2e/secret.png".into(),
        "deep/../../secret.png".into(),
        format!("file://{absolute}"),
        absolute,
    ] {
        is_outside(&written(
            &place,
            &textured(json!([{ "uri": uri }]), json!([{ "source": 0 }])),
        ));
        // Not read by a bake, but carried into the GLB.
        let inner = json!([{ "uri": "own.png" }, { "uri": uri }]);
        fs::write(place.own.join("own.png"), png(&[[9; 4]])).unwrap();
        let both = json!([{ "source": 0 }, { "source": 1 }]);
        is_outside(&written(&place, &textured(inner, both)));
    }
    let inside = textured(
        json!([{ "uri": "deep/../own.png" }]),
        json!([{ "source": 0 }]),
    );
    load(&written(&place, &inside)).unwrap();
}

#[cfg(unix)]
#[test]
fn links_are_followed_before_they_are_judged() {
    let place = place();
    std::os::unix::fs::symlink(&place.secret, place.own.join("link.png")).unwrap();
    let document = textured(json!([{ "uri": "link.png" }]), json!([{ "source": 0 }]));
    is_outside(&written(&place, &document));
    // A scene that is a link itself may have its files beside either end.
    let real = place.own.join("deep/a.gltf");
    let document = textured(json!([{ "uri": "near.png" }]), json!([{ "source": 0 }]));
    fs::write(&real, document.gltf("b.bin")).unwrap();
    fs::write(place.own.join("b.bin"), &document.bin).unwrap();
    fs::write(place.own.join("deep/near.png"), png(&[[7; 4]])).unwrap();
    let linked = place.own.join("a.gltf");
    std::os::unix::fs::symlink(&real, &linked).unwrap();
    std::os::unix::fs::symlink("deep/near.png", place.own.join("near.png")).unwrap();
    load(&linked).unwrap();
}

#[test]
fn buffers_and_material_libraries_stay_inside_too() {
    let place = place();
    let document = Document::triangle();
    fs::write(place.own.join("../outer.bin"), &document.bin).unwrap();
    for uri in [
        "../outer.bin".to_owned(),
        format!("file://{}", place.own.join("../outer.bin").display()),
    ] {
        let path = place.own.join("a.gltf");
        fs::write(&path, document.gltf(&uri)).unwrap();
        is_outside(&path);
    }
    fs::write(place.own.join("../outer.mtl"), "newmtl m\nKd 1 0 0\n").unwrap();
    fs::write(
        place.own.join("inner.mtl"),
        "newmtl m\nmap_Kd ../secret.png\n",
    )
    .unwrap();
    for library in ["../outer.mtl", "inner.mtl"] {
        let path = place.own.join("a.obj");
        let text = format!(
            "mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
        );
        fs::write(&path, text).unwrap();
        is_outside(&path);
    }
}

#[test]
fn only_pictures_that_something_uses_are_taken_along() {
    let (folder, file) = (Folder::new(), png(&[[1, 2, 3, 4]]));
    for name in ["used.png", "unused.png", "sky.png"] {
        folder.write(name, &file);
    }
    folder.write("words.png", "root:x:0:0");
    let images = json!([{ "uri": "used.png" }, { "uri": "unused.png" }, { "uri": "words.png", "mimeType": "image/png" },
        { "uri": "used.png" }, { "uri": "sky.png" }]);
    let textures = json!([{ "source": 0 }, { "source": 2 },
        { "extensions": { "KHR_texture_basisu": { "source": 3 } } }]);
    let mut document = textured(images, textures);
    document.json["extensions"] =
        json!({ "EXT_lights_image_based": { "lights": [{ "specularImages": [[4]] }] } });
    let scene = folder.load("a.glb", document.glb()).unwrap();
    let kept: Vec<bool> = scene
        .source
        .as_ref()
        .unwrap()
        .images
        .iter()
        .map(Option::is_some)
        .collect();
    assert_eq!(
        kept,
        [true, false, false, true, true],
        "unused, and no picture by its bytes"
    );
    let read = |name: &str| scene.inputs.iter().any(|path| path.ends_with(name));
    assert!(
        read("used.png") && !read("unused.png"),
        "{:?}",
        scene.inputs
    );
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_endless_files_are_not_read() {
    let place = place();
    let pipe = place.own.join("pipe.png");
    let made = std::process::Command::new("mkfifo")
        .arg(&pipe)
        .status()
        .unwrap();
    assert!(made.success());
    std::os::unix::fs::symlink("/dev/zero", place.own.join("zero.png")).unwrap();
    let huge = fs::File::create(place.own.join("huge.png")).unwrap();
    huge.set_len(1 << 41).unwrap();
    for name in ["pipe.png", "zero.png", "huge.png"] {
        let used = textured(
            json!([{ "uri": "own.png" }, { "uri": name }]),
            json!([{ "source": 0 }, { "source": 1 }]),
        );
        fs::write(place.own.join("own.png"), png(&[[9; 4]])).unwrap();
        // Not needed for a bake: a device is outside, the others stay what they are.
        let path = written(&place, &used);
        assert_eq!(load(&path).is_err(), name == "zero.png", "{name}");
        let path = place.own.join("a.gltf");
        fs::write(&path, Document::triangle().gltf(name)).unwrap();
        load_with(&path, Files::Anywhere).unwrap_err();
    }
}

#[test]
fn an_edit_after_the_load_is_noticed_and_one_that_changes_nothing_is_not() {
    let folder = Folder::new();
    let document = textured(
        json!([{ "uri": "a.png" }, { "uri": "b.png" }]),
        json!([{ "source": 0 }, { "source": 1 }]),
    );
    let all = || {
        folder.write("a.png", png(&[[1; 4]]));
        folder.write("b.png", png(&[[2; 4]]));
        folder.write("a.bin", &document.bin);
        folder.write("a.gltf", document.gltf("a.bin"))
    };
    let path = all();
    let scene = load(&path).unwrap();
    assert!(!scene.was_edited());
    all();
    assert!(!scene.was_edited(), "the same bytes, written again");
    folder.write("b.png", png(&[[3; 4]]));
    assert!(!scene.was_edited(), "a picture that no term reads");
    folder.write("a.png", png(&[[3; 4]]));
    assert!(scene.was_edited());
    all();
    fs::remove_file(&path).unwrap();
    assert!(scene.was_edited());
    let obj = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let scene = load(&obj).unwrap();
    assert!(!scene.was_edited());
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
    assert!(scene.was_edited());
}

#[test]
fn a_document_that_could_not_be_written_back_is_refused_at_load() {
    let mut document = Document::triangle();
    let mut deep = json!(1);
    for _ in 0..200 {
        deep = json!([deep]);
    }
    document.json["extras"] = deep;
    let error = document.load().unwrap_err().to_string();
    assert!(
        error.contains("JSON") && error.contains("recursion"),
        "{error}"
    );
}

#[test]
fn a_sound_picture_that_is_too_large_is_not_called_broken() {
    // 40,000 x 40,000 grey pixels of one bit: 200 MB packed, 6 GB as colours; only its header is needed to know.
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], body: &[u8]| {
        let content = [&kind[..], body].concat();
        file.extend((body.len() as u32).to_be_bytes());
        file.extend(&content);
        file.extend(crc(&content).to_be_bytes());
    };
    let side = 40_000u32.to_be_bytes();
    chunk(b"IHDR", &[&side[..], &side, &[16, 6, 0, 0, 0]].concat());
    chunk(b"IDAT", &[0x78, 0x9c, 3, 0, 0, 0, 0, 1]);
    chunk(b"IEND", &[]);
    let folder = Folder::new();
    folder.write("large.png", file);
    let document = textured(json!([{ "uri": "large.png" }]), json!([{ "source": 0 }]));
    let error = folder
        .load("a.glb", document.glb())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("scale it down") && !error.contains("repair"),
        "{error}"
    );
}

/// CRC-32 of PNG, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 * (sum & 1))
        })
    })
}
