//! One piece of a texel's footprint inside one triangle, ready to be sampled: everything is affine in (s, t).

use crate::options::Shading;
use atlas::{Piece, TILE};
use glam::{DVec2, DVec3};
use rays::{Patch, above};

/// Corner weights as functions of a place, in the unit square of a texel or in a tile: those of the second and third
/// corner at (0, 0), and their change along either edge.
pub(crate) type Weights = [[f32; 2]; 3];

/// A triangle or parallelogram of a footprint. Positions are f64 until the ray is set; directions and normals are f32.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    /// Area in texels; of a whole triangle that of a texel's square on its plane, in squared units of the world.
    pub area: f64,
    /// The closed surface that it is part of.
    pub body: Option<u32>,
    /// Share of the footprint's area before the cell; 0 for an only cell.
    pub start: f32,
    inverse_share: f32,
    /// The unit square is folded onto the triangle under its diagonal by this times the lesser coordinate; 0 for a cell
    /// that is the whole parallelogram, 1/2 for a triangle.
    pub fold: f32,
    /// Position at (0, 0) and its change along s and t. Exactly constant along an axis in which the triangle is flat.
    pub position: [DVec3; 3],
    /// Shading normal at (0, 0) and its change along s and t; of unit length where it does not change.
    pub normal: [DVec3; 3],
    /// Unit geometric normal, on the lit side.
    pub geometric: DVec3,
    /// How a ray's origin stands off.
    pub lift: DVec3,
    /// Of a whole triangle, the weights of its second and third corner over its tile, and the least corner weights of a
    /// sample.
    pub weights: Weights,
    pub least: [f32; 3],
    smooth: bool,
    /// The shading normal is the geometric normal all over the cell.
    pub is_flat: bool,
}

/// A point of a surface with what a ray needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub position: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
    /// Unit geometric normal, on the lit side.
    pub geometric: DVec3,
}

impl Sample {
    /// The direction in which the ray of `direction` leaves the surface; `None` where it counts 0: below the horizon of
    /// the shading normal, or in exact shading below the facet.
    pub fn leaving(&self, shading: Shading, direction: DVec3) -> Option<DVec3> {
        if direction.dot(self.normal) <= 0.0 {
            return None;
        }
        let height = direction.dot(self.geometric);
        match shading {
            _ if height > 0.0 => Some(direction),
            Shading::Production if height < 0.0 => Some(direction - 2.0 * height * self.geometric),
            _ => None,
        }
    }
}

impl Cell {
    /// Adds the cells of a piece of so much area in texels. Corners are kept the patch's inset away from the
    /// triangle's edges; a parallelogram that would need it at one corner becomes two triangles.
    pub fn push(
        cells: &mut Vec<Cell>,
        (patch, body): (&Patch, Option<u32>),
        piece: &Piece,
        area: f64,
    ) {
        let mut push = |fold, weights, area| {
            cells.push(Self::of((patch, body), fold, weights, area));
        };
        let [a, b, c] = piece.corners;
        if !piece.square {
            let kept = |w| if patch.keeps(w) { w } else { patch.kept(w) };
            push(0.5, [a, b, c].map(kept), area);
            return;
        }
        let d = b + c - a;
        if [a, b, c, d].iter().all(|&w| patch.keeps(w)) {
            push(0.0, [a, b, c], area);
            return;
        }
        let [a, b, c, d] = [a, b, c, d].map(|w| patch.kept(w));
        push(0.5, [a, b, c], 0.5 * area);
        push(0.5, [d, c, b], 0.5 * area);
    }

    /// All of a triangle that texels hold whole, by its corner weights as affine functions of the place in the tile:
    /// (s, t) are the weights of its second and third corner.
    pub fn whole((patch, body): (&Patch, Option<u32>), weights: impl Fn(DVec2) -> DVec3) -> Self {
        let [a, b, c] = [DVec2::ZERO, DVec2::X, DVec2::Y].map(weights);
        let weights = [a, b - a, c - a];
        let cell = Self::between((patch, body), 0.5, (patch.corners, patch.normals()), 0.0);
        // What the tile may have of it lies in a square on its plane, and in its own box.
        let [at, s, t] = cell.position;
        let [along, across] = [weights[1], weights[2]].map(|w| s * w.y + t * w.z);
        let half = 0.5 * f64::from(TILE) * (along.abs() + across.abs());
        let middle = at + s * a.y + t * a.z + 0.5 * f64::from(TILE) * (along + across);
        let reach = if (patch.high - patch.low).element_sum() < 2.0 * half.element_sum() {
            patch.low.abs().max(patch.high.abs())
        } else {
            middle.abs() + half
        };
        let [_, u, v] = weights;
        Self {
            area: patch.twice_area * (u.y * v.z - u.z * v.y).abs(),
            lift: patch.geometric * patch.offset(reach),
            weights: weights.map(|w| [w.y as f32, w.z as f32]),
            least: patch.least_weights().as_vec3().to_array(),
            ..cell
        }
    }

    fn of(patch: (&Patch, Option<u32>), fold: f32, weights: [DVec3; 3], area: f64) -> Self {
        let corners = weights.map(|w| patch.0.position(w));
        let normals = weights.map(|w| patch.0.normal(w));
        Self::between(patch, fold, (corners, normals), area)
    }

    /// Of positions and normals at the corners.
    fn between(
        (patch, body): (&Patch, Option<u32>),
        fold: f32,
        (corners, normals): ([DVec3; 3], [DVec3; 3]),
        area: f64,
    ) -> Self {
        let affine = |[a, b, c]: [DVec3; 3]| [a, b - a, c - a];
        let [a, b, c] = corners.map(DVec3::abs);
        let smooth = normals[0] != normals[1] || normals[0] != normals[2];
        let normal: [DVec3; 3] = match smooth {
            true => affine(normals),
            false => {
                let normal = normals[0].try_normalize();
                [normal.unwrap_or(patch.geometric), DVec3::ZERO, DVec3::ZERO]
            }
        };
        Self {
            area,
            body,
            start: 0.0,
            inverse_share: 1.0,
            fold,
            position: affine(corners),
            is_flat: !smooth && is_along(normal[0], patch.geometric),
            normal,
            geometric: patch.geometric,
            lift: patch.geometric * patch.offset(a.max(b).max(c)),
            weights: [[0.0; 2]; 3],
            least: [0.0; 3],
            smooth,
        }
    }

    /// Lets rays begin at least so far off the surface.
    pub fn lift_to(&mut self, least: f64) {
        if least > self.lift.dot(self.geometric) {
            self.lift = least * self.geometric;
        }
    }

    /// Takes `normal`, of unit length, as the one shading normal. It stays on the lit side of the surface.
    pub fn bend(&mut self, normal: DVec3) {
        let kept = above(normal, self.geometric);
        self.normal = [kept, DVec3::ZERO, DVec3::ZERO];
        (self.smooth, self.is_flat) = (false, is_along(kept, self.geometric));
    }

    /// Sets the shares of the cells of one footprint.
    pub fn share(cells: &mut [Cell]) {
        let total: f64 = cells.iter().map(|cell| cell.area).sum();
        let (mut before, mut start) = (0.0, 0.0);
        for cell in cells {
            before += cell.area;
            let end = (before / total) as f32;
            cell.start = start;
            cell.inverse_share = 1.0 / (end - start).max(f32::MIN_POSITIVE);
            start = end;
        }
    }

    /// Weights of the second and third corner, moved as far from the edges of a whole triangle as samples stay.
    #[inline(always)]
    pub fn kept(&self, weights: [f32; 2]) -> [f32; 2] {
        kept_in(self.least, weights)
    }

    /// Start, 1 over the share of the footprint's area, and fold.
    #[inline(always)]
    pub fn placement(&self) -> [f32; 3] {
        [self.start, self.inverse_share, self.fold]
    }

    /// True where the shading normal changes over the cell.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.smooth
    }

    /// True where both cells have one shading normal, the same.
    #[inline(always)]
    pub fn shades_like(&self, other: &Cell) -> bool {
        !self.smooth
            && !other.smooth
            && self.normal[0] == other.normal[0]
            && self.geometric == other.geometric
    }

    /// Corners: of a triangle three, one of them twice; of a parallelogram four.
    pub fn corners(&self) -> [DVec3; 4] {
        let [a, along, across] = self.position;
        let fourth = if self.fold == 0.0 {
            a + along + across
        } else {
            a
        };
        [a, a + along, a + across, fourth]
    }

    /// Area in the world, squared units.
    pub fn world_area(&self) -> f64 {
        let [_, s, t] = self.position;
        let share = if self.fold == 0.0 { 1.0 } else { 0.5 };
        share * s.cross(t).length()
    }

    /// Corners about what a square has of a whole triangle: its own where it is small, else those of the square on its
    /// plane. `weights` are those at points of the unit square.
    pub fn corners_in(&self, weights: impl Fn([f32; 2]) -> [f32; 2]) -> [DVec3; 4] {
        let own = self.corners();
        let square = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|u| self.at(weights(u)));
        let extent = |of: &[DVec3; 4]| {
            let low = of[0].min(of[1]).min(of[2]).min(of[3]);
            let high = of[0].max(of[1]).max(of[2]).max(of[3]);
            (high - low).element_sum()
        };
        if extent(&own) < extent(&square) {
            own
        } else {
            square
        }
    }

    /// (s, t) of the centroid.
    pub fn centre(&self) -> [f32; 2] {
        if self.fold == 0.0 {
            [0.5; 2]
        } else {
            [1.0 / 3.0; 2]
        }
    }

    /// The position at (s, t).
    pub fn at(&self, [s, t]: [f32; 2]) -> DVec3 {
        self.position[0] + self.position[1] * f64::from(s) + self.position[2] * f64::from(t)
    }

    /// The surface at (s, t).
    pub fn sample(&self, [s, t]: [f32; 2]) -> Sample {
        let position = self.at([s, t]);
        let normal = match self.smooth {
            true => {
                let [n, along, across] = self.normal;
                let normal = n + along * f64::from(s) + across * f64::from(t);
                normal.try_normalize().unwrap_or(self.geometric)
            }
            false => self.normal[0],
        };
        Sample {
            position,
            normal,
            geometric: self.geometric,
        }
    }
}

/// True where one of two unit vectors is the other.
fn is_along(a: DVec3, b: DVec3) -> bool {
    a.dot(b) >= 1.0 - 1e-12
}

/// (s, t) in a cell with this placement: the square is stretched over the cell, so that stratified numbers stay
/// stratified, and folded onto a triangle as in E. Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
#[inline(always)]
pub(crate) fn place_in([start, inverse, fold]: [f32; 3], [u0, u1]: [f32; 2]) -> [f32; 2] {
    let s = ((u0 - start) * inverse).clamp(0.0, 1.0);
    let folded = fold * s.min(u1);
    [s - folded, u1 - folded]
}

/// Weights of the second and third corner of a triangle of whose corners none has less than `least`.
#[inline(always)]
pub(crate) fn kept_in(least: [f32; 3], [s, t]: [f32; 2]) -> [f32; 2] {
    let most = |a: f32, b: f32| if a > b { a } else { b };
    let first = most(1.0 - s - t, least[0]);
    let [s, t] = [most(s, least[1]), most(t, least[2])];
    let scale = 1.0 / (first + s + t);
    [s * scale, t * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_along_the_facet_leaves_it_under_no_shading() {
        let sample = Sample {
            position: DVec3::ZERO,
            normal: DVec3::new(0.6, 0.0, 0.8),
            geometric: DVec3::Z,
        };
        let below = DVec3::new(0.8, 0.0, -0.6);
        for shading in [Shading::Production, Shading::Exact] {
            assert_eq!(sample.leaving(shading, DVec3::X), None);
            assert_eq!(sample.leaving(shading, DVec3::NEG_X), None);
            assert_eq!(sample.leaving(shading, DVec3::Z), Some(DVec3::Z));
        }
        // The normal faces it, the facet does not: mirrored on the facet.
        let tilted = DVec3::new(0.9, 0.0, -0.1).normalize();
        assert!(tilted.dot(sample.normal) > 0.0 && below.dot(sample.normal) == 0.0);
        assert_eq!(sample.leaving(Shading::Exact, tilted), None);
        let up = sample.leaving(Shading::Production, tilted).expect("a ray");
        assert!((up - DVec3::new(tilted.x, 0.0, -tilted.z)).length() < 1e-15);
    }
}
