//! Whether eyes at some places see a point of a surface.

use atlas::SurfacePoint;
use rays::{Ray, RayBackend, World};

/// What stops a ray this close before a point, in lengths of the way, is taken for the point itself: its own surface,
/// as 32-bit numbers place it.
const CLOSE: f32 = 1e-4;

/// True where nothing stands between the point and one of the eyes, and the eye is on a side that can be seen: the
/// front, or any side of a double-sided surface.
pub(crate) fn is_seen(
    eyes: &[[f64; 3]],
    point: &SurfacePoint,
    world: &World,
    backend: &dyn RayBackend,
) -> bool {
    let corners = world.corners(point.instance, point.triangle);
    let [a, b, c] = point.weights;
    let target = (corners[0] * a + corners[1] * b + corners[2] * c).to_array();
    let origin = world.origin().to_array();
    eyes.iter().any(|eye| {
        let eye: [f64; 3] = std::array::from_fn(|axis| eye[axis] - origin[axis]);
        let ray = Ray {
            origin: eye.map(|x| x as f32),
            direction: [0, 1, 2].map(|axis| (target[axis] - eye[axis]) as f32),
            t_min: 0.0,
            t_max: 1.0 + CLOSE,
        };
        backend.closest(&ray).is_some_and(|hit| {
            hit.t >= 1.0 - CLOSE && (hit.front || world.is_double_sided(hit.instance))
        })
    })
}
