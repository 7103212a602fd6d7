//! Rims: what a wall cuts off from the end of a chart.
//!
//! A floor that reaches a little through its wall ends in a rim that sees the other side. It may be a hundredth of a texel, and its light
//! would still be a leak all over the texel that it shares with the floor. So where something stands between the middle of a footprint that
//! covers its texel in part and a third of it at most, that part is left out.

use super::seen::EDGE;
use super::texel::Texel;
use glam::DVec3;
use rays::{Coherence, Ray, RayBackend, RayPacket};

/// A footprint that covers so much of its texel is taken to end no chart; one may end there, on a border of texels.
const WHOLE: f32 = 0.999;
/// How high above the surface one looks for what stands there, as a share of the footprint's size, and how far its corners may lie off
/// their plane.
const HEIGHT: f64 = 0.01;
/// A wall in the last hundredth of the way to a corner ends the surface there: such a rim is less than half a hundredth of the footprint.
const REST: f32 = 0.99;

/// Leaves the rim of a footprint out, where it has one.
pub(crate) fn leave_out(texel: &mut Texel, backend: &dyn RayBackend) {
    if texel.coverage >= WHOLE || texel.open || texel.seen.share == 0.0 {
        return;
    }
    let cell = &texel.cells[0];
    let up = cell.sample(cell.centre()).geometric;
    let (middle, mut size) = (texel.position, 0.0f64);
    let corners = texel.cells.iter().flat_map(|cell| cell.corners());
    let corners: Vec<DVec3> = corners.collect();
    for corner in &corners {
        size = size.max(corner.distance(middle));
    }
    let height = HEIGHT * size;
    let is_flat = |corner: &DVec3| (corner - middle).dot(up).abs() <= height;
    if !corners.iter().all(is_flat) || height < 4.0 * cell.lift.length() {
        return;
    }
    let look = Look {
        backend,
        from: middle + up * height,
        way: up * height,
    };
    if !look.parted(&corners).contains(&true) {
        return;
    }
    // A coordinate of 1 would choose no cell. Between two cells the surface jumps, so both sides are looked at.
    let at = |k: usize| (k as f64 / EDGE as f64).min(1.0 - 1e-7);
    let ends = texel.ends().iter();
    let beside = ends.flat_map(|&end| [f64::from(end.next_down()), f64::from(end)]);
    let columns: Vec<f64> = (0..=EDGE).map(at).chain(beside).collect();
    let rows = (0..=EDGE).map(at);
    let places: Vec<[f64; 2]> = rows
        .flat_map(|row| columns.iter().map(move |&column| [column, row]))
        .collect();
    let point = |place: &[f64; 2]| texel.sample_of(*place).position;
    let parted = look.parted(&places.iter().map(point).collect::<Vec<_>>());
    if 3 * parted.iter().filter(|parted| **parted).count() > parted.len() {
        return;
    }
    let cut: Vec<[f64; 2]> = places
        .into_iter()
        .zip(parted)
        .filter(|of| of.1)
        .map(|of| of.0)
        .collect();
    texel.keep(|stratum| {
        let [left, top] = [stratum % EDGE, stratum / EDGE];
        let holds = |[column, row]: &[f64; 2]| {
            (at(left)..=at(left + 1)).contains(column) && (at(top)..=at(top + 1)).contains(row)
        };
        !cut.iter().any(holds)
    });
}

/// A place above the surface from which one looks along it.
struct Look<'a> {
    backend: &'a dyn RayBackend,
    from: DVec3,
    /// From the surface up to the height of the look.
    way: DVec3,
}

impl Look<'_> {
    /// For each point of the surface, whether something stands between, and not just before it.
    fn parted(&self, points: &[DVec3]) -> Vec<bool> {
        let mut parted = Vec::with_capacity(points.len());
        for points in points.chunks(16) {
            let mut packet = RayPacket::<16>::new();
            for (lane, &point) in points.iter().enumerate() {
                let direction = point + self.way - self.from;
                packet.set(
                    lane,
                    &Ray {
                        origin: self.from.as_vec3().to_array(),
                        direction: direction.as_vec3().to_array(),
                        t_min: 0.0,
                        t_max: REST,
                    },
                );
            }
            let active = u32::MAX >> (32 - points.len());
            let met = self
                .backend
                .occluded16(&packet, active, Coherence::Coherent);
            parted.extend((0..points.len()).map(|lane| met >> lane & 1 == 1));
        }
        parted
    }
}
