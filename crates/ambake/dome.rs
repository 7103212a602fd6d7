//! Finds what stands around everything and keeps the sky from it, such as a sky dome.

use crate::job::Job;
use crate::points::points_on;
use crate::shell::{Stand, over};
use crate::swallowed::{Swallowed, swallowed};
use atlas::{ObjectName, SurfacePoint};
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
/// So many of the objects in it are asked what they see, at so many points of each, and so many faces of each instance
/// whether they lie in a solid.
const OBJECTS: usize = 64;
const POINTS: u32 = 64;
const FACES: u32 = 32;
/// Of the rays of points that see it, or the sky over the horizon, one in so many may leave it upward. What leaves
/// downward does not count: a dome needs no ground.
const LEAVING: u32 = 200;
/// Of those that go upward one in so many meets it, and of these one in so many may meet something beyond it.
const MEETING: u32 = 10;
/// Of the faces in a closed body one in so many may lie in no solid.
const FREE: usize = 16;

/// The warning that names a sheet around most of a scene, which hides the sky from all that is in it, or a solid that
/// holds something large. What is around most of a scene does not count where light was asked for that needs no sky.
pub(crate) fn enclosed(job: &Job) -> Option<WarningReport> {
    let (world, backend) = (job.world(), job.backend());
    let up = job.options().up.direction().into();
    let needs_sky = job.options().max_distance.is_none() && !job.has_lamps();
    let sheet = || {
        let dome = sheet_around(world, backend, up)?;
        let message = "what stands in it sees next to no sky over the horizon; where it is a sky dome or a shell, \
                       `--no-cast NAME` lets the light through it";
        Some((dome.name, message.to_owned()))
    };
    let solid = || {
        let dome = find(world, |dome, within| buries(world, dome, within))?;
        let message = "what stands in a body that looks outward lies in a solid and gets no light; where the body is a \
                       sky dome or a shell, `--no-cast NAME` lets the light through it";
        Some((dome.name, message.to_owned()))
    };
    let around = needs_sky.then(|| sheet().or_else(solid)).flatten();
    let (name, message) = around.or_else(|| holder(job))?;
    Some(WarningReport {
        kind: "enclosed".into(),
        place: format!("object `{name}`"),
        count: 1,
        message,
    })
}

/// The name of an object in which others lie whole, and the warning about it.
fn holder(job: &Job) -> Option<(String, String)> {
    let takes_texels = |of: &ObjectName| {
        let placements = &job.atlas().placements;
        let mut instances = of.instances.iter();
        instances.any(|&instance| placements[instance as usize].is_somewhere())
    };
    let Swallowed {
        holder,
        largest,
        others,
    } = swallowed(job.world(), takes_texels)?;
    let more = match others {
        0 => String::new(),
        _ => format!(" and of {others} more"),
    };
    let message = format!(
        "this solid holds nearly all of object `{largest}`{more}: no light gets there, and nobody sees it; where the \
         solid is not to be drawn, as a body for collisions, `--no-cast {holder} --exclude {holder}` leaves it out, \
         and elsewhere `--exclude {largest}` saves texels"
    );
    Some((holder, message))
}

/// The instances of what stands around most of a scene and keeps the sky from it, such as a sky dome that blocks light;
/// none where nothing does. A picture of the scene is taken from within it, see [`render::Framing::fitted`].
///
/// * `up`: of any length above 0. The sky below the horizon does not count.
pub fn surrounding(world: &World, backend: &dyn RayBackend, up: DVec3) -> Vec<u32> {
    sheet_around(world, backend, up).map_or(Vec::new(), |dome| dome.instances)
}

fn sheet_around(world: &World, backend: &dyn RayBackend, up: DVec3) -> Option<ObjectName> {
    find(world, |dome, within| {
        is_sheet_around((world, backend), up, dome, within)
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
    /// They go upward.
    upward: u32,
    /// They leave the scene upward.
    left: u32,
    /// They meet the sheet first.
    met: u32,
    /// And would meet something beyond it.
    beyond: u32,
}

/// True where next to no ray from some objects leaves the scene upward, many meet a further one first, and nothing is
/// beyond it. Points before which other things stand all around do not count.
fn is_sheet_around(
    (world, backend): (&World, &dyn RayBackend),
    up: DVec3,
    sheet: &ObjectName,
    within: &[&ObjectName],
) -> bool {
    let mut sums = Counts::default();
    let points = within.iter().flat_map(|of| points_on(world, of, POINTS));
    for point in points {
        let of = from_point((world, backend), up, sheet, &point);
        if of.met + of.left > 0 {
            sums.cast += of.cast;
            sums.upward += of.upward;
            sums.left += of.left;
            sums.met += of.met;
            sums.beyond += of.beyond;
        }
    }
    let Counts {
        cast,
        upward,
        left,
        met,
        beyond,
    } = sums;
    met > 0 && left <= cast / LEAVING && met >= upward / MEETING && beyond <= met / MEETING
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

/// What becomes of rays from a point of a surface; nothing of one that is buried, as the bottom of what stands on a
/// ground, which looks out below it.
fn from_point(
    (world, backend): (&World, &dyn RayBackend),
    up: DVec3,
    sheet: &ObjectName,
    point: &SurfacePoint,
) -> Counts {
    let mut counts = Counts::default();
    let Some(stand) = Stand::at(world, point) else {
        return counts;
    };
    if world.is_buried(point.instance, point.triangle, point.weights) {
        return counts;
    }
    for direction in over(stand.normal) {
        let is_upward = u32::from(direction.dot(up) > 0.0);
        counts.cast += 1;
        counts.upward += is_upward;
        let ray = stand.ray(stand.normal, direction);
        match backend.closest(&ray) {
            None => counts.left += is_upward,
            Some(hit) if sheet.instances.contains(&hit.instance) => {
                let beyond = Ray {
                    t_min: hit.t + stand.off as f32,
                    ..ray
                };
                counts.met += 1;
                counts.beyond += u32::from(backend.occluded(&beyond));
            }
            Some(_) => {}
        }
    }
    counts
}
