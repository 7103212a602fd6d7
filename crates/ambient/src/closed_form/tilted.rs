//! Open points whose shading normal leans away from the geometric normal.
//!
//! The hemisphere is that of the shading normal; its part below the geometric plane is blocked by the surface itself.

use super::phong_open_angle;
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

/// Specular term seen along a shading normal tilted by `delta` radians, `0..=π`: the lobe stands on the shading normal and
/// the geometric plane cuts it. `exponent` is finite and `>= 0`.
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
}
