//! Whether a point of a surface can be seen: by `--seen-from` from some places or within rooms, and not inside
//! of another body.

use crate::eyes::is_seen;
use crate::options::Options;
use crate::shell::Shell;
use ::bake::Buried;
use atlas::SurfacePoint;
use rays::{RayBackend, World};

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
