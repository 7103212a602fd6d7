//! `STEM.layout`: an atlas that a file gives back, and files that it does not fit.

use super::support::layout;
use ambake_report::{layout_hash, read_layout, write_layout};
use scene::Scene;
use serde_json::json;
use std::path::Path;

fn instances() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/instances.gltf");
    scene::load(&path).unwrap()
}

#[test]
fn a_layout_is_read_as_it_was_written_where_key_and_scene_are_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let scene = instances();
    let path = folder.path().join("instances.layout");
    let key = json!({ "scene": "instances", "size": 8 });
    assert!(read_layout(&path, &key, &scene).unwrap().is_none());
    for (split, pages) in [(false, 1), (true, 2)] {
        let atlas = layout(&scene, split, pages);
        std::fs::remove_file(&path).ok();
        write_layout(&path, &key, &atlas).unwrap();
        let read = read_layout(&path, &key, &scene).unwrap().expect("an atlas");
        assert_eq!(layout_hash(&read), layout_hash(&atlas));
        assert_eq!(read.placements, atlas.placements);
        for (read, written) in read.meshes.iter().zip(&atlas.meshes) {
            assert_eq!(read.source_vertices, written.source_vertices);
            assert_eq!(read.uvs, written.uvs);
            assert_eq!(read.triangles, written.triangles);
            assert_eq!(read.triangle_pages, written.triangle_pages);
            assert_eq!(read.hidden, written.hidden);
        }
        let other = json!({ "scene": "instances", "size": 16 });
        assert!(read_layout(&path, &other, &scene).unwrap().is_none());
        // A scene of more meshes under the same key.
        let mut more = scene.clone();
        more.meshes.push(more.meshes[0].clone());
        assert!(read_layout(&path, &key, &more).unwrap().is_none());
    }
}

#[test]
fn a_layout_that_does_not_fit_the_scene_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let scene = instances();
    let key = json!("instances");
    let atlas = layout(&scene, true, 2);
    let refused = |name: &str, spoil: &dyn Fn(&mut atlas::Atlas)| {
        let mut spoilt = atlas.clone();
        spoil(&mut spoilt);
        let path = folder.path().join(name);
        write_layout(&path, &key, &spoilt).unwrap();
        let why = read_layout(&path, &key, &scene)
            .expect_err(name)
            .to_string();
        assert!(why.contains("it does not fit the scene"), "{name}: {why}");
    };
    refused("a vertex that there is not", &|a| {
        a.meshes[0].triangles[0][1] = 1 << 20
    });
    refused("a source that there is not", &|a| {
        a.meshes[0].source_vertices[0] = 1 << 20;
    });
    refused("a triangle too few", &|a| {
        a.meshes[0].triangles.pop();
        a.meshes[0].triangle_pages.pop();
        a.meshes[0].hidden.pop();
    });
    refused("a page too few", &|a| {
        a.meshes[0].triangle_pages.pop();
    });
    refused(
        "a triangle of which is not told whether it is hidden",
        &|a| {
            a.meshes[0].hidden.pop();
        },
    );
    refused("no number", &|a| a.meshes[0].uvs[0].x = f32::NAN);
    refused("an object without a place", &|a| {
        a.placements.pop();
    });
    refused("a page past the last", &|a| a.placements[0].page = 2);
    refused("no pages", &|a| a.page_count = 0);
    refused("an endless offset", &|a| {
        a.placements[0].offset[1] = f32::INFINITY
    });
}
