//! The Phong term of an open point, for any real exponent and every view.
//!
//! The lobe about R is cut by the plane of N; what is left is a lune. In coordinates with the poles on the lune's
//! corners the integral of X. Zhang, Y. Gao, "Generalised Ambient Reflection Models for Lambertian and Phong Surfaces",
//! ICIP 2009, equation (14), separates into two integrals of powers of the cosine. With W(n) = ∫ cosⁿ over -π/2..π/2
//! and W(n) W(n+1) = 2π/(n+1), the normalised term is
//!
//! ```text
//! G(n, θ) = 1/W(n) ∫ cosⁿ over -π/2..π/2-θ = 1 - T  (θ <= π/2),  T  (θ > π/2)
//! T = I(sin²θ; (n+1)/2, 1/2) / 2, a regularised incomplete beta function
//! ```
//!
//! so G is the distribution function of Student's t with n + 1 degrees of freedom at √(n+1) cot θ. T is evaluated by
//! whichever of three forms has positive terms and converges fast; no gamma function appears, because differences of
//! log-gammas lose nine digits at n = 1e6.

use crate::quadrature::gauss;
use std::f64::consts::{PI, TAU};

/// Phong ambient term of an open point, scaled so that it is 1 at normal view: `(n+1)/2π ∫ (R·L)ⁿ dω` over the lune.
///
/// Relative error below 1e-14 up to a view of 90 degrees, and below 1e-13 in the tail beyond, down to underflow.
///
/// * `exponent`: n, finite and `>= 0`.
/// * `n_dot_v`: cosine of the angle θ between normal and view, `-1..=1`; negative when the eye is below the surface,
///   where the same formula holds. Give it with small *relative* error near 0: the slope there is √(n/2π).
/// * `n_cross_v`: sine of θ, `0..=1`, the length of the cross product. It is asked for because near normal view the
///   cosine does not hold the angle, and for n < 1 the slope in the cosine is infinite there.
///
/// ```
/// use ambake_ambient::closed_form::phong_open;
/// assert_eq!(phong_open(50.0, 1.0, 0.0), 1.0);
/// assert_eq!(phong_open(50.0, 0.0, 1.0), 0.5);
/// ```
pub fn phong_open(exponent: f64, n_dot_v: f64, n_cross_v: f64) -> f64 {
    let tail = tail(exponent, n_dot_v.abs(), n_cross_v);
    if n_dot_v < 0.0 { tail } else { 1.0 - tail }
}

/// [`phong_open`] for a view angle in radians, `0..=π`.
pub fn phong_open_angle(exponent: f64, theta_view: f64) -> f64 {
    let (sine, cosine) = theta_view.sin_cos();
    phong_open(exponent, cosine, sine)
}

/// The reciprocal variant with the cosine law, `(n+2)/2π ∫ (R·L)ⁿ (N·L) dω` over the lune; 1 at normal view.
///
/// E. Lafortune, Y. Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering", 1994. Not one
/// of the baked layers: it bounds what the missing cosine of the paper's term costs. Arguments as in [`phong_open`].
/// The error is relative up to 90 degrees and absolute beyond, where two terms cancel.
pub fn phong_open_cosine(exponent: f64, n_dot_v: f64, n_cross_v: f64) -> f64 {
    let n = exponent;
    let edge = (0.5 * (n + 2.0) * log_sine2(n_dot_v, n_cross_v)).exp();
    n_dot_v * phong_open(n + 1.0, n_dot_v, n_cross_v)
        + (n + 2.0) / (n + 1.0) * edge / (TAU * inverse_wallis(n + 2.0))
}

/// The smaller share T of the lobe, for `c` = |cos θ|.
fn tail(n: f64, c: f64, s: f64) -> f64 {
    let log_s2 = log_sine2(c, s);
    let inverse_w = inverse_wallis(n);
    if s * s <= 0.5 {
        let front = (0.5 * (n + 1.0) * log_s2).exp() * c / (n + 1.0) * inverse_w;
        return front * series(0.5 * n + 1.0, 0.5 * n + 1.5, s * s);
    }
    if n < 2.0 || -(n + 0.5) * log_s2 < 3.0 {
        let front = (0.5 * (n + 1.0) * log_s2).exp() * c * inverse_w;
        return 0.5 - front * series(0.5 * n + 1.0, 1.5, c * c);
    }
    // Directly: ∫ cosⁿ from the elevation φ of the view up to π/2. cos(φ+d) is taken relative to cos φ = s, and the
    // range ends where the integrand has fallen by e^-42.
    let elevation = c.atan2(s);
    let cot = c / s;
    let length = 84.0 / n / (cot + (cot * cot + 84.0 / n).sqrt());
    let end = length.min(0.5 * PI - elevation);
    let ratio = |d: f64| {
        let fall = 2.0 * (elevation + 0.5 * d).sin() * (0.5 * d).sin() / s;
        (n * (-fall).ln_1p()).exp()
    };
    (0.5 * n * log_s2).exp() * inverse_w * gauss(&ratio, 0.0, end)
}

/// ln sin²θ from whichever of cosine and sine holds it.
fn log_sine2(c: f64, s: f64) -> f64 {
    if c.abs() < 0.7 {
        (-c * c).ln_1p()
    } else {
        2.0 * s.ln()
    }
}

/// Gauss' hypergeometric 2F1(1, a; b; x) for 0 <= x <= 1/2: positive terms, summed until they no longer count.
fn series(mut a: f64, mut b: f64, x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    while term > 0.25 * f64::EPSILON * sum {
        term *= a / b * x;
        sum += term;
        a += 1.0;
        b += 1.0;
    }
    sum
}

/// 1/W(n), W(n) = ∫ cosⁿ over -π/2..π/2 = √π Γ((n+1)/2) / Γ(n/2+1).
///
/// Raised to n >= 40 by W(n+2) = W(n) (n+1)/(n+2), then the asymptotic series in 1/(n+½)².
pub(crate) fn inverse_wallis(exponent: f64) -> f64 {
    let (mut n, mut factor) = (exponent, 1.0);
    while n < 40.0 {
        factor *= (n + 1.0) / (n + 2.0);
        n += 2.0;
    }
    let z = n + 0.5;
    let u = 1.0 / (z * z);
    let correction = u
        * (1.0 / 16.0
            + u * (-19.0 / 512.0
                + u * (631.0 / 8_192.0
                    + u * (-174_317.0 / 524_288.0 + u * 20_491_783.0 / 8_388_608.0))));
    factor * (z / TAU).sqrt() * (1.0 + correction)
}

#[cfg(test)]
mod tests;
