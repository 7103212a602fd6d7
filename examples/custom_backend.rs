//! Brings a ray backend of one's own: the plainest there is, which tries every triangle. Any engine's ray tracer fits
//! in its place.
//!
//! Run it with `cargo run --release --example custom_backend`.

#![allow(clippy::print_stdout, reason = "an example shows what it did")]

use ambake::rays::{Coherence, Ray, RayBackend, RayPacket, SurfaceHit, World};
use ambake::{Backend, Bake, Layer};
use glam::DVec3;

/// The triangles of a world in one list.
struct EveryTriangle {
    triangles: Vec<Triangle>,
}

struct Triangle {
    corners: [DVec3; 3],
    instance: u32,
    number: u32,
}

impl EveryTriangle {
    fn new(world: &World) -> Self {
        let mut triangles = Vec::new();
        for instance in 0..world.parts.len() as u32 {
            let count = world.part(instance).1.triangles().len() as u32;
            triangles.extend((0..count).map(|number| Triangle {
                corners: world.corners(instance, number),
                instance,
                number,
            }));
        }
        Self { triangles }
    }
}

impl RayBackend for EveryTriangle {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, _: Coherence) -> u32 {
        (0..16)
            .filter(|lane| active >> lane & 1 == 1)
            .filter(|&lane| self.occluded(&packet.get(lane)))
            .fold(0, |mask, lane| mask | 1 << lane)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.triangles
            .iter()
            .any(|triangle| meet(ray, triangle).is_some())
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        let hits = self
            .triangles
            .iter()
            .filter_map(|triangle| meet(ray, triangle));
        hits.min_by(|a, b| a.t.total_cmp(&b.t))
    }

    fn name(&self) -> &'static str {
        "every-triangle"
    }

    fn describe(&self) -> String {
        format!("every one of {} triangles", self.triangles.len())
    }

    fn memory_bytes(&self) -> u64 {
        size_of_val(self.triangles.as_slice()) as u64
    }
}

/// T. Möller, B. Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997, from both sides.
fn meet(ray: &Ray, triangle: &Triangle) -> Option<SurfaceHit> {
    let [a, b, c] = triangle.corners;
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let q = s.cross(ab);
    let [u, v, t] = [s.dot(p), direction.dot(q), ac.dot(q)].map(|x| x / determinant);
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    let within = t > f64::from(ray.t_min.max(0.0)) && t <= f64::from(ray.t_max);
    (inside && within).then_some(SurfaceHit {
        t: t as f32,
        instance: triangle.instance,
        triangle: triangle.number,
        barycentric: [u as f32, v as f32],
        front: determinant > 0.0,
    })
}

fn main() -> Result<(), ambake::Error> {
    let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
    let bake = Bake::new(&scene).size(64).rays(64);
    let own = bake
        .clone()
        .with_backend(|world| Ok(Box::new(EveryTriangle::new(world))))
        .run(&())?;
    let obvhs = bake.backend(Backend::Obvhs).run(&())?;
    println!("{}", own.job().backend().describe());

    let [a, b] = [&own, &obvhs].map(|baked| baked.page(0).layer(Layer::Diffuse));
    let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
    println!("{differ} of {} texels differ from obvhs", a.len());
    assert_eq!(differ, 0, "both backends see the same triangles");
    Ok(())
}
