//! The integrated terms of one texel.

use ambient::Estimate;
use ambient::any_view::Coefficients;
use glam::DVec3;

/// Terms of a texel with their standard errors, normalised as the file contract says: 1 is open.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Terms {
    /// Open solid angle / 2 pi.
    pub visibility: Estimate,
    /// (1/pi) times the integral of V cos.
    pub diffuse: Estimate,
    /// ((n+1)/2pi) times the integral of V (R.V)^n.
    pub specular: Estimate,
    /// The same of the part of a lobe of GGX that Fresnel's (1 - V·H)^5 weighs.
    pub white: f64,
    /// Where the texel is open and whence its light comes; zeros where neither is asked for.
    pub directional: Directional,
    /// (1/pi) times the integral of L V cos, linear RGB.
    pub irradiance: Estimate<DVec3>,
    /// ((n+1)/2pi) times the integral of L V (R.V)^n, linear RGB.
    pub reflection: Estimate<DVec3>,
    /// The open directions, for any view; `None` where they are not asked for, for they are larger than all the rest.
    pub any_view: Option<Box<AnyView>>,
    /// What two independent halves of the rays differ by.
    pub halves: Halves,
    /// Rays spent.
    pub rays: u64,
}

/// Harmonics of the open directions of a texel with what they leave.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AnyView {
    /// The coefficients.
    pub coefficients: Coefficients,
    /// Root mean square error of the specular term over all views.
    pub std_err: f64,
}

/// Where a texel is open, and whence the light of the sky comes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Directional {
    /// (1/pi) times the integral of V cos times the direction: two thirds of the normal for an open texel.
    pub bent: DVec3,
    /// Harmonics of the light up to order 1, linear RGB: (1/4pi) times the integral of L V over the sphere, and the
    /// same times each axis of the direction. A direction's length is 1, so the vector of the last three is at most as
    /// long as the first.
    pub light: [DVec3; 4],
}

/// Half of the difference between the terms of two independent halves of the rays: a term plus and minus its half are
/// two estimates of it. 0 where no ray was needed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Halves {
    /// Of [`Terms::diffuse`].
    pub diffuse: f64,
    /// Of [`Terms::visibility`].
    pub visibility: f64,
    /// Of [`Terms::specular`].
    pub specular: f64,
    /// Of [`Terms::irradiance`].
    pub irradiance: DVec3,
    /// Of [`Terms::reflection`].
    pub reflection: DVec3,
    /// Of [`Terms::directional`].
    pub directional: Directional,
}

impl Directional {
    /// Under a sky of radiance `sky` all over, of which the share `open` of the sphere is open, with the mean
    /// `direction` over the sphere.
    pub fn even(sky: DVec3, open: f64, direction: DVec3) -> [DVec3; 4] {
        let [x, y, z] = direction.to_array().map(|axis| sky * axis);
        [sky * open, x, y, z]
    }

    /// Of a flat, open texel under a uniform sky.
    pub fn open(sky: DVec3, normal: DVec3) -> Self {
        Self {
            bent: normal * (2.0 / 3.0),
            light: Self::even(sky, 0.5, 0.25 * normal),
        }
    }

    /// `by` on each pair of numbers.
    pub(crate) fn with(&self, other: &Self, by: impl Fn(DVec3, DVec3) -> DVec3) -> Self {
        Self {
            bent: by(self.bent, other.bent),
            light: std::array::from_fn(|k| by(self.light[k], other.light[k])),
        }
    }
}

/// The light of a term under a uniform sky: the sky's radiance times the term.
pub(crate) fn uniform_light(sky: DVec3, term: Estimate) -> Estimate<DVec3> {
    Estimate {
        value: sky * term.value,
        std_err: sky.element_sum() / 3.0 * term.std_err,
    }
}
