//! What scenes are made of: instances, filters, threads. What is refused: the module `refused`.

mod common;
#[path = "scenes/refused.rs"]
mod refused;

use ambake_embree::{Coherence, Device, Keep, Ray, RayPacket, Scene, SceneBuilder};
use common::{Random, ask, device, ray, scene, soup};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

const IDENTITY: [[f32; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
const FLAT: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]];

/// A ray along -z that meets the plane of `FLAT` at (x, y), at t = 1.
fn down(x: f32, y: f32) -> Ray {
    Ray {
        origin: [x, y, 1.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    }
}

/// The image of a point; exact where every product and sum is a float.
fn place(t: &[[f32; 3]; 4], p: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|row| t[0][row] * p[0] + t[1][row] * p[1] + t[2][row] * p[2] + t[3][row])
}

#[test]
fn handles_are_send_and_sync() {
    fn shared<T: Send + Sync + Clone>() {}
    fn moved<T: Send>() {}
    shared::<Device>();
    shared::<Scene>();
    moved::<SceneBuilder>();
}

#[test]
fn instances_equal_the_flattened_mesh() {
    let Some(device) = device() else { return };
    let mut random = Random(3);
    // Vertices on a grid of 1/1024 and transforms of powers of two: flattening is exact.
    let (mut positions, triangles) = soup(&mut random, 1000);
    for x in positions.iter_mut().flatten() {
        *x = (*x * 1024.0).round() / 1024.0;
    }
    let turned = [
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.25, -2.0],
    ];
    let mirrored = [
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [2.0, 0.0, 0.0],
    ];
    let stretched = [
        [0.0, 0.0, 0.5],
        [0.0, -4.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 8.0, 0.125],
    ];
    let sheared = [
        [1.0, 0.0, 0.0],
        [0.5, 1.0, 0.0],
        [0.25, -0.5, 2.0],
        [-4.0, 0.0, 0.0],
    ];
    let transforms = [IDENTITY, turned, mirrored, stretched, sheared];
    for robust in [false, true] {
        let part = scene(&device, robust, &(positions.clone(), triangles.clone()));
        let mut instanced = SceneBuilder::new(&device).robust(robust);
        let mut flattened = SceneBuilder::new(&device).robust(robust);
        instanced.triangles(&FLAT, &[[0, 1, 2]]).expect("a mesh");
        flattened.triangles(&FLAT, &[[0, 1, 2]]).expect("a mesh");
        for t in &transforms {
            let placed: Vec<_> = positions.iter().map(|&p| place(t, p)).collect();
            let id = instanced.instance(&part, *t).expect("an instance");
            assert_eq!(Ok(id), flattened.triangles(&placed, &triangles));
        }
        let instanced = instanced.commit().expect("a scene");
        let flattened = flattened.commit().expect("a scene");
        let (mut inside, mut fronts) = (0, 0);
        for _ in 0..100_000 {
            let mut ray = ray(&mut random);
            ray.origin = ray.origin.map(|x| 4.0 * x);
            let (a, b) = (instanced.closest(&ray), flattened.closest(&ray));
            assert_eq!(
                instanced.occluded(&ray),
                flattened.occluded(&ray),
                "{ray:?}"
            );
            assert_eq!(a.is_some(), b.is_some(), "{ray:?} {a:?} {b:?}");
            let (Some(a), Some(b)) = (a, b) else { continue };
            assert_eq!(a.instance.unwrap_or(0), b.geometry, "{ray:?} {a:?} {b:?}");
            assert_eq!(a.primitive, b.primitive, "{ray:?} {a:?} {b:?}");
            assert_eq!(b.instance, None);
            let Some(id) = a.instance else { continue };
            assert_eq!(a.geometry, 0, "geometry of the instanced scene");
            // A mirror turns the winding over, so the flattened triangle shows its other side.
            let turns_over = id == 3;
            assert_eq!(a.front, b.front != turns_over, "{ray:?} {a:?} {b:?}");
            inside += 1;
            fronts += u32::from(a.front);
        }
        println!("robust {robust}: {inside} hits in instances, {fronts} on the front");
        assert!(
            inside > 2_000 && fronts > 1_000,
            "{inside} hits test nothing"
        );
    }
}

#[test]
fn instances_keep_t_the_interval_and_the_normal_of_the_geometry() {
    let Some(device) = device() else { return };
    for robust in [false, true] {
        let part = scene(&device, robust, &(FLAT.to_vec(), vec![[0, 1, 2]]));
        let mut builder = SceneBuilder::new(&device).robust(robust);
        // Upside down and four times as large, at z = 2: the normal still is +z in the geometry's space.
        let flip = [
            [4.0, 0.0, 0.0],
            [0.0, 4.0, 0.0],
            [0.0, 0.0, -4.0],
            [0.0, 0.0, 2.0],
        ];
        builder.instance(&part, flip).expect("an instance");
        let scene = builder.commit().expect("a scene");
        let mut ray = down(0.5, 0.5);
        ray.origin[2] = 10.0;
        let hit = ask(&scene, &ray).expect("the plane is below");
        assert_eq!((hit.instance, hit.geometry, hit.primitive), (Some(0), 0, 0));
        assert!(hit.t == 8.0 || hit.t == 8.0_f32.next_down(), "{}", hit.t);
        assert!(
            hit.normal[2] > 0.0 && hit.normal[0] == 0.0 && hit.normal[1] == 0.0,
            "{hit:?}"
        );
        assert!(
            !hit.front,
            "seen from the geometry the ray comes from below"
        );
        let t = if robust { hit.t } else { 8.0 };
        for (t_min, t_max, meets) in [
            (0.0, t, true),
            (0.0, t.next_down(), false),
            (t, 9.0, false),
            (t.next_down(), 9.0, true),
        ] {
            let hit = ask(
                &scene,
                &Ray {
                    t_min,
                    t_max,
                    ..ray
                },
            );
            assert_eq!(hit.is_some(), meets, "robust {robust}, ({t_min}, {t_max}]");
        }
        ray.origin[2] = 2.0;
        assert_eq!(ask(&scene, &ray), None, "a ray that starts on the instance");
    }
}

#[test]
fn only_kept_hits_count() {
    let Some(device) = device() else { return };
    for robust in [false, true] {
        let mut builder = SceneBuilder::new(&device).robust(robust);
        // The corner weights of FLAT at (x, y) are ((x + 1) / 4, (y + 1) / 4).
        let keep: Keep = Arc::new(|primitive, [u, v], _| primitive == 1 || (u < 0.5 && v < 0.25));
        let lower = FLAT.map(|[x, y, _]| [x, y, -1.0]);
        let positions = [FLAT, lower].concat();
        builder
            .masked_triangles(&positions, &[[0, 1, 2], [3, 4, 5]], keep)
            .expect("a mesh");
        let masked = builder.commit().expect("a scene");
        let mut builder = SceneBuilder::new(&device).robust(robust);
        builder.instance(&masked, IDENTITY).expect("an instance");
        let instanced = builder.commit().expect("a scene");
        for scene in [&masked, &instanced] {
            for (x, y, primitive) in [
                (0.0, -0.5, 0),
                (0.5, -0.25, 0),
                (1.5, -0.5, 1),
                (0.0, 0.5, 1),
            ] {
                let ray = down(x, y);
                let hit = ask(scene, &ray).expect("two planes are below");
                assert_eq!(
                    hit.primitive, primitive,
                    "robust {robust}, ({x}, {y}): {hit:?}"
                );
                let short = ask(scene, &Ray { t_max: 1.5, ..ray });
                assert_eq!(
                    short.is_some(),
                    primitive == 0,
                    "robust {robust}, ({x}, {y})"
                );
            }
        }
    }
}

#[test]
fn a_filter_runs_only_for_its_own_geometry_and_active_lanes() {
    let Some(device) = device() else { return };
    let calls = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&calls);
    let mut builder = SceneBuilder::new(&device);
    let keep: Keep = Arc::new(move |_, _, _| {
        counted.fetch_add(1, Ordering::Relaxed);
        false
    });
    let far = FLAT.map(|[x, y, z]| [x + 100.0, y, z]);
    builder
        .masked_triangles(&far, &[[0, 1, 2]], keep)
        .expect("a mesh");
    builder.triangles(&FLAT, &[[0, 1, 2]]).expect("a mesh");
    let scene = builder.commit().expect("a scene");
    let mut packet = RayPacket::<16>::new();
    for lane in 0..16 {
        packet.set(lane, &down(if lane % 2 == 0 { 0.0 } else { 100.0 }, 0.0));
    }
    let blocked = scene.occluded_packet(&packet, 0x00ff, Coherence::Incoherent);
    assert_eq!(blocked, 0x0055);
    assert_eq!(calls.load(Ordering::Relaxed), 4);
}

#[test]
fn a_panic_in_a_filter_reaches_the_caller_of_the_query() {
    let Some(device) = device() else { return };
    let mut builder = SceneBuilder::new(&device);
    let keep: Keep = Arc::new(|_, _, _| std::panic::resume_unwind(Box::new("from the filter")));
    builder
        .masked_triangles(&FLAT, &[[0, 1, 2]], keep)
        .expect("a mesh");
    let scene = builder.commit().expect("a scene");
    let mut packet = RayPacket::<8>::new();
    (0..8).for_each(|lane| packet.set(lane, &down(0.0, 0.0)));
    let queries: [&dyn Fn(); 3] = [
        &|| assert!(scene.occluded(&down(0.0, 0.0))),
        &|| assert!(scene.closest(&down(0.0, 0.0)).is_some()),
        &|| {
            assert_ne!(
                scene.occluded_packet(&packet, u32::MAX, Coherence::Coherent),
                0
            )
        },
    ];
    for query in queries {
        let panic = catch_unwind(AssertUnwindSafe(query)).expect_err("the panic");
        assert_eq!(panic.downcast_ref::<&str>(), Some(&"from the filter"));
    }
    assert!(!scene.occluded(&down(100.0, 0.0)), "no panic is left over");
}

#[test]
fn an_empty_scene_is_hit_by_nothing_and_has_no_bounds() {
    let Some(device) = device() else { return };
    let empty = SceneBuilder::new(&device).commit().expect("a scene");
    assert_eq!(ask(&empty, &down(0.0, 0.0)), None);
    assert_eq!(empty.bounds(), None);
    let mut builder = SceneBuilder::new(&device);
    builder.instance(&empty, IDENTITY).expect("an instance");
    let scene = builder.commit().expect("a scene");
    assert_eq!(ask(&scene, &down(0.0, 0.0)), None);
    assert_eq!(scene.bounds(), None);
}

#[test]
fn bounds_are_those_of_the_vertices() {
    let Some(device) = device() else { return };
    let scene = scene(&device, false, &(FLAT.to_vec(), vec![[0, 1, 2]]));
    assert_eq!(scene.bounds(), Some([[-1.0, -1.0, 0.0], [3.0, 3.0, 0.0]]));
}

#[test]
fn a_scene_outlives_the_handles_it_was_made_from() {
    let Some(device) = device() else { return };
    let keep: Keep = Arc::new(|primitive, _, _| primitive == 0);
    let mut builder = SceneBuilder::new(&device);
    builder
        .masked_triangles(&FLAT, &[[0, 1, 2]], keep)
        .expect("a mesh");
    let part = builder.commit().expect("a scene");
    let mut builder = SceneBuilder::new(&device);
    builder.instance(&part, IDENTITY).expect("an instance");
    drop((part, device));
    let scene = builder.commit().expect("a scene");
    assert!(scene.occluded(&down(0.0, 0.0)));
}

#[test]
fn many_threads_build_and_trace_at_once() {
    let Some(device) = device() else { return };
    let mesh = soup(&mut Random(7), 5_000);
    let shared = scene(&device, true, &mesh);
    let count = |scene: &Scene| {
        let mut random = Random(8);
        (0..20_000)
            .filter(|_| scene.occluded(&ray(&mut random)))
            .count()
    };
    let expected = count(&shared);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                let own = scene(&device, true, &mesh);
                assert_eq!(count(&own), expected);
                assert_eq!(count(&shared), expected);
            });
        }
    });
}

#[test]
fn building_leaves_the_callers_float_rules_alone() {
    let Some(device) = device() else { return };
    let scene = scene(&device, false, &soup(&mut Random(10), 10_000));
    scene.occluded(&down(0.0, 0.0));
    let half = std::hint::black_box(f32::MIN_POSITIVE) / 2.0;
    assert_ne!(half, 0.0, "denormal results are flushed to zero");
    assert_ne!(
        half * std::hint::black_box(2.0),
        0.0,
        "denormal operands count as zero"
    );
}

/// Small enough for valgrind; `rays.rs` asks a million.
#[test]
fn many_packets_equal_singles() {
    let Some(device) = device() else { return };
    let mut random = Random(11);
    let (positions, triangles) = soup(&mut random, 200);
    let mut builder = SceneBuilder::new(&device).robust(true);
    builder.triangles(&positions, &triangles).expect("a mesh");
    let scene = builder.commit().expect("a scene");
    for _ in 0..40 {
        let mut wide = RayPacket::<16>::new();
        let mut narrow = RayPacket::<8>::new();
        let mut singles = 0;
        for lane in 0..16 {
            let ray = Ray {
                origin: random.point(),
                direction: random.point(),
                t_min: 0.0,
                t_max: f32::INFINITY,
            };
            wide.set(lane, &ray);
            narrow.set(lane % 8, &ray);
            singles |= u32::from(scene.occluded(&ray)) << lane;
            assert_eq!(scene.closest(&ray).is_some(), singles >> lane & 1 == 1);
        }
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            assert_eq!(scene.occluded_packet(&wide, u32::MAX, coherence), singles);
            assert_eq!(
                scene.occluded_packet(&narrow, 0xff, coherence),
                singles >> 8
            );
        }
    }
}
