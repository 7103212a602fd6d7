//! Which bodies are solids, cavities and rooms, and which side of them is lit.

mod blinds;
mod cliffs;
mod folds;
mod grounds;
mod rooms;
mod tiles;
mod uneven;
mod wounds;

use super::*;
use crate::Mix;
use crate::fixture::{block, mask_left_half, mesh, placed_scene, scene, world};
use glam::{DQuat, Vec3};
use scene::Mesh;

fn unit(inward: bool) -> Mesh {
    block(Vec3::ZERO, Vec3::ONE, inward)
}

/// A level square that looks up, `half` wide to each side.
fn level(y: f32, half: f32) -> Mesh {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let positions = corners.map(|(x, z)| Vec3::new(x, y, z)).to_vec();
    mesh(positions, vec![[0, 2, 1], [0, 3, 2]])
}

/// A sheet that nothing is near to.
fn sheet() -> Mesh {
    level(-3.0, 9.0)
}

/// In how many more solids than cavities a point lies.
fn depth(solids: &Solids, point: DVec3) -> i32 {
    let near = solids.about(point, point);
    near.iter()
        .map(|&body| solids.depth(body, point, None))
        .sum()
}

fn solids(meshes: Vec<Mesh>) -> Solids {
    Solids::of(world(scene(meshes)).scene())
}

const INSIDE: DVec3 = DVec3::new(0.3, -0.2, 0.4);

#[test]
fn a_box_is_a_solid_however_it_is_wound() {
    for inward in [false, true] {
        let solids = solids(vec![unit(inward), sheet()]);
        assert_eq!(solids.count(), 1, "inward {inward}");
        assert_eq!(solids.inside_out(), [(0, 0)][..usize::from(inward)]);
        for (point, expected) in [
            (INSIDE, 1),
            (DVec3::new(0.0, 0.999, 0.0), 1),
            (DVec3::new(0.0, 1.001, 0.0), 0),
            (DVec3::new(-1.001, 0.5, 0.2), 0),
            (DVec3::new(5.0, 0.0, 0.0), 0),
        ] {
            assert_eq!(depth(&solids, point), expected, "inward {inward}, {point}");
        }
    }
}

#[test]
fn a_box_that_looks_inward_is_lit_from_behind_where_nothing_is_in_it() {
    type Change = fn(&mut scene::Material);
    let stone = || vec![unit(true), sheet()];
    let chair = || block(Vec3::new(0.5, -0.8, 0.5), Vec3::splat(0.2), false);
    let beside = [2.0 * DVec3::X];
    let cases: [(Vec<Mesh>, &[DVec3], Change, usize); 8] = [
        (stone(), &[], |_| {}, 12),
        (stone(), &beside, |_| {}, 12),
        (vec![unit(false), sheet()], &[], |_| {}, 0),
        // A light in it, a lamp of its own, one side, something that stands in it, nothing else.
        (stone(), &[INSIDE], |_| {}, 0),
        (stone(), &[], |m| m.emission = Vec3::ONE, 0),
        (stone(), &[], |m| m.double_sided = false, 0),
        (vec![unit(true), chair()], &[], |_| {}, 0),
        (vec![unit(true)], &[], |_| {}, 0),
    ];
    for (meshes, lights, change, expected) in cases {
        let mut scene = scene(meshes);
        change(&mut scene.materials[0]);
        let backs = Solids::of(world(scene).scene()).backs(lights);
        let triangles: usize = backs.iter().map(|(_, of)| of.len()).sum();
        assert_eq!(triangles, expected);
    }
}

#[test]
fn normals_of_a_tile_that_point_away_from_where_its_ground_looks_are_told() {
    // Three tiles in a row, level or in a slope; the normals of the last look the other way.
    let tiles = |rise: f32| {
        let mut ground = mesh(Vec::new(), Vec::new());
        for k in 0..3u32 {
            let mut tile = level(0.0, 1.0);
            let start = k as f32;
            tile.positions
                .iter_mut()
                .for_each(|p| p.y = rise * (start + 0.5 + 0.5 * p.x));
            ground
                .positions
                .extend(tile.positions.iter().map(|p| *p + 2.0 * k as f32 * Vec3::X));
            ground
                .triangles
                .extend(tile.triangles.iter().map(|of| of.map(|v| v + 4 * k)));
            ground
                .normals
                .extend([if k == 2 { Vec3::NEG_Y } else { Vec3::Y }; 4]);
        }
        ground
    };
    let averse = |mesh: Mesh| Solids::of(world(scene(vec![mesh])).scene()).averse(&[]);
    assert_eq!(averse(tiles(0.0)), [(0, vec![4, 5])]);
    assert_eq!(averse(tiles(0.3)), [(0, vec![4, 5])]);
    // Most look down: then who is to say which side is lit.
    let mut most = tiles(0.0);
    most.normals[..4].fill(Vec3::NEG_Y);
    assert_eq!(averse(most), []);
    // Nor where a surface looks to two sides.
    let mut folded = tiles(0.0);
    folded.positions.push(Vec3::new(2.0, -3.0, 0.0));
    folded.normals.push(Vec3::Y);
    folded.triangles.push([8, 12, 9]);
    folded.triangles.push([9, 12, 8]);
    assert_eq!(averse(folded), []);
}

#[test]
fn normals_that_point_into_a_box_are_told_from_those_of_a_corner_or_of_a_room() {
    let with_normals = |inward: bool, sign: f32| {
        let mut block = unit(inward);
        let middle = INSIDE.as_vec3();
        block.normals = (block.positions.iter())
            .map(|p| sign * (*p - middle).normalize())
            .collect();
        block
    };
    let averse = |mesh: Mesh| {
        let scene = scene(vec![mesh, sheet()]);
        let found = Solids::of(world(scene).scene()).averse(&[]);
        found.iter().map(|(_, of)| of.len()).sum::<usize>()
    };
    assert_eq!(averse(with_normals(false, -1.0)), 12);
    assert_eq!(averse(with_normals(false, 1.0)), 0);
    // Two of one shape, one with normals of its own, and a mirrored place of that.
    let meshes = vec![with_normals(false, 1.0), with_normals(false, -1.0)];
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let [near, far] = [5.0, 9.0].map(|x| DAffine3::from_translation(x * DVec3::X));
    let placed = [(0, near), (1, far), (1, mirrored)];
    let found = Solids::of(world(placed_scene(meshes, &placed)).scene()).averse(&[]);
    assert_eq!(found, [(1, (0..12).collect())]);
    // Faces that look inward are told by their winding.
    assert_eq!(averse(with_normals(true, -1.0)), 0);
    assert_eq!(averse(with_normals(true, 1.0)), 0);
    assert_eq!(averse(unit(false)), 0);
    // A room whose faces are wound the wrong way: something stands in it, or a light.
    let room = || with_normals(false, -1.0);
    let chair = block(Vec3::new(0.5, -0.8, 0.5), Vec3::splat(0.2), false);
    let furnished = Solids::of(world(scene(vec![room(), chair])).scene()).averse(&[]);
    assert_eq!(furnished, []);
    let lit = Solids::of(world(scene(vec![room(), sheet()])).scene()).averse(&[INSIDE]);
    assert_eq!(lit, []);
    // An open box too is a body.
    let mut open = room();
    open.triangles.truncate(10);
    assert_eq!(averse(open), 10);
    // One corner that leans to the other side so much that its faces do: two corners of each are right.
    let mut bent = with_normals(false, 1.0);
    bent.normals[0] *= -4.0;
    assert_eq!(averse(bent.clone()), 0);
    // All corners of one side, which has two triangles.
    for (normal, at) in bent.normals.iter_mut().zip(&bent.positions) {
        let outward = *at - INSIDE.as_vec3();
        *normal = if outward.x > 0.0 { -outward } else { outward };
    }
    assert_eq!(averse(bent), 2);
    // One wall of a room, be it closed or open.
    let room = unit(true);
    let corners = room
        .triangles
        .iter()
        .flatten()
        .map(|&corner| room.positions[corner as usize]);
    let mut wall = mesh(
        corners.collect(),
        (0..12).map(|k| [0, 1, 2].map(|v| 3 * k + v)).collect(),
    );
    let is_wall = |of: &[Vec3]| of.iter().all(|p| p.x == 1.0);
    for of in wall.positions.chunks(3) {
        let inward = (of[1] - of[0]).cross(of[2] - of[0]).normalize();
        wall.normals
            .extend([if is_wall(of) { -inward } else { inward }; 3]);
    }
    assert_eq!(averse(wall.clone()), 2);
    let positions = wall.positions.clone();
    let is_other = |of: &[u32; 3]| of.iter().all(|&corner| positions[corner as usize].z == 1.0);
    wall.triangles.retain(|of| !is_other(of));
    assert_eq!((wall.triangles.len(), averse(wall)), (10, 2));
}

#[test]
fn a_mirrored_and_a_squeezed_placement_keep_their_inside() {
    let turn = DQuat::from_rotation_y(0.3);
    let at = DVec3::new(20.0, 1.0, -3.0);
    let placed = [
        DAffine3::IDENTITY,
        DAffine3::from_scale_rotation_translation(DVec3::new(-2.0, 1.0, 0.1), turn, at),
    ];
    let scene = placed_scene(vec![unit(false)], &placed.map(|place| (0, place)));
    let solids = Solids::of(world(scene).scene());
    for place in placed {
        assert_eq!(depth(&solids, place.transform_point3(INSIDE)), 1);
        assert_eq!(depth(&solids, place.transform_point3(DVec3::Y * 1.01)), 0);
    }
    assert_eq!(solids.shapes.len(), 1, "both share one shape");
}

#[test]
fn an_open_and_a_cut_out_box_bury_nothing() {
    let mut open = unit(false);
    open.triangles.pop();
    assert_eq!(solids(vec![open]).count(), 0);
    let mut masked = scene(vec![unit(false)]);
    mask_left_half(&mut masked);
    assert_eq!(Solids::of(world(masked).scene()).count(), 0);
    let mut folded = unit(false);
    folded.triangles = vec![[0, 1, 2], [0, 2, 1]];
    assert_eq!(
        solids(vec![folded]).count(),
        0,
        "a folded sheet has no inside"
    );
}

#[test]
fn a_body_of_two_materials_closes_over_both_meshes() {
    let (mut lower, mut upper) = (unit(false), unit(false));
    lower.triangles.truncate(5);
    upper.triangles.drain(..5);
    let mut scene = scene(vec![lower, sheet(), upper]);
    // Of one node each, or all of one.
    for apart in [0, 1] {
        for (node, instance) in (0..).zip(&mut scene.instances) {
            instance.node = apart * node;
        }
        let solids = Solids::of(world(scene.clone()).scene());
        assert_eq!(solids.count(), 1);
        assert_eq!(depth(&solids, INSIDE), 1);
        assert_eq!(solids.own(0, 0), solids.own(2, 0));
        assert_eq!(solids.own(1, 0), None);
    }
}

#[test]
fn seams_of_vertices_do_not_cut_a_surface() {
    let mut split = unit(false);
    let corners: Vec<Vec3> = split
        .triangles
        .iter()
        .flatten()
        .map(|&v| split.positions[v as usize])
        .collect();
    split.triangles = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    split.positions = corners;
    assert_eq!(depth(&solids(vec![split]), INSIDE), 1);
}

#[test]
fn a_lived_in_room_is_air_and_its_furniture_is_solid() {
    let chair = block(Vec3::new(0.5, -0.8, 0.5), Vec3::splat(0.2), false);
    let solids = solids(vec![unit(true), chair, sheet()]);
    assert_eq!(depth(&solids, INSIDE), 0);
    assert_eq!(depth(&solids, DVec3::new(0.5, -0.8, 0.45)), 1);
    assert!(solids.inside_out().is_empty());
}

#[test]
fn a_room_is_air_by_what_lies_mostly_in_it_unless_something_large_is_outside() {
    let chair = block(Vec3::new(0.5, -0.9, 0.5), Vec3::splat(0.2), false);
    // The sides of the room have 4 square units: what has less than 2 is small.
    for (half, expected) in [(0.69, 0), (0.75, 1)] {
        let solids = solids(vec![unit(true), chair.clone(), level(-3.0, half)]);
        assert_eq!(depth(&solids, INSIDE), expected, "beside {half}");
    }
    // What is large beside the one room is small beside another, whose sides have 36.
    let hall = block(Vec3::X * 9.0, Vec3::splat(3.0), true);
    let bench = block(Vec3::new(9.0, -2.9, 0.0), Vec3::splat(0.2), false);
    let ground = level(-7.0, 2.0);
    let solids = solids(vec![unit(true), chair, hall, bench, ground]);
    let depths = [INSIDE, DVec3::X * 9.0].map(|point| depth(&solids, point));
    assert_eq!(depths, [1, 0]);
}

#[test]
fn a_cavity_is_air_with_or_without_furniture() {
    let shell = block(Vec3::ZERO, Vec3::splat(1.2), false);
    let chair = block(Vec3::new(0.5, -0.8, 0.5), Vec3::splat(0.2), false);
    for (furniture, at_chair) in [(vec![], 0), (vec![chair], 1)] {
        let solids = solids([vec![shell.clone(), unit(true)], furniture].concat());
        assert_eq!(depth(&solids, INSIDE), 0);
        assert_eq!(depth(&solids, DVec3::new(0.5, -0.8, 0.45)), at_chair);
        assert_eq!(depth(&solids, DVec3::new(1.1, 0.0, 0.0)), 1, "in the wall");
        let own = solids.own(1, 0).expect("the cavity is closed");
        assert_eq!(
            solids.depth(own, DVec3::X, Some(own)),
            -1,
            "its own walls stand in the open"
        );
    }
}

#[test]
fn a_solid_does_not_bury_itself_but_one_that_lies_elsewhere_may() {
    let moved = block(Vec3::X * 0.1, Vec3::ONE, false);
    let solids = solids(vec![unit(false), moved]);
    let own = solids.own(0, 0).expect("closed");
    assert_eq!(solids.depth(own, INSIDE, Some(own)), 0);
    assert_ne!(solids.own(1, 0), Some(own));
    assert_eq!(depth(&solids, INSIDE), 2);
}

#[test]
fn surfaces_far_from_a_box_do_not_meet_it() {
    let solids = solids(vec![unit(false)]);
    let corners = |low: DVec3, high: DVec3| [low, high].into_iter();
    assert!(solids.meets(0, corners(DVec3::splat(0.9), DVec3::splat(1.1))));
    assert!(!solids.meets(0, corners(DVec3::splat(-0.9), DVec3::splat(0.9))));
    assert!(!solids.meets(0, corners(DVec3::splat(1.1), DVec3::splat(2.0))));
}

#[test]
fn depths_near_a_surface_are_those_seen_from_far() {
    // Edges and corners on the lattice, a leaning one, and one in another.
    let turned = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(0.7);
    let mut leaning = unit(false);
    for position in &mut leaning.positions {
        *position = (turned * position.as_dvec3()).as_vec3();
    }
    let cases = [
        vec![unit(false)],
        vec![unit(true)],
        vec![leaning],
        vec![block(Vec3::ZERO, Vec3::splat(3.0), false), unit(true)],
    ];
    for (case, meshes) in cases.into_iter().enumerate() {
        let solids = solids(meshes);
        for middle in [
            DVec3::new(1.0, 1.0, 0.5),
            DVec3::new(0.9, 0.1, 1.2),
            DVec3::ZERO,
        ] {
            let at = |k: u32| f64::from(k % 9) / 4.0 - 1.0;
            let points: Vec<DVec3> = (0..729)
                .map(|k| middle + 0.5 * DVec3::new(at(k), at(k / 9), at(k / 81)))
                .collect();
            for body in 0..2.min(solids.bodies.len() as u32) {
                let mut near = solids.near(body, points.iter().copied());
                for &point in &points {
                    let expected = solids.depth(body, point, None);
                    assert_eq!(near.depth(point, None), expected, "case {case}, {point}");
                }
            }
        }
    }
}

#[test]
fn heights_near_a_sheet_are_those_asked_of_all_of_it() {
    // Bumps, of which one stands out of the box of points.
    let bump = |k: u32| [0.0, 0.3, -0.2, 0.9, 0.1][k as usize % 5];
    let corner = |k: u32| Vec3::new((k % 7) as f32, bump(k * k), (k / 7) as f32);
    let square = |k: u32| {
        let a = k / 6 * 7 + k % 6;
        [[a, a + 7, a + 1], [a + 1, a + 7, a + 8]]
    };
    let sheet = mesh(
        (0..49).map(corner).collect(),
        (0..36).flat_map(square).collect(),
    );
    let mut post = block(Vec3::new(3.0, 2.0, 3.0), Vec3::new(0.4, 3.0, 0.4), false);
    post.positions.iter_mut().for_each(|p| p.y += 0.05);
    let solids = solids(vec![sheet, post]);
    let ground = (0..solids.bodies.len() as u32).find(|&body| solids.is_ground(body));
    let ground = ground.expect("the post is rooted in the sheet");
    let Inside::Behind(rooted) = &solids.bodies[ground as usize].inside else {
        panic!("a ground");
    };
    let post = Some(rooted[0]);
    let mut mix = Mix(3);
    let mut point = |half: f64| {
        let at = [0; 3].map(|_| half * (2.0 * mix.unit() - 1.0));
        DVec3::new(3.0, 0.2, 3.0) + DVec3::from(at)
    };
    let mut counts = [0; 2];
    for half in [0.05, 0.4, 2.5] {
        let points: Vec<DVec3> = (0..500).map(|_| point(half)).collect();
        let mut near = solids.near(ground, points.iter().copied());
        for &point in &points {
            let expected = solids.depth(ground, point, post);
            assert_eq!(near.depth(point, post), expected, "{point}");
            counts[expected as usize] += 1;
        }
    }
    assert!(counts[0] > 200 && counts[1] > 200, "{counts:?}");
}

#[test]
fn depths_out_of_the_box_that_was_given_are_those_seen_from_far() {
    let solids = solids(vec![unit(false)]);
    let box_of = [DVec3::splat(0.5), DVec3::splat(0.9)];
    for first in [DVec3::splat(0.7), DVec3::splat(3.0)] {
        let mut near = solids.near(0, box_of.into_iter());
        near.depth(first, None);
        for point in [
            DVec3::new(0.7, 0.7, 3.0),
            DVec3::new(-3.0, 0.7, 0.7),
            DVec3::new(0.1, -1.5, 0.2),
            DVec3::new(0.1, -0.5, 0.2),
            DVec3::splat(0.6),
        ] {
            let expected = solids.depth(0, point, None);
            assert_eq!(near.depth(point, None), expected, "{point} after {first}");
        }
    }
}

/// An upright tube without ends about the vertical axis.
fn tube(low: f32, high: f32) -> Mesh {
    let mut open = block(
        Vec3::Y * (low + high) * 0.5,
        Vec3::new(0.5, (high - low) * 0.5, 0.5),
        false,
    );
    open.triangles.retain(|t| {
        (0..3).any(|k| open.positions[t[k] as usize].y != open.positions[t[0] as usize].y)
    });
    open
}

/// The depth at a point of a triangle of the second mesh.
fn buried(solids: &Solids, point: DVec3) -> i32 {
    let (own, near) = (solids.own(1, 0), solids.about(point, point));
    near.iter()
        .map(|&body| solids.depth(body, point, own))
        .sum()
}

fn buried_at(solids: &Solids, heights: [f64; 3]) -> [i32; 3] {
    heights.map(|y| buried(solids, DVec3::new(0.5, y, 0.1)))
}
