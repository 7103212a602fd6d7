//! A camera for a scene, from what is known of it.

use crate::{Camera, Error};
use glam::DVec3;
use rays::{Bounds, World};

/// Where a picture is taken from, as far as it is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// The eye in scene units; `None` for a place in front, above and to the right from which the whole scene is seen.
    pub eye: Option<DVec3>,
    /// The point that is looked at; `None` for the middle of the scene.
    pub look: Option<DVec3>,
    /// Direction that is upward in the picture.
    pub up: DVec3,
    /// Vertical field of view in radians, above 0 and below π.
    pub fov: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Default for Framing {
    /// The whole scene in 960 x 540 pixels, y upward, 40 degrees.
    fn default() -> Framing {
        Framing {
            eye: None,
            look: None,
            up: DVec3::Y,
            fov: 40f64.to_radians(),
            size: [960, 540],
        }
    }
}

impl Framing {
    /// The camera that frames what is left open.
    ///
    /// # Errors
    /// [`Error::Camera`], see [`Camera::new`].
    pub fn camera(&self, world: &World) -> Result<Camera, Error> {
        let front = Camera::front(self.up.normalize_or(DVec3::Y));
        let eye = self
            .eye
            .unwrap_or_else(|| self.eye_outside(world, &[], front));
        let middle = extent(world, &[]).center();
        self.camera_at([eye, self.look.unwrap_or(middle)])
    }

    /// The nearest eye in a unit direction from the middle of the scene from which all of it is seen but what stands
    /// `around` it.
    pub(crate) fn eye_outside(&self, world: &World, around: &[u32], toward: DVec3) -> DVec3 {
        let middle = extent(world, around).center();
        let corners = drawn(world, around).flat_map(|instance| {
            let triangles = world.part(instance).1.triangles().len() as u32;
            (0..triangles).flat_map(move |triangle| world.corners(instance, triangle))
        });
        Camera::framing(corners, middle, toward, self.up, self.fov, self.size)
    }

    /// The camera at an eye that looks at a point, whatever stands here for them.
    ///
    /// # Errors
    /// [`Error::Camera`], see [`Camera::new`].
    pub fn camera_at(&self, [eye, look]: [DVec3; 2]) -> Result<Camera, Error> {
        Camera::new(eye, look, self.up, self.fov, self.size)
    }
}

/// The instances that rays meet but for those `around` them; all of a scene in which they meet none.
pub(crate) fn drawn<'a>(
    world: &'a World,
    around: &'a [u32],
) -> impl Iterator<Item = u32> + Clone + 'a {
    let all = 0..world.scene().instances.len() as u32;
    let is_in = |instance: u32| world.casts(instance) && !around.contains(&instance);
    let has_any = all.clone().any(is_in);
    all.filter(move |&instance| !has_any || is_in(instance))
}

/// The box of what is drawn.
pub(crate) fn extent(world: &World, around: &[u32]) -> Bounds {
    let boxes = drawn(world, around).filter_map(|instance| world.box_of(instance));
    let both = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    both.map_or(world.bounds(), |(min, max)| Bounds { min, max })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{white, world};
    use glam::Vec3;

    #[test]
    fn a_scene_whose_z_points_upward_is_seen_as_its_twin_with_y_upward() {
        let turn = |v: Vec3| Vec3::new(v.x, -v.z, v.y);
        let card = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y];
        let [upright, turned] = [card, card.map(turn)].map(|card| world(&[white(card)]).0);
        let twin = Framing::default().camera(&upright).unwrap();
        let framing = Framing {
            up: DVec3::Z,
            ..Framing::default()
        };
        let camera = framing.camera(&turned).unwrap();
        let eye = DVec3::new(twin.eye.x, -twin.eye.z, twin.eye.y);
        assert!(
            (camera.eye - eye).length() < 1e-6,
            "{camera:?} for {twin:?}"
        );
    }

    #[test]
    fn what_no_ray_meets_is_not_looked_at() {
        let card = white([Vec3::ZERO, Vec3::X, Vec3::Y]);
        let far = white([Vec3::X * 900.0, Vec3::X, Vec3::Y]);
        let (whole, _) = world(&[card, far]);
        let mut scene = whole.scene().as_ref().clone();
        scene.instances[1].casts = false;
        let world = World::new(std::sync::Arc::new(scene), rays::WorldOptions::default()).unwrap();
        let camera = Framing::default().camera(&world).unwrap();
        assert!(
            (camera.eye - DVec3::new(0.5, 0.5, 0.0)).length() < 10.0,
            "{camera:?}"
        );
    }

    #[test]
    fn what_is_given_stands_and_the_rest_frames_the_scene() {
        let place = [Vec3::new(2.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0];
        let (world, _) = world(&[white(place)]);
        let framing = Framing {
            eye: None,
            look: None,
            up: DVec3::Y,
            fov: 0.7,
            size: [160, 90],
        };
        let middle = DVec3::new(3.0, 0.0, 0.0);
        let camera = framing.camera(&world).unwrap();
        let toward = (middle - camera.eye).normalize();
        assert!((camera.forward - toward).length() < 1e-12, "{camera:?}");
        assert!(camera.eye.y > 0.0 && camera.eye.x > 3.0, "{camera:?}");
        let eye = DVec3::new(3.0, 5.0, 1.0);
        let given = Framing {
            eye: Some(eye),
            ..framing
        };
        let camera = given.camera(&world).unwrap();
        assert_eq!(camera.eye, eye);
        assert_eq!(camera, framing.camera_at([eye, middle]).unwrap());
        let same = Framing {
            look: Some(eye),
            ..given
        };
        assert!(same.camera(&world).is_err(), "it looks at its own eye");
    }
}
