//! A pinhole camera.

use crate::Error;
use bake::Bounds;
use glam::DVec3;

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

    /// An eye from which everything within `bounds` fits a field of view of `fov` radians, looked at from above, in front and
    /// to the right.
    pub fn framing(bounds: Bounds, fov: f64) -> DVec3 {
        let radius = (0.5 * bounds.diagonal()).max(f64::from(f32::MIN_POSITIVE));
        bounds.center() + DVec3::new(0.5, 0.5, 1.0).normalize() * (radius / (0.5 * fov).sin())
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
    fn the_framed_box_is_inside_the_picture() {
        let bounds = Bounds {
            min: DVec3::new(-3.0, 0.0, 1.0),
            max: DVec3::new(5.0, 1.0, 2.0),
        };
        let fov = 0.7;
        let eye = Camera::framing(bounds, fov);
        let camera = Camera::new(eye, bounds.center(), DVec3::Y, fov, [100, 100]).unwrap();
        for corner in 0..8 {
            let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
            let to = DVec3::new(pick(0), pick(1), pick(2)) - eye;
            let depth = to.dot(camera.forward);
            assert!(to.dot(camera.up).abs() <= depth * camera.slope, "{corner}");
            assert!(
                to.dot(camera.right).abs() <= depth * camera.slope,
                "{corner}"
            );
        }
    }
}
