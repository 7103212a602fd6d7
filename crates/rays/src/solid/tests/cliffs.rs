//! Scenes in which everything meets everything: what is asked grows with them, and not with their squares.

use super::placed::{PlacedTree, most_meetings, sheets};
use super::*;
use crate::mix::Mix;

#[test]
fn copies_that_coincide_are_one_body_and_do_not_bury_each_other() {
    let place = DAffine3::from_translation(DVec3::X);
    // A mesh, and another one that equals it.
    let placed: Vec<(u32, DAffine3)> = (0..60).map(|k| (k % 2, place)).collect();
    let world = world(placed_scene(vec![unit(false), unit(false)], &placed));
    let solids = world.solids();
    assert_eq!((solids.bodies(), solids.count()), (1, 1));
    assert_eq!(depth(solids, INSIDE + DVec3::X), 1);
    for instance in 0..60 {
        assert_eq!(solids.own(instance, 3), solids.own(0, 3), "{instance}");
        assert!(!world.is_buried(instance, 3, [0.4, 0.3, 0.3]), "{instance}");
    }
}

#[test]
fn the_cavity_of_a_shell_that_stands_twice_is_air() {
    let hollow = block(Vec3::ZERO, Vec3::splat(0.5), true);
    let placed = [0, 0, 1].map(|mesh| (mesh, DAffine3::IDENTITY));
    let scene = placed_scene(vec![unit(false), hollow], &placed);
    let solids = Solids::of(world(scene).scene());
    assert_eq!(depth(&solids, DVec3::splat(0.1)), 0);
    assert_eq!(depth(&solids, DVec3::splat(0.7)), 1);
}

#[test]
fn a_heap_of_sheets_is_asked_in_proportion_and_the_ground_beside_it_as_ever() {
    let mut mix = Mix(7);
    let mut unit = || DVec3::new(mix.unit(), mix.unit(), mix.unit()) - 0.5;
    // Blades that meet in a point.
    let mut blade = || {
        let (tip, side) = (unit().normalize(), 0.04 * unit().normalize());
        let corners = [DVec3::ZERO, tip, tip + side].map(|p| p.as_vec3() + Vec3::Y * 20.0);
        mesh(corners.to_vec(), vec![[0, 1, 2]])
    };
    for count in [500, 2000, 8000] {
        let mut meshes = vec![level(0.0, 9.0), tube(-0.5, 1.5)];
        meshes.extend((0..count).map(|_| blade()));
        let solids = solids(meshes);
        let placed = solids.placed_surfaces();
        let found = sheets(&PlacedTree::of(placed.iter().collect()));
        let asked: usize = found.iter().map(|sheet| sheet.near.len()).sum();
        assert!(asked <= most_meetings(placed.len()), "{count}: {asked}");
        assert_eq!(found[0].near, [1], "the largest is asked first");
        assert_eq!(buried(&solids, DVec3::new(0.5, -0.2, 0.1)), 1);
    }
    assert!(most_meetings(80_000) == 4 * most_meetings(20_000));
}

#[test]
fn of_boxes_in_boxes_all_but_the_outermost_are_buried_by_one_of_them() {
    const COUNT: u32 = 200;
    let boxes = (1..=COUNT).map(|k| block(Vec3::ZERO, Vec3::splat(k as f32), false));
    let world = world(scene(boxes.collect()));
    for (instance, triangle) in (0..COUNT).flat_map(|i| (0..12).map(move |t| (i, t))) {
        let expected = instance + 1 < COUNT;
        let weights = [0.5, 0.2, 0.3];
        assert_eq!(world.is_buried(instance, triangle, weights), expected);
        assert_eq!(
            world.burial(instance, triangle).is_buried(weights),
            expected
        );
        let corner = world.corners(instance, triangle)[0];
        let own = world.solids().own(instance, triangle);
        assert_eq!(world.solids().swallow(corner, corner, own), expected);
    }
}

#[test]
fn what_lies_in_a_cavity_is_swallowed_by_nothing() {
    let hollow = block(Vec3::ZERO, Vec3::splat(0.5), true);
    let solids = solids(vec![unit(false), hollow]);
    let swallows = |at: f64, own| solids.swallow(DVec3::splat(at), DVec3::splat(at), own);
    assert!(!swallows(0.1, None) && !swallows(1.1, None));
    assert!(swallows(0.7, None) && !swallows(0.7, solids.own(0, 0)));
    assert!(!swallows(1.0, None), "on a surface nothing is certain");
}
