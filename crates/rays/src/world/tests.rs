//! Where corners are, what is instanced, and which way normals point.

use super::*;
use crate::fixture::{block, placed_scene, square};
use crate::geometry::Positions;
use glam::Vec3;

fn build(places: &[DAffine3], instancing: bool) -> Result<World, Error> {
    let placed: Vec<_> = places.iter().map(|place| (0, *place)).collect();
    let mut square = square(0.0);
    square.normals = vec![Vec3::new(0.6, 0.0, 0.8); 4];
    World::new(
        Arc::new(placed_scene(vec![square], &placed)),
        WorldOptions {
            instancing,
            alpha_test_all: false,
        },
    )
}

#[test]
fn normals_of_what_is_lit_from_behind_point_outward() {
    for (mirror, side, instancing) in [
        (1.0, None, true),
        (-1.0, None, true),
        (1.0, Some(-1.0), false),
        (-1.0, Some(-1.0), true),
        (1.0, Some(1.0), true),
        (-1.0, Some(1.0), false),
    ] {
        let mut stone = block(Vec3::ZERO, Vec3::ONE, true);
        let outward = |side: f32| {
            let along = |p: &Vec3| side * p.normalize();
            stone.positions.iter().map(along).collect()
        };
        stone.normals = side.map_or(Vec::new(), outward);
        let scale = DVec3::new(mirror, 1.0, 1.0);
        let [near, far] = [3.0, 9.0].map(|x| DVec3::new(x, 0.0, 0.0));
        let places = [near, far]
            .map(|at| DAffine3::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, at));
        let placed = [(0, places[0]), (0, places[1]), (1, DAffine3::IDENTITY)];
        let scene = placed_scene(vec![stone, square(-5.0)], &placed);
        let options = WorldOptions {
            instancing,
            ..WorldOptions::default()
        };
        let mut world = World::new(Arc::new(scene), options).expect("a world");
        // A light in one of the two: they share their mesh.
        world.turn_over([far].into_iter());
        assert!(!world.has_turned_over(0) && !world.has_turned_over(1));
        assert!(world.is_turned_by([far].into_iter()) && !world.is_turned_by([].into_iter()));
        world.turn_over([].into_iter());
        assert!(world.has_turned_over(0) && world.has_turned_over(1) && !world.has_turned_over(2));
        for (instance, at) in [(0, near), (1, far)] {
            for triangle in 0..12 {
                let corners = world.corners(instance, triangle);
                let middle = corners.iter().sum::<DVec3>() / 3.0 - at;
                assert!(world.face(instance, triangle).dot(middle) > 0.0);
                let normals = world.normals(instance, triangle);
                assert_eq!(normals.is_some(), side.is_some());
                let is_outward = |[n, ..]: [DVec3; 3]| n.dot(middle) > 0.0;
                assert!(normals.is_none_or(is_outward), "{mirror} {side:?}");
                let away = side != Some(1.0);
                assert_eq!(
                    world.lit(instance, triangle, &corners).is_reversed,
                    away,
                    "{mirror} {side:?}"
                );
            }
        }
    }
}

fn turned(at: DVec3) -> DAffine3 {
    let turn = glam::DQuat::from_rotation_z(0.3);
    DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 3.0, -4.0), turn, at)
}

#[test]
fn a_mesh_is_instanced_only_where_it_is_used_twice_and_asked_for() {
    let shape = |world: World| (world.geometries.len(), world.parts[0].transform.is_some());
    let (once, twice) = ([turned(DVec3::X)], [turned(DVec3::X), turned(DVec3::Y)]);
    assert_eq!(shape(build(&once, true).unwrap()), (1, false));
    assert_eq!(shape(build(&twice, true).unwrap()), (1, true));
    assert_eq!(shape(build(&twice, false).unwrap()), (2, false));
}

#[test]
fn flattened_corners_are_the_f64_product_rounded_once() {
    let place = turned(DVec3::new(0.1, 0.2, 0.3));
    let world = build(&[place], true).unwrap();
    let expected = place
        .transform_point3(DVec3::new(-1.0, -1.0, 0.0))
        .as_vec3()
        .as_dvec3();
    assert_eq!(world.corners(0, 0)[0], expected);
    assert_eq!(
        (
            world.parts[0].stretch(),
            world.parts[0].rounding(DVec3::Z, &world.corners(0, 0))
        ),
        (1.0, 0.0)
    );
}

#[test]
fn instanced_corners_are_the_f32_transform_applied_in_f64() {
    let places = [turned(DVec3::new(0.1, 0.2, 0.3)), turned(DVec3::Y)];
    let world = build(&places, true).unwrap();
    let single = places[0].as_affine3a().as_daffine3();
    assert_eq!(
        world.corners(0, 0)[0],
        single.transform_point3(DVec3::new(-1.0, -1.0, 0.0))
    );
    let bounds = world.bounds();
    for instance in 0..2 {
        for corner in world.corners(instance, 0) {
            assert!(corner.cmpge(bounds.min).all() && corner.cmple(bounds.max).all());
        }
    }
}

#[test]
fn a_far_scene_is_brought_near_and_says_from_where() {
    let far = DAffine3::from_translation(DVec3::new(4e6, 0.0, -3e6));
    let scene = Arc::new(placed_scene(vec![square(0.0)], &[(0, far)]));
    let options = WorldOptions::default();
    let near = World::near(scene.clone(), options).unwrap();
    let far = World::new(scene, options).unwrap();
    assert_eq!(far.origin(), DVec3::ZERO);
    assert!(near.scale_bound() < 10.0, "{}", near.scale_bound());
    for (near_corner, far_corner) in near.corners(0, 0).into_iter().zip(far.corners(0, 0)) {
        assert_eq!(near_corner + near.origin(), far_corner);
    }
}

#[test]
fn unplaced_positions_are_the_meshes_own() {
    let world = build(&[DAffine3::IDENTITY], true).unwrap();
    assert!(matches!(world.geometries[0].positions, Positions::Mesh(..)));
    let expected = Bounds {
        min: DVec3::new(-1.0, -1.0, 0.0),
        max: DVec3::new(1.0, 1.0, 0.0),
    };
    assert_eq!((world.bounds(), world.scale_bound()), (expected, 1.0));
}

#[test]
fn normals_stay_perpendicular_and_outside_under_mirrored_stretching() {
    let world = build(&[DAffine3::from_scale(DVec3::new(2.0, 1.0, -1.0))], true).unwrap();
    assert!(world.parts[0].mirrors());
    let [normal, ..] = world.normals(0, 0).unwrap();
    // (0.6 / 2, 0, 0.8 / -1), to length 1.
    let expected = DVec3::new(0.3, 0.0, -0.8).normalize();
    assert!(
        (normal - expected).length() < 1e-7,
        "{normal}: the f32 input holds 24 bits"
    );
}

#[test]
fn placements_beyond_single_precision_are_an_error() {
    for place in [
        DAffine3::from_scale(DVec3::splat(1e39)),
        DAffine3::from_translation(DVec3::splat(1e300)),
    ] {
        let error = build(&[place], true).unwrap_err().to_string();
        assert!(error.starts_with("object object of fixture.obj"), "{error}");
        assert!(build(&[place, place], true).is_err());
    }
}

#[test]
fn what_rays_cannot_be_carried_into_is_flattened_and_nothing_else() {
    let shape = |world: World| -> Vec<bool> {
        (world.parts.iter().map(|part| part.transform.is_some())).collect()
    };
    let scaled = |scale: DVec3, x: f64| {
        DAffine3::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, DVec3::X * x)
    };
    let mut shear = DAffine3::IDENTITY;
    shear.matrix3.z_axis = DVec3::new(1.0, 1.0, 1e-8);
    for odd in [
        scaled(DVec3::splat(1e-9), 1e9),
        scaled(DVec3::splat(1e-6), 1e12),
        scaled(DVec3::splat(1e-11), 1e7),
        scaled(DVec3::new(1.0, 1e-14, 1.0), 0.0),
        scaled(DVec3::splat(1e13), 0.0),
        shear,
    ] {
        let places = [DAffine3::IDENTITY, turned(DVec3::X), odd];
        let world = build(&places, true).unwrap();
        assert_eq!(shape(world), [true, true, false], "{odd:?}");
    }
    // Near the end of the range no instance has room for the rays of the scene.
    let world = build(&[DAffine3::IDENTITY, scaled(DVec3::ONE, 9.5e17)], true).unwrap();
    assert_eq!(shape(world), [false, false]);
    let plain = [scaled(DVec3::new(1.0, 1e-6, 1.0), 1e5), turned(DVec3::Y)];
    assert_eq!(shape(build(&plain, true).unwrap()), [true, true]);
}

#[test]
fn a_transform_that_vanishes_in_single_precision_is_flattened() {
    let tiny = DAffine3::from_scale(DVec3::new(1e-60, 1.0, 1.0));
    let world = build(&[tiny, DAffine3::IDENTITY], true).unwrap();
    assert!(world.parts[0].transform.is_none() && world.parts[1].transform.is_some());
}
