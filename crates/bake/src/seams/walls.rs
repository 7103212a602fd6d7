//! What stands on a seam: a wall on the joint of two panels of a floor. Light may end there, and nobody sees both sides at once.

use super::border::Border;
use glam::{DVec3, Vec3};
use rays::{NUDGE, Ray, RayBackend, World};

/// How far to either side one looks for what stands there, in texels.
const REACH: f64 = 0.5;
/// How high above the surface, as a share of that: over what lies on it, below what it is a part of.
const HEIGHT: f64 = 0.05;
/// How far beside the seam the look begins, as a share of that, for a wall may stand exactly on it. Over a ridge of two slopes of δ this
/// sinks twice the sine of δ times as deep, which [`HEIGHT`] covers.
const BESIDE: f64 = 0.02;
/// The cosine of the angle between a surface and what stands on it, at most.
const UPRIGHT: f64 = 0.5;

/// A scene in which to look for walls.
pub(super) struct Walls<'a> {
    pub world: &'a World,
    pub backend: &'a dyn RayBackend,
    /// The chart of each triangle, mesh by mesh.
    pub charts: &'a [Vec<u32>],
}

impl Walls<'_> {
    /// True where something parts the two sides of a seam, at these shares of the ways of its borders.
    pub fn part(&self, sides: [&Border; 2], [at, _]: [f64; 2]) -> bool {
        let (place, normal) = (sides[0].at(at), sides[0].normal_at(at));
        let reach = sides.map(|side| REACH * side.depth);
        let least = reach[0].min(reach[1]);
        if BESIDE * least < NUDGE * place.abs().max_element() {
            return false;
        }
        let above = place + normal * (HEIGHT * least);
        let start = above + sides[0].inward * (BESIDE * least);
        let mut ends = sides.into_iter().zip(reach);
        ends.any(|(side, reach)| {
            let end = above + side.inward * reach;
            self.stands(sides, normal, start, end)
        })
    }

    /// True where a straight way meets something that stands on the surface and is of neither chart.
    fn stands(&self, sides: [&Border; 2], normal: DVec3, start: DVec3, end: DVec3) -> bool {
        let [origin, direction] = [start, end - start].map(|v| v.as_vec3());
        let ray = Ray {
            origin: origin.to_array(),
            direction: Vec3::to_array(&direction),
            t_min: 0.0,
            t_max: 1.0,
        };
        let Some(hit) = self.backend.closest(&ray) else {
            return false;
        };
        let mesh = self.world.scene().instances[hit.instance as usize].mesh;
        let chart = self.charts[mesh as usize][hit.triangle as usize];
        let [a, b, c] = self.world.corners(hit.instance, hit.triangle);
        let face = (b - a).cross(c - a).normalize_or_zero();
        let is_other = sides.iter().all(|side| side.chart != [hit.instance, chart]);
        is_other && face.dot(normal).abs() <= UPRIGHT
    }
}
