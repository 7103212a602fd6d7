//! A pinhole camera.

use crate::Error;
use glam::{DQuat, DVec3};

/// Where a picture is taken from. The frame is orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The pinhole, in scene units.
    pub eye: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to its top.
    pub up: DVec3,
    /// Unit vector into it.
    pub forward: DVec3,
    /// Tangent of half the vertical field of view.
    pub slope: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Camera {
    /// The camera at `eye` that looks at the point `look`, `up` pointing upward in the picture.
    ///
    /// `fov` is the vertical field of view in radians, above 0 and below π.
    ///
    /// # Errors
    /// [`Error::Camera`] where `look` is at the eye or in the direction of `up`.
    pub fn new(
        eye: DVec3,
        look: DVec3,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Camera, Error> {
        let fail = |problem| Error::Camera { problem };
        let forward = (look - eye)
            .try_normalize()
            .ok_or_else(|| fail("looks at its own eye"))?;
        // Below this sine the upright is rounding.
        let right = forward.cross(up.normalize_or_zero());
        if right.length() < 1e-7 {
            return Err(fail("looks along its upright"));
        }
        let right = right.normalize();
        Ok(Camera {
            eye,
            right,
            up: right.cross(forward),
            forward,
            slope: (0.5 * fov).tan(),
            size,
        })
    }

    /// Unit direction in front, above and to the right.
    pub const FRONT: DVec3 = DVec3::new(
        0.408_248_290_463_863,
        0.408_248_290_463_863,
        0.816_496_580_927_726,
    );

    /// [`Camera::FRONT`] where the unit direction `up` stands in place of y.
    pub fn front(up: DVec3) -> DVec3 {
        DQuat::from_rotation_arc(DVec3::Y, up) * Camera::FRONT
    }

    /// The nearest eye in the unit direction `toward` from which all `points` fit into the picture with a margin of a
    /// twentieth, `middle` looked at. The other arguments are those of [`Camera::new`].
    pub fn framing(
        points: impl Iterator<Item = DVec3>,
        middle: DVec3,
        toward: DVec3,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> DVec3 {
        let right = up.cross(toward).normalize_or(DVec3::X);
        let upright = toward.cross(right);
        let slope = (0.5 * fov).tan();
        let wide = slope * f64::from(size[0]) / f64::from(size[1]);
        let distance = points.map(|point| {
            let from = point - middle;
            let aside = (from.dot(right).abs() / wide).max(from.dot(upright).abs() / slope);
            aside + from.dot(toward)
        });
        let distance = distance.fold(f64::from(f32::MIN_POSITIVE), f64::max);
        middle + toward * (1.05 * distance)
    }

    /// True where the picture shows what lies in a direction from the eye.
    pub(crate) fn frames(&self, way: DVec3) -> bool {
        let [width, height] = self.size.map(f64::from);
        let reach = self.slope * way.dot(self.forward);
        way.dot(self.up).abs() <= reach && way.dot(self.right).abs() <= reach * width / height
    }

    /// Unit direction through the point `(x, y)` of the picture in pixels, `(0, 0)` the upper left corner.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let [width, height] = self.size.map(f64::from);
        let scale = 2.0 * self.slope / height;
        (self.forward
            + self.right * ((x - 0.5 * width) * scale)
            + self.up * ((0.5 * height - y) * scale))
            .normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_at_half_the_field_of_view() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let quarter = std::f64::consts::FRAC_PI_2;
        let camera = Camera::new(eye, eye - DVec3::Z, DVec3::Y, quarter, [4, 2]).unwrap();
        let half = 0.5f64.sqrt();
        let close = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-15, "{a} for {b}");
        close(camera.direction(2.0, 1.0), DVec3::NEG_Z);
        close(camera.direction(2.0, 0.0), DVec3::new(0.0, half, -half));
        close(
            camera.direction(4.0, 1.0),
            DVec3::new(2.0, 0.0, -1.0).normalize(),
        );
    }

    #[test]
    fn a_camera_without_direction_is_refused() {
        let at = |look, up| Camera::new(DVec3::ZERO, look, up, 1.0, [1, 1]).is_err();
        assert!(at(DVec3::ZERO, DVec3::Y));
        assert!(at(DVec3::Y, DVec3::Y));
        assert!(at(DVec3::X, DVec3::ZERO));
        assert!(!at(DVec3::X, DVec3::Y));
    }

    #[test]
    fn framed_points_fill_the_picture() {
        let points = [
            DVec3::new(-3.0, 0.0, 1.0),
            DVec3::new(5.0, 1.0, 2.0),
            DVec3::new(1.0, 1.5, 0.0),
        ];
        let middle = DVec3::new(1.0, 0.75, 1.0);
        for (size, fov) in [([100, 100], 0.7), ([960, 540], 0.7), ([100, 300], 1.4)] {
            let eye = Camera::framing(
                points.into_iter(),
                middle,
                Camera::FRONT,
                DVec3::Y,
                fov,
                size,
            );
            let camera = Camera::new(eye, middle, DVec3::Y, fov, size).unwrap();
            let wide = camera.slope * f64::from(size[0]) / f64::from(size[1]);
            let farthest = points.map(|point| {
                let to = point - eye;
                let [x, y] = [
                    to.dot(camera.right) / wide,
                    to.dot(camera.up) / camera.slope,
                ];
                x.abs().max(y.abs()) / to.dot(camera.forward)
            });
            let farthest = farthest.into_iter().fold(0.0, f64::max);
            assert!(farthest < 1.0 && farthest > 0.9, "{size:?}: {farthest}");
        }
    }
}
