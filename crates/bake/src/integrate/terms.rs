//! The integrated terms of one texel.

use ambient::Estimate;
use ambient::any_view::Coefficients;
use glam::DVec3;

/// Terms of a texel with their standard errors, normalised as the file contract says: 1 is open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Terms {
    /// Open solid angle / 2 pi.
    pub visibility: Estimate,
    /// (1/pi) times the integral of V cos.
    pub diffuse: Estimate,
    /// ((n+1)/2pi) times the integral of V (R.V)^n.
    pub specular: Estimate,
    /// Cosine-weighted mean open direction, not normalised.
    pub bent: DVec3,
    /// (1/pi) times the integral of L V cos, linear RGB.
    pub irradiance: Estimate<DVec3>,
    /// ((n+1)/2pi) times the integral of L V (R.V)^n, linear RGB.
    pub reflection: Estimate<DVec3>,
    /// The open directions, for any view; zeros where they are not asked for.
    pub any_view: AnyView,
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

/// Half of the difference between the terms of two independent halves of the rays: a term plus and minus its half are two estimates
/// of it. 0 where no ray was needed.
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
}

/// The light of a term under a uniform sky: the sky's radiance times the term.
pub(crate) fn uniform_light(sky: DVec3, term: Estimate) -> Estimate<DVec3> {
    Estimate {
        value: sky * term.value,
        std_err: sky.element_sum() / 3.0 * term.std_err,
    }
}
