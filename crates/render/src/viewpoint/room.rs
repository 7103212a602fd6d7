//! The scene as a place to look around in: what rays from a place meet, how closed it is there, and which view shows
//! most.

use super::subject::{Point, focus, normal, points};
use crate::Camera;
use crate::framing::extent;
use glam::{DQuat, DVec3};
use rays::{Bounds, Ray, RayBackend, Stops, SurfaceHit, World};
use std::f64::consts::{PI, TAU};

/// Directions in which a place looks around.
const AROUND: u32 = 64;
/// A place is closed where so many of them meet fronts of surfaces, and half open where fewer do: a hall below a
/// skylight.
const CLOSED: u32 = 58;
const HALF_OPEN: u32 = 36;
/// A place is above a floor where so much of what is below it meets fronts.
const FLOOR: f64 = 1.0 / 3.0;
/// A place is inside of a solid where so many meet backs.
const SOLID: u32 = 12;
/// A view from another side is taken where it shows so many times as many of them.
const BETTER: f64 = 1.25;
/// What a view within a scene of rooms tells counts so many times against one from outside.
const ROOMS: f64 = 1.4;
/// By how much the steeper views rise above the others, in radians: 25 degrees.
const STEEPER: f64 = 25.0 * PI / 180.0;
/// Rays across a picture by which one from inside and one from outside are compared.
const ACROSS: u32 = 40;
/// Cells of a grid along the longest side of a scene, in each of which a piece of surface is of one body.
const CELLS: f64 = 16.0;
/// Of the directions over a surface, one in so many is asked whether it meets nothing.
const OPEN: usize = 4;
/// A ray goes on so much of its way past what it does not meet.
const PAST: f32 = 1e-5;
/// So much of the way to what is around the scene an eye may take.
const BEFORE: f64 = 0.9;

/// True where most of the free space is closed.
fn is_closed(places: &[Place]) -> bool {
    let closed = places.iter().filter(|place| place.1 >= CLOSED).count();
    closed >= 2 && 5 * closed >= 3 * places.len()
}

/// A place where there is room, and how many directions meet fronts there.
type Place = (DVec3, u32);

/// A view from within a scene.
pub(super) struct Within {
    /// Eye and look-at point.
    pub through: [DVec3; 2],
    /// How many times what it tells counts.
    pub counts: f64,
    /// Most of the free space is closed.
    pub is_closed: bool,
    /// The closed places.
    pub places: Vec<DVec3>,
}

/// The scene as a place to look around in.
pub(super) struct Room<'a> {
    pub world: &'a World,
    backend: &'a dyn RayBackend,
    /// What no ray meets here.
    pub around: &'a [u32],
    up: DVec3,
    /// The part of the scene that is looked at, and whether that is not all.
    pub focus: Bounds,
    pub is_part: bool,
    /// What is to be seen.
    points: Vec<Point>,
}

impl<'a> Room<'a> {
    pub fn of(world: &'a World, backend: &'a dyn RayBackend, around: &'a [u32], up: DVec3) -> Self {
        let focus = focus(world, around);
        Self {
            world,
            backend,
            around,
            up: up.normalize_or(DVec3::Y),
            focus: focus.unwrap_or(extent(world, around)),
            is_part: focus.is_some(),
            points: points(world, around),
        }
    }

    fn first(&self, eye: DVec3, toward: DVec3) -> Option<SurfaceHit> {
        self.first_of([eye, toward], Stops::Any, |instance| {
            !self.around.contains(&instance)
        })
    }

    /// The same without what lets some of the light through: glass closes no room.
    fn first_wall(&self, eye: DVec3, toward: DVec3) -> Option<SurfaceHit> {
        self.first_of([eye, toward], Stops::All, |instance| {
            !self.around.contains(&instance)
        })
    }

    /// The first of what is wanted and stops as much.
    fn first_of(
        &self,
        [eye, toward]: [DVec3; 2],
        stops: Stops,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<SurfaceHit> {
        let mut ray = Ray {
            origin: eye.as_vec3().to_array(),
            direction: toward.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        loop {
            let hit = self.backend.closest_that(&ray, stops)?;
            if wanted(hit.instance) {
                // What is baked as the front.
                let is_turned = self.world.is_turned_over(hit.instance, hit.triangle);
                let front = hit.front != is_turned;
                return Some(SurfaceHit { front, ..hit });
            }
            ray.t_min = (hit.t * (1.0 + PAST)).max(ray.t_min.next_up());
        }
    }

    /// As much of a way from a place as ends well before what is around.
    pub fn before_what_is_around(&self, place: DVec3, way: DVec3) -> DVec3 {
        let end = self.first_of([place, way], Stops::Any, |instance| {
            self.around.contains(&instance)
        });
        way * end.map_or(1.0, |hit| BEFORE * f64::from(hit.t)).min(1.0)
    }

    /// True where an eye at a place sees the front of a point.
    fn sees(&self, eye: DVec3, point: &Point) -> bool {
        let hit = self.first(eye, point.at - eye);
        hit.is_some_and(|hit| hit.front && (hit.instance, hit.triangle) == point.triangle)
    }

    /// A distance beyond all that is looked at.
    fn far(&self) -> f64 {
        2.0 * (self.focus.max - self.focus.min).length()
    }

    /// The direction from which most points are seen, of eight around the scene and eight steeper ones: that of
    /// [`Camera::front`] unless many more are from another around, and a steeper one where many more are from there.
    pub fn outside(&self) -> DVec3 {
        let front = Camera::front(self.up);
        let axis = self.up.cross(front).normalize_or(DVec3::X);
        let rings = [0.0, STEEPER].map(|rise| DQuat::from_axis_angle(axis, -rise) * front);
        let seen = |toward: DVec3| {
            let is_seen = |point: &&Point| self.sees(point.at + self.far() * toward, point);
            self.points.iter().filter(is_seen).count()
        };
        let mut best = (seen(rings[0]), rings[0]);
        for ring in rings {
            let turned = (0..8)
                .map(|step| DQuat::from_axis_angle(self.up, TAU * f64::from(step) / 8.0) * ring);
            let most = turned.map(|toward| (seen(toward), toward));
            let most = most.reduce(|a, b| if b.0 > a.0 { b } else { a });
            best = most
                .filter(|most| most.0 as f64 > BETTER * best.0 as f64)
                .unwrap_or(best);
        }
        best.1
    }

    /// What rays from places in directions tell of what they meet, in bits: the entropy of the pieces of surface whose
    /// fronts they meet. Backs tell nothing. A piece is what lies in one cell of a grid over the scene and faces one of
    /// six ways, so that a fine mesh tells no more than a coarse one. P.-P. Vázquez, M. Feixas, M. Sbert, W. Heidrich,
    /// "Viewpoint Selection using Viewpoint Entropy" (2001), whose pieces are the triangles, without what lies behind
    /// the scene.
    pub fn told(&self, rays: impl Iterator<Item = [DVec3; 2]>) -> f64 {
        let cell = (self.focus.max - self.focus.min).max_element() / CELLS;
        let hits = rays.filter_map(|[eye, toward]| {
            let hit = self.first(eye, toward)?;
            let at = eye + f64::from(hit.t) * toward - self.focus.min;
            let normal = normal(&self.world.corners(hit.instance, hit.triangle));
            let axis = normal.abs().max_position();
            let place = (at / cell).floor().as_i64vec3().to_array();
            Some((hit.front, (place, axis, normal[axis] > 0.0)))
        });
        let hits: Vec<_> = hits.collect();
        let fronts = hits.iter().filter(|hit| hit.0);
        let mut fronts: Vec<_> = fronts.map(|hit| hit.1).collect();
        fronts.sort_unstable();
        let share = |same: &[_]| same.len() as f64 / hits.len() as f64;
        let shares = fronts.chunk_by(|a, b| a == b).map(share);
        shares.map(|share| -share * share.log2()).sum()
    }

    /// Rays through the picture of a camera.
    pub fn through(&self, camera: &Camera) -> impl Iterator<Item = [DVec3; 2]> {
        let [width, height] = camera.size.map(f64::from);
        (0..ACROSS * ACROSS).map(move |index| {
            let part = |k: u32| (f64::from(k) + 0.5) / f64::from(ACROSS);
            let [x, y] = [width * part(index % ACROSS), height * part(index / ACROSS)];
            [camera.eye, camera.direction(x, y)]
        })
    }

    /// Places in the scene's box that are in no solid.
    pub fn places(&self) -> Vec<Place> {
        let bounds = self.focus;
        let extent = bounds.max - bounds.min;
        let place = |index: u32| {
            let part = [index % 5, index / 5 % 5, index / 25].map(|k| (f64::from(k) + 0.5) / 5.0);
            let eye = bounds.min + extent * DVec3::from_array(part);
            let (mut fronts, mut backs) = (0, 0);
            for k in 0..AROUND {
                match self.first_wall(eye, spiral(k)) {
                    Some(hit) if hit.front => fronts += 1,
                    Some(_) => backs += 1,
                    None => {}
                }
            }
            (backs < SOLID).then_some((eye, fronts))
        };
        (0..5 * 5 * 5).filter_map(place).collect()
    }

    /// The view from within that shows most; `None` where no place is half open.
    pub fn within(&self) -> Option<Within> {
        let places = self.places();
        let is_closed = is_closed(&places);
        let least = if is_closed { CLOSED } else { HALF_OPEN };
        // Below land that looks down there is no floor.
        let has_floor = |eye: DVec3| self.shut(eye, -self.up) >= FLOOR;
        let eyes = places.iter().filter(|place| place.1 >= least);
        let eyes = eyes.map(|place| place.0).filter(|eye| has_floor(*eye));
        let through = self.best(eyes, |_, _| true)?;
        let closed = places.iter().filter(|place| place.1 >= CLOSED);
        let closed: Vec<DVec3> = closed.map(|place| place.0).collect();
        // A place counts by how much of it is roofed: a doll's house without a roof is looked at from above, a cave or
        // a hall below a skylight is not. Nobody is to look at the outside of rooms, unless that tells far more: then
        // what is closed are cupboards.
        let counts = match is_closed {
            true if self.is_furnished(&closed) => ROOMS,
            true => 1.0,
            false => self.shut(through[0], self.up),
        };
        Some(Within {
            through,
            counts,
            is_closed,
            places: closed,
        })
    }

    /// True where at least as many points are seen from closed places as from outside alone. Rooms show what they have
    /// within; the fronts, handles and feet of a piece of furniture are outside.
    fn is_furnished(&self, closed: &[DVec3]) -> bool {
        let is_within = |point: &&Point| closed.iter().any(|eye| self.sees(*eye, point));
        let (within, others): (Vec<_>, Vec<_>) = self.points.iter().partition(is_within);
        let from = |point: &Point, k: u32| point.at + self.far() * spiral(k);
        let is_outside = |point: &&&Point| (0..AROUND).any(|k| self.sees(from(point, k), point));
        within.len() >= others.iter().filter(is_outside).count()
    }

    /// The view from within that shows most of what sees the sky; `None` where no half open place does.
    pub fn within_light(&self) -> Option<[DVec3; 2]> {
        let places = self.places().into_iter();
        let eyes = places.filter(|place| place.1 >= HALF_OPEN);
        self.best(eyes.map(|place| place.0), |at, hit| self.is_open(at, hit))
    }

    /// The share of the directions of a place toward a side that meet fronts.
    pub fn shut(&self, eye: DVec3, side: DVec3) -> f64 {
        let toward_side = || (0..AROUND).map(spiral).filter(|way| way.dot(side) > 0.0);
        let is_met = |toward: &DVec3| self.first(eye, *toward).is_some_and(|hit| hit.front);
        toward_side().filter(is_met).count() as f64 / toward_side().count().max(1) as f64
    }

    /// True where some of a few rays over the front of a hit, which lies at a place, meet nothing.
    fn is_open(&self, at: DVec3, hit: &SurfaceHit) -> bool {
        let normal = self
            .world
            .face(hit.instance, hit.triangle)
            .normalize_or_zero();
        let from = at + f64::from(PAST) * self.far() * normal;
        let over = (0..AROUND).map(spiral).filter(|way| way.dot(normal) > 0.25);
        over.step_by(OPEN)
            .any(|way| self.first(from, way).is_none())
    }

    /// Eye, one of some, and look-at point that show most of what counts; `None` where nothing counts.
    fn best(
        &self,
        eyes: impl Iterator<Item = DVec3>,
        counts: impl Fn(DVec3, &SurfaceHit) -> bool,
    ) -> Option<[DVec3; 2]> {
        let mut best: Option<(f64, [DVec3; 2])> = None;
        for eye in eyes {
            for step in 0..12 {
                let (score, far) = self.depth(eye, TAU * f64::from(step) / 12.0, &counts);
                if score > best.map_or(0.0, |(most, _)| most) {
                    best = Some((score, [eye, far]));
                }
            }
        }
        best.map(|(_, view)| view)
    }

    /// How much is to be seen in a horizontal direction, and a point to look at there: the mean logarithm of the
    /// distance of what is met and counts; things close to the eye and backs count nothing.
    fn depth(
        &self,
        eye: DVec3,
        azimuth: f64,
        counts: impl Fn(DVec3, &SurfaceHit) -> bool,
    ) -> (f64, DVec3) {
        let bounds = self.focus;
        let near = 0.03 * (bounds.max - bounds.min).length();
        let ahead = self.up.any_orthonormal_vector();
        let forward = DQuat::from_axis_angle(self.up, azimuth) * ahead - 0.15 * self.up;
        let right = forward.cross(self.up).normalize_or(DVec3::X);
        let mut sum = 0.0;
        for index in 0..9 * 5 {
            let [x, y] = [index % 9 - 4, index / 9 - 2].map(f64::from);
            let toward = forward + right * (0.2 * x) + self.up * (0.2 * y);
            let hit = self.first(eye, toward).filter(|hit| hit.front);
            let hit = hit.filter(|hit| counts(eye + f64::from(hit.t) * toward, hit));
            if let Some(hit) = hit {
                sum += (f64::from(hit.t) * toward.length() / near).max(1.0).ln();
            }
        }
        (sum, eye + forward)
    }
}

/// The k-th of [`AROUND`] directions on a spiral over the sphere.
fn spiral(k: u32) -> DVec3 {
    let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(AROUND);
    let (sin, cos) = (f64::from(k) * PI * (3.0 - 5.0f64.sqrt())).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}
