//! Bodies of which some faces run the other way round, and bodies that look inward and hide something.

use super::*;

/// A unit block about [`INSIDE`] of which these triangles are turned round.
fn block_but(inward: bool, turned: &[usize]) -> Mesh {
    let mut block = unit(inward);
    for &triangle in turned {
        block.triangles[triangle].swap(1, 2);
    }
    block
}

/// Triangles of the first mesh that are lit from behind.
fn backs(meshes: Vec<Mesh>, lights: &[DVec3]) -> Vec<u32> {
    let found = Solids::of(world(scene(meshes)).scene()).backs(lights);
    let of_first = found.into_iter().find(|(mesh, _)| *mesh == 0);
    of_first.map_or(Vec::new(), |(_, triangles)| triangles)
}

#[test]
fn faces_that_run_against_the_others_of_a_body_are_lit_on_its_side() {
    let all = || 0..12u32;
    for turned in [&[0][..], &[0, 1], &[3, 6, 7], &[0, 2, 4, 6]] {
        let is_turned = |triangle: &u32| turned.contains(&(*triangle as usize));
        let turned_ones: Vec<u32> = all().filter(is_turned).collect();
        let others: Vec<u32> = all().filter(|triangle| !is_turned(triangle)).collect();
        // A body that looks outward but for some faces, and one that looks inward but for some, alone or not.
        for beside in [vec![], vec![sheet()]] {
            let with = |block: Mesh| [vec![block], beside.clone()].concat();
            assert_eq!(backs(with(block_but(false, turned)), &[]), turned_ones);
            assert_eq!(backs(with(block_but(true, turned)), &[]), others);
        }
        // A room with a light in it, or a chair: what looks out of it looks in.
        assert_eq!(
            backs(vec![block_but(true, turned), sheet()], &[INSIDE]),
            turned_ones
        );
        let chair = block(Vec3::new(0.5, -0.8, 0.5), Vec3::splat(0.2), false);
        assert_eq!(
            backs(vec![block_but(true, turned), chair], &[]),
            turned_ones
        );
    }
}

#[test]
fn a_body_with_some_faces_turned_is_a_solid_and_an_open_or_one_sided_one_stays() {
    let of = |mesh: Mesh| Solids::of(world(scene(vec![mesh, sheet()])).scene());
    let whole = of(unit(false));
    let uneven = of(block_but(false, &[0, 3, 8]));
    assert_eq!(uneven.count(), whole.count());
    assert_eq!(
        uneven.shapes[0].surfaces[0].volume,
        whole.shapes[0].surfaces[0].volume
    );
    assert!(uneven.inside_out().iter().any(|of| of.0 == 0) && whole.inside_out().is_empty());
    let mut open = block_but(false, &[0]);
    open.triangles.pop();
    assert!(backs(vec![open, sheet()], &[]).is_empty());
    let mut one_sided = scene(vec![block_but(false, &[0]), sheet()]);
    one_sided.materials[0].double_sided = false;
    assert!(Solids::of(world(one_sided).scene()).backs(&[]).is_empty());
}

#[test]
fn faces_that_a_file_holds_twice_are_lit_as_the_first_are() {
    let twice = |mesh: &Mesh, copies: &[usize]| {
        let mut mesh = mesh.clone();
        let copies = copies.iter().map(|&triangle| mesh.triangles[triangle]);
        mesh.triangles.extend(copies.collect::<Vec<_>>());
        mesh
    };
    let every: Vec<usize> = (0..12).collect();
    // A sheet, and a body without one triangle: their borders run along the edges of both copies.
    assert!(backs(vec![twice(&level(0.0, 1.0), &[0, 1]), unit(false)], &[]).is_empty());
    let mut open = unit(false);
    open.triangles.pop();
    for copies in [&every[..11], &[10], &[0, 3]] {
        assert!(
            backs(vec![twice(&open, copies), sheet()], &[]).is_empty(),
            "{copies:?}"
        );
        // A copy of what is turned is turned.
        let of_turned = backs(vec![twice(&block_but(false, &[0]), copies), sheet()], &[]);
        let copy = copies
            .iter()
            .position(|&of| of == 0)
            .map(|at| 12 + at as u32);
        let turned: Vec<u32> = [0].into_iter().chain(copy).collect();
        assert_eq!(of_turned, turned, "{copies:?}");
    }
}

#[test]
fn a_body_that_looks_inward_is_no_room_where_more_stands_on_it_than_in_it() {
    let hidden = || block(Vec3::new(0.0, -0.4, 0.0), Vec3::splat(0.3), false);
    let house = |half: f32| block(Vec3::Y * (1.0 + half), Vec3::splat(half), false);
    for (others, is_turned) in [
        (vec![hidden()], false),
        (vec![hidden(), house(0.6)], true),
        (vec![hidden(), house(0.2)], false),
        // In the next room, and larger than the body.
        (
            vec![hidden(), block(Vec3::Y * 2.0, Vec3::ONE, true), house(0.6)],
            false,
        ),
        (vec![hidden(), house(1.5)], false),
    ] {
        // Closed, and without a triangle.
        for triangles in [12, 11] {
            let mut body = unit(true);
            body.triangles.truncate(triangles);
            let found = backs([vec![body], others.clone()].concat(), &[]).len();
            let right = if is_turned { triangles } else { 0 };
            assert_eq!(
                found,
                right,
                "{triangles} triangles, {} others",
                others.len()
            );
        }
    }
    // What fills it leaves no room, however that is wound.
    for (half, is_turned) in [(0.7, false), (0.9, true)] {
        for inward in [false, true] {
            let within = block(Vec3::ZERO, Vec3::splat(half), inward);
            let found = backs(vec![unit(true), within, sheet()], &[]).len();
            assert_eq!(found, if is_turned { 12 } else { 0 }, "{half} {inward}");
        }
    }
    let lit = backs(vec![unit(true), hidden(), house(0.6)], &[INSIDE]);
    assert!(lit.is_empty());
}
