//! What stands on a seam: a wall on the joint of two panels of a floor, or a ramp. Light may end there, and nobody sees
//! both sides at once.
//!
//! It is found from the triangles alone, in 64 bits. Rays would do, but where two surfaces tie for the closest, ray
//! libraries name different ones, and a seam that goes or stays moves all texels along it.

use super::border::Border;
use super::pair::{Pair, Walls};
use glam::DVec3;
use rayon::prelude::*;
use rays::{Boxes, NUDGE, World, around};

/// How far to either side one looks for what stands there, in texels.
const REACH: f64 = 0.5;
/// How high above the surface, as a share of that: over what lies on it, below what it is a part of.
const HEIGHT: f64 = 0.05;
/// How far beyond the seam the look begins, as a share of that, for a wall may stand exactly on it, or a rounding
/// beside it.
const BESIDE: f64 = 0.02;
/// The cosine of the angle between a surface and what stands on it, at most: a ramp of 15 degrees. What is flatter lies
/// on it or is a part of it.
const LYING: f64 = 0.966;

/// What stands on each of these pairs. `charts` has the chart of each triangle, mesh by mesh. Surfaces with holes are
/// left out: light goes through them.
pub(super) fn walls(
    world: &World,
    charts: &[Vec<u32>],
    borders: &[Border],
    pairs: &[Pair],
) -> Vec<Walls> {
    let strips: Vec<Strip> = (pairs.iter().enumerate())
        .flat_map(|(pair, of)| Strip::of(pair as u32, of, borders))
        .collect();
    let numbered = (0..).zip(&strips);
    let boxes = Boxes::of(numbered.map(|(number, strip)| {
        let (low, high) = strip.limits();
        (number, low, high)
    }));
    let scene = world.scene();
    let instances = scene.instances.par_iter().enumerate();
    let found = instances.flat_map(|(instance, object)| {
        let mesh = &scene.meshes[object.mesh as usize];
        let is_solid = scene.materials[mesh.material as usize].is_opaque();
        let instance = instance as u32;
        let meets = |(low, high)| boxes.any(low, high, |_| true);
        let is_near = is_solid && world.box_of(instance).is_some_and(meets);
        let count = if is_near { mesh.triangles.len() } else { 0 };
        let (strips, boxes) = (&strips, &boxes);
        (0..count as u32)
            .into_par_iter()
            .flat_map_iter(move |triangle| {
                let corners = world.corners(instance, triangle);
                let [a, b, c] = corners;
                let chart = charts[object.mesh as usize].get(triangle as usize);
                let own = chart.map(|&chart| [instance, chart]);
                let mut stands: Vec<(u32, [f64; 2])> = Vec::new();
                boxes.any(a.min(b).min(c), a.max(b).max(c), |number| {
                    let strip = &strips[number as usize];
                    let is_other = !strip.charts.map(Some).contains(&own);
                    let span = is_other.then(|| strip.under(corners)).flatten();
                    stands.extend(span.map(|span| (strip.pair, span)));
                    false
                });
                stands
            })
    });
    let mut walls = vec![Walls::new(); pairs.len()];
    for (pair, span) in found.collect::<Vec<_>>() {
        walls[pair as usize].push(span);
    }
    walls
}

/// A strip just above the surface on one side of a seam, from a little beyond it on. Where the sides are not equally
/// high, the step between them stands on the lower one.
struct Strip {
    pair: u32,
    charts: [[u32; 2]; 2],
    /// The beginning of the seam, and the way to its end.
    from: DVec3,
    along: DVec3,
    /// Unit direction away from the seam, and across the strip.
    inward: DVec3,
    up: DVec3,
    /// Shading normal of the surface.
    normal: DVec3,
    /// From where to where it reaches inward.
    across: [f64; 2],
}

impl Strip {
    /// The two strips of a pair; none where texels are not clear of the rounding of coordinates.
    fn of(number: u32, pair: &Pair, borders: &[Border]) -> impl Iterator<Item = Self> {
        let sides = pair.borders.map(|border| &borders[border as usize]);
        let charts = sides.map(|side| side.chart);
        let least = REACH * sides[0].depth.min(sides[1].depth);
        sides
            .into_iter()
            .zip(pair.spans)
            .filter_map(move |(side, span)| {
                let ends = span.map(|t| side.at(t));
                let normal = side.normal_at(0.5 * (span[0] + span[1]));
                let along = ends[1] - ends[0];
                let up = along.cross(side.inward).try_normalize()?;
                let is_clear = BESIDE * least >= NUDGE * ends[0].abs().max_element();
                is_clear.then(|| Self {
                    pair: number,
                    charts,
                    from: ends[0] + normal * (HEIGHT * least),
                    along,
                    inward: up.cross(along).normalize(),
                    up,
                    normal,
                    across: [-BESIDE * least, REACH * side.depth],
                })
            })
    }

    /// The box around it.
    fn limits(&self) -> (DVec3, DVec3) {
        let across = self.across.map(|across| self.inward * across);
        let corners =
            [DVec3::ZERO, self.along].map(|end| across.map(|across| self.from + end + across));
        around(corners.into_iter().flatten())
    }

    /// The shares of the seam beside which a triangle stands on the strip.
    fn under(&self, corners: [DVec3; 3]) -> Option<[f64; 2]> {
        let [a, b, c] = corners;
        let face = (b - a).cross(c - a).try_normalize()?;
        if face.dot(self.normal).abs() > LYING {
            return None;
        }
        let heights = corners.map(|corner| (corner - self.from).dot(self.up));
        let cut = [0, 1, 2].map(|k| {
            let (next, [from, to]) = ((k + 1) % 3, [heights[k], heights[(k + 1) % 3]]);
            let crosses = (from < 0.0) != (to < 0.0);
            crosses.then(|| corners[k].lerp(corners[next], from / (from - to)) - self.from)
        });
        let mut cut = cut.into_iter().flatten();
        let ends = [cut.next()?, cut.next()?];
        let [from, to] = ends.map(|end| end.dot(self.inward));
        // The part of the cut that is within the strip, as shares of the way between its ends.
        let mut part = [0.0f64, 1.0];
        if from == to {
            (self.across[0]..=self.across[1])
                .contains(&from)
                .then_some(())?;
        } else {
            let limits = self.across.map(|across| (across - from) / (to - from));
            part = [
                part[0].max(limits[0].min(limits[1])),
                part[1].min(limits[0].max(limits[1])),
            ];
        }
        if part[0] > part[1] {
            return None;
        }
        let shares =
            part.map(|t| ends[0].lerp(ends[1], t).dot(self.along) / self.along.length_squared());
        Some([shares[0].min(shares[1]), shares[0].max(shares[1])])
    }
}
