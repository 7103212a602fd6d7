//! Open points whose shading normal leans away from the geometric normal.
//!
//! The hemisphere is that of the shading normal; its part below the geometric plane is blocked by the surface itself.

use super::phong_open_angle;
use glam::DVec3;
use std::f64::consts::PI;

/// Visibility of an open plane about a shading normal tilted by `delta` radians, `0..=π`: 1 − δ/π.
pub fn tilted_visibility(delta: f64) -> f64 {
    1.0 - delta / PI
}

/// Diffuse term of an open plane about a shading normal tilted by `delta` radians, `0..=π`: cos²(δ/2).
pub fn tilted_diffuse(delta: f64) -> f64 {
    let c = (0.5 * delta).cos();
    c * c
}

/// Cosine-weighted mean open direction of an open plane, not of unit length: (1/π) ∫ (N·L) L dω over N·L, Ng·L >= 0.
///
/// * `normal`, `geometric`: unit vectors N and Ng, at an angle δ of `0..=π`.
///
/// The directions form a lune. With the poles on its corners, L = (sin θ cos φ, sin θ sin φ, cos θ), N at φ = 0 and Ng
/// at φ = δ, it is δ − π/2 <= φ <= π/2, and ∫ sin³θ dθ = 4/3 leaves ∫ cos φ (cos φ, sin φ) dφ, so the mean is 4/3π [((π
/// − δ)/2 + sin 2δ / 4) N + (sin² δ / 2) T], T the part of Ng across N, of unit length.
pub fn tilted_bent(normal: DVec3, geometric: DVec3) -> DVec3 {
    let (cos, sin) = (normal.dot(geometric), normal.cross(geometric).length());
    let delta = sin.atan2(cos);
    let across = (geometric - cos * normal).normalize_or_zero();
    let along = 0.5 * (PI - delta) + 0.5 * sin * cos;
    (normal * along + across * (0.5 * sin * sin)) * (4.0 / (3.0 * PI))
}

/// Mean open direction of an open plane over the whole sphere, not of unit length: (1/4π) ∫ L dω over N·L, Ng·L >= 0.
///
/// * `normal`, `geometric`: unit vectors N and Ng, at an angle of less than π.
///
/// On the lune of [`tilted_bent`] ∫ sin²θ dθ = π/2 and ∫ (cos φ, sin φ) dφ = (1 + cos δ, sin δ), which is N + Ng.
pub fn tilted_mean(normal: DVec3, geometric: DVec3) -> DVec3 {
    (normal + geometric) / 8.0
}

/// Specular term seen along a shading normal tilted by `delta` radians, `0..=π`: the lobe stands on the shading normal
/// and the geometric plane cuts it. `exponent` is finite and `>= 0`.
pub fn tilted_specular(exponent: f64, delta: f64) -> f64 {
    phong_open_angle(exponent, delta)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilts_of_the_table_of_hard_cases() {
        for (degrees, visibility, diffuse) in [
            (10.0_f64, 0.944_444_444_444_444_4, 0.992_403_876_506_104),
            (30.0, 0.833_333_333_333_333_4, 0.933_012_701_892_219_3),
            (60.0, 0.666_666_666_666_666_7, 0.75),
        ] {
            let delta = degrees.to_radians();
            assert!((tilted_visibility(delta) - visibility).abs() < 4e-16);
            assert!((tilted_diffuse(delta) - diffuse).abs() < 4e-16);
            // With n = 1 the lobe is the cosine itself.
            assert!((tilted_specular(1.0, delta) - diffuse).abs() < 4e-16);
        }
    }

    #[test]
    fn bent_normal_of_a_tilted_plane_is_that_of_quadrature() {
        let geometric = DVec3::Z;
        for degrees in [0.0_f64, 10.0, 45.0, 90.0, 130.0, 180.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let normal = DVec3::new(sin, 0.0, cos);
            let (mut sum, mut mean, n) = (DVec3::ZERO, DVec3::ZERO, 1000);
            // Midpoints in the cosine of the zenith angle and in the azimuth: equal solid angles.
            for i in 0..n {
                let z = (f64::from(i) + 0.5) / f64::from(n);
                let r = (1.0 - z * z).sqrt();
                for j in 0..n {
                    let (s, c) = ((f64::from(j) + 0.5) / f64::from(n) * 2.0 * PI).sin_cos();
                    let l = DVec3::new(r * c, r * s, z);
                    sum += l * l.dot(normal).max(0.0);
                    mean += l * f64::from(u8::from(l.dot(normal) > 0.0));
                }
            }
            let exact = sum * (2.0 / f64::from(n * n));
            let found = tilted_bent(normal, geometric);
            // The kink at the horizon of N leaves an error of the order of a cell's width squared.
            assert!(
                (found - exact).length() < 2e-5,
                "{degrees}: {found} {exact}"
            );
            let (found, exact) = (
                tilted_mean(normal, geometric),
                mean * (0.5 / f64::from(n * n)),
            );
            // A cell at the horizon of N counts wholly or not at all.
            assert!(
                (found - exact).length() < 2e-5,
                "{degrees}: {found} {exact}"
            );
        }
    }
}
