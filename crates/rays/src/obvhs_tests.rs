//! What the obvhs backend promises, in both kinds of trees.

use crate::backend::{Coherence, Ray, RayBackend, RayPacket, SurfaceHit, TreeKind};
use crate::fixture::{
    Dice, mask_left_half, mesh, placed_scene, scene, soup, sphere, square, world,
};
use crate::mix::Mix;
use crate::obvhs_backend::ObvhsBackend;
use crate::triangle::ShearedRay;
use crate::world::World;
use glam::{DAffine3, DVec3, Vec3};

const KINDS: [TreeKind; 2] = [TreeKind::Cwbvh, TreeKind::Bvh2];

fn ray(origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> Ray {
    Ray {
        origin: origin.to_array(),
        direction: direction.to_array(),
        t_min,
        t_max,
    }
}

fn endless(origin: Vec3, direction: Vec3) -> Ray {
    ray(origin, direction, 0.0, f32::INFINITY)
}

/// The first hit by trying every triangle of every part in its own space.
fn exhaustive(world: &World, ray: &Ray) -> Option<SurfaceHit> {
    let origin = DVec3::from_array(ray.origin.map(f64::from));
    let direction = DVec3::from_array(ray.direction.map(f64::from));
    let mut best: Option<SurfaceHit> = None;
    for (instance, part) in world.parts.iter().enumerate() {
        let geometry = &world.geometries[part.geometry as usize];
        let sight = ShearedRay::new(
            part.inverse().transform_point3(origin),
            part.inverse().transform_vector3(direction),
        );
        for (triangle, indices) in geometry.triangles().iter().enumerate() {
            let corners = indices.map(|vertex| geometry.positions[vertex as usize].to_array());
            let Some(crossing) = sight.cross(&corners) else {
                continue;
            };
            let t = crossing.t as f32;
            let nearer = best.is_none_or(|best| t < best.t);
            if t > ray.t_min && t <= ray.t_max && nearer {
                best = Some(SurfaceHit {
                    t,
                    instance: instance as u32,
                    triangle: triangle as u32,
                    barycentric: crossing.barycentric.map(|weight| weight as f32),
                    front: crossing.front != (part.transform.is_none() && part.mirrors()),
                });
            }
        }
    }
    best
}

fn assert_exhaustive(world: &World, rays: impl Iterator<Item = Ray>) -> usize {
    let backends = KINDS.map(|kind| ObvhsBackend::build(world, kind));
    let mut hits = 0;
    for ray in rays {
        let truth = exhaustive(world, &ray);
        hits += usize::from(truth.is_some());
        for backend in &backends {
            let hit = backend.closest(&ray);
            let place = backend.describe();
            assert_eq!(
                hit.map(|hit| hit.t),
                truth.map(|hit| hit.t),
                "{place}: {ray:?}"
            );
            assert_eq!(backend.occluded(&ray), truth.is_some(), "{place}: {ray:?}");
        }
    }
    hits
}

fn triangles(dice: &mut Dice, count: usize, size: f32, scale: f32) -> Vec<[Vec3; 3]> {
    (0..count)
        .map(|_| {
            let center = dice.point();
            [0; 3].map(|_| (center + dice.point() * size) * scale)
        })
        .collect()
}

#[test]
fn trees_find_what_trying_all_triangles_finds_at_every_scale() {
    for scale in [1e-30, 1e-4, 1.0, 1e5, 1e30] {
        let mut dice = Dice(Mix(1));
        let world = world(scene(vec![soup(&triangles(&mut dice, 300, 0.2, scale))]));
        let rays = (0..3000).map(|_| {
            let limit = if dice.roll() < 0.5 {
                f32::INFINITY
            } else {
                dice.roll() * scale
            };
            ray(dice.point() * scale, dice.point(), 0.0, limit)
        });
        let hits = assert_exhaustive(&world, rays);
        assert!(
            (500..2500).contains(&hits),
            "scale {scale}: {hits} hits say nothing"
        );
    }
}

#[test]
fn the_length_of_a_direction_only_scales_t() {
    let mut dice = Dice(Mix(2));
    let world = world(scene(vec![soup(&triangles(&mut dice, 100, 0.3, 1.0))]));
    for length in [1e-30, 1e-12, 1e12, 1e30] {
        let rays = (0..500).map(|_| endless(dice.point(), dice.point() * length));
        assert!(assert_exhaustive(&world, rays) > 50);
    }
}

#[test]
fn far_origins_reach_small_scenes() {
    let mut dice = Dice(Mix(3));
    let world = world(scene(vec![soup(&triangles(&mut dice, 200, 0.3, 1.0))]));
    for distance in [1e2, 1e4, 1e6] {
        let rays = (0..500).map(|_| {
            let origin = dice.point().normalize() * distance;
            endless(origin, dice.point() - origin)
        });
        let hits = assert_exhaustive(&world, rays);
        assert!(hits > 50, "{hits} at {distance}");
    }
}

#[test]
fn rays_in_lattice_planes_along_axes_agree_with_trying_all() {
    let mut corners = Vec::new();
    for x in -3..3 {
        for y in -3..3 {
            let base = Vec3::new(x as f32, y as f32, ((x + y) % 2) as f32);
            corners.push([base, base + Vec3::X, base + Vec3::new(1.0, 1.0, 0.0)]);
            corners.push([base, base + Vec3::Z, base + Vec3::new(0.0, 1.0, 1.0)]);
        }
    }
    let world = world(scene(vec![soup(&corners)]));
    let mut dice = Dice(Mix(4));
    let signs = [0.0, -0.0, 1.0, -1.0];
    let rays = (0..4000).map(|_| {
        let mut pick = |values: &[f32]| values[(dice.roll() * values.len() as f32) as usize];
        let direction = Vec3::new(pick(&signs), pick(&signs), pick(&signs));
        let steps = [-3.0, -2.0, -0.5, 0.0, 0.25, 1.0, 2.0];
        endless(
            Vec3::new(pick(&steps), pick(&steps), pick(&steps)),
            direction,
        )
    });
    assert!(assert_exhaustive(&world, rays) > 500);
}

#[test]
fn surfaces_a_millionth_apart_stay_apart() {
    for scale in [1e-4f32, 1.0, 1e5] {
        let gap = 1e-6 * scale;
        let pair = [0.0, gap].map(|z| {
            let mut square = square(z);
            square
                .positions
                .iter_mut()
                .for_each(|p| *p *= Vec3::new(scale, scale, 1.0));
            square
        });
        let world = world(scene(pair.to_vec()));
        for kind in KINDS {
            let backend = ObvhsBackend::build(&world, kind);
            let at = Vec3::new(0.3, 0.2, 0.0) * scale;
            let hit = backend
                .closest(&endless(at, Vec3::Z))
                .map(|hit| (hit.t, hit.instance));
            assert_eq!(hit, Some((gap, 1)), "{kind:?} at scale {scale}");
            assert!(backend.occluded(&ray(at, Vec3::Z, 0.0, gap)));
            assert!(!backend.occluded(&ray(at, Vec3::Z, 0.0, gap.next_down())));
            assert!(!backend.occluded(&endless(at, Vec3::NEG_Z)));
        }
    }
}

#[test]
fn intervals_are_open_below_and_closed_above() {
    let world = world(scene(vec![square(1.0)]));
    for kind in KINDS {
        let backend = ObvhsBackend::build(&world, kind);
        let meets =
            |t_min, t_max| backend.occluded(&ray(Vec3::new(0.3, 0.2, 0.0), Vec3::Z, t_min, t_max));
        assert!(meets(0.0, 1.0));
        assert!(!meets(0.0, 1.0f32.next_down()));
        assert!(!meets(1.0, f32::INFINITY));
        assert!(meets(1.0f32.next_down(), f32::INFINITY));
        assert!(!meets(2.0, 0.5), "an empty interval");
        let on = |direction| backend.occluded(&endless(Vec3::new(0.3, 0.2, 1.0), direction));
        assert!(
            !on(Vec3::Z) && !on(Vec3::NEG_Z) && !on(Vec3::X),
            "t = 0 lies outside"
        );
    }
}

#[test]
fn rays_aimed_at_edges_and_vertices_do_not_leak() {
    let sphere = sphere(4);
    let world = world(scene(vec![sphere.clone()]));
    for kind in KINDS {
        let backend = ObvhsBackend::build(&world, kind);
        let mut dice = Dice(Mix(5));
        for round in 0..20_000 {
            let [a, b, _] = sphere.triangles[round % sphere.triangles.len()]
                .map(|v| sphere.positions[v as usize]);
            let target = if round % 2 == 0 {
                a
            } else {
                a.lerp(b, dice.roll())
            };
            let origin = dice.point() * 0.5;
            let ray = endless(origin, target - origin);
            assert!(backend.occluded(&ray), "{kind:?}: {ray:?}");
        }
    }
}

#[test]
fn thousands_of_equal_triangles_and_ever_smaller_ones_are_found() {
    let mut corners = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 3000];
    corners.extend((0..120).map(|i| {
        let size = 0.5f32.powi(i);
        [
            Vec3::new(0.0, 0.0, size),
            Vec3::new(size, 0.0, size),
            Vec3::new(0.0, size, size),
        ]
    }));
    let world = world(scene(vec![soup(&corners)]));
    let mut dice = Dice(Mix(6));
    let rays = (0..300).map(|i| {
        let size = 0.5f32.powi(i % 120);
        let target = Vec3::new(0.2 * size, 0.3 * size, size);
        let origin = target + dice.point() * size;
        endless(origin, target - origin)
    });
    assert!(assert_exhaustive(&world, rays) > 250);
}

#[test]
fn instances_are_met_where_they_are_placed() {
    let mut dice = Dice(Mix(7));
    let places: Vec<(u32, DAffine3)> = (0..12)
        .map(|i| {
            let size = [0.01, 1.0, 30.0][i % 3];
            let stretch = DVec3::new(size, size * 0.5, if i % 2 == 0 { -size } else { size });
            let turn = glam::DQuat::from_axis_angle(dice.point().as_dvec3().normalize(), i as f64);
            let place = DAffine3::from_scale_rotation_translation(
                stretch,
                turn,
                dice.point().as_dvec3() * 20.0,
            );
            (0, place)
        })
        .collect();
    let world = world(placed_scene(vec![sphere(2)], &places));
    assert_eq!((world.geometries.len(), world.parts.len()), (1, 12));
    let rays = (0..3000).map(|i| {
        let aim = places[i % places.len()]
            .1
            .transform_point3(dice.point().as_dvec3())
            .as_vec3();
        let origin = dice.point() * 30.0;
        endless(origin, aim - origin)
    });
    assert!(assert_exhaustive(&world, rays) > 2000);
}

#[test]
fn fronts_follow_the_mesh_through_mirroring_placements() {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let lift = DAffine3::from_translation(DVec3::Z);
    for places in [vec![(0, mirror)], vec![(0, mirror), (0, mirror * lift)]] {
        let world = world(placed_scene(vec![square(0.0)], &places));
        assert_eq!(world.parts[0].transform.is_some(), places.len() > 1);
        for kind in KINDS {
            let backend = ObvhsBackend::build(&world, kind);
            let front = |z: f32| {
                let hit =
                    backend.closest(&endless(Vec3::new(0.1, 0.3, z), Vec3::new(0.0, 0.0, -z)));
                hit.map(|hit| hit.front)
            };
            assert_eq!(
                (front(5.0), front(-5.0)),
                (Some(true), Some(false)),
                "{kind:?}"
            );
        }
    }
}

#[test]
fn holes_of_a_masked_material_let_rays_pass() {
    let mut masked = scene(vec![square(0.0), square(-1.0)]);
    masked.meshes[1].material = 1;
    masked.materials.push(masked.materials[0].clone());
    mask_left_half(&mut masked);
    let world = world(masked);
    for kind in KINDS {
        let backend = ObvhsBackend::build(&world, kind);
        let first = |x: f32| {
            backend
                .closest(&endless(Vec3::new(x, 0.2, 1.0), Vec3::NEG_Z))
                .map(|hit| hit.instance)
        };
        assert_eq!((first(-0.5), first(0.5)), (Some(1), Some(0)));
        assert!(!backend.occluded(&ray(Vec3::new(-0.5, 0.2, 1.0), Vec3::NEG_Z, 0.0, 1.5)));
        assert!(backend.occluded(&ray(Vec3::new(0.5, 0.2, 1.0), Vec3::NEG_Z, 0.0, 1.5)));
    }
}

#[test]
fn rays_that_are_not_finite_and_worlds_without_triangles_meet_nothing() {
    let worlds = [
        scene(Vec::new()),
        scene(vec![mesh(Vec::new(), Vec::new())]),
        scene(vec![square(0.0)]),
    ];
    for world in worlds.map(world) {
        for kind in KINDS {
            let backend = ObvhsBackend::build(&world, kind);
            for bad in [
                endless(Vec3::new(0.0, 0.0, f32::NAN), Vec3::NEG_Z),
                endless(Vec3::new(f32::INFINITY, 0.0, 1.0), Vec3::NEG_Z),
                endless(Vec3::Z, Vec3::new(0.0, f32::NAN, -1.0)),
                endless(Vec3::Z, Vec3::new(0.0, f32::INFINITY, -1.0)),
                endless(Vec3::Z, Vec3::ZERO),
                ray(Vec3::Z, Vec3::NEG_Z, f32::NAN, f32::INFINITY),
                ray(Vec3::Z, Vec3::NEG_Z, 0.0, f32::NAN),
                endless(Vec3::Z, Vec3::Z),
            ] {
                assert!(!backend.occluded(&bad), "{bad:?}");
                assert_eq!(backend.closest(&bad), None, "{bad:?}");
            }
        }
    }
}

#[test]
fn packets_answer_their_active_lanes_alone() {
    let world = world(scene(vec![square(0.0)]));
    let backend = ObvhsBackend::build(&world, TreeKind::Cwbvh);
    let mut packet = RayPacket::<16>::new();
    for lane in 0..16 {
        let down = if lane % 2 == 0 { Vec3::NEG_Z } else { Vec3::Z };
        packet.set(lane, &endless(Vec3::new(0.3, 0.2, 1.0), down));
    }
    assert_eq!(
        backend.occluded16(&packet, 0xffff, Coherence::Incoherent),
        0x5555
    );
    assert_eq!(
        backend.occluded16(&packet, 0x00f3, Coherence::Coherent),
        0x0051
    );
    assert_eq!(backend.occluded16(&packet, 0, Coherence::Coherent), 0);
}

#[test]
fn of_triangles_in_one_place_the_first_that_faces_the_ray_is_met() {
    let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    // Up, down, up again, and down by other first corners; beside them a triangle of its own.
    let orders = [[a, b, c], [a, c, b], [b, c, a], [c, b, a], [a, b, -c]];
    let own = scene(orders.map(|order| soup(&[order])).to_vec());
    let one = scene(vec![soup(&orders)]);
    let mirror = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    // A placement that mirrors turns corners in the world, not fronts.
    let mirrored = placed_scene(
        orders.map(|order| soup(&[order])).to_vec(),
        &[(1, mirror), (0, DAffine3::IDENTITY), (2, mirror)],
    );
    let twice = placed_scene(
        vec![soup(&orders[..2])],
        &[(0, mirror * DAffine3::from_translation(DVec3::Z)); 3],
    );
    let at = |z: f32| endless(Vec3::new(0.2, 0.3, z), Vec3::new(0.0, 0.0, -z));
    for (scene, above, below) in [
        (own, (0, 0), (1, 0)),
        (one, (0, 0), (0, 1)),
        // The first looks up in the mesh, which is down after the mirror, and so on.
        (mirrored, (0, 0), (2, 0)),
        (twice, (0, 1), (0, 0)),
    ] {
        let world = world(scene);
        for kind in KINDS {
            let backend = ObvhsBackend::build(&world, kind);
            for (z, place) in [(5.0, above), (-5.0, below)] {
                let hit = backend.closest(&at(z)).expect("the triangle is there");
                assert_eq!((hit.instance, hit.triangle), place, "{kind:?} from {z}");
                assert!(hit.front, "{kind:?} from {z}");
                let [a, b, c] = world.corners(hit.instance, hit.triangle);
                let [v, w] = hit.barycentric.map(f64::from);
                let met = (1.0 - v - w) * a + v * b + w * c;
                let z = met.z;
                assert!((met - DVec3::new(0.2, 0.3, z)).length() < 1e-6, "{met}");
            }
        }
    }
}
