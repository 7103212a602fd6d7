//! Which side of a scene is shown, and when it is shown from within.

use super::*;
use crate::fixture::{see_through, white, world};
use glam::Vec3;

const FRAMING: Framing = Framing {
    eye: None,
    look: None,
    up: DVec3::Y,
    fov: 0.7,
    size: [160, 90],
};

/// The six sides of a box from 0 to (8, 3, 6), fronts inward; only some of them.
fn room(sides: usize) -> Vec<crate::fixture::Sheet> {
    let [x, y, z] = [Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z * 6.0];
    let sides_of = [
        [Vec3::ZERO, z, x],
        [Vec3::ZERO, y, z],
        [Vec3::ZERO, x, y],
        [x, z, y],
        [z, y, x],
        [y, x, z],
    ];
    sides_of.into_iter().take(sides).map(white).collect()
}

#[test]
fn a_closed_room_is_looked_at_from_inside_and_an_open_one_from_outside() {
    for (sides, inside) in [(6, true), (5, false), (3, false)] {
        let (world, backend) = world(&room(sides));
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        let bounds = world.bounds();
        let within = camera.eye.cmpgt(bounds.min).all() && camera.eye.cmplt(bounds.max).all();
        assert_eq!(within, inside, "{sides} sides: {camera:?}");
        assert_eq!(camera.slope > 0.6, inside, "{sides} sides: {camera:?}");
    }
}

#[test]
fn a_shell_that_lets_light_through_is_looked_at_from_outside() {
    let places: Vec<_> = room(6).iter().map(|sheet| sheet.place).collect();
    for (stops, inside) in [(1.0, true), (0.9, false)] {
        let (world, backend) = see_through(&places, stops);
        let places = places_within(&world, backend.as_ref());
        assert_ne!(places.is_empty(), inside, "{stops}");
    }
}

#[test]
fn a_body_that_is_baked_from_outside_has_no_places_within() {
    // A mattress, whose faces look inward and are drawn from both sides, and something beside it.
    let mut mesh = scene::authored::Mesh::default();
    let corner = |k: u32| [k >> 2, k >> 1 & 1, k & 1].map(|side| side as f32);
    mesh.positions = (0..8).map(corner).collect();
    let sides = [
        [2, 3, 1, 0],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [6, 7, 3, 2],
        [4, 6, 2, 0],
        [1, 3, 7, 5],
    ];
    let split = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    mesh.triangles = sides.into_iter().flat_map(split).collect();
    let mut material = scene::authored::Material::default();
    material.double_sided = true;
    let mut beside = scene::authored::Mesh::default();
    beside.positions = vec![[1.05, 0.0, 0.0], [1.05, 0.0, 0.1], [1.1, 0.0, 0.0]];
    beside.triangles = vec![[0, 1, 2]];
    let scene = scene::Scene::from_meshes(vec![mesh, beside], vec![material]).unwrap();
    let mut world = World::new(std::sync::Arc::new(scene), Default::default()).unwrap();
    let kind = rays::BackendKind::Obvhs(rays::TreeKind::Cwbvh);
    let backend = rays::build(kind, &world, 1).unwrap();
    let within = places_within(&world, backend.as_ref()).len();
    world.turn_over(std::iter::empty());
    assert!(world.has_turned_over(0) && within > 0, "{within}");
    assert_eq!(places_within(&world, backend.as_ref()), []);
}

#[test]
fn empty_cupboards_with_everything_before_them_are_looked_at_from_outside() {
    // A block of shut compartments, with and without many small things before one of its walls.
    let shut = |k: u32| {
        let cell = Vec3::new((k % 4) as f32, (k / 4 % 3) as f32, (k / 12) as f32);
        let size = Vec3::new(0.25, 1.0 / 3.0, 0.25);
        let mut sides = room(6);
        for side in &mut sides {
            side.place = side.place.map(|at| at * size);
            side.place[0] += cell * size * Vec3::new(8.0, 3.0, 6.0);
        }
        sides
    };
    let [x, y, z] = [Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z * 6.0];
    let doors = [[z * 1.01, x, y], [y * 1.01, z, x], [x * 1.01, y, z]].map(white);
    let cupboards = || (0..48).flat_map(shut);
    let things = (0..96).flat_map(|k| {
        let [x, y] = [k % 12, k / 12].map(|at| at as f32);
        block(
            Vec3::new(0.66 * x, 0.37 * y, 6.2),
            Vec3::new(0.3, 0.2, 0.3),
            1,
        )
    });
    // Without doors nothing but backs is to be seen from outside.
    let full: Vec<_> = cupboards().chain(doors).chain(things).collect();
    for (sheets, inside) in [(cupboards().collect(), true), (full, false)] {
        let (world, backend) = world(&sheets);
        let camera = FRAMING.fitted(&world, backend.as_ref(), &[], false);
        assert_eq!(camera.unwrap().slope > 0.6, inside);
        let places = places_within(&world, backend.as_ref());
        assert_eq!(!places.is_empty(), inside);
    }
}

#[test]
fn a_shut_wardrobe_is_no_room_and_the_same_boards_around_furniture_are_one() {
    let boards = [
        [[0.0, 0.0, 0.0], [0.03, 2.0, 0.6]],
        [[1.17, 0.0, 0.0], [1.2, 2.0, 0.6]],
        [[0.03, 0.0, 0.0], [1.17, 2.0, 0.02]],
        [[0.03, 0.0, 0.02], [1.17, 0.03, 0.6]],
        [[0.03, 1.97, 0.02], [1.17, 2.0, 0.6]],
        [[0.0, 0.0, 0.605], [0.598, 2.0, 0.63]],
        [[0.602, 0.0, 0.605], [1.2, 2.0, 0.63]],
    ];
    let handles_and_feet = [
        [[0.54, 0.95, 0.63], [0.56, 1.1, 0.66]],
        [[0.64, 0.95, 0.63], [0.66, 1.1, 0.66]],
        [[0.0, -0.1, 0.0], [0.05, 0.0, 0.05]],
        [[1.15, -0.1, 0.0], [1.2, 0.0, 0.05]],
        [[0.0, -0.1, 0.55], [0.05, 0.0, 0.6]],
        [[1.15, -0.1, 0.55], [1.2, 0.0, 0.6]],
    ];
    let furniture = [
        [[0.2, 0.03, 0.1], [0.5, 0.5, 0.2]],
        [[0.8, 0.03, 0.1], [1.0, 0.7, 0.3]],
        [[0.2, 0.9, 0.02], [0.6, 1.2, 0.04]],
        [[0.5, 0.03, 0.4], [0.7, 0.4, 0.5]],
    ];
    for (things, is_room) in [(&handles_and_feet[..], false), (&furniture, true)] {
        let blocks = boards.iter().chain(things);
        let blocks = blocks.map(|corners| corners.map(Vec3::from));
        let sheets: Vec<_> = blocks
            .flat_map(|[low, high]| block(low, high - low, 1))
            .collect();
        let (world, backend) = world(&sheets);
        let places = places_within(&world, backend.as_ref());
        assert_eq!(!places.is_empty(), is_room, "{} places", places.len());
        let camera = FRAMING.fitted(&world, backend.as_ref(), &[], false);
        assert_eq!(camera.unwrap().slope > 0.6, is_room);
    }
}

#[test]
fn a_pot_with_two_walls_is_looked_at_from_outside() {
    const SIDES: u32 = 32;
    // Radii and heights of the pot and of its lid, and what lies between them.
    let pot = [0.0, 0.6, 0.95, 1.0, 0.8, 0.75, 0.95, 0.9, 0.57, 0.0];
    let heights = [0.0, 0.0, 0.4, 0.8, 1.2, 1.2, 0.8, 0.42, 0.05, 0.05];
    let lid = [0.0, 0.74, 0.74, 0.5, 0.1, 0.15, 0.0];
    let above = [1.15, 1.15, 1.2, 1.3, 1.35, 1.5, 1.55];
    let turned = |radii: &[f32], heights: &[f32], gap: f32| {
        let mut mesh = scene::authored::Mesh::default();
        for (radius, height) in radii.iter().zip(heights) {
            mesh.positions.extend((0..SIDES).map(|side| {
                let (sin, cos) = (std::f32::consts::TAU * side as f32 / SIDES as f32).sin_cos();
                [radius * cos, height + gap, -radius * sin]
            }));
        }
        let rings = radii.len() as u32 - 1;
        mesh.triangles = (0..rings * SIDES)
            .flat_map(|k| {
                let [a, b] = [k, k / SIDES * SIDES + (k + 1) % SIDES];
                [[a, b, b + SIDES], [a, b + SIDES, a + SIDES]]
            })
            .collect();
        mesh
    };
    for gap in [0.0, 0.02, 0.1] {
        let bodies = vec![turned(&pot, &heights, 0.0), turned(&lid, &above, gap)];
        let scene = scene::Scene::from_meshes(bodies, vec![Default::default()]).unwrap();
        let world = World::new(std::sync::Arc::new(scene), Default::default()).unwrap();
        let kind = rays::BackendKind::Obvhs(rays::TreeKind::Cwbvh);
        let backend = rays::build(kind, &world, 1).unwrap();
        let camera = FRAMING.fitted(&world, backend.as_ref(), &[], false);
        let camera = camera.unwrap();
        let bounds = world.bounds();
        assert_ne!(
            camera.eye.clamp(bounds.min, bounds.max),
            camera.eye,
            "{gap}: {camera:?}"
        );
    }
}

#[test]
fn a_side_beside_which_more_is_seen_gives_way_to_it() {
    // Cards toward the usual view, and fewer of which it sees only the backs.
    let front = Camera::front(DVec3::Y).as_vec3();
    let ahead = Vec3::new(front.x, 0.0, front.z).normalize();
    let turn = |degrees: f32| glam::Quat::from_rotation_y(degrees.to_radians()) * ahead;
    let card = |toward: Vec3, k: u32| {
        let along = Vec3::Y.cross(toward);
        let at = 3.0 * toward + along * (k % 4) as f32 + Vec3::Y * (k / 4) as f32;
        white([at, 0.8 * along, 0.8 * Vec3::Y])
    };
    for side in [1.0, -1.0] {
        let toward_it = (0..16).map(|k| card(ahead, k));
        let others = (0..3).map(|k| card(turn(125.0 * side), k));
        let (world, backend) = world(&toward_it.chain(others).collect::<Vec<_>>());
        let camera = FRAMING.fitted(&world, backend.as_ref(), &[], false);
        let forward = camera.unwrap().forward.as_vec3();
        let from = -Vec3::new(forward.x, 0.0, forward.z).normalize();
        assert!(
            from.dot(turn(45.0 * side)) > 0.99,
            "{side}: {from} for {ahead}"
        );
    }
}

#[test]
fn land_that_looks_down_is_looked_at_from_above() {
    // Four slopes of a wide hill, which look down, and houses on it.
    let [x, z] = [Vec3::X, Vec3::Z].map(|way| way * 8.0);
    let slope = |corner: Vec3, a: Vec3, b: Vec3| {
        // Each falls from the middle to its own corner.
        let fall = -1.5 * Vec3::Y;
        white([corner, a + fall, b + fall])
    };
    let mut sheets = vec![
        slope(3.0 * Vec3::Y, x, z),
        slope(3.0 * Vec3::Y, z, -x),
        slope(3.0 * Vec3::Y, -x, -z),
        slope(3.0 * Vec3::Y, -z, x),
    ];
    sheets.extend((0..5).flat_map(|k| {
        let at = Vec3::new(0.5 * k as f32 - 1.0, 2.9, 0.9 * k as f32 - 3.0);
        block(at, Vec3::new(0.4, 0.5, 0.2), 1)
    }));
    let (world, backend) = world(&sheets);
    let camera = FRAMING.fitted(&world, backend.as_ref(), &[], false);
    let camera = camera.unwrap();
    assert!(camera.eye.y > 3.0 && camera.slope < 0.6, "{camera:?}");
}

#[test]
fn a_brighter_view_stands_where_the_sky_is_seen() {
    // A long dark hall, and beside it a short one without most of its roof.
    let [x, y, z] = [Vec3::X * 16.0, Vec3::Y * 3.0, Vec3::Z * 6.0];
    let roof = |from: f32, to: f32| [y + Vec3::X * from, Vec3::X * (to - from), z];
    let sheets = [
        [Vec3::ZERO, z, x],
        [Vec3::ZERO, y, z],
        [Vec3::ZERO, x, y],
        [x, z, y],
        [z, y, x],
        roof(0.0, 11.0),
        roof(14.0, 16.0),
        [Vec3::X * 10.0, z, y],
        [Vec3::X * 10.1, y, z],
    ];
    let (world, backend) = world(&sheets.map(white));
    let backend = backend.as_ref();
    let fitted = FRAMING.fitted(&world, backend, &[], false).unwrap();
    assert!((0.0..10.0).contains(&fitted.eye.x), "{fitted:?}");
    let brighter: Vec<_> = FRAMING.brighter(&world, backend, &[]).collect();
    assert!((10.1..16.0).contains(&brighter[0].eye.x), "{brighter:?}");
    assert_eq!(brighter.len(), 2);
}

#[test]
fn a_hall_below_a_skylight_is_looked_at_from_inside() {
    // Three eighths of its ceiling are open.
    let [x, y, z] = [Vec3::X * 2.5, Vec3::Y * 3.0, Vec3::Z * 6.0];
    let mut sheets = room(5);
    sheets.extend([Vec3::ZERO, Vec3::X * 5.5].map(|at| white([at + y, x, z])));
    let (world, backend) = world(&sheets);
    let camera = FRAMING
        .fitted(&world, backend.as_ref(), &[], false)
        .unwrap();
    let bounds = world.bounds();
    let within = camera.eye.cmpgt(bounds.min).all() && camera.eye.cmplt(bounds.max).all();
    assert!(within, "{camera:?}");
}

#[test]
fn a_wall_that_shows_its_back_is_looked_at_from_the_other_side() {
    let wall = |front: bool| {
        let [a, b] = [Vec3::X * 4.0, Vec3::Y * 4.0];
        world(&[white(if front {
            [Vec3::ZERO, a, b]
        } else {
            [Vec3::ZERO, b, a]
        })])
    };
    for (front, side) in [(true, 1.0), (false, -1.0)] {
        let (world, backend) = wall(front);
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        assert!(camera.eye.z * side > 0.0, "{front}: {camera:?}");
    }
}

#[test]
fn a_row_of_houses_is_looked_at_from_its_fronts() {
    // A plain wall toward the view that is taken otherwise, windows on the other side.
    let [x, y, z] = [Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z];
    let mut sheets: Vec<_> = [
        [Vec3::ZERO, y, x],
        [z, x, y],
        [y, z, x],
        [Vec3::ZERO, z, y],
        [x, y, z],
    ]
    .map(white)
    .into();
    sheets.extend((0..24).map(|k| {
        let at = Vec3::new((k % 8) as f32 + 0.2, (k / 8) as f32 + 0.2, -0.01);
        white([at, Vec3::Y * 0.6, Vec3::X * 0.6])
    }));
    let (world, backend) = world(&sheets);
    let camera = FRAMING
        .fitted(&world, backend.as_ref(), &[], false)
        .unwrap();
    assert!(camera.eye.z < 0.0, "{camera:?}");
}

/// The six sides of a box, fronts outward, each of so many tiles across.
fn block(low: Vec3, edge: Vec3, tiles: usize) -> Vec<crate::fixture::Sheet> {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|way| way * edge);
    let sides = [
        [low, x, z],
        [low, z, y],
        [low, y, x],
        [low + x, y, z],
        [low + y, z, x],
        [low + z, x, y],
    ];
    let tile = |[at, a, b]: [Vec3; 3], k: usize| {
        let [i, j] = [k % tiles, k / tiles].map(|k| k as f32);
        let [a, b] = [a, b].map(|way| way / tiles as f32);
        white([at + a * i + b * j, a, b])
    };
    let tiled = sides.map(|side| (0..tiles * tiles).map(move |k| tile(side, k)));
    tiled.into_iter().flatten().collect()
}

#[test]
fn a_finely_meshed_table_is_looked_at_as_a_coarse_one_is() {
    let camera = |tiles: usize| {
        let floor = [Vec3::new(-5.0, 0.0, -5.0), Vec3::Z * 10.0, Vec3::X * 10.0];
        let mut sheets = vec![white(floor)];
        let [low, edge] = [Vec3::new(-1.5, 1.0, -1.5), Vec3::new(3.0, 0.2, 3.0)];
        sheets.extend(block(low, edge, tiles));
        for [x, z] in [[-1.4, -1.4], [-1.4, 1.2], [1.2, -1.4], [1.2, 1.2]] {
            let leg = [Vec3::new(x, 0.0, z), Vec3::new(0.2, 1.0, 0.2)];
            sheets.extend(block(leg[0], leg[1], 1));
        }
        let (world, backend) = world(&sheets);
        FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap()
    };
    let coarse = camera(1);
    assert!(coarse.eye.y > 1.2, "{coarse:?}");
    assert_eq!(camera(40), coarse);
}

#[test]
fn a_cave_with_land_before_it_is_looked_at_from_inside() {
    // A room whose ceiling, walls and floor are of many faces, and of which one end is open.
    let tile = |k: u32, [at, a, b]: [Vec3; 3]| {
        let [i, j] = [k % 10, k / 10].map(|k| k as f32);
        white([at + a * i + b * j, a, b])
    };
    let [x, y, z] = [Vec3::X * 0.8, Vec3::Y * 0.3, Vec3::Z * 0.6];
    let [right, top, end] = [x, y, z].map(|edge| edge * 10.0);
    let sides = [
        [Vec3::ZERO, z, x],
        [Vec3::ZERO, y, z],
        [top, x, z],
        [end, y, x],
        [right, z, y],
    ];
    let mut sheets: Vec<_> = (0..500)
        .map(|k| tile(k % 100, sides[k as usize / 100]))
        .collect();
    sheets.push(white([-0.5 * end, 0.5 * end, right]));
    let (world, backend) = world(&sheets);
    let camera = FRAMING
        .fitted(&world, backend.as_ref(), &[], false)
        .unwrap();
    // From within or from its mouth.
    let [low, high] = [DVec3::new(0.0, 0.0, -0.5), DVec3::new(8.0, 3.0, 6.0)];
    assert_eq!(camera.eye.clamp(low, high), camera.eye, "{camera:?}");
    assert!(camera.forward.z > 0.5, "{camera:?}");
}

#[test]
fn a_plane_far_wider_than_the_scene_is_not_what_is_looked_at() {
    let card = |k: i32| {
        let place = Vec3::new((k % 10) as f32, (k / 10) as f32, 0.0);
        white([place, Vec3::X, Vec3::Y])
    };
    let mut sheets: Vec<_> = (0..100).map(card).collect();
    sheets.push(crate::fixture::ground());
    let (world, backend) = world(&sheets);
    let camera = FRAMING
        .fitted(&world, backend.as_ref(), &[], false)
        .unwrap();
    assert!(camera.eye.length() < 100.0, "{camera:?}");
}

#[test]
fn what_stands_around_a_scene_is_not_what_is_looked_at() {
    // A room without a ceiling and two of its walls, in a far and in a near box.
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    let around = |far: f32| {
        let [low, edge] = [Vec3::new(4.0, 1.5, 3.0) - far, Vec3::splat(2.0 * far)];
        let [x, y, z] = [x, y, z].map(|way| way * edge);
        let sides = [
            [low, z, x],
            [low, y, z],
            [low, x, y],
            [low + x, z, y],
            [low + y, x, z],
            [low + z, y, x],
        ];
        sides.map(white)
    };
    let alone = world(&room(3));
    let camera = FRAMING.fitted(&alone.0, alone.1.as_ref(), &[], false);
    let camera = camera.unwrap();
    for (far, is_same) in [(100.0, true), (8.0, false)] {
        let mut sheets = room(3);
        sheets.extend(around(far));
        let (world, backend) = world(&sheets);
        let dome: Vec<u32> = (3..9).collect();
        let within = FRAMING.fitted(&world, backend.as_ref(), &dome, false);
        let within = within.unwrap();
        assert_eq!(within == camera, is_same, "{within:?} for {camera:?}");
        assert!(
            within.forward.distance(camera.forward) < 1e-9,
            "{within:?} for {camera:?}"
        );
        let off = (within.eye - DVec3::new(4.0, 1.5, 3.0)).abs();
        assert!(off.max_element() < f64::from(far), "{within:?}");
    }
}

#[test]
fn what_is_given_stands() {
    let (world, backend) = world(&room(6));
    let framing = Framing {
        look: Some(DVec3::ONE),
        ..FRAMING
    };
    let camera = framing
        .fitted(&world, backend.as_ref(), &[], false)
        .unwrap();
    assert_eq!(camera, framing.camera(&world).unwrap());
}
