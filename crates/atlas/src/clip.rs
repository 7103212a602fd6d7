//! A triangle clipped to axis-aligned boxes, carrying barycentric weights along.
//!
//! Weights are interpolated with the corners, so they stay convex combinations however thin the triangle is, and
//! areas are measured in weights times the area of the whole triangle: the parts of a triangle add up to it.

use glam::{DVec2, DVec3};

/// A corner of a clipped polygon.
#[derive(Clone, Copy, Default)]
pub(crate) struct Corner {
    /// Position in texels.
    pub p: DVec2,
    /// Weights of the triangle's three corners.
    pub w: DVec3,
}

/// Corners of a triangle cut by at most four half-planes, with room for rounding.
const CAPACITY: usize = 8;

/// A convex polygon on the stack.
#[derive(Clone)]
pub(crate) struct Polygon {
    len: usize,
    corners: [Corner; CAPACITY],
}

impl Polygon {
    /// No corner.
    pub const EMPTY: Self = Self {
        len: 0,
        corners: [Corner {
            p: DVec2::ZERO,
            w: DVec3::ZERO,
        }; CAPACITY],
    };

    pub fn triangle(p: [DVec2; 3]) -> Polygon {
        let mut polygon = Self::EMPTY;
        for (p, w) in p.into_iter().zip([DVec3::X, DVec3::Y, DVec3::Z]) {
            polygon.push(Corner { p, w });
        }
        polygon
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// Smallest and largest coordinate along `axis`.
    pub fn range(&self, axis: usize) -> (f64, f64) {
        self.corners()
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| {
                (lo.min(c.p[axis]), hi.max(c.p[axis]))
            })
    }

    /// Parts it along the line `coordinate(axis) = limit`. A part of which nothing or only a line is left is empty.
    #[inline(always)]
    pub fn split(&self, axis: usize, limit: f64, before: &mut Polygon, after: &mut Polygon) {
        (before.len, after.len) = (0, 0);
        let (mut is_before, mut is_after) = (false, false);
        let Some(mut a) = self.corners().last() else {
            return;
        };
        let mut da = a.p[axis] - limit;
        for b in self.corners() {
            let db = b.p[axis] - limit;
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let t = da / (da - db);
                let mut cut = Corner {
                    p: a.p.lerp(b.p, t),
                    w: a.w.lerp(b.w, t),
                };
                cut.p[axis] = limit;
                before.push(cut);
                after.push(cut);
            }
            if db <= 0.0 {
                before.push(*b);
            }
            if db >= 0.0 {
                after.push(*b);
            }
            (is_before, is_after) = (is_before | (db < 0.0), is_after | (db > 0.0));
            (a, da) = (b, db);
        }
        if !is_before {
            before.len = 0;
        }
        if !is_after {
            after.len = 0;
        }
    }

    #[inline(always)]
    fn push(&mut self, corner: Corner) {
        debug_assert!(self.len < CAPACITY, "polygon of {} corners", self.len + 1);
        if self.len < CAPACITY {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }
}

/// Share of the whole triangle's area that the triangle `a b c` takes, from weights alone.
pub(crate) fn share(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (u, v) = (b - a, c - a);
    // The three projections are equal on paper; the weights sum to 1.
    (u.y * v.z - u.z * v.y).abs()
}
