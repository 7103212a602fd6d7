//! Where a surface stands to a sheet: how far in front of it and behind it the surface goes.

use super::facing::facing;
use crate::solid::placed::{CROSSES, Placed};
use crate::solid::tree::SurfaceTree;
use glam::DVec3;
use scene::Scene;
use std::collections::HashSet;

/// Where along an edge points are asked how they stand to a sheet.
const ALONG_EDGES: [f64; 3] = [0.23, 0.5, 0.77];
/// No line that looks for a sheet leans by more of its length, and no coordinate is rounded by more of its own.
const LEANS: f64 = 1e-5;
const ROUNDED: f64 = 1e-9;

/// Where a surface stands to a sheet.
pub(super) struct Stand {
    /// How far it goes in front and behind, in lengths of the mesh's space; what is less than `least` only touches, and
    /// what keeps off the sheet reaches less than nothing behind it.
    pub front: f64,
    pub behind: f64,
    pub least: f64,
    /// Some of it is before or behind the sheet, not beside it.
    pub meets: bool,
    /// The box of its points behind and on the sheet, in the world.
    pub low: DVec3,
    pub high: DVec3,
}

impl Stand {
    pub fn of(scene: &Scene, sheet: &Placed, tree: &SurfaceTree, other: &Placed) -> Self {
        let inverse = sheet.inverse;
        let size = inverse.transform_vector3(other.high - other.low).length();
        let mut stand = Self {
            front: 0.0,
            behind: f64::NEG_INFINITY,
            least: CROSSES * size,
            meets: false,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        let Some(front) = sheet.surface.front else {
            return stand;
        };
        // Edges of panels may run along one another, where corners are beside a sheet or over its border, and so may
        // middles be where panels join: so other points on the edges too.
        for point in points(scene, other, &Column::of(sheet, front, other)) {
            let local = inverse.transform_point3(point);
            // A wall that only stands on a floor does not cross it: what ends at the sheet is beside it.
            let Some(height) = tree.height_over(scene, local, front, true) else {
                continue;
            };
            stand.meets = true;
            stand.front = stand.front.max(height);
            stand.behind = stand.behind.max(-height);
            if height <= stand.least {
                (stand.low, stand.high) = (stand.low.min(point), stand.high.max(point));
            }
        }
        stand
    }

    /// Takes from the sheet's own points how another sheet stands to it, which may have few and far between.
    pub fn look_from(&mut self, scene: &Scene, sheet: &Placed, other: &Placed, tree: &SurfaceTree) {
        let Some(front) = facing(sheet) else {
            return;
        };
        let local_front = other.inverse.transform_vector3(front);
        let scale = sheet.inverse.transform_vector3(front).length() / local_front.length();
        let direction = local_front.normalize_or_zero();
        for point in points(scene, sheet, &Column::of(other, direction, sheet)) {
            let local = other.inverse.transform_point3(point);
            let Some(height) = tree.height_over(scene, local, direction, true) else {
                continue;
            };
            self.meets = true;
            self.front = self.front.max(-height * scale);
            self.behind = self.behind.max(height * scale);
            if height > 0.0 {
                let place = point - front * (height / local_front.length());
                (self.low, self.high) = (self.low.min(place), self.high.max(place));
            }
        }
    }

    pub fn crosses(&self) -> bool {
        self.front > self.least && self.behind > self.least
    }

    /// True for a surface that stands on the sheet, if not behind it too.
    pub fn touches(&self) -> bool {
        self.front > self.least && self.behind >= -self.least
    }

    /// True for a surface that lies in the sheet.
    pub fn is_level(&self) -> bool {
        self.meets && self.front <= self.least && self.behind <= self.least
    }

    /// What both say of one surface before two sheets.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            front: self.front.max(other.front),
            behind: self.behind.max(other.behind),
            least: self.least.max(other.least),
            meets: self.meets || other.meets,
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// Points of a surface that may be over another, each once: corners, middles and points on the edges of some of its
/// faces.
fn points(scene: &Scene, of: &Placed, over: &Column) -> Vec<DVec3> {
    let mut known = HashSet::new();
    let mut points = Vec::new();
    for [a, b, c] in of.faces(scene).filter(|face| !over.misses(face)) {
        let along = [(a, b), (b, c), (c, a)].into_iter().flat_map(|(from, to)| {
            // Both faces of an edge see it the same way.
            let is_turned = from.to_array() > to.to_array();
            let (from, to) = if is_turned { (to, from) } else { (from, to) };
            ALONG_EDGES.map(|share| from.lerp(to, share))
        });
        let own = [a, b, c, (a + b + c) / 3.0].into_iter().chain(along);
        points.extend(own.filter(|point| known.insert(point.to_array().map(f64::to_bits))));
    }
    points
}

/// The endless box about a surface along a direction: no line of [`SurfaceTree::height_over`] from beside it meets the
/// surface.
struct Column {
    /// Across the direction, with the least and the greatest of the box along them.
    axes: [(DVec3, f64, f64); 2],
}

impl Column {
    /// The column along a direction in the surface's mesh space, for points of another.
    pub fn of(surface: &Placed, front: DVec3, other: &Placed) -> Self {
        let [low, high] =
            [surface.surface.low, surface.surface.high].map(|corner| corner.as_dvec3());
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let inverse = surface.inverse;
        let from = inverse.transform_point3((other.low + other.high) * 0.5);
        let reach = inverse.matrix3.abs() * (other.high - other.low);
        let slack = LEANS * ((from - middle).length() + half.length() + reach.length())
            + ROUNDED * (from.length() + middle.length());
        let across = front.any_orthonormal_vector();
        let axes = [across, front.cross(across)].map(|axis| {
            let (at, wide) = (middle - inverse.translation, half.dot(axis.abs()) + slack);
            let own = inverse.matrix3.transpose() * axis;
            (own, at.dot(axis) - wide, at.dot(axis) + wide)
        });
        Self { axes }
    }

    /// True where all of a face is beside the column.
    fn misses(&self, face: &[DVec3; 3]) -> bool {
        self.axes.iter().any(|&(axis, least, most)| {
            let [a, b, c] = face.map(|corner| corner.dot(axis));
            a.max(b).max(c) < least || a.min(b).min(c) > most
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Column, points};
    use crate::fixture::{mesh, scene};
    use crate::solid::Solids;
    use glam::{DVec3, Vec3};
    use std::sync::Arc;

    /// A level grid of `n` by `n` unit squares at this height, with a corner at x and z of `from`.
    fn grid(n: u32, height: f32, from: f32) -> scene::Mesh {
        let along = |k: u32| from + k as f32;
        let corner = |k: u32| Vec3::new(along(k % (n + 1)), height, along(k / (n + 1)));
        let square = |k: u32| {
            let a = k / n * (n + 1) + k % n;
            [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
        };
        let corners = (0..(n + 1) * (n + 1)).map(corner).collect();
        mesh(corners, (0..n * n).flat_map(square).collect())
    }

    #[test]
    fn points_over_a_sheet_are_asked_once_and_others_never() {
        let count = |n: u32| {
            let (corners, edges) = ((n + 1) * (n + 1), 2 * n * (n + 1) + n * n);
            (corners + 3 * edges + 2 * n * n) as usize
        };
        // Below the small one are its four squares and those that touch it.
        let meshes = vec![grid(6, 0.0, 0.0), grid(2, 1.0, 2.0), grid(9, 2.0, -1.5)];
        let solids = Solids::of(&Arc::new(scene(meshes)));
        let placed = solids.placed_surfaces();
        let asked = |sheet: usize, other: usize| {
            let (sheet, other) = (&placed[sheet], &placed[other]);
            points(&solids.scene, other, &Column::of(sheet, DVec3::Y, other)).len()
        };
        assert_eq!([asked(2, 0), asked(0, 1)], [count(6), count(2)]);
        assert_eq!(asked(1, 0), count(4));
    }
}
