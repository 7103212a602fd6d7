//! Faces that nobody sees, because another face lies on them or they are inside of a body: between cubes side by side.

use crate::job::Job;
use crate::shell::{POINTS, Stand, over, spread};
use atlas::SurfacePoint;
use glam::DVec3;
use rays::{Ray, RayBackend, SurfaceHit, World};
use report::WarningReport;

/// A face is covered where so many of a hundred rays from it meet what lies on it.
const COVERED: usize = 75;
/// What lies on a face is no farther above it than this part of its edge, the root of its area.
const GAP: f64 = 1.0 / 256.0;
/// The share of the texels from which they are told of.
const LEAST: f64 = 0.2;

/// The warning about their texels, where `--seen-from` did not ask for what is seen.
pub(crate) fn hidden_faces(job: &Job) -> Option<WarningReport> {
    let options = job.options();
    if options.seen_from_within || !options.seen_from.is_empty() {
        return None;
    }
    let (world, backend, atlas) = (job.world(), job.backend(), job.atlas());
    let is_hidden = |point: &&SurfacePoint| is_hidden(world, backend, point);
    let points = spread(world.scene(), atlas);
    let share = points.iter().filter(is_hidden).count() as f64 / f64::from(POINTS);
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
             body{cure}",
            100.0 * share
        ),
    })
}

/// True where a point of a surface is buried or covered.
pub(crate) fn is_hidden(world: &World, backend: &dyn RayBackend, point: &SurfacePoint) -> bool {
    let is_dropped = !world.keeps_buried(point.instance)
        && world.is_buried(point.instance, point.triangle, point.weights);
    is_dropped || is_covered(world, backend, point)
}

/// True where most rays from a point meet something close above it, or, where a face lies on it that looks back, the
/// inside of the body behind that.
fn is_covered(world: &World, backend: &dyn RayBackend, point: &SurfacePoint) -> bool {
    let Some(stand) = Stand::at(world, point) else {
        return false;
    };
    let normal = stand.normal;
    let edge = (0.5 * world.face(point.instance, point.triangle).length()).sqrt();
    let (mut cast, mut near, mut backs) = (0, 0, 0);
    for direction in over(normal) {
        cast += 1;
        let Some(hit) = backend.closest(&stand.ray(normal, direction)) else {
            continue;
        };
        let height = f64::from(hit.t) * direction.dot(normal);
        near += usize::from(height <= GAP * edge);
        // Of two faces back to back a ray meets one, and one that comes back the other.
        let is_back = |hit: SurfaceHit| world.face(hit.instance, hit.triangle).dot(direction) > 0.0;
        let beyond = stand.place + direction * (f64::from(hit.t) + 2.0 * stand.off);
        let back = Ray {
            origin: beyond.as_vec3().to_array(),
            direction: (-direction).as_vec3().to_array(),
            t_min: 0.0,
            t_max: 4.0 * stand.off as f32,
        };
        backs += usize::from(is_back(hit) || backend.closest(&back).is_some_and(is_back));
    }
    100 * near >= COVERED * cast
        || 100 * backs >= COVERED * cast && touches(world, backend, &stand, point)
}

/// True where a face that looks back lies on the point itself.
fn touches(world: &World, backend: &dyn RayBackend, stand: &Stand, point: &SurfacePoint) -> bool {
    let looks_back = |side: DVec3| {
        let mut ray = Ray {
            t_max: 2.0 * stand.off as f32,
            ..stand.ray(side, -side)
        };
        while let Some(hit) = backend.closest(&ray) {
            let is_own = (hit.instance, hit.triangle) == (point.instance, point.triangle);
            if !is_own && world.face(hit.instance, hit.triangle).dot(stand.normal) < 0.0 {
                return true;
            }
            ray.t_min = hit.t;
        }
        false
    };
    // Of two surfaces at one distance a ray meets one.
    looks_back(stand.normal) || looks_back(-stand.normal)
}
