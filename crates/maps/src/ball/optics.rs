//! Where a camera sees which direction in a mirrored ball of radius 1.

use std::f64::consts::PI;

/// A camera on the axis of the ball. A point of the ball is named by the angle α between its normal and the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Optics {
    /// Infinitely far away.
    Orthographic,
    /// At this distance from the ball's middle in ball radii, above 1.
    Near(f64),
}

impl Optics {
    /// Half angle of the cone behind the ball that no ray reaches, radians.
    pub fn blind(self) -> f64 {
        match self {
            Self::Orthographic => 0.0,
            Self::Near(d) => (1.0 / d).asin(),
        }
    }

    /// Largest visible α, radians: the outline.
    pub fn rim(self) -> f64 {
        match self {
            Self::Orthographic => 0.5 * PI,
            Self::Near(d) => (1.0 / d).acos(),
        }
    }

    /// Angle between the mirror direction of the true ray at α and the axis, radians. It grows with α.
    ///
    /// The ray to the camera at (0, d) leaves (sin α, cos α) under the angle γ = -atan2(sin α, d - cos α); its mirror
    /// image about the normal has the angle 2α - γ.
    pub fn mirror(self, alpha: f64) -> f64 {
        match self {
            Self::Orthographic => 2.0 * alpha,
            Self::Near(d) => 2.0 * alpha + alpha.sin().atan2(d - alpha.cos()),
        }
    }

    /// The α that shows a direction at angle `theta` (0..=π) from the axis; `None` in the blind cone.
    pub fn point(self, theta: f64) -> Option<f64> {
        let Self::Near(_) = self else {
            return Some(0.5 * theta);
        };
        let (mut low, mut high) = (0.0, self.rim());
        if theta > self.mirror(high) {
            return None;
        }
        // Newton's steps, halved where they leave the bracket; mirror(α) grows.
        let mut alpha = 0.5 * theta.min(2.0 * high);
        for _ in 0..60 {
            let error = self.mirror(alpha) - theta;
            if error > 0.0 {
                high = alpha;
            } else {
                low = alpha;
            }
            let mut next = alpha - error / self.mirror_slope(alpha);
            if !(low..=high).contains(&next) {
                next = 0.5 * (low + high);
            }
            if (next - alpha).abs() <= 1e-15 {
                break;
            }
            alpha = next;
        }
        Some(alpha)
    }

    /// Distance from the middle of the picture of the ball, 1 at the outline.
    pub fn radius(self, alpha: f64) -> f64 {
        match self {
            Self::Orthographic => alpha.sin(),
            Self::Near(d) => alpha.sin() / (d - alpha.cos()) * (d * d - 1.0).sqrt(),
        }
    }

    /// d radius / d mirror at α: picture by angle, 0 at the rim of a near camera and of a far one.
    pub fn slope(self, alpha: f64) -> f64 {
        let radial = match self {
            Self::Orthographic => alpha.cos(),
            Self::Near(d) => {
                let rest = d - alpha.cos();
                ((d * alpha.cos() - 1.0) / (rest * rest)).max(0.0) * (d * d - 1.0).sqrt()
            }
        };
        radial / self.mirror_slope(alpha)
    }

    /// d mirror / d α.
    fn mirror_slope(self, alpha: f64) -> f64 {
        match self {
            Self::Orthographic => 2.0,
            Self::Near(d) => {
                let cos = alpha.cos();
                2.0 + (d * cos - 1.0) / (d * d - 2.0 * d * cos + 1.0)
            }
        }
    }
}
