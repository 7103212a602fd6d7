//! Faces that are dark for they look the wrong way: into their object, while their backs are in the open.
//!
//! Of bodies that are closed and drawn from both sides the right side is baked anyway (`turned-over`). Loose pieces,
//! and what is drawn from one side alone, are baked as the file has them, and nobody but their author knows what was
//! meant.

use crate::job::Job;
use crate::shell::{Look, POINTS, is_back};
use glam::DVec3;
use rays::{RayBackend, SurfaceHit, World};
use report::WarningReport;
use std::collections::BTreeMap;

/// Of the rays to the front of such a face none leaves the scene, and so many parts of a hundred meet backs of its own
/// object; what lies hidden under another has that one's back before it. To its back so many leave.
const BACKS: usize = 50;
const OPEN: usize = 50;
/// The share of the points of an atlas from which they are told of.
const LEAST: f64 = 0.01;

/// The side of a sheet that is baked is dark where it sees at most this share of the sky, weighed by the cosine, and
/// its other side is open from this share.
const DARK: f64 = 0.25;
const LIGHT: f64 = 0.5;
/// What a dark side looks at is close where half of it is within this part of the scene's diagonal.
const CLOSE: f64 = 1.0 / 16.0;
/// What looks up so steeply, by the sine, is a floor in a shell that looks outward: nobody looks at its bottom.
const LEVEL: f64 = 0.5;
/// An object is told of where so much of it is so, a share of its texels.
const NOTABLE: f64 = 0.125;
/// And so many of the points that stand for it.
const FEWEST: u32 = 4;

/// The warning about them; `None` where a limit of distance lets light through what is closed.
pub(crate) fn faces_away(job: &Job, looks: &[Look]) -> Option<WarningReport> {
    if job.options().max_distance.is_some() {
        return None;
    }
    let (world, backend, atlas) = (job.world(), job.backend(), job.atlas());
    let mut found: BTreeMap<u32, u32> = BTreeMap::new();
    for look in looks {
        if looks_away(world, backend, look) {
            *found.entry(look.point.instance).or_default() += 1;
        }
    }
    let share = f64::from(found.values().sum::<u32>()) / f64::from(POINTS);
    let (most, _) = found
        .iter()
        .max_by_key(|(instance, count)| (**count, u32::MAX - **instance))?;
    (share >= LEAST).then(|| WarningReport {
        kind: "faces-away".into(),
        place: format!("object `{}`", world.scene().instances[*most as usize].name),
        count: (share * atlas.audit.texels as f64) as u64,
        message: format!(
            "{:.0} % of the texels lie on faces that look into their own object and are dark, while their backs are in \
             the open: turn these faces over in the scene, unless nobody sees their backs",
            (100.0 * share).max(1.0)
        ),
    })
}

/// The warnings about objects that are drawn from both sides, and of which a notable part is baked dark while its other
/// side is light: sheets that are wound the wrong way, such as a roof that looks into its house. None of rooms, whose
/// insides are looked at, and none of cut-out leaves, which look anywhere.
pub(crate) fn dark_sides(job: &Job, looks: &[Look]) -> Vec<WarningReport> {
    let (world, backend, atlas) = (job.world(), job.backend(), job.atlas());
    if job.options().max_distance.is_some() {
        return Vec::new();
    }
    let up = job.options().up.direction().into();
    let mut outward = 0;
    let mut counts: BTreeMap<&str, [u32; 3]> = BTreeMap::new();
    for look in looks {
        let name = &world.scene().instances[look.point.instance as usize].name;
        let [all, within, before] = counts.entry(name).or_default();
        *all += 1;
        match side(world, backend, up, look) {
            Side::BeforeBacks => *within += 1,
            Side::BeforeFronts => *before += 1,
            Side::Outward => outward += 1,
            Side::Other => {}
        }
    }
    // Fronts close by are the body under a cloak, or the other side of a hollow wing. In a level of rooms they are the
    // rooms: hardly anything there looks outward alone.
    let fronts: u32 = counts.values().map(|of| of[2]).sum();
    let are_rooms = outward < fronts;
    let found = counts
        .into_iter()
        .filter_map(|(name, [all, within, before])| {
            let dark = if are_rooms { within } else { within + before };
            let is_told = dark >= FEWEST && f64::from(dark) >= NOTABLE * f64::from(all);
            is_told.then_some((name, dark))
        });
    let found: Vec<(&str, u32)> = found.collect();
    let share = |dark: u32| f64::from(dark) / f64::from(POINTS);
    let whole = share(found.iter().map(|of| of.1).sum());
    let message = format!(
        "{:.0} % of the texels show the dark side of faces that are drawn from both sides: the side of their winding \
         is baked, which sees little of the sky, while their other side is in the open; turn these faces over in the \
         scene (flip their normals), unless one looks at them from within",
        (100.0 * whole).max(1.0)
    );
    let report = |&(name, dark): &(&str, u32)| WarningReport {
        kind: "dark-sides".into(),
        place: format!("object `{name}`"),
        count: (share(dark) * atlas.audit.texels as f64) as u64,
        message: message.clone(),
    };
    found.iter().map(report).collect()
}

/// What the two sides of a point look at.
enum Side {
    /// The baked side is dark and the other in the open; most rays from the dark one meet backs.
    BeforeBacks,
    /// The same before fronts that are close.
    BeforeFronts,
    /// The baked side is in the open and the other is dark.
    Outward,
    /// Anything else.
    Other,
}

/// What the sides of a point of a surface look at. Anything else is what is drawn from one side, cut out by a texture,
/// buried, a floor, or found by [`faces_away`].
fn side(world: &World, backend: &dyn RayBackend, up: DVec3, look: &Look) -> Side {
    let scene = world.scene();
    let point = &look.point;
    let mesh = &scene.meshes[scene.instances[point.instance as usize].mesh as usize];
    let normal = look.stand.normal;
    let cosine = |way: &DVec3| way.dot(normal);
    let all: f64 = look.ways.iter().map(|(way, _)| cosine(way)).sum();
    let free = look.ways.iter().filter(|(_, hit)| hit.is_none());
    let seen: f64 = free.map(|(way, _)| cosine(way)).sum();
    let other = || -> f64 {
        let free = look.behind().filter(|(_, ray)| !backend.occluded(ray));
        free.map(|(way, _)| -cosine(&way)).sum()
    };
    if seen >= LIGHT * all && other() <= DARK * all {
        return Side::Outward;
    }
    if seen > DARK * all
        || !scene.materials[mesh.material as usize].is_opaque()
        || !world.is_double_sided(point.instance)
        || other() < LIGHT * all
        || world.is_buried(point.instance, point.triangle, point.weights)
        || looks_away(world, backend, look)
    {
        return Side::Other;
    }
    let backs = look.hits().filter(|(way, hit)| is_back(world, *way, hit));
    let backs = backs.count();
    let mut lengths: Vec<f64> = look.hits().map(|(_, hit)| f64::from(hit.t)).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    let is_close = lengths[lengths.len() / 2] <= CLOSE * world.bounds().diagonal();
    let is_floor = normal.dot(up) > LEVEL * up.length();
    match 2 * backs >= lengths.len() {
        true if is_floor => Side::Other,
        true => Side::BeforeBacks,
        false if is_close => Side::BeforeFronts,
        false => Side::Other,
    }
}

/// True where a face looks into its own object and its back does not.
fn looks_away(world: &World, backend: &dyn RayBackend, look: &Look) -> bool {
    let point = &look.point;
    let own =
        |of: &(DVec3, SurfaceHit)| is_back(world, of.0, &of.1) && of.1.instance == point.instance;
    if look.hits().count() < look.ways.len()
        || 100 * look.hits().filter(own).count() < BACKS * look.ways.len()
        || world.is_buried(point.instance, point.triangle, point.weights)
    {
        return false;
    }
    let leaving = look.behind().filter(|(_, ray)| !backend.occluded(ray));
    100 * leaving.count() >= OPEN * look.ways.len()
}
