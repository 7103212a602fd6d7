//! Every normalisation constant, and which source says what.
//!
//! Stored terms, each 1 for an open point under a uniform sky (`specular` at normal view), Ω the open directions:
//!
//! * `visibility` = |Ω| / 2π, the traditional occlusion factor.
//! * `diffuse` = (1/π) ∫ N·L dω, the Lambertian term.
//! * `specular` = (n+1)/2π ∫ (R·L)ⁿ dω, the Phong term; R mirrors the view about the normal and R·L is clamped at 0.
//!
//! **The doubled diffuse factor.** X. Zhang, Y. Gao, ICIP 2009, print 2π i_a k_d for a convex body in (6), (10) and (16);
//! ∫ N·L dω over a hemisphere is π. The specular sums (15) and (16) are right. We take π, so that `diffuse` is 1 when open.
//!
//! **The clamp.** Equations (8) to (10) leave R·V unclamped; the limits of (14) clamp it, and the figure needs that.
//!
//! **Below the horizon.** The part of the lobe below the surface is lost, not made up for: at grazing view the term is 1/2.
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
//! **1984.** G. Miller, R. Hoffman, "Illumination and Reflection Maps", divide both maps by 4π; see the factors below.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Solid angle of the hemisphere, sr: divides the open solid angle in `visibility`.
pub const HEMISPHERE: f64 = TAU;

/// ∫ N·L dω over the hemisphere, sr: divides the integral in `diffuse`. Equation (6) prints twice this.
pub const PROJECTED_HEMISPHERE: f64 = PI;

/// What the 1984 normalisation of a map multiplies its integral by, against 1/π for the diffuse map.
pub const MAP_1984: f64 = 0.25 * FRAC_1_PI;

/// (n+1)/2π, what `specular` multiplies the lobe's integral by. `exponent` is `>= 0`.
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
