//! Finds what stands around everything and keeps the sky from it, such as a sky dome.

use crate::job::Job;
use crate::shell::over;
use atlas::ObjectName;
use glam::DVec3;
use rays::{Bounds, Ray, RayBackend, World};
use report::WarningReport;
use std::collections::BTreeSet;

/// A dome has at least this share of the scene's largest side.
const LARGE: f64 = 0.49;
/// What is in it may stand out of its box by this share of its side.
const NEAR: f64 = 0.001;
/// So many objects may be a dome, the largest ones.
const CANDIDATES: usize = 4;
/// So many of the objects in it are asked what they see, and so many faces of each.
const OBJECTS: usize = 64;
const FACES: u32 = 32;
/// Of the rays of faces that see it, or the sky, one in so many may leave it.
const LEAVING: u32 = 200;
/// One in so many meets it, and of these one in so many may meet something beyond it.
const MEETING: u32 = 10;
/// Of the faces in a closed body one in so many may lie in no solid.
const FREE: usize = 16;

/// The warning that names a sheet around most of a scene, which hides the sky from all that is in it. `None` where
/// light was asked for that needs no sky.
pub(crate) fn enclosed(job: &Job) -> Option<WarningReport> {
    if job.options().max_distance.is_some() || job.has_lamps() {
        return None;
    }
    let (world, backend) = (job.world(), job.backend());
    let (dome, message) = match sheet_around(world, backend) {
        Some(dome) => (
            dome,
            "what stands in it sees no sky; where it is a sky dome or a shell, `--no-cast NAME` lets the light \
             through it",
        ),
        None => (
            find(world, |dome, within| buries(world, dome, within))?,
            "what stands in a body that looks outward lies in a solid and gets no light; where the body is a sky dome \
             or a shell, `--no-cast NAME` lets the light through it",
        ),
    };
    Some(WarningReport {
        kind: "enclosed".into(),
        place: format!("object `{}`", dome.name),
        count: 1,
        message: message.into(),
    })
}

/// The instances of what stands around most of a scene and keeps the sky from it, such as a sky dome that blocks light;
/// none where nothing does. A picture of the scene is taken from within it, see [`render::Framing::fitted`].
pub fn surrounding(world: &World, backend: &dyn RayBackend) -> Vec<u32> {
    sheet_around(world, backend).map_or(Vec::new(), |dome| dome.instances)
}

fn sheet_around(world: &World, backend: &dyn RayBackend) -> Option<ObjectName> {
    find(world, |dome, within| {
        is_sheet_around(world, backend, dome, within)
    })
}

/// The largest object with most others in its box, of some of which something holds.
fn find(
    world: &World,
    holds_for: impl Fn(&ObjectName, &[&ObjectName]) -> bool,
) -> Option<ObjectName> {
    let mut objects = atlas::object_names(world.scene());
    let boxes: Vec<Option<Bounds>> = objects.iter().map(|of| bounds_of(world, of)).collect();
    let large = LARGE * side(world.bounds());
    let casts = |object: &ObjectName| object.instances.iter().any(|&i| world.casts(i));
    let mut candidates: Vec<(usize, Bounds)> = boxes
        .iter()
        .enumerate()
        .filter_map(|(k, of)| Some((k, (*of)?)))
        .filter(|(k, of)| side(*of) >= large && casts(&objects[*k]))
        .collect();
    candidates.sort_by(|a, b| side(b.1).total_cmp(&side(a.1)));
    candidates.truncate(CANDIDATES);
    let hides = |&(dome, around): &(usize, Bounds)| {
        let is_within = |k: &usize| *k != dome && boxes[*k].is_some_and(|of| holds(around, of));
        let within: Vec<usize> = (0..objects.len()).filter(is_within).collect();
        let step = within.len().div_ceil(OBJECTS).max(1);
        let some: Vec<&ObjectName> = within.iter().step_by(step).map(|&k| &objects[k]).collect();
        !within.is_empty()
            && 2 * within.len() >= objects.len() - 1
            && holds_for(&objects[dome], &some)
    };
    let (dome, _) = candidates.into_iter().find(hides)?;
    Some(objects.swap_remove(dome))
}

/// The box around an object.
fn bounds_of(world: &World, object: &ObjectName) -> Option<Bounds> {
    let boxes = object.instances.iter().filter_map(|&i| world.box_of(i));
    let both = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    both.map(|(min, max)| Bounds { min, max })
}

fn side(bounds: Bounds) -> f64 {
    (bounds.max - bounds.min).max_element()
}

fn holds(outer: Bounds, inner: Bounds) -> bool {
    let slack = NEAR * side(outer);
    let (min, max) = (inner.min + slack, inner.max - slack);
    outer.min.cmple(min).all() && outer.max.cmpge(max).all()
}

/// What became of rays.
#[derive(Default)]
struct Counts {
    cast: u32,
    /// They leave the scene.
    left: u32,
    /// They meet the sheet first.
    met: u32,
    /// And would meet something beyond it.
    beyond: u32,
}

/// True where next to no ray from faces of some objects leaves the scene, many meet a further one first, and nothing is
/// beyond it. Faces before which other things stand all around do not count.
fn is_sheet_around(
    world: &World,
    backend: &dyn RayBackend,
    sheet: &ObjectName,
    within: &[&ObjectName],
) -> bool {
    let mut sums = Counts::default();
    for (instance, triangle) in some_faces(world, within) {
        let of = from_face((world, backend), sheet, instance, triangle);
        if of.met + of.left > 0 {
            sums.cast += of.cast;
            sums.left += of.left;
            sums.met += of.met;
            sums.beyond += of.beyond;
        }
    }
    let Counts {
        cast,
        left,
        met,
        beyond,
    } = sums;
    met > 0 && left <= cast / LEAVING && met >= cast / MEETING && beyond <= met / MEETING
}

/// Faces of objects, an instance and a triangle each.
fn some_faces<'a>(
    world: &'a World,
    of: &'a [&ObjectName],
) -> impl Iterator<Item = (u32, u32)> + 'a {
    let instances = of.iter().flat_map(|object| &object.instances);
    instances.flat_map(|&instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        let step = count.div_ceil(FACES).max(1);
        (0..count)
            .step_by(step as usize)
            .map(move |triangle| (instance, triangle))
    })
}

/// True where nearly all of some objects lies in solids of another.
fn buries(world: &World, solid: &ObjectName, objects: &[&ObjectName]) -> bool {
    let solids = world.solids();
    let shell = [solid];
    let bodies = some_faces(world, &shell).filter_map(|face| solids.own(face.0, face.1));
    let bodies: BTreeSet<u32> = bodies.collect();
    let is_in = |&(instance, triangle): &(u32, u32)| {
        let middle = world.corners(instance, triangle).iter().sum::<DVec3>() / 3.0;
        let own = solids.own(instance, triangle);
        let mut bodies = bodies.iter();
        bodies.any(|&body| solids.depth(body, middle, own) > 0)
    };
    let all = some_faces(world, objects).count();
    let free = some_faces(world, objects)
        .filter(|face| !is_in(face))
        .count();
    !bodies.is_empty() && all > 0 && FREE * free <= all
}

/// What becomes of rays from the middle of a face; nothing of one that is buried, as the bottom of what stands on a
/// ground, which looks out below it.
fn from_face(
    (world, backend): (&World, &dyn RayBackend),
    sheet: &ObjectName,
    instance: u32,
    triangle: u32,
) -> Counts {
    let off = 1e-5 * world.bounds().diagonal();
    let ray = |origin: DVec3, direction: DVec3| Ray {
        origin: origin.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let mut counts = Counts::default();
    let Some(normal) = world.face(instance, triangle).try_normalize() else {
        return counts;
    };
    if world.is_buried(instance, triangle, [1.0 / 3.0; 3]) {
        return counts;
    }
    let middle = world.corners(instance, triangle).iter().sum::<DVec3>() / 3.0;
    let origin = middle + normal * off;
    for direction in over(normal) {
        counts.cast += 1;
        match backend.closest(&ray(origin, direction)) {
            None => counts.left += 1,
            Some(hit) if sheet.instances.contains(&hit.instance) => {
                let beyond = origin + direction * (f64::from(hit.t) + off);
                counts.met += 1;
                counts.beyond += u32::from(backend.occluded(&ray(beyond, direction)));
            }
            Some(_) => {}
        }
    }
    counts
}
