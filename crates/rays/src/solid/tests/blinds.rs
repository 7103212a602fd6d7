//! Sheets that look at something close before them.

use super::*;

/// Half of a wall's and of a plank's width and height, and how far the plank stands before the wall.
const WALL: Vec3 = Vec3::new(2.0, 1.5, 0.1);
const PLANK: [f32; 2] = [0.15, 0.7];
const GAP: f32 = 0.017;

/// An upright sheet about a point, that looks along z or against it.
fn upright(at: Vec3, half: [f32; 2], along: bool) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corner = |(x, y)| at + Vec3::new(x * half[0], y * half[1], 0.0);
    let faces = [[[0, 2, 1], [0, 3, 2]], [[0, 1, 2], [0, 2, 3]]];
    let faces = faces[usize::from(along)].to_vec();
    mesh(corners.map(corner).to_vec(), faces)
}

/// A plank beside the middle of a wall whose front lies in z = 0.
fn plank(x: f32, gap: f32, along: bool) -> Mesh {
    upright(Vec3::new(x, 0.1, gap), PLANK, along)
}

fn wall() -> Mesh {
    block(Vec3::NEG_Z * WALL.z, WALL, false)
}

/// The numbers of meshes that are lit from behind, all of each.
fn turned(scene: Scene, places: &[DVec3]) -> Vec<u32> {
    let backs = Solids::of(world(scene).scene()).backs(places);
    let of = |(mesh, triangles): (u32, Vec<u32>)| {
        assert_eq!(triangles, [0, 1], "mesh {mesh}");
        mesh
    };
    backs.into_iter().map(of).collect()
}

#[test]
fn a_plank_that_looks_at_its_wall_is_lit_from_behind_however_it_is_placed() {
    let row = vec![
        wall(),
        plank(-1.0, GAP, false),
        plank(-0.6, GAP, false),
        plank(-0.2, GAP, true),
        plank(0.2, GAP, false),
    ];
    assert_eq!(turned(scene(row.clone()), &[]), [1, 2, 4]);
    let turn = DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
    let moved = DAffine3::from_scale_rotation_translation(DVec3::splat(7.0), turn, DVec3::ONE);
    let mirrored = moved * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    for place in [moved, mirrored] {
        let placed: Vec<_> = (0..5).map(|mesh| (mesh, place)).collect();
        assert_eq!(turned(placed_scene(row.clone(), &placed), &[]), [1, 2, 4]);
    }
    // The same plank also stands where its front is seen.
    let away = DAffine3::from_translation(DVec3::Z);
    let placed = [(0, DAffine3::IDENTITY), (1, DAffine3::IDENTITY), (1, away)];
    assert!(turned(placed_scene(row, &placed), &[]).is_empty());
}

#[test]
fn a_plank_stays_as_it_is_where_its_front_may_be_lit_or_seen() {
    // Farther off than an eighth of its width, which is 0.3; a light in the gap, and one before the back.
    let at = |gap: f32| scene(vec![wall(), plank(0.0, gap, false)]);
    assert_eq!(turned(at(0.037), &[]), [1]);
    assert!(turned(at(0.038), &[]).is_empty());
    let light = |z: f64| [DVec3::new(0.05, 0.3, z)];
    assert!(turned(at(GAP), &light(0.01)).is_empty());
    assert_eq!(turned(at(GAP), &light(0.03)), [1]);
    // Drawn from one side, a lamp itself, before a wall that is cut out.
    type Change = fn(&mut Scene);
    let changes: [Change; 3] = [
        |of| of.materials[0].double_sided = false,
        |of| of.materials[0].emission = Vec3::ONE,
        |of| {
            of.materials.push(of.materials[0].clone());
            of.meshes[1].material = 1;
            mask_left_half(of);
        },
    ];
    for change in changes {
        let mut scene = at(GAP);
        change(&mut scene);
        assert!(turned(scene, &[]).is_empty());
    }
    // It stands out beyond the wall by a 20th of its width; it stands in a crack; something stands in the gap.
    let beyond = scene(vec![wall(), plank(WALL.x - 0.135, GAP, false)]);
    assert!(turned(beyond, &[]).is_empty());
    let before = upright(Vec3::new(0.0, 0.1, 2.0 * GAP), [0.5, 1.0], false);
    let crack = vec![wall(), plank(0.0, GAP, false), before];
    assert!(turned(scene(crack), &[]).is_empty());
    let with = |half: Vec3| {
        let thing = block(Vec3::new(0.05, 0.1, 0.0), half, false);
        turned(scene(vec![wall(), plank(0.0, GAP, false), thing]), &[])
    };
    assert!(with(Vec3::new(0.06, 0.4, 0.005)).is_empty());
    // A ledge that goes on beyond, and a column about the end of the plank, do not.
    assert_eq!(with(Vec3::new(1.0, 0.4, 0.005)), [1]);
    assert_eq!(with(Vec3::new(0.12, 0.4, 0.2)), [1]);
}

#[test]
fn a_wide_floor_and_its_ceiling_stay_as_they_are() {
    // 3 high, 100 wide: lower than a 32nd of the width. The ceiling is larger than what it looks at.
    let hall = |height: f32| {
        let ceiling = upright(Vec3::Z * height, [60.0, 60.0], false);
        vec![upright(Vec3::ZERO, [50.0, 50.0], true), ceiling]
    };
    let desk = || block(Vec3::new(9.0, 8.0, 0.4), Vec3::new(20.0, 20.0, 0.4), false);
    let with_a_desk = [hall(3.0), vec![desk()]].concat();
    assert!(turned(scene(with_a_desk), &[]).is_empty());
    let same = [[50.0; 2], [49.9; 2]];
    let sheets = (0..)
        .zip(same)
        .map(|(k, half)| upright(Vec3::Z * k as f32, half, k == 0));
    assert!(turned(scene(sheets.collect()), &[]).is_empty());
    // Alone, the floor is as a rug that lies on its front; higher, it is not.
    assert_eq!(turned(scene(hall(3.0)), &[]), [0]);
    assert!(turned(scene(hall(3.2)), &[]).is_empty());
}
