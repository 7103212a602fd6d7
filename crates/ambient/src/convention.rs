//! Every normalisation constant, and which source says what.
//!
//! Stored terms, each 1 for an open point under a uniform sky (`specular` at normal view), Ω the open directions:
//!
//! * `visibility` = |Ω| / 2π, the traditional occlusion factor.
//! * `diffuse` = (1/π) ∫ N·L dω, the Lambertian term.
//! * `specular` = (n+1)/2π ∫ (R·L)ⁿ dω, the Phong term; R mirrors the view about the normal and R·L is clamped at 0.
//!
//! **The doubled diffuse factor.** X. Zhang, Y. Gao, ICIP 2009, print 2π i_a k_d for a convex body in (6), (10) and
//! (16); ∫ N·L dω over a hemisphere is π. The specular sums (15) and (16) are right. We take π, so that `diffuse` is 1
//! when open.
//!
//! **The clamp.** Equations (8) to (10) leave R·V unclamped; the limits of (14) clamp it, and the figure needs that.
//!
//! **Below the horizon.** The part of the lobe below the surface is lost, not made up for: at grazing view the term is
//! 1/2.
//!
//! **No cosine in the specular term.** The paper's integral has none; it is the model that is baked.
//!
//! **Coefficients.** The paper's I_a = 2π i_a is neither radiance nor irradiance. The sky is a radiance here, albedo is
//! π k_d and the specular colour 2π k_s / (n+1).
//!
//! **Shading normals.** The hemisphere is the shading normal's; what lies below the geometric plane is blocked.
//!
//! **N·V < 0** (an eye below an interpolated normal): the same formula with an angle beyond 90 degrees, not a clamp.
//!
//! **1984.** G. Miller, R. Hoffman, "Illumination and Reflection Maps", sections 6.1 and 6.2, divide both maps by 4π,
//! so that a constant map of 1 gives D = 1/4 and S = 1/(2(n+1)). We offer that and, by default, the factors of our own
//! terms, with which a constant map of 1 gives 1. Their mirror would vanish in that sum; section 6 says that its map is
//! the illumination map, which we take. Their varnish adds 0.5 to the lobe at its axis alone, which we read as half
//! that mirror.
//!
//! **What does not belong here**: factors of a method that cancel (a rule's weights, a sampler's Jacobian, the
//! orthonormal spherical harmonics) stand with the method.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Solid angle of the sphere, sr: divides an integral over all directions into their mean.
pub const SPHERE: f64 = 2.0 * TAU;

/// Solid angle of the hemisphere, sr: divides the open solid angle in `visibility`.
pub const HEMISPHERE: f64 = TAU;

/// ∫ N·L dω over the hemisphere, sr: divides the integral in `diffuse`. Equation (6) prints twice this.
pub const PROJECTED_HEMISPHERE: f64 = PI;

/// 1/π, what a diffuse map multiplies ∫ I max(0, N·L) dω by: one over [`PROJECTED_HEMISPHERE`].
pub const LAMBERT_SCALE: f64 = FRAC_1_PI;

/// 1/4π, what the mean over all directions multiplies its integral by: one over [`SPHERE`].
pub const MEAN_SCALE: f64 = 0.25 * FRAC_1_PI;

/// 1/4π, what the 1984 text multiplies the integral of either map by, whatever the lobe (sections 6.1 and 6.2).
pub const MAP_1984: f64 = 0.25 * FRAC_1_PI;

/// What the 1984 text's varnish adds of the mirrored map (section 6.2, lobe 3).
pub const VARNISH_1984: f64 = 0.5;

/// (n+1)/2π, what `specular` multiplies the lobe's integral by. `exponent` is `>= 0`.
///
/// ```
/// use ambake_ambient::convention::{HEMISPHERE, LAMBERT_SCALE, lobe_scale};
/// assert_eq!(lobe_scale(0.0) * HEMISPHERE, 1.0);
/// assert_eq!(lobe_scale(1.0), LAMBERT_SCALE);
/// ```
pub fn lobe_scale(exponent: f64) -> f64 {
    (exponent + 1.0) / TAU
}

/// Albedo of the paper's diffuse coefficient k_d: π k_d. Energy is conserved while that is at most 1.
pub fn albedo_of(k_d: f64) -> f64 {
    PI * k_d
}

/// Specular colour of the paper's coefficient k_s at lobe exponent n: 2π k_s / (n+1).
pub fn specular_of(k_s: f64, exponent: f64) -> f64 {
    k_s / lobe_scale(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_one_over_the_integrals_that_they_normalise() {
        // One rounding of a division and one of the constant.
        let bound = f64::EPSILON;
        for (factor, integral) in [
            (LAMBERT_SCALE, PROJECTED_HEMISPHERE),
            (MEAN_SCALE, SPHERE),
            (lobe_scale(0.0), HEMISPHERE),
            (lobe_scale(1.0), PROJECTED_HEMISPHERE),
        ] {
            let product = factor * integral;
            assert!((product - 1.0).abs() <= bound, "{factor} of {integral}");
        }
        // Under a constant map of 1: D = 1/4, and S = 1/(2(n+1)) = 1/22 for n = 10.
        assert!((MAP_1984 / LAMBERT_SCALE - 0.25).abs() <= bound);
        assert!((MAP_1984 / lobe_scale(10.0) - 1.0 / 22.0).abs() <= bound);
    }
}
