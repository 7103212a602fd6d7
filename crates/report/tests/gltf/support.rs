//! Layouts, pictures and containers for the tests of the written GLB.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests say what they skip"
)]

use ambake_report::{Output, Shades, occlusion_png, write_gltf};
use atlas::{Atlas, Audit, MeshLayout, Placement, UvSource};
use glam::Vec2;
use scene::Scene;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A layout that splits every triangle off (or keeps the vertices), each object in a cell of its own, with every third
/// triangle on a second page where `pages` is 2.
pub fn layout(scene: &Scene, split: bool, pages: u32) -> Atlas {
    let mesh = |mesh: &scene::Mesh| {
        let corners = mesh.triangles.as_flattened();
        let vertices = mesh.positions.len() as u32;
        let place = |i: u32| Vec2::new((i % 97) as f32 / 97.0, (i / 97 % 89) as f32 / 89.0);
        let count = if split {
            corners.len() as u32
        } else {
            vertices
        };
        let own: Vec<u32> = (0..count).collect();
        MeshLayout {
            source_vertices: if split { corners.to_vec() } else { own.clone() },
            uvs: own.iter().map(|&i| place(i)).collect(),
            triangles: if split {
                own.as_chunks().0.to_vec()
            } else {
                mesh.triangles.clone()
            },
            triangle_pages: match pages {
                1 => Vec::new(),
                _ => (0..mesh.triangles.len())
                    .map(|t| u16::from(t % 3 == 2))
                    .collect(),
            },
            hidden: match split {
                true => (0..mesh.triangles.len()).map(|t| t % 2 == 1).collect(),
                false => Vec::new(),
            },
        }
    };
    let cells = (scene.instances.len() as f32).sqrt().ceil();
    let placement = |i: usize| Placement {
        page: 0,
        scale: [1.0 / cells; 2],
        offset: [
            (i as f32 % cells).floor() / cells,
            (i as f32 / cells).floor() / cells,
        ],
    };
    Atlas {
        page_size: 8,
        page_count: pages,
        gutter: 2,
        meshes: scene.meshes.iter().map(mesh).collect(),
        placements: (0..scene.instances.len()).map(placement).collect(),
        source: UvSource::Unwrapped,
        audit: Audit::default(),
        density: 1.0,
        chart_count: 1,
        notes: Vec::new(),
    }
}

/// A PNG file.
pub fn picture() -> Vec<u8> {
    let values: Vec<f32> = (0..64).map(|i| i as f32 / 63.0).collect();
    occlusion_png(8, &values)
}

/// One picture a page.
pub fn pictures(atlas: &Atlas) -> Vec<Vec<u8>> {
    vec![picture(); atlas.page_count as usize]
}

pub fn write(scene: &Scene, atlas: &Atlas, dir: &Path, name: &str) -> PathBuf {
    let bytes = write_gltf(scene, atlas, Some(&pictures(atlas)), &Shades::new()).unwrap();
    let mut out = Output::create(dir).unwrap();
    out.stage_bytes(name, &bytes).unwrap();
    out.publish().unwrap().remove(0)
}

/// The number of errors that Khronos' validator finds in all; `None` where it is not installed.
fn validate(files: &[PathBuf]) -> Option<Vec<Value>> {
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/tools/validate-gltf.mjs"
    );
    let run = match Command::new("node").arg(script).args(files).output() {
        Ok(run) if run.status.code() != Some(77) => run,
        _ => {
            crate::skip::skip(
                "node or its module gltf-validator is absent (npm install in tests/tools)",
            );
            return None;
        }
    };
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(!text.is_empty(), "{}", String::from_utf8_lossy(&run.stderr));
    Some(
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
    )
}

pub fn assert_valid(files: &[PathBuf]) {
    // Of no model there is nothing to be said; that it is absent was.
    if files.is_empty() {
        return;
    }
    for line in validate(files).into_iter().flatten() {
        assert_eq!(line["errors"], 0, "{line:#}");
        println!("{} warnings {}", line["file"], line["warnings"]);
    }
}

/// The chunks of a GLB.
pub fn open(path: &Path) -> (Value, Vec<u8>) {
    let source = scene::load(path).unwrap().source.unwrap();
    (source.json.clone(), source.buffers[0].clone())
}

pub fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    for word in [
        2,
        28 + text.len() as u32 + bin.len() as u32,
        text.len() as u32,
        0x4E4F_534A,
    ] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(text);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// World positions of all triangles' corners, in an order that does not depend on the objects' order.
pub fn corners(scene: &Scene) -> Vec<[u64; 9]> {
    let mut all = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for triangle in &mesh.triangles {
            let points = triangle.map(|v| {
                instance
                    .transform
                    .transform_point3(mesh.positions[v as usize].as_dvec3())
            });
            let bits: Vec<u64> = points
                .iter()
                .flat_map(|p| p.to_array())
                .map(f64::to_bits)
                .collect();
            all.push(bits.try_into().unwrap());
        }
    }
    all.sort_unstable();
    all
}
