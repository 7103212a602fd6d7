//! Whether a point of a surface can be seen: by `--seen-from` from some places or within rooms, and not inside
//! of another body.

use crate::options::Options;
use crate::shell::Shell;
use ::bake::Buried;
use atlas::SurfacePoint;
use rays::{Ray, RayBackend, World};

/// What stops a ray this close before a point, in lengths of the way, is taken for the point itself: its own surface,
/// as 32-bit numbers place it.
const CLOSE: f32 = 1e-4;

/// Tells the layout what can be seen; `None` where all can.
pub(crate) fn oracle<'a>(
    options: &'a Options,
    world: &'a World,
    backend: &'a dyn RayBackend,
) -> Option<Box<atlas::Seen<'a>>> {
    let buries = options.buried == Buried::Drop && world.solids().count() > 0;
    let eyes = &options.seen_from[..];
    let within = options.seen_from_within;
    let shell = within.then(|| Shell::of(world, backend)).flatten();
    if !buries && eyes.is_empty() && shell.is_none() {
        return None;
    }
    let is_seen = move |point: &SurfacePoint| match &shell {
        Some(shell) => !shell.hides(point),
        None => eyes.is_empty() || is_seen(eyes, point, world, backend),
    };
    Some(Box::new(move |points| {
        let Some((first, others)) = points.split_first() else {
            return false;
        };
        let (instance, triangle) = (first.instance, first.triangle);
        let buries = buries && !world.keeps_buried(instance);
        // One point often tells.
        let is_open = !buries || !world.is_buried(instance, triangle, first.weights);
        if is_open && is_seen(first) {
            return true;
        }
        let mut burial = buries.then(|| world.burial(instance, triangle));
        let mut is_open = |point: &SurfacePoint| match &mut burial {
            Some(burial) => !burial.is_buried(point.weights),
            None => true,
        };
        others.iter().any(|point| is_open(point) && is_seen(point))
    }))
}

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
