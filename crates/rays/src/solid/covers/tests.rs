//! Which layers cover what, at exact heights.

use super::*;
use crate::fixture::{block, mask_left_half, mesh, placed_scene, world};
use glam::{DAffine3, DQuat, Vec3};
use scene::Mesh;

/// A level square of height `y`, `half` to each side, that looks up or down.
fn level(y: f32, half: f32, up: bool) -> Mesh {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let positions = corners.map(|(x, z)| Vec3::new(x, y, z)).to_vec();
    let faces = [[[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]];
    mesh(positions, faces[usize::from(up)].to_vec())
}

/// How many triangles lie at most `above` over the middle of the first mesh's triangle, on a surface that looks up;
/// by placements that turn, mirror and move all of it.
fn over(meshes: Vec<Mesh>, masked: bool, triangle: u32, above: f64) -> Vec<usize> {
    let turn = DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
    let moved = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, 1.0, 2.0));
    let mirrored = moved * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let count = |place: DAffine3| {
        let placed: Vec<_> = (0..meshes.len() as u32).map(|k| (k, place)).collect();
        let mut scene = placed_scene(meshes.clone(), &placed);
        if masked {
            mask_left_half(&mut scene);
        }
        let world = world(scene);
        let at = place.transform_point3(DVec3::new(0.01, 0.0, 0.02));
        let up = place.transform_vector3(DVec3::Y);
        let covers = world.solids().covers(None, (0, triangle), || f64::INFINITY);
        let is_over = |of: &Cover| (of.least..=above).contains(&(of.corners[0] - at).dot(up));
        let over = |covers: Covers| {
            covers
                .over((at, at), (at, up), above)
                .filter(is_over)
                .count()
        };
        covers.map_or(0, over)
    };
    [DAffine3::IDENTITY, moved, mirrored].map(count).to_vec()
}

#[test]
fn a_sheet_just_above_a_surface_that_looks_as_it_does_covers_it() {
    let floor = || level(0.0, 4.0, true);
    let mark = |y: f32| level(y, 0.5, true);
    assert_eq!(over(vec![floor(), mark(0.001)], false, 0, 0.01), [2; 3]);
    // Too high for this texel; in the floor, below it, and looking at it.
    assert_eq!(over(vec![floor(), mark(0.001)], false, 0, 0.0009), [0; 3]);
    for y in [0.0, -0.001] {
        assert_eq!(over(vec![floor(), mark(y)], false, 0, 0.01), [0; 3], "{y}");
    }
    let plate = level(0.001, 0.5, false);
    assert_eq!(over(vec![floor(), plate], false, 0, 0.01), [0; 3]);
    // A mark that is cut out is one too.
    assert_eq!(over(vec![floor(), mark(0.001)], true, 0, 0.01), [2; 3]);
}

#[test]
fn a_layer_lies_as_far_above_as_it_is_asked_to() {
    // A sheet as long as 1, of which a 32nd is 0.03125.
    let meshes = || vec![level(0.0, 1.5, true), level(0.05, 0.5, true)];
    assert_eq!(over(meshes(), false, 0, 1.0), [0; 3]);
    let placed = [0, 1].map(|mesh| (mesh, DAffine3::IDENTITY));
    let world = world(placed_scene(meshes(), &placed));
    let solids = world.solids();
    for (asked, count) in [(0.0, 0), (0.049, 0), (0.051, 2), (10.0, 2)] {
        let covering = solids.covering(asked);
        let covers = solids.covers(Some(&covering), (0, 0), || f64::INFINITY);
        let found = covers.map_or(0, |covers| {
            let (at, up) = (DVec3::ZERO, DVec3::Y);
            covers.over((at, at), (at, up), asked).count()
        });
        assert_eq!(found, count, "{asked}");
    }
}

#[test]
fn a_mark_on_a_closed_body_covers_the_side_that_it_lies_on() {
    let slab = block(Vec3::Y * -0.5, Vec3::new(3.0, 0.5, 3.0), false);
    let top = (0..12).find(|&t| {
        let corners = slab.triangles[t as usize].map(|k| slab.positions[k as usize]);
        corners.iter().all(|corner| corner.y == 0.0)
    });
    let top = top.expect("a block has a top");
    let meshes = || vec![slab.clone(), level(0.002, 0.5, true)];
    assert_eq!(over(meshes(), false, top, 0.01), [2; 3]);
}

/// Whether each of these points of the first mesh, which looks along `normal` there, has something straight above it
/// within `above` that covers it.
fn covered(meshes: Vec<Mesh>, points: &[(Vec3, Vec3)], above: f64) -> Vec<bool> {
    let placed: Vec<_> = (0..meshes.len() as u32)
        .map(|k| (k, DAffine3::IDENTITY))
        .collect();
    let triangles = meshes[0].triangles.len() as u32;
    let world = world(placed_scene(meshes, &placed));
    let is_covered = |&(at, normal): &(Vec3, Vec3)| {
        let (at, up) = (at.as_dvec3(), normal.as_dvec3().normalize());
        let is_over = |of: Cover| {
            let [a, b, c] = of.corners;
            let front = (b - a).cross(c - a);
            let height = (a - at).dot(front) / up.dot(front);
            let top = at + height * up;
            let sides = [(a, b), (b, c), (c, a)];
            let is_in = |(from, to): (DVec3, DVec3)| front.cross(to - from).dot(top - from) >= 0.0;
            (of.least..=above).contains(&height) && sides.into_iter().all(is_in)
        };
        (0..triangles).any(|triangle| {
            let covers = world.solids().covers(None, (0, triangle), || f64::INFINITY);
            covers.is_some_and(|covers| covers.over((at, at), (at, up), above).any(is_over))
        })
    };
    points.iter().map(is_covered).collect()
}

/// So many squares across, from -`half` to `half` by x and z, of a height by x.
fn bent(half: f32, across: u32, height: impl Fn(f32) -> f32) -> Mesh {
    let step = 2.0 * half / across as f32;
    let place = |k: u32| {
        let [x, z] = [k % (across + 1), k / (across + 1)].map(|k| k as f32 * step - half);
        Vec3::new(x, height(x), z)
    };
    let corner = |k: u32| k / across * (across + 1) + k % across;
    let faces = (0..across * across).map(corner).flat_map(|a| {
        let [b, c, d] = [a + 1, a + across + 2, a + across + 1];
        [[a, c, b], [a, d, c]]
    });
    mesh(
        (0..(across + 1).pow(2)).map(place).collect(),
        faces.collect(),
    )
}

#[test]
fn a_layer_covers_what_it_follows_however_both_bend() {
    let road = |x: f32| 0.3 * x * x;
    // Faces of one do not end where those of the other do.
    let meshes = || vec![bent(2.0, 64, road), bent(0.5, 20, |x| road(x) + 0.004)];
    let at = |x: f32, z: f32| (Vec3::new(x, road(x), z), Vec3::new(-0.6 * x, 1.0, 0.0));
    let places = [-1.2, -0.53, -0.47, -0.21, 0.02, 0.33, 0.47, 0.53, 1.2];
    for z in [-0.56f32, -0.44, 0.07, 0.44, 0.56] {
        let points = places.map(|x| at(x, z));
        let expected = places.map(|x| x.abs() < 0.5 && z.abs() < 0.5);
        assert_eq!(covered(meshes(), &points, 0.01), expected, "{z}");
        assert_eq!(covered(meshes(), &points, 0.002), [false; 9], "{z}");
    }
}

#[test]
fn a_thin_closed_body_covers_what_it_is_near_to_and_a_thick_one_nothing() {
    let floor = || level(0.0, 4.0, true);
    let body = |thick: f32, inward| {
        let middle = Vec3::Y * (0.001 + 0.5 * thick);
        block(middle, Vec3::new(0.4, 0.5 * thick, 0.4), inward)
    };
    let points = [0.0, 0.39, 0.41, 1.0].map(|x| (Vec3::new(x, 0.0, 0.1), Vec3::Y));
    for inward in [false, true] {
        let rug = |above| covered(vec![floor(), body(0.006, inward)], &points, above);
        for above in [0.008, 0.0011] {
            assert_eq!(rug(above), [true, true, false, false], "{above} {inward}");
        }
        assert_eq!(rug(0.0009), [false; 4], "{inward}");
        let block = || body(0.4, inward);
        assert_eq!(covered(vec![floor(), block()], &points, 0.5), [false; 4]);
    }
}

#[test]
fn corners_steps_boards_and_slots_cover_nothing_that_is_seen() {
    let floor = || level(0.0, 4.0, true);
    let points = |places: &[[f32; 3]], normal: Vec3| -> Vec<_> {
        places.iter().map(|&p| (Vec3::from(p), normal)).collect()
    };
    // Beside a wall, a board on edge and a step of a hair.
    let floor_points = points(
        &[[0.011, 0.0, 0.0], [-0.2, 0.0, 0.0], [0.5, 0.0, 0.5]],
        Vec3::Y,
    );
    let wall = block(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.01, 1.0, 1.0), false);
    let board = block(
        Vec3::new(0.005, 0.05, 0.0),
        Vec3::new(0.005, 0.05, 1.0),
        false,
    );
    let step = block(
        Vec3::new(-0.1, 0.001, 0.0),
        Vec3::new(0.1, 0.001, 1.0),
        false,
    );
    for (name, other, labels) in [
        ("wall", wall, [false; 3]),
        ("board", board, [false; 3]),
        ("step", step, [false; 3]),
    ] {
        let found = covered(vec![floor(), other], &floor_points, 0.02);
        assert_eq!(found, labels, "{name}");
    }
    // The walls of a slot look at each other, and are as good as touching where it is narrow.
    let side = |x: f32| block(Vec3::new(x, 0.5, 0.0), Vec3::new(0.01, 0.5, 1.0), false);
    let within = points(&[[0.01, 0.5, 0.0]], Vec3::X);
    let slot = |above| covered(vec![side(0.0), side(0.025)], &within, above);
    assert_eq!([slot(0.004), slot(0.006)], [[false], [true]]);
}
