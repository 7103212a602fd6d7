//! The scene as a place to look around in: what rays from a place meet, how closed it is there, and which view shows
//! most.

use super::subject::{Point, focus, points};
use crate::framing::extent;
use crate::{Camera, Framing};
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
/// And one from the side next to it where it shows so many times as many.
const BESIDE: f64 = 1.125;
/// By how much the steeper views rise above the others, in radians: 25 degrees.
const STEEPER: f64 = 25.0 * PI / 180.0;
/// Of the points one in so many is asked which view from within shows most.
const ASKED: usize = 2;
/// Of the directions over a surface, one in so many is asked whether it meets nothing.
const OPEN: usize = 4;
/// A point that sees the sky counts so many times in a brighter view.
const LIT: usize = 4;
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
    pub camera: Camera,
    /// How many points it shows, by how much of what is above it is closed: a doll's house without a roof is looked at
    /// from above, a cave or a hall below a skylight is not.
    pub shows: f64,
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

    /// What a ray from a place in a direction meets first, but for what only stands around the scene.
    pub fn first(&self, eye: DVec3, toward: DVec3) -> Option<SurfaceHit> {
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

    /// How many points are seen from far away in a direction.
    fn seen(&self, toward: DVec3) -> usize {
        let is_seen = |point: &&Point| self.sees(point.at + self.far() * toward, point);
        self.points.iter().filter(is_seen).count()
    }

    /// How many points are seen in the picture of a camera.
    pub fn shown(&self, camera: &Camera) -> usize {
        let is_shown =
            |point: &&Point| camera.frames(point.at - camera.eye) && self.sees(camera.eye, point);
        self.points.iter().filter(is_shown).count()
    }

    /// The direction from which most points are seen, of eight around the scene and eight steeper ones: that of
    /// [`Camera::front`] unless many more are from another around, and a steeper one where many more are from there.
    /// From the next one to either side some more are enough, so that none is taken that looks at a corner behind
    /// which most is hidden.
    pub fn outside(&self) -> DVec3 {
        let front = Camera::front(self.up);
        let axis = self.up.cross(front).normalize_or(DVec3::X);
        let toward = |index: usize| {
            let rise = [0.0, STEEPER][index / 8];
            let turn = TAU * (index % 8) as f64 / 8.0;
            DQuat::from_axis_angle(self.up, turn) * (DQuat::from_axis_angle(axis, -rise) * front)
        };
        let seen: Vec<f64> = (0..16)
            .map(|index| self.seen(toward(index)) as f64)
            .collect();
        let better = |best: usize, others: &[usize], by: f64| {
            let others = others.iter().copied();
            let most = others.reduce(|a, b| if seen[b] > seen[a] { b } else { a });
            most.filter(|&most| seen[most] > by * seen[best])
                .unwrap_or(best)
        };
        let rings = [0, 8].map(|ring| [0, 1, 2, 3, 4, 5, 6, 7].map(|step| ring + step));
        let best = rings
            .iter()
            .fold(0, |best, ring| better(best, ring, BETTER));
        let beside = [1, 7].map(|turn| best / 8 * 8 + (best + turn) % 8);
        toward(better(best, &beside, BESIDE))
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

    /// The view from within that shows most, through the lens of a framing; `None` where no place is half open.
    pub fn within(&self, lens: &Framing) -> Option<Within> {
        let places = self.places();
        let is_closed = is_closed(&places);
        let least = if is_closed { CLOSED } else { HALF_OPEN };
        let eyes = places.iter().filter(|place| place.1 >= least);
        let camera = self.best(eyes.map(|place| place.0), lens, |_| 1)?;
        let closed = places.iter().filter(|place| place.1 >= CLOSED);
        Some(Within {
            camera,
            shows: self.shut(camera.eye, self.up) * self.shown(&camera) as f64,
            is_closed,
            places: closed.map(|place| place.0).collect(),
        })
    }

    /// The closed places, and whether most of the free space is closed.
    pub fn closed(&self) -> (Vec<DVec3>, bool) {
        let places = self.places();
        let closed = places.iter().filter(|place| place.1 >= CLOSED);
        (closed.map(|place| place.0).collect(), is_closed(&places))
    }

    /// True where a place is above a floor: below land that looks down there is none.
    pub fn has_floor(&self, eye: DVec3) -> bool {
        self.shut(eye, -self.up) >= FLOOR
    }

    /// True where at least as many points are seen from closed places as from outside alone. Rooms show what they have
    /// within; the fronts, handles and feet of a piece of furniture are outside.
    pub fn is_furnished(&self, closed: &[DVec3]) -> bool {
        let is_within = |point: &&Point| closed.iter().any(|eye| self.sees(*eye, point));
        let (within, others): (Vec<_>, Vec<_>) = self.points.iter().partition(is_within);
        let from = |point: &Point, k: u32| point.at + self.far() * spiral(k);
        let is_outside = |point: &&&Point| (0..AROUND).any(|k| self.sees(from(point, k), point));
        within.len() >= others.iter().filter(is_outside).count()
    }

    /// The view from within that shows most where what sees the sky counts for more; `None` where no
    /// place is half open.
    pub fn within_light(&self, lens: &Framing) -> Option<Camera> {
        let places = self.places().into_iter();
        let eyes = places.filter(|place| place.1 >= HALF_OPEN);
        let counts = |point: &Point| if self.is_open(point) { LIT } else { 1 };
        self.best(eyes.map(|place| place.0), lens, counts)
    }

    /// The share of the directions of a place toward a side that meet fronts.
    pub fn shut(&self, eye: DVec3, side: DVec3) -> f64 {
        let toward_side = || (0..AROUND).map(spiral).filter(|way| way.dot(side) > 0.0);
        let is_met = |toward: &DVec3| self.first(eye, *toward).is_some_and(|hit| hit.front);
        toward_side().filter(is_met).count() as f64 / toward_side().count().max(1) as f64
    }

    /// True where some of a few rays over the front of a point meet nothing.
    fn is_open(&self, point: &Point) -> bool {
        let (instance, triangle) = point.triangle;
        let normal = self.world.face(instance, triangle).normalize_or_zero();
        let from = point.at + f64::from(PAST) * self.far() * normal;
        let over = (0..AROUND).map(spiral).filter(|way| way.dot(normal) > 0.25);
        over.step_by(OPEN)
            .any(|way| self.first(from, way).is_none())
    }

    /// The view from one of some eyes that stand above a floor, in one of twelve directions around, that shows most by
    /// what each point counts; `None` where none shows anything.
    fn best(
        &self,
        eyes: impl Iterator<Item = DVec3>,
        lens: &Framing,
        counts: impl Fn(&Point) -> usize,
    ) -> Option<Camera> {
        let points = self.points.iter().step_by(ASKED);
        let points: Vec<_> = points.map(|point| (point, counts(point))).collect();
        let ahead = self.up.any_orthonormal_vector();
        let mut best = (0, None);
        for eye in eyes.filter(|eye| self.has_floor(*eye)) {
            let seen = points.iter().filter(|(point, _)| self.sees(eye, point));
            let seen: Vec<_> = seen
                .map(|(point, counts)| (point.at - eye, *counts))
                .collect();
            for step in 0..12 {
                let turn = DQuat::from_axis_angle(self.up, TAU * f64::from(step) / 12.0);
                let camera = lens.camera_at([eye, eye + turn * ahead - 0.15 * self.up]);
                let Ok(camera) = camera else { continue };
                let shown = seen.iter().filter(|(way, _)| camera.frames(*way));
                let shown = shown.map(|(_, counts)| counts).sum();
                if shown > best.0 {
                    best = (shown, Some(camera));
                }
            }
        }
        best.1
    }
}

/// The k-th of [`AROUND`] directions on a spiral over the sphere.
fn spiral(k: u32) -> DVec3 {
    let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(AROUND);
    let (sin, cos) = (f64::from(k) * PI * (3.0 - 5.0f64.sqrt())).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}
