//! Where a scene is best looked at from when nobody says: around it, three quarters from above; inside it, where it is
//! closed.

mod room;
mod subject;
#[cfg(test)]
mod tests;

use crate::{Camera, Error, Framing};
use glam::DVec3;
use rays::{RayBackend, World};
use room::{Room, Within};
use std::f64::consts::PI;

/// Vertical field of view inside of a room, in radians: 65 degrees.
const WIDE: f64 = 65.0 * PI / 180.0;

impl Framing {
    /// The camera that shows a scene best: the one of [`Framing::camera`], from another side or steeper where that
    /// shows more of it, and inside where a place within tells more than the view from outside: it counts by how much
    /// of what is above it is closed, and more where most of the free space in the scene's box is closed. Inside, the
    /// field of view is at least 65 degrees unless `keep_fov`.
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
        let within = self.within(&room, &outside, keep_fov)?;
        Ok(within.map_or(outside, |(camera, _)| camera))
    }

    /// The view from within a scene and its camera, where that tells more than the one `outside`.
    fn within(
        &self,
        room: &Room,
        outside: &Camera,
        keep_fov: bool,
    ) -> Result<Option<(Camera, Within)>, Error> {
        let Some(view) = room.within() else {
            return Ok(None);
        };
        let fov = match keep_fov {
            true => self.fov,
            false => self.fov.max(WIDE),
        };
        let inside = Framing { fov, ..*self }.camera_at(view.through)?;
        let [own, other] = [&inside, outside].map(|camera| room.told(room.through(camera)));
        Ok((view.counts * own > other).then_some((inside, view)))
    }

    /// The cameras to fall back on where what [`Framing::fitted`] shows from within is dark: within, where most of what
    /// is seen sees the sky, and outside.
    pub fn brighter(
        &self,
        world: &World,
        backend: &dyn RayBackend,
        around: &[u32],
    ) -> impl Iterator<Item = Camera> {
        let room = Room::of(world, backend, around, self.up);
        let wide = Framing {
            fov: self.fov.max(WIDE),
            ..*self
        };
        let within = (room.within_light()).and_then(|view| wide.camera_at(view).ok());
        within.into_iter().chain(self.around(&room).ok())
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
/// is seen from outside; none elsewhere.
pub fn places_within(world: &World, backend: &dyn RayBackend) -> Vec<DVec3> {
    let framing = Framing::default();
    let room = Room::of(world, backend, &[], framing.up);
    let view = (framing.around(&room)).and_then(|outside| framing.within(&room, &outside, false));
    let view = view.ok().flatten().map(|(_, view)| view);
    view.filter(|view| view.is_closed)
        .map_or(Vec::new(), |view| view.places)
}
