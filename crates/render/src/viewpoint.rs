//! Where a scene is best looked at from when nobody says: around it, three quarters from above; inside it, where it is
//! closed.

use crate::framing::{drawn, extent};
use crate::{Camera, Error, Framing};
use glam::{DQuat, DVec3};
use rays::{Bounds, Ray, RayBackend, Stops, SurfaceHit, World};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Vertical field of view inside of a room, in radians: 65 degrees.
const WIDE: f64 = 65.0 * PI / 180.0;
/// Directions in which a place looks around.
const AROUND: u32 = 64;
/// A place is closed where so many of them meet fronts of surfaces, and half open where fewer do: a hall below a
/// skylight.
const CLOSED: u32 = 58;
const HALF_OPEN: u32 = 36;
/// Points on surfaces by which views from outside are compared.
const POINTS: usize = 1024;
/// A place is inside of a solid where so many meet backs.
const SOLID: u32 = 12;
/// A view from another side is taken where it shows so many times as many of them.
const BETTER: f64 = 1.25;
/// By how much the steeper views rise above the others, in radians: 25 degrees.
const STEEPER: f64 = 25.0 * PI / 180.0;
/// Rays across a picture by which one from inside and one from outside are compared.
const ACROSS: u32 = 40;
/// Cells of a grid along the longest side of a scene, in each of which a piece of surface is of one body.
const CELLS: f64 = 16.0;
/// Flat regions are told apart by so much of a normal, and by so much of the scene's extent along it.
const TURN: f64 = 1.0 / 8.0;
const STEP: f64 = 1.0 / 1024.0;
/// A ray goes on so much of its way past what it does not meet.
const PAST: f32 = 1e-5;
/// So much of the way to what is around the scene an eye may take.
const BEFORE: f64 = 0.9;

/// Triangles that are looked at, at most, to find where the scene is.
const SAMPLED: usize = 50_000;
/// Thousandths of the triangles that may surround the scene on each side.
const CUT: usize = 10;
/// They do where the rest takes less than this part of the whole extent.
const SMALL: f64 = 0.2;

impl Framing {
    /// The camera that shows a scene best: the one of [`Framing::camera`], from another side or steeper where that
    /// shows more of it, and inside where most of the free space in the scene's box is closed, or where a place within
    /// tells more than the view from outside, counted by how much of what is above it is closed. Inside, the field of
    /// view is at least 65 degrees unless `keep_fov`.
    ///
    /// * `around`: instances that only stand around the scene, as a sky dome does. They are not what is looked at, and
    ///   the eye is before them.
    ///
    /// # Errors
    /// [`Error::Camera`], see [`Camera::new`].
    pub fn fitted(
        &self,
        world: &World,
        backend: &dyn RayBackend,
        around: &[u32],
        keep_fov: bool,
    ) -> Result<Camera, Error> {
        if self.eye.is_some() || self.look.is_some() {
            return self.camera(world);
        }
        let room = Room::of(world, backend, around, self.up);
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
        let outside = self.around(&room)?;
        let Some(view) = room.best(&places, HALF_OPEN) else {
            return Ok(outside);
        };
        let inside = inside(view)?;
        // A place counts by how much of it is roofed: a doll's house without a roof is looked at from above, a cave or
        // a hall below a skylight is not.
        let roofed = room.roofed(inside.eye);
        let [within, without] = [&inside, &outside].map(|camera| room.told(room.through(camera)));
        Ok(match roofed * within > without {
            true => inside,
            false => outside,
        })
    }

    /// The camera of [`Framing::fitted`] outside of a scene, whether or not it shows most there.
    ///
    /// # Errors
    /// [`Error::Camera`], see [`Camera::new`].
    pub fn outside(
        &self,
        world: &World,
        backend: &dyn RayBackend,
        around: &[u32],
    ) -> Result<Camera, Error> {
        self.around(&Room::of(world, backend, around, self.up))
    }

    fn around(&self, room: &Room) -> Result<Camera, Error> {
        let toward = room.outside(&points(room.world, room.around));
        let middle = room.focus.center();
        let eye = match room.is_part {
            false => self.eye_outside(room.world, room.around, toward),
            true => {
                let focus = room.focus;
                let corner = |k: usize| [focus.min, focus.max][k];
                let corners = (0..8).map(|k| {
                    let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(corner);
                    DVec3::new(x.x, y.y, z.z)
                });
                Camera::framing(corners, middle, toward, self.up, self.fov, self.size)
            }
        };
        let eye = match room.around {
            [] => eye,
            _ => middle + room.before_what_is_around(middle, eye - middle),
        };
        self.camera_at([eye, middle])
    }
}

/// Places in a scene from which people look, where most of the free space in its box is closed; none elsewhere.
pub fn places_within(world: &World, backend: &dyn RayBackend) -> Vec<DVec3> {
    let room = Room::of(world, backend, &[], DVec3::Y);
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
    world: &'a World,
    backend: &'a dyn RayBackend,
    /// What no ray meets here.
    around: &'a [u32],
    up: DVec3,
    /// The part of the scene that is looked at, and whether that is not all.
    focus: Bounds,
    is_part: bool,
}

impl<'a> Room<'a> {
    fn of(world: &'a World, backend: &'a dyn RayBackend, around: &'a [u32], up: DVec3) -> Self {
        let focus = focus(world, around);
        Self {
            world,
            backend,
            around,
            up: up.normalize_or(DVec3::Y),
            focus: focus.unwrap_or(extent(world, around)),
            is_part: focus.is_some(),
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
    fn before_what_is_around(&self, place: DVec3, way: DVec3) -> DVec3 {
        let end = self.first_of([place, way], Stops::Any, |instance| {
            self.around.contains(&instance)
        });
        way * end.map_or(1.0, |hit| BEFORE * f64::from(hit.t)).min(1.0)
    }

    /// The direction from which most of some points are seen, of eight around the scene and eight steeper ones: that of
    /// [`Camera::front`] unless many more are from another around, and a steeper one where many more are from there.
    fn outside(&self, points: &[Point]) -> DVec3 {
        let front = Camera::front(self.up);
        let axis = self.up.cross(front).normalize_or(DVec3::X);
        let rings = [0.0, STEEPER].map(|rise| DQuat::from_axis_angle(axis, -rise) * front);
        let far = 2.0 * (self.focus.max - self.focus.min).length();
        let seen = |toward: DVec3| {
            let is_seen = |point: &&Point| {
                let hit = self.first(point.at + far * toward, -toward);
                hit.is_some_and(|hit| hit.front && (hit.instance, hit.triangle) == point.triangle)
            };
            points.iter().filter(is_seen).count()
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
    fn told(&self, rays: impl Iterator<Item = [DVec3; 2]>) -> f64 {
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
    fn through(&self, camera: &Camera) -> impl Iterator<Item = [DVec3; 2]> {
        let [width, height] = camera.size.map(f64::from);
        (0..ACROSS * ACROSS).map(move |index| {
            let part = |k: u32| (f64::from(k) + 0.5) / f64::from(ACROSS);
            let [x, y] = [width * part(index % ACROSS), height * part(index / ACROSS)];
            [camera.eye, camera.direction(x, y)]
        })
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

    /// Eye and look-at point inside, where most of the free space is closed.
    fn closed(&self, places: &[Place]) -> Option<[DVec3; 2]> {
        is_closed(places).then(|| self.best(places, CLOSED))?
    }

    /// The share of the directions above the horizon of a place that meet fronts.
    fn roofed(&self, eye: DVec3) -> f64 {
        let above = || {
            (0..AROUND)
                .map(spiral)
                .filter(|toward| toward.dot(self.up) > 0.0)
        };
        let is_met = |toward: &DVec3| self.first(eye, *toward).is_some_and(|hit| hit.front);
        above().filter(is_met).count() as f64 / above().count().max(1) as f64
    }

    /// Eye and look-at point that show most, at a place where so many directions or more meet fronts.
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
fn focus(world: &World, around: &[u32]) -> Option<Bounds> {
    let instances = drawn(world, around);
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
    let bounds = extent(world, around);
    ((max - min).length() < SMALL * (bounds.max - bounds.min).length())
        .then_some(Bounds { min, max })
}

/// A point on a triangle, of which instance and number are given.
struct Point {
    at: DVec3,
    triangle: (u32, u32),
}

/// A triangle's normal, of the length of twice its area.
fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a)
}

/// Points on the surfaces of a scene, by the roots of the areas of the flat regions of its objects: what is detailed
/// counts for more than its area, and what is large for more than its number. Into how many triangles a region is cut
/// does not count.
fn points(world: &World, around: &[u32]) -> Vec<Point> {
    let triangles = drawn(world, around).flat_map(|instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        (0..count).map(move |triangle| ((instance, triangle), world.corners(instance, triangle)))
    });
    let bounds = extent(world, around);
    let [middle, size] = [bounds.center(), bounds.max - bounds.min];
    let apart = (size.length() * STEP).max(f64::MIN_POSITIVE);
    let region = |instance: u32, corners: &[DVec3; 3]| {
        let normal = normal(corners).normalize_or_zero();
        let along = normal.dot(corners.iter().sum::<DVec3>() / 3.0 - middle);
        let turned = (normal / TURN).round().as_ivec3().to_array();
        (instance, turned, (along / apart).round() as i64)
    };
    let area = |corners: &[DVec3; 3]| normal(corners).length();
    let mut regions: HashMap<_, f64> = HashMap::new();
    for ((instance, _), corners) in triangles.clone() {
        *regions.entry(region(instance, &corners)).or_default() += area(&corners);
    }
    let weight = |instance: u32, corners: &[DVec3; 3]| {
        let all = regions.get(&region(instance, corners));
        let all = all.copied().filter(|all| *all > 0.0);
        all.map_or(0.0, |all| area(corners) / all.sqrt())
    };
    let weights = triangles
        .clone()
        .map(|((i, _), corners)| weight(i, &corners));
    let total: f64 = weights.sum();
    let step = total / POINTS as f64;
    let (mut points, mut before) = (Vec::with_capacity(POINTS), 0.0);
    for (triangle, corners) in triangles {
        let [a, b, c] = corners;
        before += weight(triangle.0, &corners);
        while points.len() < POINTS && (points.len() as f64 + 0.5) * step < before {
            // Of a triangle's points each has its own place in it.
            let k = points.len() as f64;
            let [u, v] = [0.754_877_666, 0.569_840_291].map(|turn| (k * turn).fract());
            let root = f64::sqrt(u);
            let at = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
            points.push(Point { at, triangle });
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
    use crate::fixture::{see_through, white, world};
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
            let camera = FRAMING
                .fitted(&world, backend.as_ref(), &[], false)
                .unwrap();
            let bounds = world.bounds();
            let within = camera.eye.cmpgt(bounds.min).all() && camera.eye.cmplt(bounds.max).all();
            assert_eq!(within, inside, "{sides} sides: {camera:?}");
            assert_eq!(camera.slope > 0.6, inside, "{sides} sides: {camera:?}");
        }
    }

    #[test]
    fn a_shell_that_lets_light_through_is_looked_at_from_outside() {
        let places: Vec<_> = room(6).iter().map(|sheet| sheet.place).collect();
        for (stops, inside) in [(1.0, true), (0.9, false)] {
            let (world, backend) = see_through(&places, stops);
            let places = places_within(&world, backend.as_ref());
            assert_ne!(places.is_empty(), inside, "{stops}");
        }
    }

    #[test]
    fn a_body_that_is_baked_from_outside_has_no_places_within() {
        // A mattress, whose faces look inward and are drawn from both sides, and something beside it.
        let mut mesh = scene::authored::Mesh::default();
        let corner = |k: u32| [k >> 2, k >> 1 & 1, k & 1].map(|side| side as f32);
        mesh.positions = (0..8).map(corner).collect();
        let sides = [
            [2, 3, 1, 0],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [6, 7, 3, 2],
            [4, 6, 2, 0],
            [1, 3, 7, 5],
        ];
        let split = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        mesh.triangles = sides.into_iter().flat_map(split).collect();
        let mut material = scene::authored::Material::default();
        material.double_sided = true;
        let mut beside = scene::authored::Mesh::default();
        beside.positions = vec![[1.05, 0.0, 0.0], [1.05, 0.0, 0.1], [1.1, 0.0, 0.0]];
        beside.triangles = vec![[0, 1, 2]];
        let scene = scene::Scene::from_meshes(vec![mesh, beside], vec![material]).unwrap();
        let mut world = World::new(std::sync::Arc::new(scene), Default::default()).unwrap();
        let kind = rays::BackendKind::Obvhs(rays::Layout::Cwbvh);
        let backend = rays::build(kind, &world, 1).unwrap();
        let within = places_within(&world, backend.as_ref()).len();
        world.turn_over(std::iter::empty());
        assert!(world.has_turned_over(0) && within > 0, "{within}");
        assert_eq!(places_within(&world, backend.as_ref()), []);
    }

    #[test]
    fn a_hall_below_a_skylight_is_looked_at_from_inside() {
        // Three eighths of its ceiling are open.
        let [x, y, z] = [Vec3::X * 2.5, Vec3::Y * 3.0, Vec3::Z * 6.0];
        let mut sheets = room(5);
        sheets.extend([Vec3::ZERO, Vec3::X * 5.5].map(|at| white([at + y, x, z])));
        let (world, backend) = world(&sheets);
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
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
            let camera = FRAMING
                .fitted(&world, backend.as_ref(), &[], false)
                .unwrap();
            assert!(camera.eye.z * side > 0.0, "{front}: {camera:?}");
        }
    }

    #[test]
    fn a_row_of_houses_is_looked_at_from_its_fronts() {
        // A plain wall toward the view that is taken otherwise, windows on the other side.
        let [x, y, z] = [Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z];
        let mut sheets: Vec<_> = [
            [Vec3::ZERO, y, x],
            [z, x, y],
            [y, z, x],
            [Vec3::ZERO, z, y],
            [x, y, z],
        ]
        .map(white)
        .into();
        sheets.extend((0..24).map(|k| {
            let at = Vec3::new((k % 8) as f32 + 0.2, (k / 8) as f32 + 0.2, -0.01);
            white([at, Vec3::Y * 0.6, Vec3::X * 0.6])
        }));
        let (world, backend) = world(&sheets);
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        assert!(camera.eye.z < 0.0, "{camera:?}");
    }

    /// The six sides of a box, fronts outward, each of so many tiles across.
    fn block(low: Vec3, edge: Vec3, tiles: usize) -> Vec<crate::fixture::Sheet> {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|way| way * edge);
        let sides = [
            [low, x, z],
            [low, z, y],
            [low, y, x],
            [low + x, y, z],
            [low + y, z, x],
            [low + z, x, y],
        ];
        let tile = |[at, a, b]: [Vec3; 3], k: usize| {
            let [i, j] = [k % tiles, k / tiles].map(|k| k as f32);
            let [a, b] = [a, b].map(|way| way / tiles as f32);
            white([at + a * i + b * j, a, b])
        };
        let tiled = sides.map(|side| (0..tiles * tiles).map(move |k| tile(side, k)));
        tiled.into_iter().flatten().collect()
    }

    #[test]
    fn a_finely_meshed_table_is_looked_at_as_a_coarse_one_is() {
        let camera = |tiles: usize| {
            let floor = [Vec3::new(-5.0, 0.0, -5.0), Vec3::Z * 10.0, Vec3::X * 10.0];
            let mut sheets = vec![white(floor)];
            let [low, edge] = [Vec3::new(-1.5, 1.0, -1.5), Vec3::new(3.0, 0.2, 3.0)];
            sheets.extend(block(low, edge, tiles));
            for [x, z] in [[-1.4, -1.4], [-1.4, 1.2], [1.2, -1.4], [1.2, 1.2]] {
                let leg = [Vec3::new(x, 0.0, z), Vec3::new(0.2, 1.0, 0.2)];
                sheets.extend(block(leg[0], leg[1], 1));
            }
            let (world, backend) = world(&sheets);
            FRAMING
                .fitted(&world, backend.as_ref(), &[], false)
                .unwrap()
        };
        let coarse = camera(1);
        assert!(coarse.eye.y > 1.2, "{coarse:?}");
        assert_eq!(camera(40), coarse);
    }

    #[test]
    fn a_cave_with_land_before_it_is_looked_at_from_inside() {
        // A room whose ceiling, walls and floor are of many faces, and of which one end is open.
        let tile = |k: u32, [at, a, b]: [Vec3; 3]| {
            let [i, j] = [k % 10, k / 10].map(|k| k as f32);
            white([at + a * i + b * j, a, b])
        };
        let [x, y, z] = [Vec3::X * 0.8, Vec3::Y * 0.3, Vec3::Z * 0.6];
        let [right, top, end] = [x, y, z].map(|edge| edge * 10.0);
        let sides = [
            [Vec3::ZERO, z, x],
            [Vec3::ZERO, y, z],
            [top, x, z],
            [end, y, x],
            [right, z, y],
        ];
        let mut sheets: Vec<_> = (0..500)
            .map(|k| tile(k % 100, sides[k as usize / 100]))
            .collect();
        sheets.push(white([-0.5 * end, 0.5 * end, right]));
        let (world, backend) = world(&sheets);
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        let is_in = camera.eye.cmpgt(DVec3::ZERO).all() && camera.eye.z < f64::from(end.z);
        assert!(is_in, "{camera:?}");
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
        let camera = FRAMING
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        assert!(camera.eye.length() < 100.0, "{camera:?}");
    }

    #[test]
    fn what_stands_around_a_scene_is_not_what_is_looked_at() {
        // A room without a ceiling and two of its walls, in a far and in a near box.
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
        let around = |far: f32| {
            let [low, edge] = [Vec3::new(4.0, 1.5, 3.0) - far, Vec3::splat(2.0 * far)];
            let [x, y, z] = [x, y, z].map(|way| way * edge);
            let sides = [
                [low, z, x],
                [low, y, z],
                [low, x, y],
                [low + x, z, y],
                [low + y, x, z],
                [low + z, y, x],
            ];
            sides.map(white)
        };
        let alone = world(&room(3));
        let camera = FRAMING.fitted(&alone.0, alone.1.as_ref(), &[], false);
        let camera = camera.unwrap();
        for (far, is_same) in [(100.0, true), (8.0, false)] {
            let mut sheets = room(3);
            sheets.extend(around(far));
            let (world, backend) = world(&sheets);
            let dome: Vec<u32> = (3..9).collect();
            let within = FRAMING.fitted(&world, backend.as_ref(), &dome, false);
            let within = within.unwrap();
            assert_eq!(within == camera, is_same, "{within:?} for {camera:?}");
            assert!(
                within.forward.distance(camera.forward) < 1e-9,
                "{within:?} for {camera:?}"
            );
            let off = (within.eye - DVec3::new(4.0, 1.5, 3.0)).abs();
            assert!(off.max_element() < f64::from(far), "{within:?}");
        }
    }

    #[test]
    fn what_is_given_stands() {
        let (world, backend) = world(&room(6));
        let framing = Framing {
            look: Some(DVec3::ONE),
            ..FRAMING
        };
        let camera = framing
            .fitted(&world, backend.as_ref(), &[], false)
            .unwrap();
        assert_eq!(camera, framing.camera(&world).unwrap());
    }
}
