//! Occlusion, roughness and metalness in one picture, where a file's coordinates are kept: read back by the crate
//! `gltf` and judged by Khronos' validator.

use crate::support::{Page, assert_valid_gltf, bake, files, report};
use gltf::json::Root;
use image::{ImageFormat, Rgb, RgbImage};
use serde_json::json;
use std::io::Cursor;

/// A floor with coordinates that a bake can keep, under a lid without; its roughness is a board of 4 x 4 texels.
fn floor() -> Vec<u8> {
    let board = RgbImage::from_fn(4, 4, |x, y| Rgb([7, (40 * x + 10) as u8, (60 * y) as u8]));
    let mut png = Cursor::new(Vec::new());
    board
        .write_to(&mut png, ImageFormat::Png)
        .expect("a picture");
    let floor = [
        [0.0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    let lid = floor.map(|[x, _, z]| [0.5 * x, 0.3, z]);
    let uvs = [
        [0.125f32, 0.125],
        [0.875, 0.125],
        [0.875, 0.875],
        [0.125, 0.875],
    ];
    let floats = |numbers: &[f32]| {
        numbers
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let indices: Vec<u8> = [0u16, 2, 1, 0, 3, 2]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let parts = [
        floats(floor.as_flattened()),
        floats(lid.as_flattened()),
        floats(uvs.as_flattened()),
        indices,
        png.into_inner(),
    ];
    let mut bin = Vec::new();
    let views: Vec<_> = parts
        .iter()
        .map(|part| {
            let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": part.len() });
            bin.extend(part);
            bin.resize(bin.len().next_multiple_of(4), 0);
            view
        })
        .collect();
    let corner = |view: u32, max: [f32; 3], min: [f32; 3]| {
        json!({ "bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3", "max": max,
            "min": min })
    };
    let json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bin.len() }],
        "bufferViews": views,
        "accessors": [
            corner(0, [1.0, 0.0, 1.0], [0.0; 3]),
            corner(1, [0.5, 0.3, 1.0], [0.0, 0.3, 0.0]),
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "images": [{ "bufferView": 4, "mimeType": "image/png" }],
        "textures": [{ "source": 0 }],
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0.5,
        "metallicRoughnessTexture": { "index": 0 } } }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 2 }, "indices": 3, "material": 0 }] },
            { "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 3 }] },
        ],
        "nodes": [{ "name": "floor", "mesh": 0 }, { "name": "lid", "mesh": 1 }],
        "scenes": [{ "nodes": [0, 1] }],
    });
    let mut text = serde_json::to_vec(&json).expect("JSON");
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = (28 + text.len() + bin.len()) as u32;
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(total.to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

#[test]
fn kept_coordinates_get_one_picture_of_occlusion_roughness_and_metalness() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("floor.glb");
    std::fs::write(&path, floor()).expect("written");
    let flags = ["--size=64", "--rays=32", "--exclude=lid", "--for=godot"];
    let (out, page) = bake(&path, &[&flags[..], &["--uv=keep"]].concat());
    let packed = out.path().join("floor.orm.glb");
    assert_valid_gltf(&packed);
    let told = report(out.path())["lightmaps"].to_string();
    assert!(told.contains("floor.orm.glb"), "{told}");

    let bytes = std::fs::read(&packed).expect("written");
    let glb = gltf::Glb::from_slice(&bytes).expect("a GLB");
    let root = Root::from_slice(&glb.json).expect("glTF");
    let bin = glb.bin.expect("a buffer");
    let material = &root.materials[0];
    let occlusion = material.occlusion_texture.as_ref().expect("occlusion");
    let surface = &material.pbr_metallic_roughness.metallic_roughness_texture;
    let surface = surface.as_ref().expect("roughness");
    assert_eq!((occlusion.tex_coord, surface.tex_coord), (1, 1));
    assert_eq!(occlusion.index.value(), surface.index.value());
    let texture = &root.textures[surface.index.value()];
    let view = root.images[texture.source.value()]
        .buffer_view
        .expect("a view");
    let view = &root.buffer_views[view.value()];
    let from = view.byte_offset.map_or(0, |offset| offset.0 as usize);
    let picture = image::load_from_memory(&bin[from..][..view.byte_length.0 as usize]);
    let picture = picture.expect("a picture").into_rgb8();
    assert_eq!(picture.dimensions(), (64, 64));
    holds(&picture, &page);

    // Coordinates of its own: there is nothing to pack.
    let (own, _) = bake(&path, &[&flags[..], &["--uv=unwrap"]].concat());
    let names = files(own.path());
    assert!(names.iter().all(|name| !name.contains("orm")), "{names:?}");
}

/// Red is the diffuse term; green and blue are the board, bilinear between the middles of its texels.
fn holds(picture: &RgbImage, page: &Page) {
    let (diffuse, coverage) = (page.plane("diffuse"), page.plane("coverage"));
    let mut dark = 0;
    for (x, y, Rgb([red, green, blue])) in picture.enumerate_pixels() {
        let at = (y * 64 + x) as usize;
        if coverage[at] == 0.0 {
            continue;
        }
        assert!(
            (f32::from(*red) - 255.0 * diffuse[at]).abs() <= 0.51,
            "{x} {y}"
        );
        dark += usize::from(*red < 200);
        let board = |i: u32| ((i as f32 + 0.5) / 16.0 - 0.5).clamp(0.0, 3.0);
        assert!(
            (f32::from(*green) - (40.0 * board(x) + 10.0)).abs() <= 0.6,
            "{x} {y}: {green}"
        );
        assert!(
            (f32::from(*blue) - 60.0 * board(y)).abs() <= 0.6,
            "{x} {y}: {blue}"
        );
    }
    assert!(dark > 100, "{dark} texels are dark");
}
