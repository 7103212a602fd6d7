//! The share of a Phong lobe that a polygon blocks.

use super::clip::{above, edges};
use super::quadrature::adaptive;
use ambient::Frame;
use glam::DVec3;
use std::f64::consts::TAU;

/// The part of the specular term that a polygon takes away: `(n+1)/2π ∫ (R·L)ⁿ dω` over the polygon, clipped to the
/// horizon of `normal` and to the front of the lobe; `0..=1`, absolute error a few 1e-15.
///
/// * `axis`: R, the mirror image of the view about the normal, a unit vector.
/// * `exponent`: n, any real number `>= 0`.
///
/// With Stokes' theorem the integral runs over the boundary: along a great circle with unit normal m, S = 1/(n+1) ∮ (1
/// − xⁿ⁺¹)/(1 − x²) R·m dt, x = R·w(t). The integrand is smooth where the edge meets the axis, so no winding number is
/// needed. (J. Arvo, "Applications of Irradiance Tensors to the Simulation of Non-Lambertian Phenomena", 1995, has the
/// sums for integer n.)
pub fn polygon_specular(vertices: &[DVec3], normal: DVec3, axis: DVec3, exponent: f64) -> f64 {
    share(&above(&above(vertices, normal), axis), axis, exponent)
}

/// Specular term of an open plane whose shading normal leans away from the geometric one, for any view.
///
/// The lobe about `axis` is cut by both planes: `(n+1)/2π ∫ (R·L)ⁿ dω` over N·L, Ng·L, R·L >= 0.
///
/// * `normal`, `geometric`, `axis`: unit vectors N, Ng, R.
/// * `exponent`: n, any real number `>= 0`.
pub fn tilted_phong(normal: DVec3, geometric: DVec3, axis: DVec3, exponent: f64) -> f64 {
    let frame = Frame::from_normal(normal);
    let (t, b) = (frame.tangent, frame.bitangent);
    // Four octants, because a clipped hemisphere can have opposite corners and an octant cannot.
    let octants = [[t, b], [b, -t], [-t, -b], [-b, t]];
    octants
        .iter()
        .map(|[x, y]| polygon_specular(&[*x, *y, normal], geometric, axis, exponent))
        .sum()
}

/// The boundary integral over a chain in front of the lobe.
fn share(vertices: &[DVec3], axis: DVec3, exponent: f64) -> f64 {
    let sum: f64 = edges(vertices)
        .iter()
        .map(|&(a, b)| edge(a, b, axis, exponent))
        .sum();
    (sum / TAU).abs()
}

/// ∫ (1 − xⁿ⁺¹)/(1 − x²) R·m dt along the great circle from `a` to `b`.
fn edge(a: DVec3, b: DVec3, axis: DVec3, exponent: f64) -> f64 {
    let normal = a.cross(b);
    let Some(m) = normal.try_normalize() else {
        return 0.0;
    };
    // x = √(1 − h²) cos t, t from the place nearest to the axis; 1 − x² = h² + (1 − h²) sin² t.
    let h = axis.dot(m);
    let nearest = (axis - m * h).try_normalize().unwrap_or(a);
    let radius2 = (axis - m * h).length_squared();
    let integrand = |t: f64| {
        let y = h * h + radius2 * t.sin() * t.sin();
        if y < 1e-30 {
            return 0.5 * (exponent + 1.0);
        }
        -(0.5 * (exponent + 1.0) * (-y.min(1.0)).ln_1p()).exp_m1() / y
    };
    let start = m.dot(nearest.cross(a)).atan2(nearest.dot(a));
    let end = start + normal.length().atan2(a.dot(b));
    let integral = if start < 0.0 && end > 0.0 {
        adaptive(&integrand, start, 0.0) + adaptive(&integrand, 0.0, end)
    } else {
        adaptive(&integrand, start, end)
    };
    h * integral
}
