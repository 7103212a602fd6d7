//! Larger files: nothing is lost, and memory is bounded.

use super::support::{Document, Folder, U32};
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

    let points = |scene: &ambake_scene::Scene| -> Vec<[f32; 3]> {
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
