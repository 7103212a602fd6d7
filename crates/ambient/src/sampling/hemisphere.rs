//! Directions over the whole hemisphere: cosine-weighted, uniform, and anything between.

use super::turn::turn_sin_cos;
use crate::convention::HEMISPHERE;
use glam::DVec3;
use std::f64::consts::TAU;

/// Mixture of cosine-weighted and uniform directions about +z, drawn by one analytic inverse.
///
/// With μ = cos θ the pdf of μ is `2aμ + b`, a + b = 1; per steradian that is `(2aμ + b) / 2π`. One point set serves two
/// integrals: with `w` = 1 for an open ray, the mean of `w · diffuse_weight` estimates the diffuse term and the mean of
/// `w · visibility_weight` the visibility. Both weights are bounded when 0 < a < 1, so neither variance diverges.
///
/// ```
/// use ambake_ambient::sampling::{Mixture, Stream};
/// // A wall fills the half x < 0: half of the directions are open, and half of the diffuse term is left.
/// let (mixture, stream) = (Mixture::BALANCED, Stream::new(0, 0, 0, 0, 0));
/// let (mut visibility, mut diffuse) = (0.0, 0.0);
/// for index in 0..1024 {
///     let [u, v, ..] = stream.point(index);
///     let direction = mixture.sample([u, v]);
///     if direction.x > 0.0 {
///         visibility += mixture.visibility_weight(direction.z) / 1024.0;
///         diffuse += mixture.diffuse_weight(direction.z) / 1024.0;
///     }
/// }
/// assert!((visibility - 0.5_f64).abs() < 0.01 && (diffuse - 0.5_f64).abs() < 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture {
    cosine_share: f64,
}

impl Mixture {
    /// Cosine-weighted directions, pdf μ/π.
    pub const COSINE: Mixture = Mixture { cosine_share: 1.0 };
    /// Directions of uniform solid angle, pdf 1/2π.
    pub const UNIFORM: Mixture = Mixture { cosine_share: 0.0 };
    /// Half of each: the diffuse weight is below 4/3, the visibility weight between 2/3 and 2.
    pub const BALANCED: Mixture = Mixture { cosine_share: 0.5 };

    /// The mixture with `cosine_share` = a.
    ///
    /// # Panics
    ///
    /// If `cosine_share` is outside `0..=1`.
    pub const fn new(cosine_share: f64) -> Mixture {
        assert!(
            cosine_share >= 0.0 && cosine_share <= 1.0,
            "cosine share outside 0..=1"
        );
        Mixture { cosine_share }
    }

    /// The share a of cosine-weighted directions.
    pub const fn cosine_share(self) -> f64 {
        self.cosine_share
    }

    /// The local unit direction of a point of the unit square; `u[0] = 1` is the pole, `u[1]` the azimuth in turns.
    ///
    /// The distribution function is aμ² + bμ. With q = √(b² + 4a·u₀) its inverse is μ = 2u₀/(b + q), and the complement is
    /// 1 − μ = 2(1 − u₀)/(1 + a + q): no difference of like numbers at the pole or at the horizon.
    #[inline(always)]
    pub fn sample(self, u: [f64; 2]) -> DVec3 {
        let a = self.cosine_share;
        let b = 1.0 - a;
        let q = (b * b + 4.0 * a * u[0]).sqrt();
        // The smallest normal number stands in for b + q = 0, which only a = 1 with u = 0 gives.
        let mu = 2.0 * u[0] / (b + q).max(f64::MIN_POSITIVE);
        let complement = 2.0 * (1.0 - u[0]) / (1.0 + a + q);
        let r = (complement * (1.0 + mu)).sqrt();
        let (s, c) = turn_sin_cos(u[1]);
        DVec3::new(r * c, r * s, mu)
    }

    /// Probability per steradian of a local unit direction; 0 below the horizon.
    pub fn pdf(self, direction: DVec3) -> f64 {
        if direction.z < 0.0 {
            return 0.0;
        }
        self.density(direction.z) / HEMISPHERE
    }

    /// The point that [`Mixture::sample`] maps to a local unit direction of the upper hemisphere.
    pub fn invert(self, direction: DVec3) -> [f64; 2] {
        let a = self.cosine_share;
        let mu = direction.z;
        [mu * (a * mu + (1.0 - a)), azimuth(direction)]
    }

    /// Weight of an open ray in the mean that estimates the diffuse term: 2μ/(2aμ + b); 1 at the pole when a = 1.
    #[inline(always)]
    pub fn diffuse_weight(self, mu: f64) -> f64 {
        2.0 * mu / self.density(mu)
    }

    /// Weight of an open ray in the mean that estimates the visibility: 1/(2aμ + b).
    #[inline(always)]
    pub fn visibility_weight(self, mu: f64) -> f64 {
        1.0 / self.density(mu)
    }

    /// Probability density of μ itself.
    #[inline(always)]
    fn density(self, mu: f64) -> f64 {
        2.0 * self.cosine_share * mu + (1.0 - self.cosine_share)
    }
}

/// Azimuth in turns, `0..1`.
pub(super) fn azimuth(direction: DVec3) -> f64 {
    let turns = direction.y.atan2(direction.x) / TAU;
    if turns < 0.0 { turns + 1.0 } else { turns }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Stream, chi_square};

    const SHARES: [f64; 6] = [0.0, 1e-9, 0.25, 0.5, 0.75, 1.0];

    #[test]
    fn sampling_and_inverting_returns_the_point() {
        for a in SHARES {
            let mixture = Mixture::new(a);
            let stream = Stream::new(1, 0, 0, 0, 0);
            for i in 0..4096 {
                let p = stream.point(i);
                let u = [p[0], p[1]];
                let d = mixture.sample(u);
                assert!((d.length() - 1.0).abs() < 1e-15, "a {a}, u {u:?}: {d}");
                let v = mixture.invert(d);
                // A few roundings of numbers below 2.
                assert!((v[0] - u[0]).abs() < 1e-15, "a {a}: {v:?} for {u:?}");
                assert!((v[1] - u[1]).abs() < 1e-15, "a {a}: {v:?} for {u:?}");
            }
        }
    }

    #[test]
    fn corners_of_the_square_are_the_pole_and_the_horizon() {
        for a in SHARES {
            let mixture = Mixture::new(a);
            assert_eq!(mixture.sample([1.0, 0.3]), DVec3::Z, "a {a}");
            assert_eq!(mixture.sample([0.0, 0.0]), DVec3::X, "a {a}");
        }
    }

    #[test]
    fn histograms_match_the_pdf() {
        for a in SHARES {
            let mixture = Mixture::new(a);
            chi_square::check(1.0, |u| mixture.sample(u), |d| mixture.pdf(d));
        }
    }

    #[test]
    fn open_sky_is_one_in_both_terms() {
        // The mean over a net: 2^16 points, error of the one-dimensional stratified midpoint rule far below 1e-4.
        let stream = Stream::new(4, 0, 0, 0, 0);
        for a in [0.25, 0.5, 0.75] {
            let mixture = Mixture::new(a);
            let (mut diffuse, mut visibility) = (0.0, 0.0);
            for i in 0..1 << 16 {
                let p = stream.point(i);
                let mu = mixture.sample([p[0], p[1]]).z;
                diffuse += mixture.diffuse_weight(mu);
                visibility += mixture.visibility_weight(mu);
            }
            let n = f64::from(1 << 16);
            // Stratified in 2^16 cells, each cell errs by at most its own range: total variation below 2/b a term.
            let bound = 2.0 / (1.0 - a) / n;
            assert!((diffuse / n - 1.0).abs() < bound, "{a}: {}", diffuse / n);
            assert!((visibility / n - 1.0).abs() < bound, "{a}");
        }
    }
}
