//! Faces that nobody sees, because another face lies on them or they are inside of a body, between cubes side by side,
//! or in a cupboard that is shut.

use crate::job::Job;
use crate::shell::{Look, POINTS, is_back};
use crate::shut::is_in_cupboard;
use glam::DVec3;
use rays::{Ray, RayBackend, World};
use report::WarningReport;

/// A face is covered where so many of a hundred rays from it meet what lies on it.
const COVERED: usize = 75;
/// What lies on a face is no farther above it than this part of its edge, the root of its area.
const GAP: f64 = 1.0 / 256.0;
/// The share of the texels from which they are told of.
const LEAST: f64 = 0.2;

/// The warning about their texels, where `--seen-from` did not ask for what is seen.
pub(crate) fn hidden_faces(job: &Job, looks: &[Look]) -> Option<WarningReport> {
    let options = job.options();
    if options.seen_from_within || !options.seen_from.is_empty() {
        return None;
    }
    let (world, backend, atlas) = (job.world(), job.backend(), job.atlas());
    let (mut hidden, mut shut, mut open, mut lit) = (0, 0, 0, 0);
    for look in looks {
        if is_hidden(world, backend, look) {
            hidden += 1;
        } else if is_in_cupboard(world, backend, &look.point) {
            shut += 1;
        } else {
            open += 1;
            lit += u32::from(sees_sky(look));
        }
    }
    // Where hardly anything else is, or that is dark too, people look at what is in there.
    let has_light = f64::from(open) >= 0.5 * LEAST * f64::from(POINTS) && 2 * lit > open;
    hidden += if has_light { shut } else { 0 };
    let share = f64::from(hidden) / f64::from(POINTS);
    let cure = match atlas.source.is_packed() {
        true => {
            "; `--seen-from 'X,Y,Z;X,Y,Z'`, with places all around from which one looks, gives each chart that none of \
             them sees one texel, and taking these faces out of the scene ends this line"
        }
        false => "; taking these faces out of the scene leaves their texels to others",
    };
    (share >= LEAST).then(|| WarningReport {
        kind: "hidden-faces".into(),
        place: "scene".into(),
        count: (share * atlas.audit.texels as f64) as u64,
        message: format!(
            "{:.0} % of the texels lie on faces that nobody sees, because others lie on them or they are inside of a \
             body or of a shut space that is no room{cure}",
            100.0 * share
        ),
    })
}

/// True where an eighth or more of the ways from a point leave the scene.
fn sees_sky(look: &Look) -> bool {
    8 * (look.ways.len() - look.hits().count()) >= look.ways.len()
}

/// True where a point of a surface is buried or covered.
pub(crate) fn is_hidden(world: &World, backend: &dyn RayBackend, look: &Look) -> bool {
    let point = &look.point;
    let is_dropped = !world.keeps_buried(point.instance)
        && world.is_buried(point.instance, point.triangle, point.weights);
    is_dropped || is_covered(world, backend, look)
}

/// True where most rays from a point meet something close above it, or, where a face lies on it that looks back, the
/// inside of the body behind that.
fn is_covered(world: &World, backend: &dyn RayBackend, look: &Look) -> bool {
    let (point, stand) = (&look.point, &look.stand);
    let edge = (0.5 * world.face(point.instance, point.triangle).length()).sqrt();
    let (mut near, mut backs) = (0, 0);
    for (way, hit) in look.hits() {
        let height = f64::from(hit.t) * way.dot(stand.normal);
        near += usize::from(height <= GAP * edge);
        // Of two faces back to back a ray meets one, and one that comes back the other.
        let beyond = stand.place + way * (f64::from(hit.t) + 2.0 * stand.off);
        let back = Ray {
            origin: beyond.as_vec3().to_array(),
            direction: (-way).as_vec3().to_array(),
            t_min: 0.0,
            t_max: 4.0 * stand.off as f32,
        };
        let other = || backend.closest(&back);
        backs += usize::from(
            is_back(world, way, &hit) || other().is_some_and(|hit| is_back(world, way, &hit)),
        );
    }
    let covered = COVERED * look.ways.len();
    100 * near >= covered || 100 * backs >= covered && touches(world, backend, look)
}

/// True where a face that looks back lies on the point itself.
fn touches(world: &World, backend: &dyn RayBackend, look: &Look) -> bool {
    let (point, stand) = (&look.point, &look.stand);
    let looks_back = |side: DVec3| {
        let mut ray = Ray {
            t_max: 2.0 * stand.off as f32,
            ..stand.ray(side, -side)
        };
        while let Some(hit) = backend.closest(&ray) {
            let is_own = (hit.instance, hit.triangle) == (point.instance, point.triangle);
            if !is_own && is_back(world, -stand.normal, &hit) {
                return true;
            }
            ray.t_min = hit.t;
        }
        false
    };
    // Of two surfaces at one distance a ray meets one.
    looks_back(stand.normal) || looks_back(-stand.normal)
}
