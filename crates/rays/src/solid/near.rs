//! What bodies count at many points that lie near one another.

use super::tree::{CLEAR, height_over};
use super::{Body, Solids};
use crate::triangle::ShearedRay;
use glam::DVec3;
use scene::around;

/// A closed surface about a box. The first point is looked at from far away, as [`Solids::depth`] does; from there to
/// the others, what lies between is counted.
#[derive(Debug)]
pub struct Near<'a> {
    solids: &'a Solids,
    body: u32,
    /// The box, in the body's space.
    low: DVec3,
    high: DVec3,
    /// All faces that may meet it; of a surface that looks to one side those over and under it.
    faces: Vec<Plane>,
    sheet: Vec<[[f32; 3]; 3]>,
    /// A point in the body's space, and how often the surface winds around it.
    known: Option<(DVec3, i32)>,
}

impl Near<'_> {
    /// The closed surface.
    pub fn body(&self) -> u32 {
        self.body
    }

    /// As [`Solids::depth`]; soon known of points in the box.
    pub fn depth(&mut self, point: DVec3, own: Option<u32>) -> i32 {
        let solids = self.solids;
        solids.depth_by(self.body, point, own, |_| self.holds(point))
    }

    /// True where a point of a body that it cuts lies behind it.
    pub fn cuts(&mut self, point: DVec3, own: Option<u32>) -> bool {
        self.solids.cuts(self.body, own) && self.holds(point)
    }

    fn holds(&mut self, point: DVec3) -> bool {
        let solids = self.solids;
        let of = &solids.bodies[self.body as usize];
        if solids.surface(of).front.is_none() {
            let winding = |local| self.winding(of, local);
            return solids.holds_by(of, point, (|_, _| None, winding));
        }
        let height = |local, front| match self.has(local) {
            true => height_over(&self.sheet, local, front),
            false => solids.tree(of).height(&solids.scene, local, front),
        };
        solids.holds_by(of, point, (height, |_| 0))
    }

    /// True for a point in the box.
    fn has(&self, point: DVec3) -> bool {
        let apart = point.cmplt(self.low) | point.cmpgt(self.high);
        !apart.any()
    }

    fn winding(&mut self, body: &Body, point: DVec3) -> i32 {
        let far = || self.solids.winding(body, point);
        if !self.has(point) {
            return far();
        }
        let climbed = self
            .known
            .and_then(|(from, winding)| Some(winding + climb(&self.faces, from, point)?));
        let winding = climbed.unwrap_or_else(far);
        if self.known.is_none() {
            self.known = Some((point, winding));
            for plane in &mut self.faces {
                plane.known = plane.height(point);
            }
        }
        winding
    }
}

/// A triangle and its plane.
#[derive(Debug)]
struct Plane {
    corners: [[f32; 3]; 3],
    /// Of any length.
    normal: DVec3,
    /// Height along the normal, of the plane and of the known point above it, and how far off heights may be.
    at: f64,
    known: f64,
    rounding: f64,
}

impl Plane {
    /// Of a triangle, for points with coordinates up to `reach`.
    fn of(corners: [[f32; 3]; 3], reach: f64) -> Self {
        let [a, b, c] = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
        let normal = (b - a).cross(c - a);
        let reach = reach.max(a.abs().max(b.abs()).max(c.abs()).max_element());
        let longest = (b - a).abs().max((c - a).abs()).element_sum();
        Self {
            corners,
            normal,
            at: normal.dot(a),
            known: 0.0,
            rounding: 64.0 * f64::EPSILON * longest * longest * reach,
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.at
    }
}

/// How much higher the winding number is at the end of a straight way than at its start, which is the known point,
/// where all that the way may cross are these triangles; `None` where it comes too near to an edge, or ends too near to
/// a triangle, to tell.
fn climb(faces: &[Plane], from: DVec3, to: DVec3) -> Option<i32> {
    let way = ShearedRay::new(from, to - from);
    let mut climb = 0;
    for face in faces {
        // Most ways stay on one side of the plane.
        let (start, end) = (face.known, face.height(to));
        let clear = face.rounding + CLEAR * (end - start).abs();
        if start.min(end) > clear || start.max(end) < -clear {
            continue;
        }
        let Some(crossing) = way.cross(&face.corners) else {
            continue;
        };
        if crossing.t < -CLEAR || crossing.t > 1.0 + CLEAR {
            continue;
        }
        let [u, v] = crossing.barycentric;
        let margin = u.min(v).min(1.0 - u - v);
        if margin < CLEAR || crossing.t.min(1.0 - crossing.t) < CLEAR {
            return None;
        }
        // Outward faces seen from their front lead inward.
        climb += if crossing.front { 1 } else { -1 };
    }
    Some(climb)
}

impl Solids {
    /// A closed surface about the box of some points, for the depth at many points in it.
    pub fn near(&self, body: u32, points: impl Iterator<Item = DVec3>) -> Near<'_> {
        let of = &self.bodies[body as usize];
        let (low, high) = around(points.map(|point| of.inverse.transform_point3(point)));
        // Points between those given are rounded too.
        let slack = 1e-6 * (high - low).max_element();
        let (low, high) = (low - slack, high + slack);
        let (tree, front) = (self.tree(of), self.surface(of).front);
        let sheet = front.map(|front| tree.over(&self.scene, [low, high], front));
        let faces = match sheet {
            Some(_) => Vec::new(),
            None => tree.about(&self.scene, low, high),
        };
        let reach = low.abs().max(high.abs()).max_element();
        let faces = faces.into_iter().chain(self.panes(of).copied());
        Near {
            solids: self,
            body,
            low,
            high,
            faces: faces.map(|corners| Plane::of(corners, reach)).collect(),
            sheet: sheet.unwrap_or_default(),
            known: None,
        }
    }
}
