//! Larger files: nothing is lost, and memory is bounded.

use super::support::{Document, Folder, U32, png};
use ambake_scene::{MaterialModel, Scene};
use glam::Vec2;
use serde_json::json;
use std::fmt::Write;

/// Vertices of a grid of `n` by `n` squares, and their triangles.
fn grid(n: u32) -> (Vec<f32>, Vec<u32>) {
    let m = n + 1;
    let positions = (0..m * m)
        .flat_map(|i| [(i % m) as f32, (i / m) as f32, (i % 7) as f32])
        .collect();
    let corner = |i: u32| i / n * m + i % n;
    let triangles = (0..n * n)
        .map(corner)
        .flat_map(|a| [a, a + 1, a + m + 1, a, a + m + 1, a + m])
        .collect();
    (positions, triangles)
}

#[test]
fn two_hundred_thousand_triangles_load_alike_from_obj_and_glb() {
    let (positions, triangles) = grid(316);
    let mut text = String::new();
    positions
        .chunks(3)
        .for_each(|p| writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap());
    let corner = |i: u32| i + 1;
    triangles.chunks(3).for_each(|t| {
        writeln!(
            text,
            "f {0} {1} {2}",
            corner(t[0]),
            corner(t[1]),
            corner(t[2])
        )
        .unwrap();
    });
    let obj = Folder::new().load("a.obj", text).unwrap();

    let mut document = Document::triangle();
    let accessor = document.floats("VEC3", &positions);
    let bytes: Vec<u8> = triangles.iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = document.accessor(U32, "SCALAR", triangles.len(), &bytes);
    *document.primitive() = json!({ "attributes": { "POSITION": accessor }, "indices": indices });
    let glb = document.load().unwrap();

    let points = |scene: &Scene| -> Vec<[f32; 3]> {
        let mesh = &scene.meshes[0];
        mesh.triangles
            .iter()
            .flatten()
            .map(|&i| mesh.positions[i as usize].to_array())
            .collect()
    };
    assert_eq!(
        (obj.meshes[0].triangles.len(), obj.meshes[0].positions.len()),
        (199_712, 317 * 317)
    );
    assert!(points(&obj) == points(&glb));
    // Nothing is kept beyond what is there.
    for mesh in obj.meshes.iter().chain(&glb.meshes) {
        assert_eq!(mesh.positions.capacity(), mesh.positions.len());
        assert_eq!(mesh.triangles.capacity(), mesh.triangles.len());
    }
}

/// The number and the red of the picture of each material.
fn reds(scene: &Scene) -> Vec<(u32, f32)> {
    let map = |material: &ambake_scene::Material| match &material.surface {
        MaterialModel::MetallicRoughness { base_map, .. } => base_map.clone(),
        MaterialModel::Phong { albedo_map, .. } => albedo_map.clone(),
        MaterialModel::SpecularGlossiness { diffuse_map, .. } => diffuse_map.clone(),
    };
    let maps = scene.materials.iter().map(|m| map(m).unwrap());
    maps.map(|map| (map.image, scene.color(&map, Vec2::ZERO).x))
        .collect()
}

#[test]
fn the_same_picture_under_several_names_is_decoded_and_kept_once() {
    let (red, black) = (png(&[[255, 0, 0, 255]]), png(&[[0, 0, 0, 255]]));
    let expected = [(0, 1.0), (1, 0.0), (0, 1.0), (0, 1.0), (0, 1.0)];
    let folder = Folder::new();
    for (name, bytes) in [("red.png", &red), ("copy.png", &red), ("black.png", &black)] {
        folder.write(name, bytes);
    }

    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    document.primitive()["material"] = json!(0);
    let view = document.view(&red);
    document.json["images"] = json!([{ "uri": "red.png" }, { "uri": "black.png" },
        { "uri": "copy.png", "name": "other" },
        { "bufferView": view, "mimeType": "image/png" }, { "uri": "red.png" }]);
    let each = |i: usize| {
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } },
            "normalTexture": { "index": i } })
    };
    document.json["textures"] = (0..5).map(|i| json!({ "source": i })).collect();
    document.wear((0..5).map(each).collect());
    let scene = folder.load("a.glb", document.glb()).unwrap();
    assert_eq!((scene.images.len(), scene.packed_images.len()), (2, 2));
    assert_eq!(reds(&scene), expected);
    let maps = scene.materials.iter().map(|m| m.normal_map.as_ref());
    let maps: Vec<u32> = maps.map(|map| map.unwrap().texture.image).collect();
    assert_eq!(maps, expected.map(|(image, _)| image));
    // The files are taken along as the document names them.
    let source = scene.source.unwrap();
    let kept = source
        .images
        .iter()
        .map(|image| image.as_ref().map(|image| image.bytes.clone()));
    let kept: Vec<_> = kept.collect();
    let all = [Some(&red), Some(&black), Some(&red), None, Some(&red)];
    assert_eq!(kept, all.map(|bytes| bytes.cloned()));

    let names = ["red.png", "black.png", "copy.png", "./red.png", "red.png"];
    let materials = names.iter().enumerate();
    let library: String = materials
        .map(|(i, name)| format!("newmtl m{i}\nmap_Kd {name}\n"))
        .collect();
    folder.write("a.mtl", library);
    let faces = (0..names.len()).map(|i| format!("usemtl m{i}\nf 1/1 2/1 3/1\n"));
    let text =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n".to_owned() + &faces.collect::<String>();
    let scene = folder.load("a.obj", text).unwrap();
    assert_eq!((scene.images.len(), reds(&scene)), (2, expected.to_vec()));
}
