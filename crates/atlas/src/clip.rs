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

/// Corners of a triangle cut by at most eight half-planes, with room for rounding.
const CAPACITY: usize = 16;

/// A convex polygon on the stack.
#[derive(Clone, Copy)]
pub(crate) struct Polygon {
    len: usize,
    corners: [Corner; CAPACITY],
}

/// Which side of a limit stays.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Side {
    Above,
    Below,
}

impl Polygon {
    pub fn triangle(p: [DVec2; 3]) -> Polygon {
        let mut corners = [Corner::default(); CAPACITY];
        for (k, w) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            corners[k] = Corner { p: p[k], w };
        }
        Polygon { len: 3, corners }
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// The part between `low` and `high` along `axis`; empty when nothing or only a line is left.
    pub fn between(&self, axis: usize, low: f64, high: f64) -> Polygon {
        self.cut(axis, low, Side::Above)
            .cut(axis, high, Side::Below)
    }

    /// Smallest and largest coordinate along `axis`.
    pub fn range(&self, axis: usize) -> (f64, f64) {
        self.corners()
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| {
                (lo.min(c.p[axis]), hi.max(c.p[axis]))
            })
    }

    /// The part on one side of the line `coordinate(axis) = limit`.
    fn cut(&self, axis: usize, limit: f64, side: Side) -> Polygon {
        let distance = |c: &Corner| match side {
            Side::Above => c.p[axis] - limit,
            Side::Below => limit - c.p[axis],
        };
        let (low, high) = self.range(axis);
        let (inside, touches) = match side {
            Side::Above => (low >= limit, high > limit),
            Side::Below => (high <= limit, low < limit),
        };
        if inside && touches {
            return *self;
        }
        let mut out = Polygon {
            len: 0,
            corners: [Corner::default(); CAPACITY],
        };
        if !touches {
            return out;
        }
        for k in 0..self.len {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % self.len]);
            let (da, db) = (distance(&a), distance(&b));
            if da >= 0.0 {
                out.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let t = da / (da - db);
                let mut cut = Corner {
                    p: a.p.lerp(b.p, t),
                    w: a.w.lerp(b.w, t),
                };
                cut.p[axis] = limit;
                out.push(cut);
            }
        }
        out
    }

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
