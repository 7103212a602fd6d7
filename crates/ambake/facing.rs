//! Faces that are dark for they look the wrong way: into their object, while their backs are in the open.
//!
//! Of bodies that are closed and drawn from both sides the right side is baked anyway (`turned-over`). Loose pieces,
//! and what is drawn from one side alone, are baked as the file has them, and nobody but their author knows what was
//! meant.

use crate::job::Job;
use crate::shell::{POINTS, Stand, over, spread};
use atlas::SurfacePoint;
use glam::DVec3;
use rays::{RayBackend, World};
use report::WarningReport;
use std::collections::BTreeMap;

/// Of the rays to the front of such a face none leaves the scene, and so many parts of a hundred meet backs of its own
/// object; what lies hidden under another has that one's back before it. To its back so many leave.
const BACKS: usize = 50;
const OPEN: usize = 50;
/// The share of the points of an atlas from which they are told of.
const LEAST: f64 = 0.01;

/// The warning about them; `None` where a limit of distance lets light through what is closed.
pub(crate) fn faces_away(job: &Job) -> Option<WarningReport> {
    if job.options().max_distance.is_some() {
        return None;
    }
    let (world, backend, atlas) = (job.world(), job.backend(), job.atlas());
    let mut found: BTreeMap<u32, u32> = BTreeMap::new();
    for point in spread(world.scene(), atlas) {
        if looks_away(world, backend, &point) {
            *found.entry(point.instance).or_default() += 1;
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

/// True where a face looks into its own object and its back does not.
fn looks_away(world: &World, backend: &dyn RayBackend, point: &SurfacePoint) -> bool {
    let (instance, triangle) = (point.instance, point.triangle);
    let Some(stand) = Stand::at(world, point) else {
        return false;
    };
    let normal = stand.normal;
    let (mut cast, mut backs) = (0, 0);
    for direction in over(normal) {
        let Some(hit) = backend.closest(&stand.ray(normal, direction)) else {
            return false;
        };
        cast += 1;
        let is_back = world.face(hit.instance, hit.triangle).dot(direction) > 0.0;
        backs += usize::from(is_back && hit.instance == instance);
    }
    if 100 * backs < BACKS * cast || world.is_buried(instance, triangle, point.weights) {
        return false;
    }
    let leaves = |direction: &DVec3| !backend.occluded(&stand.ray(-normal, *direction));
    100 * over(-normal).filter(leaves).count() >= OPEN * cast
}
