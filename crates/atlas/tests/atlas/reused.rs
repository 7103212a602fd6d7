//! Layouts that stay while the scene changes.

use crate::layouts::{apart, assert_clean};
use crate::scenes::{ball, cube, moved, scaled, scene};
use ambake_atlas::{Atlas, Options, Pages, Placement, UvMode, claims, layout, reuse};
use glam::DAffine3;
use scene::{Mesh, Scene};

/// Meshes, each with its own name, and where they stand: mesh, node, transform.
fn named(meshes: Vec<Mesh>, instances: &[(u32, u32, DAffine3)]) -> Scene {
    let mut scene = scene(meshes, instances);
    for instance in &mut scene.instances {
        instance.name = format!("node {}", instance.node);
    }
    scene
}

fn options(size: u32) -> Options {
    Options {
        page_size: size,
        uv: UvMode::Unwrap,
        ..Options::default()
    }
}

/// The layout of `after` that starts from that of `before`, and the latter.
fn again(before: &Scene, after: &Scene, size: u32) -> (Atlas, Option<Atlas>) {
    let options = options(size);
    let old = layout(before, &options, &|| false).expect("a layout");
    let [was, now] = [before, after].map(|scene| claims(scene, &options).expect("claims"));
    let new = reuse(&old, &was, after, &now, &options, None);
    (old, new)
}

/// These meshes and instances lie where they lay.
fn assert_kept(old: &Atlas, new: &Atlas, meshes: &[usize], instances: &[usize]) {
    for &m in meshes {
        assert_eq!(old.meshes[m].uvs, new.meshes[m].uvs, "mesh {m}");
        assert_eq!(old.meshes[m].triangle_pages, new.meshes[m].triangle_pages);
    }
    for &i in instances {
        assert_eq!(old.placements[i], new.placements[i], "instance {i}");
    }
}

#[test]
fn a_new_mesh_takes_free_space_two_gutters_from_all_that_stay() {
    let two = |more: bool| {
        let mut meshes = vec![cube(), ball(12)];
        let mut instances = vec![(0, 0, moved(0.0, 0.0, 0.0)), (1, 1, moved(5.0, 0.0, 0.0))];
        if more {
            meshes.push(ball(8));
            instances.push((2, 2, moved(9.0, 0.0, 0.0)));
        }
        named(meshes, &instances)
    };
    let (before, after) = (two(false), two(true));
    let (old, new) = again(&before, &after, 128);
    let new = new.expect("there is room");
    assert_clean(&new);
    assert_kept(&old, &new, &[0, 1], &[0, 1]);
    assert!(apart(&after, &new) > 4, "{}", apart(&after, &new));
    assert!(new.audit.texels > old.audit.texels);
    assert!(new.placements[2].is_somewhere());
    // Twice the same.
    let (_, once_more) = again(&before, &after, 128);
    assert_eq!(
        once_more.map(|atlas| atlas.placements),
        Some(new.placements)
    );
}

#[test]
fn a_mesh_of_another_shape_keeps_its_density() {
    let of = |size: f64| {
        let own = scaled(size, size, size);
        named(
            vec![cube(), ball(12)],
            &[(0, 0, DAffine3::IDENTITY), (1, 1, own)],
        )
    };
    let (before, after) = (of(0.8), of(0.6));
    let (old, new) = again(&before, &after, 256);
    let new = new.expect("it is smaller");
    assert_kept(&old, &new, &[0], &[0]);
    assert_clean(&new);
    let texels = |scene: &Scene, atlas: &Atlas| {
        let facts = ambake_atlas::facts(scene, atlas);
        facts.objects[1].density
    };
    let (was, is) = (texels(&before, &old), texels(&after, &new));
    assert!((is / was - 1.0).abs() < 0.02, "{was} {is}");
}

#[test]
fn one_more_copy_takes_a_rectangle_of_the_size_of_the_others() {
    let copies = |count: u32| {
        let at = |k: u32| (0, k, moved(3.0 * f64::from(k), 0.0, 0.0));
        named(vec![cube()], &(0..count).map(at).collect::<Vec<_>>())
    };
    let (before, after) = (copies(3), copies(4));
    let (old, new) = again(&before, &after, 64);
    let new = new.expect("pages are added");
    assert_clean(&new);
    assert_kept(&old, &new, &[0], &[0, 1, 2]);
    assert_eq!(new.placements[3].scale, old.placements[0].scale);
    assert!(apart(&after, &new) > 4);
    // One that stood alone has its charts where they fell, and is laid out anew with its copy.
    let (before, after) = (copies(1), copies(2));
    let (_, new) = again(&before, &after, 64);
    let new = new.expect("both are new");
    assert_clean(&new);
    let apart: Vec<Placement> = new.placements.clone();
    assert_ne!(apart[0], apart[1]);
}

#[test]
fn what_does_not_fit_the_pages_asked_for_is_laid_out_anew() {
    let of = |more: bool| {
        let mut instances = vec![(0, 0, DAffine3::IDENTITY)];
        let mut meshes = vec![cube()];
        if more {
            meshes.push(ball(12));
            instances.push((1, 1, moved(4.0, 0.0, 0.0)));
        }
        named(meshes, &instances)
    };
    let (before, after) = (of(false), of(true));
    let one = Options {
        pages: Pages::Most(1),
        ..options(64)
    };
    let old = layout(&before, &one, &|| false).expect("a layout");
    let [was, now] = [&before, &after].map(|scene| claims(scene, &one).expect("claims"));
    assert!(reuse(&old, &was, &after, &now, &one, None).is_none());
    // With further pages it stays.
    let (old, new) = again(&before, &after, 64);
    let new = new.expect("on another page");
    assert_kept(&old, &new, &[0], &[0]);
    assert!(new.page_count > old.page_count);
}
