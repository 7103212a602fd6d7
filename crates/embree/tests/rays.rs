//! The conventions of a ray: its interval, its packets, what a hit says.

mod common;

use ambake_embree::{Coherence, Keep, Lanes, PacketWidth, Ray, RayPacket, Scene, SceneBuilder};
use common::{Random, ask, device, ray, scene, soup};
use std::collections::HashSet;
use std::sync::{Arc, Mutex};

/// Unit right triangle in the plane z = `height`, wound counter-clockwise seen from +z.
fn triangle(height: f32) -> common::Mesh {
    let positions = vec![[0.0, 0.0, height], [1.0, 0.0, height], [0.0, 1.0, height]];
    (positions, vec![[0, 1, 2]])
}

/// A ray straight up through (1/4, 1/8).
fn up(z: f32, length: f32, t_min: f32, t_max: f32) -> Ray {
    Ray {
        origin: [0.25, 0.125, z],
        direction: [0.0, 0.0, length],
        t_min,
        t_max,
    }
}

/// Kernels below AVX-512 divide by way of a reciprocal that is rounded down by at most one step.
fn is_rounded(value: f32, exact: f32) -> bool {
    value == exact || value == exact.next_down()
}

#[test]
fn interval_is_open_at_t_min_and_closed_at_t_max() {
    let Some(device) = device() else { return };
    for robust in [false, true] {
        // The plane, the ray's length, and so t, are powers of two: every product is exact.
        for (height, length) in [
            (1.0, 1.0),
            (1.0, 4.0),
            (64.0, 0.5),
            (0.0625, 1.0),
            (1.0 / 1048576.0, 1.0),
        ] {
            let scene = scene(&device, robust, &triangle(height));
            let exact: f32 = height / length;
            let all = up(0.0, length, 0.0, f32::INFINITY);
            let t = scene.closest(&all).expect("the triangle is above").t;
            assert!(is_rounded(t, exact), "{t} is not {exact}");
            // Default triangles compare products, exactly; robust ones compare the t that they report.
            let t = if robust { t } else { exact };
            for (t_min, t_max, meets) in [
                (0.0, f32::INFINITY, true),
                (0.0, t, true),
                (0.0, t.next_down(), false),
                (t, f32::INFINITY, false),
                (t.next_down(), f32::INFINITY, true),
                (t * (1.0 - 4.0 * f32::EPSILON), t, true),
                (t, t, false),
                (t, t.next_up(), false),
                (2.0 * t, t, false),
                (0.0, 0.0, false),
                (-1.0, -0.5, false),
                (0.0, f32::NEG_INFINITY, false),
                (0.0, f32::NAN, false),
                (f32::NAN, t, true),
                (f32::INFINITY, f32::INFINITY, false),
            ] {
                let hit = ask(&scene, &up(0.0, length, t_min, t_max));
                assert_eq!(
                    hit.is_some(),
                    meets,
                    "robust {robust}, t {t}, interval ({t_min}, {t_max}]"
                );
                if let Some(hit) = hit {
                    assert!(is_rounded(hit.t, exact), "{} is not {exact}", hit.t);
                    assert!(
                        hit.t > t_min || t_min.is_nan(),
                        "{} is not past {t_min}",
                        hit.t
                    );
                    assert!(hit.t <= t_max, "{} is past {t_max}", hit.t);
                }
            }
        }
    }
}

#[test]
fn a_ray_never_meets_the_surface_it_starts_on_nor_what_is_behind() {
    let Some(device) = device() else { return };
    for robust in [false, true] {
        for height in [0.0, 1.0, -3.0, 0.1, 1e-30, 1e10] {
            let scene = scene(&device, robust, &triangle(height));
            for t_min in [0.0, -0.0, -1.0, f32::NEG_INFINITY] {
                for length in [1.0, -1.0, 1e-3] {
                    let on = up(height, length, t_min, f32::INFINITY);
                    assert_eq!(ask(&scene, &on), None, "robust {robust}, {on:?}");
                }
            }
        }
        let behind = scene(&device, robust, &triangle(-1.0));
        assert_eq!(ask(&behind, &up(0.0, 1.0, -2.0, f32::INFINITY)), None);
    }
}

#[test]
fn a_hit_has_the_weights_of_corners_one_and_two_and_a_right_handed_normal() {
    let Some(device) = device() else { return };
    for robust in [false, true] {
        let scene = scene(&device, robust, &triangle(2.0));
        let below = ask(&scene, &up(0.0, 1.0, 0.0, f32::INFINITY)).expect("the triangle is above");
        assert!(is_rounded(below.t, 2.0), "{}", below.t);
        let [u, v] = below.barycentric;
        assert!(is_rounded(u, 0.25) && is_rounded(v, 0.125), "{u} {v}");
        assert_eq!(below.normal, [0.0, 0.0, 1.0]);
        assert_eq!(
            (below.geometry, below.primitive, below.instance),
            (0, 0, None)
        );
        assert!(!below.front, "a ray along the normal arrives at the back");
        let above = ask(&scene, &up(3.0, -1.0, 0.0, f32::INFINITY)).expect("the triangle is below");
        assert!(is_rounded(above.t, 1.0), "{}", above.t);
        assert_eq!(above.barycentric, below.barycentric);
        assert_eq!(above.normal, below.normal);
        assert!(above.front, "a ray against the normal arrives at the front");
    }
}

#[test]
fn bits_past_the_width_are_ignored_and_unset_lanes_meet_nothing() {
    let Some(device) = device() else { return };
    let scene = scene(&device, false, &triangle(1.0));
    let mut packet = RayPacket::<8>::new();
    packet.set(3, &up(0.0, 1.0, 0.0, 2.0));
    assert_eq!(
        scene.occluded_packet(&packet, u32::MAX, Coherence::Incoherent),
        1 << 3
    );
    let mut packet = RayPacket::<16>::new();
    packet.set(15, &up(0.0, 1.0, 0.0, 2.0));
    assert_eq!(
        scene.occluded_packet(&packet, u32::MAX, Coherence::Coherent),
        1 << 15
    );
}

#[test]
fn rays_that_are_not_numbers_end_the_query() {
    let Some(device) = device() else { return };
    let scene = scene(&device, false, &soup(&mut Random(5), 500));
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        let ray = Ray {
            origin: [bad; 3],
            direction: [bad; 3],
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        scene.closest(&ray);
        scene.occluded(&ray);
        let mut packet = RayPacket::<16>::new();
        (0..16).for_each(|lane| packet.set(lane, &ray));
        scene.occluded_packet(&packet, u32::MAX, Coherence::Coherent);
    }
}

/// Traces rays in packets with random masks and compares each lane with the single ray. Returns how many are blocked.
fn compare<const N: usize>(scene: &Scene, rays: &[Ray], coherence: Coherence) -> u32
where
    Lanes<N>: PacketWidth,
{
    let mut random = Random(9);
    let mut packets = vec![RayPacket::<N>::new(); rays.len() / N];
    for (i, ray) in rays.iter().enumerate() {
        packets[i / N].set(i % N, ray);
    }
    let active: Vec<u32> = packets
        .iter()
        .map(|_| (random.bits() | random.bits()) as u32)
        .collect();
    let mut blocked = vec![!0; packets.len()];
    scene.occluded_packets(&packets, &active, &mut blocked, coherence);
    for (p, rays) in rays.chunks(N).enumerate() {
        let single = rays
            .iter()
            .enumerate()
            .map(|(lane, r)| u32::from(scene.occluded(r)) << lane);
        let expected = single.sum::<u32>() & active[p];
        assert_eq!(
            blocked[p], expected,
            "packet {p} of {N}, active {:#x}",
            active[p]
        );
    }
    blocked.iter().map(|b| b.count_ones()).sum()
}

#[test]
fn packets_equal_singles_on_a_million_rays() {
    let Some(device) = device() else { return };
    let mut random = Random(1);
    let (positions, triangles) = soup(&mut random, 3000);
    let (opaque, masked) = triangles.split_at(1500);
    let rays: Vec<Ray> = (0..1 << 20).map(|_| ray(&mut random)).collect();
    let keep: Keep =
        Arc::new(|primitive, [u, v], ray| primitive % 3 != 0 && u + v < 0.7 && ray % 5 != 0);
    for robust in [false, true] {
        let mut builder = SceneBuilder::new(&device).robust(robust);
        builder.triangles(&positions, opaque).expect("a mesh");
        builder
            .masked_triangles(&positions, masked, keep.clone())
            .expect("a mesh");
        let scene = builder.commit().expect("a scene");
        let (narrow, wide) = rays.split_at(rays.len() / 2);
        let blocked = compare::<8>(&scene, narrow, Coherence::Incoherent)
            + compare::<16>(&scene, wide, Coherence::Incoherent)
            + compare::<8>(&scene, &wide[..1 << 17], Coherence::Coherent)
            + compare::<16>(&scene, &narrow[..1 << 17], Coherence::Coherent);
        println!("robust {robust}: {blocked} of the active lanes are blocked");
        assert!(blocked > 100_000, "{blocked} blocked lanes test nothing");
    }
}

#[test]
fn a_hit_test_is_told_the_ray_that_was_cast_also_inside_an_instance() {
    let Some(device) = device() else { return };
    let mut random = Random(5);
    let (positions, triangles) = soup(&mut random, 1000);
    let told = Arc::new(Mutex::new(HashSet::new()));
    let keep: Keep = {
        let told = Arc::clone(&told);
        Arc::new(move |_, _, ray| {
            told.lock().expect("no panic").insert(ray);
            false
        })
    };
    let mut inner = SceneBuilder::new(&device).robust(true);
    inner
        .masked_triangles(&positions, &triangles, keep)
        .expect("a mesh");
    let inner = inner.commit().expect("a scene");
    let mut outer = SceneBuilder::new(&device).robust(true);
    let moved = [
        [0.0, 2.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.0, 0.0],
    ];
    outer.instance(&inner, moved).expect("an instance");
    let outer = outer.commit().expect("a scene");
    for scene in [&inner, &outer] {
        let rays: Vec<Ray> = (0..1600).map(|_| ray(&mut random)).collect();
        let cast: HashSet<u32> = rays.iter().map(Ray::id).collect();
        assert!(cast.len() > 1590, "{} ids of 1600 rays", cast.len());
        let singly = |rays: &[Ray]| {
            for ray in rays {
                assert!(!scene.occluded(ray) && scene.closest(ray).is_none());
            }
        };
        let in_packets = |rays: &[Ray]| {
            for rays in rays.chunks(16) {
                let mut packet = RayPacket::<16>::new();
                rays.iter()
                    .enumerate()
                    .for_each(|(lane, ray)| packet.set(lane, ray));
                scene.occluded_packet(&packet, u32::MAX, Coherence::Incoherent);
            }
        };
        singly(&rays);
        let by_singles = std::mem::take(&mut *told.lock().expect("no panic"));
        in_packets(&rays);
        let by_packets = std::mem::take(&mut *told.lock().expect("no panic"));
        assert!(
            by_singles.len() > 100,
            "{} rays meet anything",
            by_singles.len()
        );
        assert!(by_singles.is_subset(&cast));
        assert_eq!(by_singles, by_packets);
    }
}

#[test]
fn closest_hits_and_occlusion_agree_and_no_hit_is_outside_the_interval() {
    let Some(device) = device() else { return };
    let mut random = Random(2);
    let mesh = soup(&mut random, 2000);
    for robust in [false, true] {
        let scene = scene(&device, robust, &mesh);
        for _ in 0..200_000 {
            let ray = ray(&mut random);
            let hit = scene.closest(&ray);
            assert_eq!(hit.is_some(), scene.occluded(&ray), "{ray:?}");
            if let Some(hit) = hit {
                assert!(ray.t_min < hit.t && hit.t <= ray.t_max, "{ray:?} {hit:?}");
            }
        }
    }
}
