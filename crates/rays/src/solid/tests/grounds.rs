//! Grounds, what is rooted in them, and what has no bottom.

use super::*;
use glam::Quat;

#[test]
fn what_stands_in_an_open_ground_is_buried_below_it() {
    let (below, above) = (DVec3::new(0.5, -0.2, 0.1), DVec3::new(0.5, 0.2, 0.1));
    let closed = block(Vec3::Y * 0.5, Vec3::new(0.5, 1.0, 0.5), false);
    for body in [closed, tube(-0.5, 1.5)] {
        for turned in [DQuat::IDENTITY, DQuat::from_rotation_x(2.0)] {
            let place = DAffine3::from_quat(turned);
            let scene = placed_scene(
                vec![level(0.0, 9.0), body.clone()],
                &[(0, place), (1, place)],
            );
            let solids = Solids::of(world(scene).scene());
            let at = |point| place.transform_point3(point);
            assert_eq!(buried(&solids, at(below)), 1);
            assert_eq!(buried(&solids, at(above)), 0);
            let ground = solids.own(0, 0);
            let itself = solids.depth(ground.expect("a body"), at(below), ground);
            assert_eq!(itself, 0, "a ground buries what is rooted in it alone");
        }
    }
}

#[test]
fn an_awning_buries_no_pole_and_a_floor_no_column_of_the_storey_below() {
    let below = DVec3::new(0.5, -0.2, 0.1);
    // More of it below than above; and as much below as above, but on another floor.
    let hung = solids(vec![level(0.0, 9.0), tube(-2.0, 1.0)]);
    assert_eq!(buried(&hung, below), 0);
    let storeys = solids(vec![level(0.0, 9.0), tube(-1.0, 5.0), level(-1.0, 9.0)]);
    assert_eq!(buried(&storeys, below), 0);
    // A bracket that looks out of the top of an awning over a floor, and the same over nothing but a footing.
    let bracket = |under: f32| solids(vec![level(0.0, 2.0), tube(-0.3, 0.5), level(-3.0, under)]);
    assert_eq!(buried(&bracket(9.0), below), 0);
    assert_eq!(buried(&bracket(0.5), below), 1);
    // A plate close below the post's end is not yet at it.
    let plate = solids(vec![level(0.0, 9.0), tube(-0.3, 1.5), level(-0.6, 0.4)]);
    assert_eq!(buried(&plate, below), 1);
    let sole = solids(vec![level(0.0, 9.0), tube(-0.3, 1.5), level(-0.3, 0.4)]);
    assert_eq!(buried(&sole, below), 0);
    // The same wherever it stands.
    let afar = [level(0.0, 9.0), tube(-1.0, 5.0), level(-1.0, 9.0)].map(|mut mesh| {
        let far = Vec3::new(60.0, 40.0, -20.0);
        mesh.positions.iter_mut().for_each(|p| *p += far);
        mesh
    });
    let afar = solids(afar.to_vec());
    assert_eq!(buried(&afar, below + DVec3::new(60.0, 40.0, -20.0)), 0);
    // What crosses the sheet too does not lay it open.
    let fence = solids(vec![level(0.0, 9.0), tube(-1.0, 5.0), tube(-2.0, 3.0)]);
    assert_eq!(buried(&fence, below), 1);
}

#[test]
fn of_what_only_stands_on_a_ground_only_a_bottom_is_buried() {
    let open = solids(vec![level(0.0, 9.0), tube(0.0, 1.0)]);
    assert_eq!(open.count(), 0);
    // A body has a side there that nobody sees, and would have next to none if it stood a little higher.
    let crate_on_it = |y: f32| block(Vec3::Y * (0.5 + y), Vec3::splat(0.5), false);
    for (y, expected) in [(-0.01, 1), (0.0, 1), (0.01, 0)] {
        let solids = solids(vec![level(0.0, 9.0), crate_on_it(y)]);
        let bottom = DVec3::new(0.3, f64::from(y) - 1e-6, 0.1);
        assert_eq!(buried(&solids, bottom), expected, "at {y}");
        assert_eq!(buried(&solids, bottom + 0.1 * DVec3::Y), 0, "at {y}");
    }
}

/// A square of two triangles about the y axis, 8 wide, that rises along x.
fn slope(rise: f32, y: f32) -> Mesh {
    let mut slope = level(y, 4.0);
    slope.positions.iter_mut().for_each(|p| p.y += rise * p.x);
    slope
}

#[test]
fn a_house_is_not_rooted_in_its_ceiling() {
    let mut house = block(Vec3::Y, Vec3::ONE, false);
    let bottom = |t: &[u32; 3]| t.iter().all(|&v| house.positions[v as usize].y == 0.0);
    house.triangles = (house.triangles.iter())
        .filter(|t| !bottom(t))
        .copied()
        .collect();
    let ceiling = |half: f32| {
        let mut ceiling = level(1.8, half);
        ceiling.triangles.iter_mut().for_each(|t| t.reverse());
        ceiling
    };
    let roof = DVec3::new(0.5, 1.99, 0.1);
    assert_eq!(buried(&solids(vec![ceiling(0.9), house.clone()]), roof), 0);
    // What pokes through the ceiling of a larger hall is hidden above it.
    assert_eq!(buried(&solids(vec![ceiling(9.0), house]), roof), 1);
}

#[test]
fn of_land_and_sea_each_is_buried_behind_the_other_however_high_the_sea() {
    for sea in [-1.0, 0.0, 0.03, 1.0] {
        let land = solids(vec![level(sea, 5.0), slope(0.4, 0.0)]);
        let water = solids(vec![slope(0.4, 0.0), level(sea, 3.9)]);
        for x in [-3.5, -1.0, 0.5, 3.5] {
            let ground = 0.4 * x;
            let is_under = i32::from(ground < f64::from(sea));
            assert_eq!(
                buried(&land, DVec3::new(x, ground, 0.7)),
                is_under,
                "{sea} {x}"
            );
            let surface = DVec3::new(x, f64::from(sea), 0.7);
            assert_eq!(buried(&water, surface), 1 - is_under, "{sea} {x}");
        }
    }
}

#[test]
fn a_sea_beyond_the_end_of_the_land_is_cut_along_the_shore_and_kept_under_it() {
    // The land ends 1.6 above the sea, and one looks under it there; a smaller sea is buried.
    for (half, expected) in [(9.0, [false, true]), (3.9, [true, false])] {
        let solids = solids(vec![slope(0.4, 0.0), level(0.03, half)]);
        let (land, sea) = (solids.own(0, 0), solids.own(1, 0));
        let land_body = land.expect("the land is a ground");
        let is_held = [solids.rooted(land_body), solids.cut(land_body)]
            .map(|held| held.contains(&sea.expect("the sea is a body")));
        assert_eq!(is_held, expected, "{half}");
        // The land itself ends in the sea.
        let sea_body = sea.expect("the sea is a body");
        assert!(half < 4.0 || solids.rooted(sea_body).contains(&land_body));
        let ends = [DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0)];
        let mut near = solids.near(land_body, ends.into_iter());
        for (x, is_behind) in [(-0.5, false), (0.5, true)] {
            let point = DVec3::new(x, 0.03, 0.2);
            let found = [near.depth(point, sea) > 0, near.cuts(point, sea)];
            assert_eq!(found, expected.map(|is| is && is_behind), "{half} {x}");
        }
    }
    // Of a bridge over a valley that it does not meet nothing is cut.
    let valley = solids(vec![level(1.0, 2.0), level(0.0, 9.0)]);
    assert!((0..valley.bodies()).all(|body| valley.cut(body).is_empty()));
}

#[test]
fn a_sea_of_which_no_corner_is_near_an_island_is_buried_in_it() {
    let at = Vec3::new(15.0, 0.0, 9.0);
    let corners = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)];
    let shore = corners.map(|(x, z)| at + Vec3::new(x, -1.0, z));
    let mut positions = shore.to_vec();
    positions.push(at + Vec3::Y);
    let sides = (0..4).map(|k| [(k + 1) % 4, k, 4]).collect();
    let island = mesh(positions, sides);
    let water = solids(vec![island.clone(), level(0.0, 40.0)]);
    let land = solids(vec![level(0.0, 40.0), island]);
    for (aside, is_water) in [(0.5, false), (1.5, false), (2.5, true), (3.5, true)] {
        let out = at.as_dvec3() + DVec3::new(aside, 0.0, 0.2);
        assert_eq!(buried(&water, out), i32::from(!is_water), "{aside}");
        let ground = out + DVec3::Y * (1.0 - 0.5 * aside);
        assert_eq!(buried(&land, ground), i32::from(is_water), "{aside}");
    }
}

#[test]
fn what_is_drowned_lays_neither_shore_nor_rock_open() {
    let stone = |top: f32| {
        let middle = Vec3::new(-2.5, top - 0.2, 0.5);
        block(middle, Vec3::new(0.1, 0.2, 0.1), false)
    };
    let fish = block(Vec3::new(-3.0, -0.3, 0.6), Vec3::splat(0.1), false);
    let weed = [(-3.0, -0.8), (-2.8, -0.8), (-2.8, -0.4), (-3.0, -0.4)];
    let weed = weed.map(|(x, y)| Vec3::new(x, y, 0.1)).to_vec();
    let weed = mesh(weed, vec![[0, 1, 2], [0, 2, 3]]);
    let deep = [(-9.0, -2.0), (-4.0, -2.0), (-4.0, 2.0), (-9.0, 2.0)];
    let deep = deep.map(|(x, z)| Vec3::new(x, -1.6, z)).to_vec();
    let deep = mesh(deep, vec![[0, 2, 1], [0, 3, 2]]);
    for (name, drowned) in [
        ("stone, 1 cm under water", stone(-0.01)),
        ("stone, 1 cm above water", stone(0.01)),
        ("stone, deep", stone(-0.5)),
        ("fish", fish),
        ("weed", weed),
        ("bed beside the shore", deep),
    ] {
        let land = slope(0.4, 0.0);
        // A rock of the bed that reaches out of the water.
        let rock = block(Vec3::new(-3.0, -0.1, 0.2), Vec3::new(0.5, 1.2, 0.5), false);
        for (own, points) in [
            (
                land.clone(),
                [-3.5, -0.1, 0.1, 3.5].map(|x| DVec3::new(x, 0.4 * x, 0.9)),
            ),
            (
                rock,
                [-0.9, -0.01, 0.01, 0.9].map(|y| DVec3::new(-2.5, y, 0.2)),
            ),
        ] {
            let meshes = vec![level(0.0, 9.0), own, drowned.clone(), land.clone()];
            let solids = solids(meshes);
            let found = points.map(|point| {
                let own = solids.own(1, 0);
                let near = solids.about(point, point);
                near.iter().any(|&body| solids.depth(body, point, own) > 0)
            });
            assert_eq!(found, [true, true, false, false], "{name}");
        }
    }
}

#[test]
fn one_looks_under_a_bridge_and_between_cards_on_a_floor() {
    let mut valley = mesh(
        vec![
            Vec3::new(-4.0, 1.0, -4.0),
            Vec3::new(-4.0, 1.0, 4.0),
            Vec3::new(0.0, -1.0, 4.0),
            Vec3::new(0.0, -1.0, -4.0),
            Vec3::new(4.0, 1.0, 4.0),
            Vec3::new(4.0, 1.0, -4.0),
        ],
        vec![[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]],
    );
    let under = DVec3::new(0.1, -0.9, 0.1);
    let mut bridge = level(0.0, 3.0);
    assert_eq!(
        buried(&solids(vec![bridge.clone(), valley.clone()]), under),
        0
    );
    // As long as the valley it is a lake.
    for mesh in [&mut bridge, &mut valley] {
        mesh.positions
            .iter_mut()
            .for_each(|p| p.z = 4.0 * p.z.signum());
    }
    assert_eq!(buried(&solids(vec![bridge, valley]), under), 1);
    let card = |angle: f32| {
        let along = Vec3::new(angle.cos(), 0.0, angle.sin());
        let corners = [-along, along, along + Vec3::Y, Vec3::Y - along];
        mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    };
    let cards = solids(vec![card(0.0), card(0.5), level(0.0, 4.0)]);
    for side in [-0.7, 0.7] {
        let along = DVec3::new(0.5f64.cos(), 0.0, 0.5f64.sin());
        assert_eq!(buried(&cards, side * along + 0.5 * DVec3::Y), 0, "{side}");
    }
}

/// Where a point of the second mesh is buried, of a post's corners at these heights.
/// A room of six sheets that look inward, each so much too long on all sides.
fn crossed_sheets(over: f32) -> Vec<Mesh> {
    let (size, over) = (Vec3::new(4.0, 2.5, 3.0), Vec3::splat(over));
    let (low, high) = (-over, size + over);
    let mut sheets = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for end in [0.0, size[axis]] {
            let corner = |a: f32, b: f32| {
                let mut at = Vec3::ZERO;
                (at[axis], at[u], at[v]) = (end, a, b);
                at
            };
            let positions = vec![
                corner(low[u], low[v]),
                corner(high[u], low[v]),
                corner(high[u], high[v]),
                corner(low[u], high[v]),
            ];
            let faces = match end > 0.0 {
                true => vec![[0, 2, 1], [0, 3, 2]],
                false => vec![[0, 1, 2], [0, 2, 3]],
            };
            sheets.push(mesh(positions, faces));
        }
    }
    sheets
}

#[test]
fn sheets_that_cross_at_the_edges_of_a_room_end_where_they_cross() {
    for over in [0.002, 0.01, 0.05, 0.2] {
        let world = world(scene(crossed_sheets(over)));
        let middle = DVec3::new(2.0, 1.25, 1.5);
        for (instance, triangle) in (0..6).flat_map(|i| [(i, 0), (i, 1)]) {
            let [a, b, c] = world.corners(instance, triangle);
            for k in 0..400 {
                let (u, v) = (f64::from(k % 20) / 19.0, f64::from(k / 20) / 19.0);
                let weights = [1.0 - u.max(v), u.max(v) - u.min(v), u.min(v)]
                    .map(|w| 0.999 * w + 0.001 / 3.0);
                let point = a * weights[0] + b * weights[1] + c * weights[2];
                // How far the point is out of the room, along what it does not lie in.
                let out = ((point - middle).abs() - middle).max_element();
                if out.abs() > 1e-4 * f64::from(over) {
                    let buried = world.is_buried(instance, triangle, weights);
                    assert_eq!(buried, out > 1e-5, "{over} {instance} {point}");
                }
            }
        }
    }
}

#[test]
fn a_closed_body_is_rooted_though_more_of_it_is_below_than_above() {
    let stone = |below: f32| {
        let middle = Vec3::Y * (0.5 - below);
        solids(vec![
            level(0.0, 9.0),
            block(middle, Vec3::splat(0.5), false),
        ])
    };
    let at = DVec3::new(0.5, -0.05, 0.1);
    assert_eq!(
        [0.5, 0.7, 0.9].map(|below| buried(&stone(below), at)),
        [1, 1, 0]
    );
}

/// A unit block without its lower face, from y = `bottom`.
fn bottomless(bottom: f32) -> Mesh {
    let mut open = block(Vec3::Y * (bottom + 0.5), Vec3::splat(0.5), false);
    let is_low = |t: &[u32; 3]| t.iter().all(|&k| open.positions[k as usize].y == bottom);
    let kept = open
        .triangles
        .iter()
        .copied()
        .filter(|t| !is_low(t))
        .collect();
    open.triangles = kept;
    open
}

#[test]
fn a_prop_without_a_bottom_is_a_solid_where_it_stands() {
    let at = DVec3::new(0.3, 0.002, 0.1);
    let ground = || level(0.0, 9.0);
    let slab = || block(Vec3::Y * -0.1, Vec3::new(9.0, 0.1, 9.0), false);
    let unseen = |meshes| depth(&solids(meshes), at);
    for bottom in [0.0, -0.05, 0.0005] {
        assert_eq!(unseen(vec![ground(), bottomless(bottom)]), 1, "{bottom}");
        assert_eq!(
            unseen(vec![slab(), bottomless(bottom)]),
            1,
            "{bottom}, slab"
        );
    }
    // On two tiles; with a ground that ends under it; floating; behind a sheet and not before it; with an inhabitant;
    // turned over.
    let tile = |from: f32| {
        let mut tile = level(0.0, 4.5);
        tile.positions.iter_mut().for_each(|p| p.x += from);
        tile
    };
    assert_eq!(unseen(vec![tile(-4.5), tile(4.5), bottomless(0.0)]), 1);
    assert_eq!(unseen(vec![tile(-4.5), bottomless(0.0)]), 0);
    assert_eq!(unseen(vec![ground(), bottomless(0.1)]), 0);
    assert_eq!(unseen(vec![level(3.0, 9.0), bottomless(0.0)]), 0);
    let tenant = block(Vec3::Y * 0.5, Vec3::splat(0.1), false);
    assert_eq!(unseen(vec![ground(), bottomless(0.0), tenant]), 0);
    let mut cup = bottomless(0.0);
    for p in &mut cup.positions {
        (p.y, p.z) = (1.0 - p.y, -p.z);
    }
    assert_eq!(unseen(vec![ground(), cup]), 0);
}

#[test]
fn a_wall_that_only_stands_on_a_floor_buries_nothing_behind_it() {
    for turn in 0..4 {
        let wall = |low: f32| {
            let turn = Quat::from_rotation_y(f32::from(turn as u8) * std::f32::consts::FRAC_PI_2);
            let corners = [(-3.0, low), (3.0, low), (3.0, 2.0), (-3.0, 2.0)];
            let at = |(x, y)| (turn * Vec3::new(x, y, -2.0)).round();
            mesh(corners.map(at).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        };
        let behind = DQuat::from_rotation_y(f64::from(turn) * std::f64::consts::FRAC_PI_2)
            * DVec3::new(0.3, 1e-6, -2.5);
        for (low, expected) in [(0.0, 0), (-1.0, 1)] {
            let world = world(scene(vec![level(0.0, 3.0), wall(low)]));
            let own = world.solids().own(0, 0);
            let near = world.solids().about(behind, behind);
            let depth = |&body: &u32| world.solids().depth(body, behind, own);
            assert_eq!(
                near.iter().map(depth).sum::<i32>(),
                expected,
                "{turn} {low}"
            );
        }
    }
}

#[test]
fn what_stands_on_a_ground_lays_nothing_open_behind_it() {
    let wall = |bottom: f32| {
        let corners = [(-2.0, bottom), (2.0, bottom), (2.0, 2.0), (-2.0, 2.0)];
        let at = |(x, y)| Vec3::new(x, y, -2.0);
        mesh(corners.map(at).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    };
    let crate_at = |y: f32, half: f32| {
        let at = Vec3::new(1.0, y + half, half - 2.0);
        block(at, Vec3::splat(half), false)
    };
    let below = DVec3::new(0.3, -0.005, -2.0);
    let buried = |meshes: Vec<Mesh>| {
        let solids = solids(meshes);
        let own = solids.own(0, 0);
        let near = solids.about(below, below);
        near.iter()
            .map(|&body| solids.depth(body, below, own))
            .sum::<i32>()
    };
    let ground = || level(0.0, 9.0);
    let found = |y, half| buried(vec![wall(-0.01), ground(), crate_at(y, half)]);
    assert_eq!(found(0.0, 0.5), 1);
    // One that hangs under it may show what is there, if it is at least half as large.
    assert_eq!([found(-2.02, 1.01), found(-1.98, 0.99)], [0, 1]);
}
