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
#[derive(Clone)]
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

    /// The part between `low` and `high` along `axis`; empty when nothing or only a line is left. What is cut stands in `scratch`: a
    /// polygon that the limits do not touch is not copied.
    pub fn between<'a>(
        &'a self,
        axis: usize,
        low: f64,
        high: f64,
        [first, second]: &'a mut [Polygon; 2],
    ) -> &'a Polygon {
        self.cut(axis, low, Side::Above, first)
            .cut(axis, high, Side::Below, second)
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
    fn cut<'a>(&'a self, axis: usize, limit: f64, side: Side, out: &'a mut Polygon) -> &'a Polygon {
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
            return self;
        }
        out.len = 0;
        if !touches {
            return out;
        }
        let corners = self.corners();
        let mut da = distance(&corners[0]);
        for (k, a) in corners.iter().enumerate() {
            let b = &corners[if k + 1 < corners.len() { k + 1 } else { 0 }];
            let db = distance(b);
            if da >= 0.0 {
                out.push(*a);
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
            da = db;
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
