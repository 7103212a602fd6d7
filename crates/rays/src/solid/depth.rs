//! What bodies count at a point, and where that changes.

use super::opening::Opening;
use super::placed::box_corners;
use super::{Body, Inside, NUDGE, Solids};
use glam::DVec3;
use scene::around;

impl Solids {
    /// True where a body counts the same at all points of triangles of `own`: a solid does not bury itself, and a
    /// ground or a room buries what is rooted in it alone, and cuts what it cuts.
    pub fn spares(&self, body: u32, own: Option<u32>) -> bool {
        match &self.bodies[body as usize].inside {
            Inside::Solid => own == Some(body),
            Inside::Cavity => false,
            Inside::Room | Inside::Nothing => true,
            Inside::Behind(rooted) | Inside::Around(rooted) => {
                !is_among(rooted, own) && !self.cuts(body, own)
            }
        }
    }

    /// True for a ground that cuts the body `own`: see [`Self::cut`].
    pub fn cuts(&self, body: u32, own: Option<u32>) -> bool {
        is_among(self.cut(body), own)
    }

    /// True where what a body counts may change between these points; false is certain.
    pub fn meets(&self, body: u32, points: impl Iterator<Item = DVec3> + Clone) -> bool {
        let of = &self.bodies[body as usize];
        let is_near = |body: &Body| {
            let local = points.clone().map(|at| body.inverse.transform_point3(at));
            let (low, high) = around(local);
            let is_solid = body.inside == Inside::Solid;
            let mut openings = self.surface(body).openings.iter();
            self.tree(body).meets(&self.scene, low, high)
                || (is_solid && openings.any(|opening| opening.meets(low, high)))
        };
        if !matches!(of.inside, Inside::Around(_)) {
            return is_near(of);
        }
        let passes = |opening: &Opening| {
            let shown = |at| opening.shows(of.inverse.transform_point3(at));
            let mut shown = points.clone().map(shown);
            let first = shown.next();
            shown.any(|shown| Some(shown) != first)
        };
        let other_is_near = || {
            let (low, high) = around(points.clone());
            let is_near = |other| other != body && is_near(&self.bodies[other as usize]);
            self.room_boxes.any(low, high, is_near)
        };
        is_near(of) || self.surface(of).openings.iter().any(passes) || other_is_near()
    }

    /// What a body counts at a point of a triangle of the body `own`: 1 in a solid, behind a ground and outside of a
    /// room, -1 in a cavity, 0 elsewhere. On its own triangles the side of the surface decides and not the point: a
    /// solid does not bury itself, and a cavity is open to its own walls. A ground and a room count for what is rooted
    /// in them alone.
    pub fn depth(&self, body: u32, point: DVec3, own: Option<u32>) -> i32 {
        self.depth_by(body, point, own, |of| self.holds(of, point))
    }

    /// True where what bodies count is above 0 together; as few as tell are asked.
    pub fn outweigh(&self, bodies: &[u32], mut depth: impl FnMut(u32) -> i32) -> bool {
        let is_cavity = |body: &&u32| self.is_cavity(**body);
        // All others only add to what cavities take.
        let cavities = bodies.iter().filter(is_cavity);
        let mut sum: i32 = cavities.map(|&body| depth(body)).sum();
        let mut others = bodies.iter().filter(|body| !is_cavity(body));
        others.any(|&body| {
            sum += depth(body);
            sum > 0
        })
    }

    /// True where one solid other than `own` holds all of a box, clear of its surface, where no cavity is: nothing lays
    /// that open. It spares who asks the other bodies about the box, which may be all of the scene.
    pub fn swallow(&self, low: DVec3, high: DVec3, own: Option<u32>) -> bool {
        let reach = self.longest.max(low.abs().max(high.abs()).max_element());
        let (low, high) = (low - 2.0 * NUDGE * reach, high + 2.0 * NUDGE * reach);
        let corners = box_corners(low, high).into_iter();
        let is_about = |body: u32| {
            let of = &self.bodies[body as usize];
            let is_other = own != Some(body) && of.inside == Inside::Solid;
            is_other && self.holds(of, low) && !self.meets(body, corners.clone())
        };
        !self.cavities.any(low, high, |_| true) && self.counting.any(low, high, is_about)
    }

    /// True where the inside of a body is air again, in a solid.
    pub fn is_cavity(&self, body: u32) -> bool {
        self.bodies[body as usize].inside == Inside::Cavity
    }

    pub(super) fn depth_by(
        &self,
        body: u32,
        point: DVec3,
        own: Option<u32>,
        holds: impl FnOnce(&Body) -> bool,
    ) -> i32 {
        let of = &self.bodies[body as usize];
        let is_own = own == Some(body);
        match &of.inside {
            Inside::Room | Inside::Nothing => 0,
            Inside::Solid => i32::from(!is_own && holds(of)),
            Inside::Cavity => -i32::from(is_own || holds(of)),
            Inside::Behind(rooted) => i32::from(is_among(rooted, own) && holds(of)),
            Inside::Around(rooted) => {
                let holds_too =
                    |other| other != body && self.holds(&self.bodies[other as usize], point);
                let is_in_other = || self.room_boxes.any(point, point, holds_too);
                let is_out = || !self.is_seen_through(of, point) && !is_in_other();
                i32::from(is_among(rooted, own) && !holds(of) && is_out())
            }
        }
    }

    /// True where one may look from within a room through an opening at a point outside.
    fn is_seen_through(&self, room: &Body, point: DVec3) -> bool {
        let local = room.inverse.transform_point3(point);
        let mut openings = self.surface(room).openings.iter();
        openings.any(|opening| opening.shows(local))
    }

    pub(super) fn holds(&self, body: &Body, point: DVec3) -> bool {
        let height = |local, front| self.tree(body).height(&self.scene, local, front);
        let winding = |local| self.winding(body, local);
        self.holds_by(body, point, (height, winding))
    }

    /// True where the body holds a point, with how far in front of it a point of the body's space stands, and what
    /// winds around that.
    pub(super) fn holds_by(
        &self,
        body: &Body,
        point: DVec3,
        (height, winding): (
            impl FnOnce(DVec3, DVec3) -> Option<f64>,
            impl FnOnce(DVec3) -> i32,
        ),
    ) -> bool {
        let apart = point.cmplt(body.low) | point.cmpgt(body.high);
        if apart.any() {
            return false;
        }
        let (surface, local) = (self.surface(body), body.inverse.transform_point3(point));
        match surface.front {
            Some(front) => height(local, front).is_some_and(|height| height < 0.0),
            None => f64::from(winding(local)) * surface.content() > 0.0,
        }
    }

    /// How often a body's surface winds around a point of its own space, openings filled.
    pub(super) fn winding(&self, body: &Body, local: DVec3) -> i32 {
        let panes = self.panes(body);
        self.tree(body).winding(&self.scene, panes, local)
    }

    /// What fills the openings of a body.
    pub(super) fn panes(&self, body: &Body) -> impl Iterator<Item = &[[f32; 3]; 3]> {
        let openings = self.surface(body).openings.iter();
        openings.flat_map(|opening| &opening.panes)
    }
}

fn is_among(rooted: &[u32], own: Option<u32>) -> bool {
    own.is_some_and(|own| rooted.binary_search(&own).is_ok())
}
