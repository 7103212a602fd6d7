//! Where a scene is best looked at from when nobody says: around it, three quarters from above; inside it, where it is
//! closed.

mod room;
mod subject;
#[cfg(test)]
mod tests;
mod told;

use crate::{Camera, Error, Framing};
use glam::DVec3;
use rays::{RayBackend, World};
use room::{Room, Within};
use std::f64::consts::PI;
use told::{farthest, told};

/// What a view within furnished rooms shows counts so many times against one from outside: in a scene that is open
/// otherwise, and in one that is closed.
const ROOMS: [f64; 2] = [1.4, 3.0];
/// And so many times what it tells.
const TELLING: f64 = 1.4;
/// Vertical field of view inside of a room, in radians: 65 degrees.
const WIDE: f64 = 65.0 * PI / 180.0;

impl Framing {
    /// The camera that shows a scene best, by the share of points on its surfaces of which it sees the front; fine
    /// parts have more points than their area. It is the one of [`Framing::camera`], from another side or steeper where
    /// that shows more, or one inside where that shows more than the one outside. Inside, it counts by how much of what
    /// is above it is closed, and more in rooms that show what they have within, and the field of view is at least 65
    /// degrees unless `keep_fov`.
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
        let outside = self.around(&room)?;
        let within = self.within(&room, &outside, keep_fov);
        Ok(within.map_or(outside, |view| view.camera))
    }

    /// The view from within a scene, where that shows more than the one `outside`.
    fn within(&self, room: &Room, outside: &Camera, keep_fov: bool) -> Option<Within> {
        let lens = if keep_fov { *self } else { self.wide() };
        let view = room.within(&lens)?;
        let others = room.shown(outside) as f64;
        // Nobody is to look at the outside of rooms, unless that shows far more: then what is closed are cupboards.
        let rooms = ROOMS[usize::from(view.is_closed)];
        let is_room = || rooms * view.shows > others && room.is_furnished(&view.places);
        (view.shows > others || is_room()).then_some(view)
    }

    /// The cameras to fall back on where what [`Framing::fitted`] shows from within is dark: within, where most is
    /// seen and what sees the sky counts for more, and outside.
    pub fn brighter(
        &self,
        world: &World,
        backend: &dyn RayBackend,
        around: &[u32],
    ) -> impl Iterator<Item = Camera> {
        let room = Room::of(world, backend, around, self.up);
        let within = room.within_light(&self.wide());
        within.into_iter().chain(self.around(&room).ok())
    }

    /// As wide as it looks inside of a room.
    fn wide(&self) -> Framing {
        let fov = self.fov.max(WIDE);
        Framing { fov, ..*self }
    }

    fn around(&self, room: &Room) -> Result<Camera, Error> {
        let toward = room.outside();
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

/// Places in a scene from which people look, where most of the free space in its box is closed and tells more than what
/// is seen from outside; none elsewhere. What is baked depends on it, so a scene is one of rooms by how many parts of it
/// are looked at from within, and not by how fine these are: a plane over wires in a duct is no outside of a room.
pub fn places_within(world: &World, backend: &dyn RayBackend) -> Vec<DVec3> {
    let framing = Framing::default();
    let room = Room::of(world, backend, &[], framing.up);
    let (closed, is_closed) = room.closed();
    let rooms = || {
        let eyes = closed.iter().copied().filter(|eye| room.has_floor(*eye));
        let inside = farthest(&room, eyes, &framing.wide())?;
        let [own, other] = [inside, framing.around(&room).ok()?].map(|camera| told(&room, &camera));
        Some(own > other || TELLING * own > other && room.is_furnished(&closed))
    };
    match is_closed && rooms() == Some(true) {
        true => closed,
        false => Vec::new(),
    }
}
