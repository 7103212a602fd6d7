//! Layouts that stay while the scene changes.

use crate::layouts::{apart, assert_clean};
use crate::scenes::{ball, cube, mesh, moved, scaled, scene};
use ambake_atlas::{Atlas, Options, Pages, Placement, UvMode, UvSource, claims, layout, reuse};
use glam::{DAffine3, Vec2, Vec3};
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

/// A square of one unit with coordinates of its own: the square of edge `edge` at `at`.
fn authored(at: [f32; 2], edge: f32) -> Mesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = corners.map(|[x, y]| Vec3::new(x, 0.0, -y));
    let uv = |[x, y]: [f32; 2]| Vec2::new(at[0] + edge * x, at[1] + edge * y);
    let mut mesh = mesh("authored", positions.into(), vec![[0, 1, 2], [0, 2, 3]]);
    mesh.uv_sets = vec![corners.map(uv).into()];
    mesh
}

/// As [`again`], with coordinates that are kept; each square stands by itself.
fn kept(before: &[Mesh], after: &[Mesh], size: u32) -> (Atlas, Scene, Option<Atlas>) {
    let [before, after] = [before, after].map(|meshes| {
        let at = |k: u32| (k, k, moved(2.0 * f64::from(k), 0.0, 0.0));
        named(
            meshes.to_vec(),
            &(0..meshes.len() as u32).map(at).collect::<Vec<_>>(),
        )
    });
    let options = Options {
        uv: UvMode::Keep,
        ..options(size)
    };
    let old = layout(&before, &options, &|| false).expect("a layout");
    let [was, now] = [&before, &after].map(|scene| claims(scene, &options).expect("claims"));
    let new = reuse(&old, &was, &after, &now, &options, None);
    (old, after, new)
}

#[test]
fn authored_coordinates_of_what_is_new_stand_where_the_others_leave_them_free() {
    let before = [authored([0.1, 0.1], 0.3), authored([0.6, 0.1], 0.3)];
    let after = [&before[..], &[authored([0.1, 0.6], 0.3)]].concat();
    let (old, _, new) = kept(&before, &after, 128);
    let new = new.expect("nothing overlaps");
    assert_clean(&new);
    assert_kept(&old, &new, &[0, 1], &[0, 1]);
    assert_eq!(new.source, UvSource::Kept { set: 0 });
    assert_eq!(new.placements[2], old.placements[0], "as they stand");
}

#[test]
fn authored_coordinates_that_lie_on_others_take_a_rectangle_of_free_space() {
    let before = [authored([0.1, 0.1], 0.3), authored([0.6, 0.1], 0.3)];
    let after = [&before[..], &[authored([0.0, 0.0], 0.9)]].concat();
    let (old, after, new) = kept(&before, &after, 128);
    assert_eq!(old.source, UvSource::Kept { set: 0 });
    let new = new.expect("there is room");
    assert_clean(&new);
    assert_kept(&old, &new, &[0, 1], &[0, 1]);
    assert_eq!(new.source, UvSource::Repacked { set: 0 });
    // It gets the density of the others.
    let densities = ambake_atlas::facts(&after, &new).objects;
    let [first, third] = [0, 2].map(|k| densities[k].density);
    assert!((third / first - 1.0).abs() < 0.05, "{first} {third}");
    // Rectangles that were packed stay as well.
    let square = || authored([0.0, 0.0], 1.0);
    let (old, _, new) = kept(&[square(), square()], &[square(), square(), square()], 64);
    assert_eq!(old.source, UvSource::Repacked { set: 0 });
    let new = new.expect("on a further page, if need be");
    assert_clean(&new);
    assert_kept(&old, &new, &[0, 1], &[0, 1]);
    assert!(new.placements[2].is_somewhere());
}

#[test]
fn what_is_new_has_the_one_density_of_an_even_layout() {
    let of = |more: bool| {
        let mut meshes = vec![cube(), ball(12)];
        let mut instances = vec![(0, 0, moved(0.0, 0.0, 0.0)), (1, 1, moved(5.0, 0.0, 0.0))];
        if more {
            // So small that otherwise it would have more texels than its share.
            meshes.push(cube());
            instances.push((2, 2, scaled(0.02, 0.02, 0.02)));
        }
        named(meshes, &instances)
    };
    let options = Options {
        even: true,
        ..options(256)
    };
    let (before, after) = (of(false), of(true));
    let old = layout(&before, &options, &|| false).expect("a layout");
    let [was, now] = [&before, &after].map(|scene| claims(scene, &options).expect("claims"));
    let new = reuse(&old, &was, &after, &now, &options, None).expect("there is room");
    let facts = ambake_atlas::facts(&after, &new);
    let [first, second, small] = [0, 1, 2].map(|o| facts.objects[o].density);
    assert!((first / second - 1.0).abs() < 0.01, "{first} {second}");
    assert!((small / first - 1.0).abs() < 0.01, "{small}, not {first}");
}
