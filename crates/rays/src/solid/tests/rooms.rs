//! Rooms: what they bury outside, and what is seen through their openings.

use super::*;

/// A box that looks inward, 4 wide and from y = 0 to 3, without its face toward +x where `open`.
fn room(open: bool) -> Mesh {
    let mut room = block(Vec3::Y * 1.5, Vec3::new(4.0, 1.5, 4.0), true);
    if open {
        let at = |v: &u32| room.positions[*v as usize].x > 0.0;
        let keep = |t: &[u32; 3]| !t.iter().all(at);
        room.triangles = room.triangles.iter().filter(|t| keep(t)).copied().collect();
    }
    room
}

#[test]
fn what_stands_through_a_room_is_buried_outside_of_it() {
    let rug = level(0.01, 0.2);
    for open in [false, true] {
        // Through the floor; through floor and ceiling, without a corner in the room; with something that lies wholly
        // in it or not.
        for (low, high, expected) in [(-0.3, 1.0, [1, 0, 0]), (-0.3, 3.5, [1, 0, 1])] {
            for more in [vec![], vec![rug.clone()]] {
                let post = block(
                    Vec3::Y * (low + high) * 0.5,
                    Vec3::new(0.5, (high - low) * 0.5, 0.5),
                    false,
                );
                for post in [post, tube(low, high)] {
                    let scene = [vec![room(open), post], more.clone()].concat();
                    let solids = solids(scene);
                    let found = buried_at(&solids, [-0.1, 0.5, 3.2]);
                    assert_eq!(
                        found,
                        expected,
                        "open {open}, {low}..{high}, {}",
                        more.len()
                    );
                    let room = solids.own(0, 0);
                    let at = DVec3::new(-4.0, 1.0, 1.0);
                    let own = solids.about(at, at).into_iter();
                    let own: i32 = own.map(|body| solids.depth(body, at, room)).sum();
                    assert_eq!(own, 0, "a room does not bury itself");
                }
            }
        }
    }
}

#[test]
fn of_what_ends_at_the_floor_of_a_room_only_a_bottom_is_buried() {
    let rug = || level(0.01, 0.2);
    let open = solids(vec![room(false), tube(0.0, 1.0), rug()]);
    assert_eq!(open.count(), 0);
    let crate_on_it = block(Vec3::Y * 0.5, Vec3::splat(0.5), false);
    let closed = solids(vec![room(false), crate_on_it, rug()]);
    assert_eq!(buried_at(&closed, [-1e-6, 1e-3, 0.999]), [1, 0, 0]);
}

#[test]
fn a_room_buries_nothing_of_another_nor_what_an_opening_shows() {
    let rug = level(0.01, 0.2);
    let moved = |mut mesh: Mesh, by: Vec3| {
        mesh.positions.iter_mut().for_each(|p| *p += by);
        mesh
    };
    let buried_in = |meshes: Vec<Mesh>, points: [DVec3; 3]| {
        let solids = solids(meshes);
        points.map(|point| buried(&solids, point))
    };
    // A beam from room to room, through the wall between them.
    let beam = block(Vec3::new(5.0, 1.0, 0.0), Vec3::new(3.0, 0.1, 0.1), false);
    let next = moved(room(false), Vec3::X * 9.0);
    let points = [3.0, 4.5, 6.0].map(|x| DVec3::new(x, 1.1, 0.0));
    let rugs = |mesh: &Mesh| vec![mesh.clone(), moved(mesh.clone(), Vec3::X * 9.0)];
    let rooms = [vec![room(false), beam.clone(), next], rugs(&rug)].concat();
    assert_eq!(buried_in(rooms, points), [0, 1, 0]);
    // A post in each: each room is one of the others of the other.
    let post = |x: f32| moved(tube(-0.3, 1.0), Vec3::X * x);
    let both = vec![
        room(false),
        post(0.0),
        moved(room(false), Vec3::X * 9.0),
        post(9.0),
    ];
    let solids = solids(both);
    for (mesh, x) in [(1, 0.5), (3, 9.5)] {
        let (own, mut contents) = (solids.own(mesh, 0), 0);
        for (y, expected) in [(-0.2, 1), (0.2, 0)] {
            let at = DVec3::new(x, y, 0.1);
            let near = solids.about(at, at);
            assert!(
                near.iter()
                    .any(|&body| solids.meets(body, [at, at.with_y(0.0)].into_iter()))
            );
            let depths = near.iter().map(|&body| solids.depth(body, at, own));
            assert_eq!(depths.sum::<i32>(), expected);
            near.iter()
                .for_each(|&body| solids.content(body, &mut |_| contents += 1));
        }
        assert!(contents > 0);
    }
    // A shorter one into the open, and through an open side.
    let beam = block(Vec3::new(3.75, 1.0, 0.0), Vec3::new(1.75, 0.1, 0.1), false);
    let points = [3.0, 4.5, 5.2].map(|x| DVec3::new(x, 1.1, 0.0));
    let alone = vec![room(false), beam.clone(), rug.clone()];
    assert_eq!(buried_in(alone, points), [0, 1, 1]);
    let open = vec![room(true), beam.clone(), rug.clone()];
    assert_eq!(buried_in(open, points), [0, 0, 0]);
    // A room in a dome.
    let dome = block(Vec3::ZERO, Vec3::splat(50.0), true);
    let within = vec![room(false), beam.clone(), rug.clone(), dome];
    assert_eq!(buried_in(within, points), [0, 0, 0]);
    // Something large outside, and something small that touches the part outside.
    let street = vec![room(false), beam.clone(), rug.clone(), level(-1.0, 9.0)];
    assert_eq!(buried_in(street, points), [0, 0, 0]);
    // The largest side of the room has 64 square units: what has less than 32 on each of its own is small.
    let wall = |half: Vec3| block(Vec3::new(0.0, 8.0, 0.0), half, false);
    for (outside, expected) in [
        (level(-1.0, 2.8), [0, 1, 1]),
        (level(-1.0, 2.95), [0, 0, 0]),
        (wall(Vec3::new(3.5, 2.2, 0.1)), [0, 1, 1]),
        (wall(Vec3::new(3.5, 2.5, 0.1)), [0, 0, 0]),
        (wall(Vec3::new(0.1, 2.5, 3.5)), [0, 0, 0]),
    ] {
        let around = vec![room(false), beam.clone(), rug.clone(), outside];
        assert_eq!(buried_in(around, points), expected);
    }
    // Small beside the one room, large beside a closet.
    let closet = block(Vec3::new(-9.0, 1.0, 0.0), Vec3::ONE, true);
    let cup = block(Vec3::new(-9.0, 1.0, 0.0), Vec3::splat(0.1), false);
    let around = vec![
        room(false),
        beam.clone(),
        rug.clone(),
        closet,
        cup,
        level(-3.0, 2.0),
    ];
    assert_eq!(buried_in(around, points), [0, 1, 1]);
    let lamp = block(Vec3::new(5.0, 0.8, 0.0), Vec3::splat(0.2), false);
    let hung = vec![room(false), beam, rug, lamp];
    assert_eq!(buried_in(hung, points), [0, 0, 0]);
}

#[test]
fn a_room_buries_the_same_whether_a_file_draws_its_back_or_not() {
    let meshes = vec![room(false), tube(-0.3, 1.0), level(0.01, 0.2)];
    let mut scene = scene(meshes);
    scene.format = scene::Format::Gltf;
    for double_sided in [true, false] {
        scene.materials[0].double_sided = double_sided;
        let solids = Solids::of(world(scene.clone()).scene());
        assert_eq!(buried_at(&solids, [-0.1; 3]), [1; 3]);
    }
}

#[test]
fn what_cannot_look_at_the_outside_of_a_room_does_not_show_it() {
    let rug = || level(0.01, 0.2);
    let moved = |mut mesh: Mesh, by: Vec3| {
        mesh.positions.iter_mut().for_each(|p| *p += by);
        mesh
    };
    let wall = block(Vec3::new(9.0, 0.0, 0.0), Vec3::new(0.1, 9.0, 9.0), false);
    for (name, high, outside, expected) in [
        // The room is open at x = 4.
        (
            "ground before it",
            3.5,
            moved(level(-1.0, 9.0), Vec3::X * 13.0),
            [1, 0, 1],
        ),
        ("wall before it", 3.5, wall, [1, 0, 1]),
        (
            "ground beside it",
            3.5,
            moved(level(-1.0, 9.0), Vec3::X * 12.9),
            [0, 0, 0],
        ),
        ("hill over it", 3.5, level(3.6, 9.0), [1, 0, 1]),
        (
            "hill that it reaches out of",
            3.5,
            level(3.4, 9.0),
            [0, 0, 0],
        ),
        (
            "hill that ends over it",
            3.5,
            moved(level(3.6, 9.0), Vec3::X * 9.0),
            [0, 0, 0],
        ),
        ("ground below it", 1.0, level(-4.0, 9.0), [0, 0, 0]),
    ] {
        let turned = DQuat::from_rotation_x(0.6) * DQuat::from_rotation_z(0.5);
        for place in [DAffine3::IDENTITY, DAffine3::from_quat(turned)] {
            let meshes = vec![room(true), tube(-0.3, high), rug(), outside.clone()];
            let placed = [0, 1, 2, 3].map(|mesh| (mesh, place));
            let solids = Solids::of(world(placed_scene(meshes, &placed)).scene());
            let points = [-0.1, 0.5, 3.2].map(|y| place.transform_point3(DVec3::new(0.5, y, 0.1)));
            assert_eq!(
                points.map(|point| buried(&solids, point)),
                expected,
                "{name}"
            );
        }
    }
}
