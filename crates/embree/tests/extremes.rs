//! Debian builds Embree 3 with its assertions: whatever safe code passes must not reach one.

mod common;

use ambake_embree::{Coherence, Ray, RayPacket, Scene, SceneBuilder};
use common::{Random, device, soup};

/// A float of random bits: NaN, infinities and denormals among them; or one of few plain values.
fn wild(random: &mut Random) -> f32 {
    const PLAIN: [f32; 8] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::INFINITY,
        1.844e18,
        1.843e18,
        f32::NAN,
    ];
    let bits = random.bits();
    match bits % 3 {
        0 => f32::from_bits((bits >> 32) as u32),
        1 => PLAIN[(bits >> 32) as usize % PLAIN.len()],
        _ => random.signed(),
    }
}

fn wild_ray(random: &mut Random) -> Ray {
    Ray {
        origin: std::array::from_fn(|_| wild(random)),
        direction: std::array::from_fn(|_| wild(random)),
        t_min: wild(random),
        t_max: wild(random),
    }
}

fn trace_wild_rays(scene: &Scene, random: &mut Random, count: usize) {
    let mut narrow = RayPacket::<8>::new();
    let mut wide = RayPacket::<16>::new();
    for k in 0..count {
        let ray = wild_ray(random);
        narrow.set(k % 8, &ray);
        wide.set(k % 16, &ray);
        scene.occluded(&ray);
        scene.closest(&ray);
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            scene.occluded_packet(&narrow, random.bits() as u32, coherence);
            scene.occluded_packet(&wide, random.bits() as u32, coherence);
        }
    }
}

#[test]
fn rays_of_random_bits_only_hit_or_miss() {
    let Some(device) = device() else { return };
    let mut random = Random(11);
    let (positions, triangles) = soup(&mut random, 500);
    for robust in [false, true] {
        let mut builder = SceneBuilder::new(&device).robust(robust);
        builder.triangles(&positions, &triangles).expect("a mesh");
        let plain = builder.commit().expect("a scene");
        trace_wild_rays(&plain, &mut random, 20_000);
        let mut builder = SceneBuilder::new(&device).robust(robust);
        for scale in [1e-11_f32, 1e-6, 1.0, 1e6, 1e11] {
            let transform = [
                [0.0, scale, 0.0],
                [scale, 0.0, 0.0],
                [0.0, 0.0, -scale],
                [scale; 3],
            ];
            builder.instance(&plain, transform).expect("an instance");
        }
        let instanced = builder.commit().expect("a scene");
        trace_wild_rays(&instanced, &mut random, 20_000);
    }
}

#[test]
fn meshes_of_any_size_build() {
    let Some(device) = device() else { return };
    let mut random = Random(12);
    for robust in [false, true] {
        for compact in [false, true] {
            for scale in [0.0_f32, 1e-45, 1e-38, 1e-30, 1e-20, 1e10, 1e17, 1.6e18] {
                let (mut positions, triangles) = soup(&mut random, 300);
                positions.iter_mut().flatten().for_each(|x| *x *= scale);
                let mut builder = SceneBuilder::new(&device).robust(robust).compact(compact);
                builder.triangles(&positions, &triangles).expect("a mesh");
                let scene = builder.commit().expect("a scene");
                trace_wild_rays(&scene, &mut random, 500);
            }
        }
    }
}

#[test]
fn instances_of_any_size_build() {
    let Some(device) = device() else { return };
    let mut random = Random(13);
    let (positions, triangles) = soup(&mut random, 300);
    let mut builder = SceneBuilder::new(&device);
    builder.triangles(&positions, &triangles).expect("a mesh");
    let part = builder.commit().expect("a scene");
    let mut accepted = 0;
    for _ in 0..2_000 {
        let transform = std::array::from_fn(|_| {
            let scale = 10.0_f32.powf(20.0 * random.signed());
            random.point().map(|x| x * scale)
        });
        let mut builder = SceneBuilder::new(&device);
        if builder.instance(&part, transform).is_ok() {
            let scene = builder.commit().expect("a scene");
            trace_wild_rays(&scene, &mut random, 20);
            accepted += 1;
        }
    }
    println!("{accepted} of 2000 transforms accepted");
    assert!(accepted > 100, "{accepted}");
}
