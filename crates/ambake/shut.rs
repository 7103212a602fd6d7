//! Shut spaces, into which no light gets: the inside of a cupboard.

use crate::shell::Stand;
use atlas::SurfacePoint;
use glam::DVec3;
use rays::{Ray, RayBackend, World};
use std::f64::consts::TAU;

/// Walks of light from a point, from surface to surface, and the most surfaces on each. A space is open where so many
/// of the walks leave the scene: fewer do so through the cracks between boards.
const WALKS: u32 = 8;
const STEPS: u32 = 64;
const OPEN: u32 = 2;
/// A shut space is no room where it is no longer than this part of the scene.
const SMALL: f64 = 0.5;

/// True where a point looks into a shut space that is no room of its scene: nobody is in there.
pub(crate) fn is_in_cupboard(
    world: &World,
    backend: &dyn RayBackend,
    point: &SurfacePoint,
) -> bool {
    let Some(stand) = Stand::at(world, point) else {
        return false;
    };
    let longest = SMALL * world.bounds().diagonal();
    let (mut low, mut high, mut left) = (stand.place, stand.place, 0);
    for walk in 0..WALKS {
        let (mut place, mut normal) = (stand.place, stand.normal);
        for step in 0..STEPS {
            let direction = scattered(normal, walk * STEPS + step);
            let ray = Ray {
                origin: (place + stand.off * normal).as_vec3().to_array(),
                direction: direction.as_vec3().to_array(),
                t_min: 0.0,
                t_max: f32::INFINITY,
            };
            let Some(hit) = backend.closest(&ray) else {
                left += 1;
                break;
            };
            let face = world.face(hit.instance, hit.triangle).normalize_or_zero();
            normal = if face.dot(direction) > 0.0 {
                -face
            } else {
                face
            };
            place = DVec3::from(ray.origin.map(f64::from)) + direction * f64::from(hit.t);
            (low, high) = (low.min(place), high.max(place));
            if (high - low).length() > longest {
                return false;
            }
        }
        if left >= OPEN {
            return false;
        }
    }
    true
}

/// The k-th direction about a unit normal of those that a matt surface scatters light to, evenly spread.
fn scattered(normal: DVec3, k: u32) -> DVec3 {
    let [u, v] = [0.754_877_666, 0.569_840_291].map(|turn| (f64::from(k + 1) * turn).fract());
    let (across, along) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    normal * (1.0 - u).sqrt() + (across * cos + along * sin) * u.sqrt()
}
