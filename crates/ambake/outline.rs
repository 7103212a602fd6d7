//! Faces that nobody sees and that keep the light from others: an outline as toon shading draws it, a hair around an
//! object and turned to it, and sheets that look at what they lie on.

use crate::job::Job;
use crate::shell::{Look, is_back};
use atlas::ObjectName;
use glam::DVec3;
use rays::{Ray, RayBackend, World};
use report::WarningReport;
use std::collections::BTreeMap;

/// Such a face is no farther from what it looks at than this part of its object's longest side.
const HAIR: f64 = 1.0 / 32.0;
/// So many parts of a hundred of its rays meet that.
const MET: usize = 75;
/// So many parts of a hundred of an object's points look so.
const MOST: u32 = 75;
/// And so many of them at least.
const FEWEST: u32 = 4;

/// The warning about objects of such faces.
pub(crate) fn outlines(job: &Job, looks: &[Look]) -> Option<WarningReport> {
    let (world, backend) = (job.world(), job.backend());
    let single = looks.iter().filter(|look| {
        let instance = look.point.instance;
        world.casts(instance) && !world.is_double_sided(instance)
    });
    let mut counts: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    let mut before = BTreeMap::new();
    for look in single {
        let [all, blind] = counts.entry(look.point.instance).or_default();
        *all += 1;
        if let Some(other) = looked_at(world, backend, look) {
            *blind += 1;
            before.insert(look.point.instance, other);
        }
    }
    counts.retain(|_, [all, blind]| *blind >= FEWEST && 100 * *blind >= MOST * *all);
    let objects = atlas::object_names(world.scene());
    let object = |instance: &u32| -> Option<&ObjectName> {
        objects.iter().find(|of| of.instances.contains(instance))
    };
    let first = counts.keys().next()?;
    let (name, other) = (&object(first)?.name, &object(before.get(first)?)?.name);
    let cure = match name == other {
        true => "an outline for toon shading is to be left out of the file".to_owned(),
        false => format!(
            "`--no-cast {name} --exclude {name}` leaves it out, if it is an outline for toon shading"
        ),
    };
    Some(WarningReport {
        kind: "outlines".into(),
        place: format!("object `{name}`"),
        count: counts.len() as u64,
        message: format!(
            "faces that are drawn from one side look at object `{other}` from close by, so that nobody sees them, and \
             keep the light from it: {cure}, and a sheet that was to be seen is to be turned over"
        ),
    })
}

/// The instance of which a face sees the front, close by in nearly all directions, while its back does not look into a
/// body.
fn looked_at(world: &World, backend: &dyn RayBackend, look: &Look) -> Option<u32> {
    let own = look.point.instance;
    let (low, high) = world.box_of(own)?;
    let hair = HAIR * (high - low).max_element();
    let mut met: BTreeMap<u32, usize> = BTreeMap::new();
    for (way, hit) in look.hits() {
        let height = f64::from(hit.t) * way.dot(look.stand.normal);
        if hit.instance != own && height <= hair && !is_back(world, way, &hit) {
            *met.entry(hit.instance).or_default() += 1;
        }
    }
    let (other, count) = met.into_iter().max_by_key(|of| of.1)?;
    // Behind a face of a body is its inside, and that of its other parts.
    let is_free = |(way, ray): &(DVec3, Ray)| {
        let hit = backend.closest(ray);
        hit.is_none_or(|hit| !is_back(world, *way, &hit))
    };
    let free = look.behind().filter(is_free).count();
    let cast = look.ways.len();
    (100 * count >= MET * cast && 2 * free >= cast).then_some(other)
}
