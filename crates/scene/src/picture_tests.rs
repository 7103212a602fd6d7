//! The bound on all decoded pictures of a scene, with scenes that need few bytes.

use crate::image::Budget;
use crate::load::load_within;
use crate::{Error, Files};
use std::io::Cursor;
use std::path::Path;

/// Pixels of a picture, wide and high.
const SIZE: [u32; 2] = [256, 128];
/// Bytes of it, decoded.
const BYTES: u64 = 4 * 256 * 128;
/// Pictures in a scene.
const COUNT: u64 = 3;

/// Writes pictures of one colour each, which are small files.
fn write_pictures(folder: &Path) {
    for i in 0..COUNT {
        let pixel = image::Luma([i as u8]);
        let image = image::GrayImage::from_pixel(SIZE[0], SIZE[1], pixel);
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        std::fs::write(folder.join(format!("{i}.png")), bytes.into_inner()).unwrap();
    }
}

/// A triangle and a material for each picture.
fn gltf() -> String {
    let list = |item: fn(u64) -> String| (0..COUNT).map(item).collect::<Vec<_>>().join(",");
    let corners: Vec<u8> = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let corners: String = corners.iter().map(|b| format!("%{b:02x}")).collect();
    let images = list(|i| format!(r#"{{"uri":"{i}.png"}}"#));
    let textures = list(|i| format!(r#"{{"source":{i}}}"#));
    let materials =
        list(|i| format!(r#"{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{i}}}}}}}"#));
    let primitives = list(|i| format!(r#"{{"attributes":{{"POSITION":0}},"material":{i}}}"#));
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],
        "meshes":[{{"primitives":[{primitives}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"data:,{corners}"}}],
        "images":[{images}],"textures":[{textures}],"materials":[{materials}]}}"#
    )
}

#[test]
fn pictures_that_are_too_much_together_stop_the_load_before_they_are_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_pictures(folder);
    let file = |i: u64| std::fs::metadata(folder.join(format!("{i}.png"))).unwrap();
    let own: u64 = (0..COUNT).map(|i| 64 * file(i).len()).sum();
    let need = COUNT * BYTES - own;
    let library: String = (0..COUNT)
        .map(|i| format!("newmtl m{i}\nmap_Kd {i}.png\n"))
        .collect();
    std::fs::write(folder.join("a.mtl"), library).unwrap();
    let faces = (0..COUNT).map(|i| format!("usemtl m{i}\nf 1 2 3\n"));
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &faces.collect::<String>();
    for (name, text, place) in [
        ("a.gltf", gltf(), "a.gltf: image 2 `2.png`: "),
        ("a.obj", obj, "2.png: material `m2`: "),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        let load = |free| load_within(&path, Files::Inside, Budget::of(free));
        let scene = load(need).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.images.len() as u64, COUNT, "{name}");
        let Err(error @ Error::Invalid { .. }) = load(need - 1) else {
            panic!("{name} is loaded");
        };
        let line = error.to_string();
        let told = line.contains(place) && line.contains("decoded pictures of the scene");
        assert!(told && !line.contains('\n'), "{line}");
    }
}
