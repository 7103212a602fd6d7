//! Where a scene is best looked at from when nobody says: around it, three quarters from above; inside it, where it is
//! closed.

use crate::framing::{drawn, extent};
use crate::{Camera, Error, Framing};
use glam::{DQuat, DVec3};
use rays::{Bounds, Ray, RayBackend, SurfaceHit, World};
use std::f64::consts::{PI, TAU};

/// Vertical field of view inside of a room, in radians: 65 degrees.
const WIDE: f64 = 65.0 * PI / 180.0;
/// Directions in which a place looks around.
const AROUND: u32 = 64;
/// A place is closed where so many of them meet fronts of surfaces, and half open where fewer do: a hall below a
/// skylight.
const CLOSED: u32 = 58;
const HALF_OPEN: u32 = 36;
/// Points on surfaces by which a view from inside and one from outside are compared.
const POINTS: usize = 1024;
/// The view from inside has to show so many times as many: a doll's house without a roof is looked at from above, a
/// hall below a skylight is not.
const MORE: usize = 3;
/// A place is inside of a solid where so many meet backs.
const SOLID: u32 = 12;
/// A view from another side is taken where it shows so much more of the fronts of surfaces.
const BETTER: f64 = 0.15;

/// Triangles that are looked at, at most, to find where the scene is.
const SAMPLED: usize = 50_000;
/// Thousandths of the triangles that may surround the scene on each side.
const CUT: usize = 10;
/// They do where the rest takes less than this part of the whole extent.
const SMALL: f64 = 0.2;

impl Framing {
    /// The camera that shows a scene best: the one of [`Framing::camera`], from another side where that shows more
    /// fronts of surfaces, and inside where most of the free space in the scene's box is closed, or where three times
    /// as much of the surfaces' area is seen from a place within that is half open. Inside, the field of view is at
    /// least 65 degrees unless `keep_fov`.
    ///
    /// # Errors
    /// [`Error::Camera`], see [`Camera::new`].
    pub fn fitted(
        &self,
        world: &World,
        backend: &dyn RayBackend,
        keep_fov: bool,
    ) -> Result<Camera, Error> {
        if self.eye.is_some() || self.look.is_some() {
            return self.camera(world);
        }
        let focus = focus(world);
        let room = Room {
            backend,
            up: self.up.normalize_or(DVec3::Y),
            focus: focus.unwrap_or(extent(world)),
        };
        let inside = |view| {
            let fov = match keep_fov {
                true => self.fov,
                false => self.fov.max(WIDE),
            };
            Framing { fov, ..*self }.camera_at(view)
        };
        let places = room.places();
        if let Some(view) = room.closed(&places) {
            return inside(view);
        }
        let turned = |step: u32| {
            let angle = TAU * f64::from(step) / 8.0;
            DQuat::from_axis_angle(room.up, angle) * Camera::FRONT
        };
        let shown = (0..8).map(|step| (room.fronts(turned(step)), step));
        let shown: Vec<(f64, u32)> = shown.collect();
        let best = shown
            .iter()
            .fold(shown[0], |a, &b| if b.0 > a.0 { b } else { a });
        let step = if best.0 > shown[0].0 + BETTER {
            best.1
        } else {
            0
        };
        let middle = room.focus.center();
        let eye = match focus {
            None => self.eye_outside(world, turned(step)),
            Some(focus) => {
                let corner = |k: usize| [focus.min, focus.max][k];
                let corners = (0..8).map(|k| {
                    let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(corner);
                    DVec3::new(x.x, y.y, z.z)
                });
                Camera::framing(corners, middle, turned(step), self.up, self.fov, self.size)
            }
        };
        let outside = self.camera_at([eye, middle])?;
        let Some(view) = room.best(&places, HALF_OPEN) else {
            return Ok(outside);
        };
        let (inside, points) = (inside(view)?, points(world));
        let [more, fewer] = [&inside, &outside].map(|camera| room.shown(camera, &points));
        Ok(if more > MORE * fewer { inside } else { outside })
    }
}

/// Places in a scene from which people look, where most of the free space in its box is closed; none elsewhere.
pub fn places_within(world: &World, backend: &dyn RayBackend) -> Vec<DVec3> {
    let room = Room {
        backend,
        up: DVec3::Y,
        focus: focus(world).unwrap_or(extent(world)),
    };
    let places = room.places();
    match is_closed(&places) {
        true => (places.iter().filter(|place| place.1 >= CLOSED))
            .map(|place| place.0)
            .collect(),
        false => Vec::new(),
    }
}

/// True where most of the free space is closed.
fn is_closed(places: &[Place]) -> bool {
    let closed = places.iter().filter(|place| place.1 >= CLOSED).count();
    closed >= 2 && 5 * closed >= 3 * places.len()
}

/// A place where there is room, and how many directions meet fronts there.
type Place = (DVec3, u32);

/// The scene as a place to look around in.
struct Room<'a> {
    backend: &'a dyn RayBackend,
    up: DVec3,
    /// The part of the scene that is looked at.
    focus: Bounds,
}

impl Room<'_> {
    fn first(&self, eye: DVec3, toward: DVec3) -> Option<SurfaceHit> {
        self.backend.closest(&Ray {
            origin: eye.as_vec3().to_array(),
            direction: toward.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })
    }

    /// The share of what parallel rays from a direction meet in the scene's box that are fronts of surfaces.
    fn fronts(&self, toward: DVec3) -> f64 {
        let bounds = self.focus;
        let radius = 0.5 * (bounds.max - bounds.min).length();
        let right = self.up.cross(toward).normalize_or(DVec3::X);
        let upright = toward.cross(right);
        let (mut met, mut fronts) = (0u32, 0u32);
        for index in 0..20 * 20 {
            let [x, y] = [index % 20, index / 20].map(|k| (f64::from(k) + 0.5) / 10.0 - 1.0);
            let eye = bounds.center() + radius * (2.0 * toward + x * right + y * upright);
            if let Some(hit) = self.first(eye, -toward) {
                met += 1;
                fronts += u32::from(hit.front);
            }
        }
        f64::from(fronts) / f64::from(met.max(1))
    }

    /// Places in the scene's box that are in no solid.
    fn places(&self) -> Vec<Place> {
        let bounds = self.focus;
        let extent = bounds.max - bounds.min;
        let place = |index: u32| {
            let part = [index % 5, index / 5 % 5, index / 25].map(|k| (f64::from(k) + 0.5) / 5.0);
            let eye = bounds.min + extent * DVec3::from_array(part);
            let (mut fronts, mut backs) = (0, 0);
            for k in 0..AROUND {
                match self.first(eye, spiral(k)) {
                    Some(hit) if hit.front => fronts += 1,
                    Some(_) => backs += 1,
                    None => {}
                }
            }
            (backs < SOLID).then_some((eye, fronts))
        };
        (0..5 * 5 * 5).filter_map(place).collect()
    }

    /// Eye and look-at point inside, where most of the free space is closed.
    fn closed(&self, places: &[Place]) -> Option<[DVec3; 2]> {
        is_closed(places).then(|| self.best(places, CLOSED))?
    }

    /// Eye and look-at point that show most, at a place where so many directions meet fronts.
    fn best(&self, places: &[Place], fronts: u32) -> Option<[DVec3; 2]> {
        let mut best: Option<(f64, [DVec3; 2])> = None;
        for &(eye, _) in places.iter().filter(|place| place.1 >= fronts) {
            for step in 0..12 {
                let (score, far) = self.depth(eye, TAU * f64::from(step) / 12.0);
                if best.is_none_or(|(most, _)| score > most) {
                    best = Some((score, [eye, far]));
                }
            }
        }
        best.map(|(_, view)| view)
    }

    /// How many of some points on surfaces a camera sees from their front.
    fn shown(&self, camera: &Camera, points: &[DVec3]) -> usize {
        let is_shown = |point: &&DVec3| {
            let way = **point - camera.eye;
            let ahead = way.dot(camera.forward);
            let [width, height] = camera.size.map(f64::from);
            let [wide, high] = [camera.slope * width / height, camera.slope];
            let is_in = way.dot(camera.right).abs() <= wide * ahead
                && way.dot(camera.up).abs() <= high * ahead;
            let hit = is_in.then(|| self.first(camera.eye, way)).flatten();
            hit.is_some_and(|hit| hit.front && (f64::from(hit.t) - 1.0).abs() < 1e-3)
        };
        points.iter().filter(is_shown).count()
    }

    /// How much is to be seen in a horizontal direction, and a point to look at there: the mean logarithm of the
    /// distance of what is met; things close to the eye and backs count nothing.
    fn depth(&self, eye: DVec3, azimuth: f64) -> (f64, DVec3) {
        let bounds = self.focus;
        let near = 0.03 * (bounds.max - bounds.min).length();
        let ahead = self.up.any_orthonormal_vector();
        let forward = DQuat::from_axis_angle(self.up, azimuth) * ahead - 0.15 * self.up;
        let right = forward.cross(self.up).normalize_or(DVec3::X);
        let mut sum = 0.0;
        for index in 0..9 * 5 {
            let [x, y] = [index % 9 - 4, index / 9 - 2].map(f64::from);
            let toward = forward + right * (0.2 * x) + self.up * (0.2 * y);
            if let Some(hit) = self.first(eye, toward).filter(|hit| hit.front) {
                sum += (f64::from(hit.t) * toward.length() / near).max(1.0).ln();
            }
        }
        (sum, eye + forward)
    }
}

/// The box of nearly all triangles, where it is far smaller than that of all: a few of them, such as a plane of water,
/// then only surround the scene. `None` for other scenes.
fn focus(world: &World) -> Option<Bounds> {
    let instances = drawn(world);
    let count = |instance: u32| world.part(instance).1.triangles().len() as u32;
    let total: usize = instances.clone().map(|i| count(i) as usize).sum();
    let all = instances.flat_map(|i| (0..count(i)).map(move |triangle| (i, triangle)));
    let middle = |(i, triangle)| world.corners(i, triangle).iter().sum::<DVec3>() / 3.0;
    let middles: Vec<DVec3> = all.step_by(total / SAMPLED + 1).map(middle).collect();
    let range = |axis: usize| {
        let mut along: Vec<f64> = middles.iter().map(|middle| middle[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        let cut = along.len() * CUT / 1000;
        [along[cut], along[along.len() - 1 - cut]]
    };
    if middles.len() * CUT < 1000 {
        return None;
    }
    let [x, y, z] = [0, 1, 2].map(range);
    let (min, max) = (DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
    let bounds = extent(world);
    ((max - min).length() < SMALL * (bounds.max - bounds.min).length())
        .then_some(Bounds { min, max })
}

/// Points on the surfaces of a scene, evenly by area.
fn points(world: &World) -> Vec<DVec3> {
    let triangles = drawn(world).flat_map(|instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        (0..count).map(move |triangle| world.corners(instance, triangle))
    });
    let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
    let total: f64 = triangles.clone().map(|corners| area(&corners)).sum();
    let step = total / POINTS as f64;
    let (mut points, mut before) = (Vec::with_capacity(POINTS), 0.0);
    for [a, b, c] in triangles {
        before += area(&[a, b, c]);
        while points.len() < POINTS && (points.len() as f64 + 0.5) * step < before {
            // Of a triangle's points each has its own place in it.
            let k = points.len() as f64;
            let [u, v] = [0.754_877_666, 0.569_840_291].map(|turn| (k * turn).fract());
            let root = f64::sqrt(u);
            points.push(a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v));
        }
    }
    points
}

/// The k-th of [`AROUND`] directions on a spiral over the sphere.
fn spiral(k: u32) -> DVec3 {
    let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(AROUND);
    let (sin, cos) = (f64::from(k) * PI * (3.0 - 5.0f64.sqrt())).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{white, world};
    use glam::Vec3;

    const FRAMING: Framing = Framing {
        eye: None,
        look: None,
        up: DVec3::Y,
        fov: 0.7,
        size: [160, 90],
    };

    /// The six sides of a box from 0 to (8, 3, 6), fronts inward; only some of them.
    fn room(sides: usize) -> Vec<crate::fixture::Sheet> {
        let [x, y, z] = [Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z * 6.0];
        let sides_of = [
            [Vec3::ZERO, z, x],
            [Vec3::ZERO, y, z],
            [Vec3::ZERO, x, y],
            [x, z, y],
            [z, y, x],
            [y, x, z],
        ];
        sides_of.into_iter().take(sides).map(white).collect()
    }

    #[test]
    fn a_closed_room_is_looked_at_from_inside_and_an_open_one_from_outside() {
        for (sides, inside) in [(6, true), (5, false), (3, false)] {
            let (world, backend) = world(&room(sides));
            let camera = FRAMING.fitted(&world, backend.as_ref(), false).unwrap();
            let bounds = world.bounds();
            let within = camera.eye.cmpgt(bounds.min).all() && camera.eye.cmplt(bounds.max).all();
            assert_eq!(within, inside, "{sides} sides: {camera:?}");
            assert_eq!(camera.slope > 0.6, inside, "{sides} sides: {camera:?}");
        }
    }

    #[test]
    fn a_hall_below_a_skylight_is_looked_at_from_inside() {
        // Three eighths of its ceiling are open.
        let [x, y, z] = [Vec3::X * 2.5, Vec3::Y * 3.0, Vec3::Z * 6.0];
        let mut sheets = room(5);
        sheets.extend([Vec3::ZERO, Vec3::X * 5.5].map(|at| white([at + y, x, z])));
        let (world, backend) = world(&sheets);
        let camera = FRAMING.fitted(&world, backend.as_ref(), false).unwrap();
        let bounds = world.bounds();
        let within = camera.eye.cmpgt(bounds.min).all() && camera.eye.cmplt(bounds.max).all();
        assert!(within, "{camera:?}");
    }

    #[test]
    fn a_wall_that_shows_its_back_is_looked_at_from_the_other_side() {
        let wall = |front: bool| {
            let [a, b] = [Vec3::X * 4.0, Vec3::Y * 4.0];
            world(&[white(if front {
                [Vec3::ZERO, a, b]
            } else {
                [Vec3::ZERO, b, a]
            })])
        };
        for (front, side) in [(true, 1.0), (false, -1.0)] {
            let (world, backend) = wall(front);
            let camera = FRAMING.fitted(&world, backend.as_ref(), false).unwrap();
            assert!(camera.eye.z * side > 0.0, "{front}: {camera:?}");
        }
    }

    #[test]
    fn a_plane_far_wider_than_the_scene_is_not_what_is_looked_at() {
        let card = |k: i32| {
            let place = Vec3::new((k % 10) as f32, (k / 10) as f32, 0.0);
            white([place, Vec3::X, Vec3::Y])
        };
        let mut sheets: Vec<_> = (0..100).map(card).collect();
        sheets.push(crate::fixture::ground());
        let (world, backend) = world(&sheets);
        let camera = FRAMING.fitted(&world, backend.as_ref(), false).unwrap();
        assert!(camera.eye.length() < 100.0, "{camera:?}");
    }

    #[test]
    fn what_is_given_stands() {
        let (world, backend) = world(&room(6));
        let framing = Framing {
            look: Some(DVec3::ONE),
            ..FRAMING
        };
        let camera = framing.fitted(&world, backend.as_ref(), false).unwrap();
        assert_eq!(camera, framing.camera(&world).unwrap());
    }
}
