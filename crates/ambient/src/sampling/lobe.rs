//! Directions of a Phong lobe.

use super::hemisphere::azimuth;
use super::turn::turn_sin_cos;
use crate::convention::lobe_scale;
use glam::DVec3;

/// The lobe cosⁿ about +z, pdf `(n + 1)/2π · cosⁿ` per steradian, for n from 0 (uniform) to 1e6 and beyond.
///
/// Rays drawn from it estimate the specular term as the plain share of rays that are open and above the surface.
///
/// The zenith angle comes from sin² = −expm1(2 ln u / (n + 1)): at n = 1e6 the lobe is a thousandth of a radian wide
/// and the cosine alone has too few levels left.
///
/// ```
/// use ambake_ambient::sampling::Lobe;
/// let lobe = Lobe::new(50.0);
/// let direction = lobe.sample([0.25, 0.6]);
/// assert!((direction.z.powf(51.0) - 0.25).abs() < 1e-14);
/// assert!((lobe.invert(direction)[1] - 0.6).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    exponent: f64,
}

impl Lobe {
    /// The lobe of `exponent` n.
    ///
    /// # Panics
    ///
    /// If `exponent` is negative or not finite.
    pub const fn new(exponent: f64) -> Lobe {
        assert!(
            exponent >= 0.0 && exponent.is_finite(),
            "lobe exponent is negative or not finite"
        );
        Lobe { exponent }
    }

    /// The exponent n.
    pub const fn exponent(self) -> f64 {
        self.exponent
    }

    /// The local unit direction of a point of the unit square; `u[0] = 1` is the axis, `u[1]` the azimuth in turns.
    #[inline(always)]
    pub fn sample(self, u: [f64; 2]) -> DVec3 {
        let log_cos = u[0].ln() / (self.exponent + 1.0);
        let r = (-(2.0 * log_cos).exp_m1()).sqrt();
        let (s, c) = turn_sin_cos(u[1]);
        DVec3::new(r * c, r * s, log_cos.exp())
    }

    /// Probability per steradian of a local unit direction; 0 below the plane of the lobe.
    pub fn pdf(self, direction: DVec3) -> f64 {
        if direction.z < 0.0 {
            return 0.0;
        }
        lobe_scale(self.exponent) * power(direction, self.exponent)
    }

    /// The point that [`Lobe::sample`] maps to a local unit direction of the upper hemisphere.
    pub fn invert(self, direction: DVec3) -> [f64; 2] {
        [power(direction, self.exponent + 1.0), azimuth(direction)]
    }
}

/// zⁿ of a unit vector, accurate for large n: near the axis it is taken from the sine.
fn power(direction: DVec3, n: f64) -> f64 {
    let sin2 = direction.x * direction.x + direction.y * direction.y;
    if n == 0.0 {
        1.0
    } else if sin2 < 0.5 {
        (0.5 * n * (-sin2).ln_1p()).exp()
    } else {
        direction.z.powf(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Mixture, Stream, chi_square};

    const EXPONENTS: [f64; 8] = [0.0, 0.5, 1.0, 2.5, 10.0, 200.0, 1e4, 1e6];

    #[test]
    fn sampling_and_inverting_returns_the_point() {
        for n in EXPONENTS {
            let lobe = Lobe::new(n);
            let stream = Stream::new(1, 0, 0, 0, 0);
            for i in 0..4096 {
                let p = stream.point(i);
                let u = [p[0], p[1]];
                let d = lobe.sample(u);
                assert!((d.length() - 1.0).abs() < 1e-15, "n {n}, u {u:?}: {d}");
                let v = lobe.invert(d);
                // cos^(n+1) multiplies a relative error of 1e-16 of sin² by -ln u, at most 23.
                assert!((v[0] - u[0]).abs() < 5e-15, "n {n}: {v:?} for {u:?}");
                assert!((v[1] - u[1]).abs() < 1e-15, "n {n}: {v:?} for {u:?}");
            }
        }
    }

    #[test]
    fn histograms_match_the_pdf() {
        for n in EXPONENTS {
            let lobe = Lobe::new(n);
            // The table ends where cos^(n+1) = e^-12.
            let edge = (-(-24.0 / (n + 1.0)).exp_m1()).sqrt();
            chi_square::check(edge, |u| lobe.sample(u), |d| lobe.pdf(d));
        }
    }

    #[test]
    fn exponents_zero_and_one_are_the_uniform_and_the_cosine_density() {
        let stream = Stream::new(2, 0, 0, 0, 0);
        for i in 0..256 {
            let p = stream.point(i);
            let u = [p[0], p[1]];
            for (n, mixture) in [(0.0, Mixture::UNIFORM), (1.0, Mixture::COSINE)] {
                let d = mixture.sample(u);
                assert!((Lobe::new(n).pdf(d) - mixture.pdf(d)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_tight_lobe_keeps_its_levels() {
        // sin θ ≈ √(-2 ln u / (n + 1)) to a relative error of (-ln u)/(n + 1).
        let lobe = Lobe::new(1e6);
        for u in [1.0 - 0.5_f64.powi(33), 0.999_999, 0.9, 0.5, 1e-3] {
            let small = (-2.0 * u.ln() / 1_000_001.0).sqrt();
            let sine = lobe.sample([u, 0.0]).x;
            assert!((sine / small - 1.0).abs() < 1e-5, "u {u}: {sine}");
        }
    }
}
