//! Bodies that look inward though their surfaces are not simply closed, and what is seen from within.

use super::*;

/// How many triangles of a scene's meshes are lit from behind.
fn turned(meshes: Vec<Mesh>) -> usize {
    let backs = solids(meshes).backs(&[]);
    backs.iter().map(|(_, of)| of.len()).sum()
}

/// One mesh of several.
fn merged(meshes: &[Mesh]) -> Mesh {
    let mut all = mesh(Vec::new(), Vec::new());
    for of in meshes {
        let start = all.positions.len() as u32;
        all.positions.extend(&of.positions);
        let moved = of.triangles.iter().map(|t| t.map(|vertex| vertex + start));
        all.triangles.extend(moved);
    }
    all
}

/// Without the triangles of which all corners have this place along an axis.
fn without(mut of: Mesh, axis: usize, place: f32) -> Mesh {
    let positions = of.positions.clone();
    let lies = |t: &[u32; 3]| t.iter().all(|&v| positions[v as usize][axis] == place);
    of.triangles.retain(|t| !lies(t));
    of
}

/// A wall of a room in a plane z, around an opening from the floor to a height, all of it looking along z or back.
fn wall_with_a_door(half: Vec3, door: [f32; 2], inward: bool) -> Mesh {
    let (w, h, z) = (half.x, half.y, half.z);
    let ([d, top], low) = (door, -h);
    let points = [[-w, low], [-d, low], [d, low], [w, low], [w, h], [-w, h]];
    let points = points.into_iter().chain([[-d, low + top], [d, low + top]]);
    let positions = points.map(|[x, y]| Vec3::new(x, y, z)).collect();
    let out = [
        [0, 1, 6],
        [0, 6, 5],
        [6, 7, 4],
        [6, 4, 5],
        [2, 3, 4],
        [2, 4, 7],
    ];
    let turn = |[a, b, c]: [u32; 3]| if inward { [a, c, b] } else { [a, b, c] };
    mesh(positions, out.map(turn).to_vec())
}

/// A room of which one wall has a door; its floor and ceiling meet the corners of the door.
fn room_with_a_door() -> Mesh {
    let half = Vec3::new(2.0, 1.25, 2.0);
    let shell = without(block(Vec3::ZERO, half, true), 2, 2.0);
    merged(&[shell, wall_with_a_door(half, [0.5, 2.0], true)])
}

#[test]
fn a_body_that_looks_inward_and_lacks_a_triangle_is_lit_from_behind() {
    for missing in 0..12 {
        let lacking = |inward: bool| {
            let mut of = unit(inward);
            of.triangles.remove(missing);
            turned(vec![of, sheet()])
        };
        assert_eq!([lacking(true), lacking(false)], [11, 0], "{missing}");
    }
}

#[test]
fn bodies_that_touch_along_a_face_are_told_apart_by_what_is_on_either_side() {
    let beside = block(Vec3::X * 2.0, Vec3::ONE, false);
    let joint = merged(&[unit(true), beside.clone()]);
    let solids = solids(vec![joint, sheet()]);
    let surfaces = &solids.shapes[0].surfaces;
    assert!(
        surfaces.iter().any(|of| of.faces.len() == 24),
        "one surface"
    );
    let backs = solids.backs(&[]);
    // The face that is in both has the inside of one in front of it and that of the other behind: either will do.
    let (first, second): (Vec<u32>, Vec<u32>) = backs[0].1.iter().partition(|&&t| t < 12);
    assert_eq!((first.len(), second.len()), (12, 2), "{backs:?}");
    // A larger one that looks outward outweighs it.
    let large = block(Vec3::new(3.0, 0.0, 0.0), Vec3::new(2.0, 1.0, 1.0), false);
    let backs = turned(vec![merged(&[unit(true), large]), sheet()]);
    assert_eq!(backs, 14);
    assert_eq!(turned(vec![merged(&[unit(false), beside]), sheet()]), 0);
}

#[test]
fn rocks_that_reach_through_each_other_are_no_cavities() {
    // The box of the outer one, which is a pyramid, holds that of the inner one, of which a third lies in the pyramid.
    let (w, h) = (4.0, 4.0);
    let positions = [
        [-w, 0.0, -w],
        [w, 0.0, -w],
        [w, 0.0, w],
        [-w, 0.0, w],
        [0.0, h, 0.0],
    ];
    let faces = [
        [0, 1, 2],
        [0, 2, 3],
        [0, 4, 1],
        [1, 4, 2],
        [2, 4, 3],
        [3, 4, 0],
    ];
    let pyramid = mesh(positions.map(Vec3::from_array).to_vec(), faces.to_vec());
    let rock = block(Vec3::new(2.2, 1.2, 0.0), Vec3::splat(1.0), true);
    assert_eq!(turned(vec![pyramid.clone(), rock, sheet()]), 12);
    let cavity = block(Vec3::new(0.0, 1.0, 0.0), Vec3::splat(0.5), true);
    assert_eq!(turned(vec![pyramid, cavity, sheet()]), 0);
}

#[test]
fn a_slab_with_a_sliver_of_a_hole_is_lit_from_behind() {
    // An edge of the top runs past a corner of the side: exactly, and beside it.
    for gap in [0.0, 0.01] {
        let mut slab = block(Vec3::ZERO, Vec3::new(3.0, 0.1, 2.0), true);
        let side = slab.triangles.iter().position(|t| {
            let on = |&v: &u32| slab.positions[v as usize].z == 2.0;
            t.iter().all(on)
        });
        let [a, b, c] = slab.triangles.remove(side.expect("it has a side"));
        let [p, q] = [a, b].map(|v| slab.positions[v as usize]);
        let middle = slab.positions.len() as u32;
        slab.positions.push((p + q) * 0.5 + Vec3::Z * gap);
        slab.triangles.extend([[a, middle, c], [middle, b, c]]);
        assert_eq!(turned(vec![slab, sheet()]), 13, "gap {gap}");
    }
}

#[test]
fn a_long_and_narrow_tube_is_a_post_unless_a_hill_is_about_it() {
    let long = Vec3::new(20.0, 1.0, 1.0);
    for mouths in [&[20.0][..], &[-20.0, 20.0]] {
        let closed = block(Vec3::ZERO, long, true);
        let tube = mouths.iter().fold(closed, |of, &x| without(of, 0, x));
        let faces = tube.triangles.len();
        assert_eq!(turned(vec![tube.clone(), sheet()]), faces);
        let hill = without(block(Vec3::ZERO, long + 2.0, false), 1, -3.0);
        assert_eq!(turned(vec![tube.clone(), hill, sheet()]), 0, "a tunnel");
        let lamp = block(Vec3::ZERO, Vec3::splat(0.2), false);
        assert_eq!(turned(vec![tube, lamp, sheet()]), 0, "a corridor");
    }
}

#[test]
fn a_body_whose_shaft_reaches_out_below_it_is_lit_from_outside() {
    // A slab with a shaft that is sunk into it and out of it: less than 0 by volume, and yet it looks outward.
    let frame = |half: f32, y: f32| {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        corners.map(|[x, z]| Vec3::new(x, y, z))
    };
    let places = [(2.0, 0.0), (2.0, 0.5), (1.5, 0.5), (1.5, 0.0), (1.5, -3.0)];
    let rings = places.map(|(half, y)| frame(half, y));
    let mut faces = vec![[0, 1, 2], [0, 2, 3], [16, 18, 17], [16, 19, 18]];
    for ring in 0..4u32 {
        for k in 0..4 {
            let next = (k + 1) % 4;
            let [a, b] = [k, next].map(|k| 4 * ring + k);
            faces.extend([[a, a + 4, b], [b, a + 4, b + 4]]);
        }
    }
    let chest = block(Vec3::Y * -4.0, Vec3::new(3.0, 3.0, 3.0), false);
    let solids = solids(vec![mesh(rings.concat(), faces.clone()), chest, sheet()]);
    // From below, one sees the back of the shaft. The bottom of the slab runs on above it.
    let sunk = |of: &[u32; 3]| of.iter().all(|&corner| corner >= 12);
    let sunk: Vec<u32> = (0..)
        .zip(&faces)
        .filter(|(_, of)| sunk(of))
        .map(|(k, _)| k)
        .collect();
    assert_eq!(solids.backs(&[]), [(0, sunk)]);
}

#[test]
fn what_lies_behind_a_shallow_hood_stops_no_hole_of_it() {
    // A ceiling with a low rim, right below a slab.
    let half = Vec3::new(1.0, 0.05, 1.0);
    let ceiling = without(block(Vec3::ZERO, half, true), 1, -half.y);
    let slab = |y: f32| block(Vec3::Y * y, Vec3::new(1.2, 0.04, 1.2), false);
    assert_eq!(turned(vec![ceiling.clone(), slab(0.1), sheet()]), 0);
    // Below it the slab stops its mouth.
    assert_eq!(turned(vec![ceiling, slab(-0.1), sheet()]), 10);
}

#[test]
fn tunnels_bowls_rooms_and_folded_sheets_are_lit_where_they_look() {
    let tube = |half: Vec3| {
        without(
            without(block(Vec3::ZERO, half, true), 0, -half.x),
            0,
            half.x,
        )
    };
    for length in [1.0, 10.0] {
        let half = Vec3::new(length, 1.0, 1.0);
        assert_eq!(turned(vec![tube(half), sheet()]), 0, "tunnel of {length}");
        let blind = without(block(Vec3::ZERO, half, true), 0, half.x);
        assert_eq!(turned(vec![blind, sheet()]), 0, "blind tunnel of {length}");
    }
    // A deep bowl, a tent with an open end, a box of which one side is missing.
    for depth in [0.2, 1.0, 10.0] {
        let bowl = without(
            block(Vec3::ZERO, Vec3::new(1.0, depth, 1.0), true),
            1,
            depth,
        );
        assert_eq!(turned(vec![bowl, sheet()]), 0, "bowl of {depth}");
    }
    let ends = [-4.0, 4.0].map(|x| [[x, 0.0, -1.0], [x, 0.0, 1.0], [x, 2.0, 0.0]]);
    let tent = mesh(
        ends.concat().into_iter().map(Vec3::from_array).collect(),
        vec![
            [0, 3, 1],
            [1, 3, 4],
            [1, 4, 2],
            [2, 4, 5],
            [2, 5, 0],
            [0, 5, 3],
        ],
    );
    for turn in [false, true] {
        let mut tent = tent.clone();
        if turn {
            tent.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        assert_eq!(turned(vec![tent, sheet()]), 0);
    }
    let door = room_with_a_door();
    assert_eq!(
        turned(vec![door.clone(), sheet()]),
        0,
        "an empty room with a door"
    );
    let chair = block(Vec3::new(0.5, -0.9, 0.5), Vec3::splat(0.2), false);
    assert_eq!(turned(vec![door, chair.clone(), sheet()]), 0);
    // Furniture makes a room of what lacks a triangle, also where its legs are let into the floor.
    for sunk in [0.0, 0.4] {
        let mut room = unit(true);
        room.triangles.pop();
        let mut chair = chair.clone();
        chair.positions.iter_mut().for_each(|p| p.y -= sunk * 0.4);
        assert_eq!(turned(vec![room, chair, sheet()]), 0, "sunk by {sunk}");
    }
    let mut folded = level(0.0, 2.0);
    folded.positions.push(Vec3::new(0.0, 1.0, 0.0));
    folded.triangles.extend([[0, 1, 4], [1, 2, 4]]);
    assert_eq!(turned(vec![folded, sheet()]), 0, "a folded sheet");
}

#[test]
fn a_light_or_a_lamp_keeps_what_lacks_a_triangle_lit_from_within() {
    let lacking = || {
        let mut of = unit(true);
        of.triangles.pop();
        scene(vec![of, sheet()])
    };
    let backs = |scene: Scene, places: &[DVec3]| Solids::of(world(scene).scene()).backs(places);
    assert!(backs(lacking(), &[INSIDE]).is_empty());
    assert!(!backs(lacking(), &[DVec3::X * 2.0]).is_empty());
    let mut shining = lacking();
    shining.materials[0].emission = Vec3::ONE;
    assert!(backs(shining, &[]).is_empty());
    let mut single = lacking();
    single.materials[0].double_sided = false;
    assert!(backs(single, &[]).is_empty());
}

#[test]
fn a_hood_that_looks_inward_is_lit_from_behind_where_something_stops_its_mouth() {
    // A box without its bottom, as snow on a beam: its mouth is at y = -1.
    let hood = || without(block(Vec3::ZERO, Vec3::ONE, true), 1, -1.0);
    let beam = |y: f32, half: f32| block(Vec3::Y * y, Vec3::splat(half), false);
    let far = || block(Vec3::X * 30.0, Vec3::ONE, false);
    for (beside, expected) in [
        // It stands on a beam as wide, with a slit between, or a beam sticks in it.
        (beam(-2.0, 1.0), 10),
        (beam(-2.1, 1.0), 10),
        (beam(-1.4, 0.97), 10),
        // One looks into it beside or below them.
        (beam(-1.5, 0.5), 0),
        (beam(-3.0, 1.0), 0),
        (far(), 0),
    ] {
        assert_eq!(
            turned(vec![hood(), beside.clone(), far()]),
            expected,
            "{:?}",
            beside.positions[0]
        );
    }
    // Something stands in it.
    let chair = block(Vec3::new(0.3, 0.3, 0.2), Vec3::splat(0.3), false);
    let ground = beam(-4.0, 3.0);
    assert_eq!(turned(vec![hood(), ground.clone(), far()]), 10);
    assert_eq!(turned(vec![hood(), ground, chair, far()]), 0);
}

/// A tube along z of these half edges, open at both ends or closed at the far one.
fn corridor(half: [f32; 2], middle: f32, [from, to]: [f32; 2], is_closed: bool) -> Mesh {
    let [w, h] = half;
    let center = Vec3::new(0.0, middle, 0.5 * (from + to));
    let mut tube = block(center, Vec3::new(w, h, 1.0), true);
    // The very ends.
    for position in &mut tube.positions {
        position.z = if position.z < center.z { from } else { to };
    }
    let tube = without(tube, 2, from);
    if is_closed {
        tube
    } else {
        without(tube, 2, to)
    }
}

#[test]
fn an_empty_corridor_that_ends_at_a_door_is_lit_from_within() {
    // The door is from -0.5 to 0.5 and from -1.25 to 0.75, in the wall at z = 2.
    let room = room_with_a_door();
    let mut far_room = room.clone();
    (far_room.positions.iter_mut()).for_each(|p| (p.x, p.z) = (-p.x, 30.0 - p.z));
    // Edge to edge, before the wall, into the room, within the door, about it.
    for (half, from) in [
        ([0.5, 1.0], 2.0),
        ([0.5, 1.0], 2.01),
        ([0.5, 1.0], 2.1),
        ([0.5, 1.0], 1.9),
        ([0.48, 0.98], 2.0),
        ([0.52, 1.02], 2.001),
    ] {
        for is_closed in [false, true] {
            let corridor = corridor(half, -0.25, [from, 26.0], is_closed);
            let found = turned(vec![corridor, room.clone(), sheet()]);
            assert_eq!(found, 0, "{half:?} from {from}, closed {is_closed}");
        }
        let between = corridor(half, -0.25, [from, 30.0 - from], false);
        let found = turned(vec![between, room.clone(), far_room.clone(), sheet()]);
        assert_eq!(found, 0, "{half:?} from {from}, between two rooms");
    }
}

#[test]
fn an_empty_tunnel_whose_mouth_is_a_hole_in_a_wall_is_lit_from_within() {
    // A sheet about a round hole of the radius 1, of either winding.
    let ring = |radius: f32, z: f32| {
        (0..24).map(move |k| {
            let (sin, cos) = (k as f32 * std::f32::consts::TAU / 24.0).sin_cos();
            Vec3::new(radius * cos, radius * sin, z)
        })
    };
    let joined = |inner: [f32; 2], outer: [f32; 2], turn: bool| {
        let points = ring(inner[0], inner[1]).chain(ring(outer[0], outer[1]));
        let faces = (0..24u32).flat_map(|k| {
            let next = (k + 1) % 24;
            let faces = [[k, k + 24, next], [next, k + 24, next + 24]];
            faces.map(|[a, b, c]| if turn { [a, c, b] } else { [a, b, c] })
        });
        mesh(points.collect(), faces.collect())
    };
    let tube = |radius: f32, from: f32| joined([radius, from], [radius, 60.0], false);
    let faces = tube(1.0, 0.0).triangles.len();
    let inward = |of: &Mesh| {
        let [a, b, c] = of.triangles[0].map(|corner| of.positions[corner as usize]);
        (b - a).cross(c - a).dot(a.with_z(0.0)) < 0.0
    };
    assert!(inward(&tube(1.0, 0.0)));
    for turn in [false, true] {
        let wall = |hole: f32, size: f32| joined([hole, 0.0], [size, 0.0], turn);
        for (radius, from) in [(1.0, 0.01), (0.95, 0.0), (1.0, -0.1), (1.05, 0.1)] {
            let found = turned(vec![tube(radius, from), wall(1.0, 6.0), sheet()]);
            assert_eq!(found, 0, "{radius} from {from}, {turn}");
        }
        // A wall without a hole, about its middle, and none.
        let mut middle = wall(1.0, 6.0);
        middle.positions.iter_mut().for_each(|p| p.z = 30.0);
        for (name, wall) in [("stopped", wall(0.01, 6.0)), ("through", middle)] {
            let found = turned(vec![tube(1.0, 0.01), wall, sheet()]);
            assert_eq!(found, faces, "{name}, {turn}");
        }
    }
    assert_eq!(turned(vec![tube(1.0, 0.01), sheet()]), faces);
}

#[test]
fn posts_that_stand_on_at_and_under_something_are_lit_from_outside() {
    let slab = |low: [f32; 3], high: [f32; 3]| {
        let [low, high] = [low, high].map(Vec3::from_array);
        block(0.5 * (low + high), 0.5 * (high - low), false)
    };
    // Along z, from 0 to 30, a unit wide.
    let post = || corridor([0.5; 2], 0.0, [0.0, 30.0], false);
    let (floor, ceiling) = (
        slab([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]),
        slab([-9.0, -9.0, 30.0], [9.0, 9.0, 31.0]),
    );
    let mut ground = level(0.0, 8.0);
    ground
        .positions
        .iter_mut()
        .for_each(|p| *p = Vec3::new(p.z, p.x, 1.0));
    let cases = [
        ("between floor and ceiling", vec![floor.clone(), ceiling]),
        (
            "on a plinth",
            vec![slab([-0.7, -0.7, -1.0], [0.7, 0.7, 0.0]), floor.clone()],
        ),
        ("in the ground", vec![ground]),
        (
            "under a narrow beam",
            vec![floor.clone(), slab([-0.2, -9.0, 30.0], [0.2, 9.0, 31.0])],
        ),
        (
            "under a wide beam",
            vec![floor.clone(), slab([-0.4, -9.0, 30.0], [0.4, 9.0, 31.0])],
        ),
        (
            "under an edge",
            vec![floor.clone(), slab([0.1, -9.0, 30.0], [9.0, 9.0, 31.0])],
        ),
        (
            "beside a slab",
            vec![floor.clone(), slab([0.5, -9.0, 29.0], [9.0, 9.0, 30.0])],
        ),
        (
            "in a corner of two slabs",
            vec![
                slab([0.5, -9.0, 29.0], [9.0, 9.0, 30.0]),
                slab([-9.0, 0.5, 29.0], [0.5, 9.0, 30.0]),
            ],
        ),
        (
            "on another post",
            vec![corridor([0.4; 2], 0.0, [30.0, 60.0], true)],
        ),
    ];
    for (name, others) in cases {
        let mine = post();
        let faces = mine.triangles.len() as u32;
        let backs = solids([vec![mine], others, vec![sheet()]].concat()).backs(&[]);
        let own = backs.iter().find(|(mesh, _)| *mesh == 0);
        assert_eq!(own.map_or(0, |(_, of)| of.len() as u32), faces, "{name}");
    }
}
