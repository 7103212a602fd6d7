//! Whether a point of a triangle is buried in a body.

use crate::solid::NUDGE;
use crate::world::World;

impl World {
    /// True where a point of a triangle lies in more solids than cavities. `weights`: its barycentric coordinates.
    pub fn is_buried(&self, instance: u32, triangle: u32, weights: [f64; 3]) -> bool {
        let solids = self.solids();
        let corners = self.corners(instance, triangle);
        let position = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let sense = if self.part(instance).0.mirrors() {
            -1.0
        } else {
            1.0
        };
        let upward = match self.normals(instance, triangle) {
            Some([a, b, c]) if (a + b + c).dot(face * sense) < 0.0 => -sense,
            _ => sense,
        };
        let near = solids.about(position, position);
        let extent = near.iter().map(|&body| solids.extent(body));
        let reach = extent.fold(position.abs().max_element(), f64::max);
        let point = position + NUDGE * reach * upward * face.normalize_or_zero();
        let own = solids.own(instance, triangle);
        let depth = |&body: &u32| solids.depth(body, point, own);
        near.iter().map(depth).sum::<i32>() > 0
    }
}
