//! The paper's own closed form: equations (15) and (16), finite sums for a whole exponent.
//!
//! X. Zhang, Y. Gao, "Generalised Ambient Reflection Models for Lambertian and Phong Surfaces", ICIP 2009. Printed with
//! factorials, which overflow double precision at n = 173; here each term is the last one times a ratio, and all terms
//! are positive up to 90 degrees. [`super::phong_open`] is faster and takes any exponent and angle; this is its
//! cross-check.

use crate::convention::HEMISPHERE;
use std::f64::consts::PI;

/// Equation (15): the specular ambient term of a convex body, divided by the ambient radiance and the specular
/// coefficient, in steradians; `2π / (n + 1)` times [`super::phong_open`].
///
/// * `exponent`: a whole n. The sum has n/2 terms.
/// * `theta_view`: angle from normal to view in radians, `0..=π/2`; beyond, the terms cancel and digits are lost.
///
/// ```
/// let half = ambake_ambient::closed_form::specular_convex(2, std::f64::consts::FRAC_PI_2);
/// assert!((half - std::f64::consts::PI / 3.0).abs() < 1e-15);
/// ```
pub fn specular_convex(exponent: u32, theta_view: f64) -> f64 {
    let (sin, cos) = theta_view.sin_cos();
    let n = f64::from(exponent);
    let square = sin * sin;
    let even = exponent.is_multiple_of(2);
    let terms = if even {
        exponent / 2
    } else {
        exponent.div_ceil(2)
    };
    let (mut term, mut sum) = (if even { sin } else { 1.0 }, 0.0);
    for r in 0..terms {
        sum += term;
        let r = f64::from(r);
        term *= square
            * if even {
                (2.0 * r + 2.0) / (2.0 * r + 3.0)
            } else {
                (2.0 * r + 1.0) / (2.0 * r + 2.0)
            };
    }
    if even {
        2.0 / (n + 1.0) * (PI - theta_view + cos * sum)
    } else {
        PI / (n + 1.0) * (1.0 + cos * sum)
    }
}

/// Equation (16)'s factor K of the specular coefficient, with `I_a = 2π i_a`: [`specular_convex`] over 2π.
pub fn specular_factor(exponent: u32, theta_view: f64) -> f64 {
    specular_convex(exponent, theta_view) / HEMISPHERE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::phong_open_angle;
    use std::f64::consts::TAU;

    #[test]
    fn sums_of_equation_15_agree_with_the_closed_form_for_any_exponent() {
        for n in (0..=40).chain([99, 172, 173, 1000, 1999, 2000]) {
            for degrees in 0..=90 {
                let theta = f64::from(degrees).to_radians();
                let exact = TAU / (f64::from(n) + 1.0) * phong_open_angle(n.into(), theta);
                let sum = specular_convex(n, theta);
                // n/2 positive terms, each with a few roundings.
                let bound = 2e-15 + 4e-16 * f64::from(n) * 0.5;
                assert!(
                    (sum / exact - 1.0).abs() < bound,
                    "n {n} at {degrees}: {sum} for {exact}"
                );
            }
        }
    }

    #[test]
    fn factor_of_equation_16_halves_from_normal_to_grazing_view() {
        for n in [0, 1, 5, 50] {
            let (normal, grazing) = (specular_factor(n, 0.0), specular_factor(n, PI / 2.0));
            assert!(
                (normal - 1.0 / (f64::from(n) + 1.0)).abs() < 1e-15,
                "n {n}: {normal}"
            );
            assert!((grazing / normal - 0.5).abs() < 1e-15, "n {n}: {grazing}");
        }
    }
}
