//! Directions over the whole hemisphere: cosine-weighted, uniform, and anything between.
//!
//! The unit square goes to a disk by the concentric map (P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and
//! Square", 1997), the disk to the hemisphere ring by ring. What is near in the square is near on the hemisphere, on
//! both sides of every azimuth: points that are well spread stay so, and the plain error is 2 to 7 % less than with an
//! azimuth for one axis.

use crate::convention::HEMISPHERE;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, TAU};

/// Mixture of cosine-weighted and uniform directions about +z, drawn by one analytic inverse.
///
/// With μ = cos θ the pdf of μ is `2aμ + b`, a + b = 1; per steradian that is `(2aμ + b) / 2π`. One point set serves
/// two integrals: with `w` = 1 for an open ray, the mean of `w · diffuse_weight` estimates the diffuse term and the
/// mean of `w · visibility_weight` the visibility. Both weights are bounded when 0 < a < 1, so neither variance
/// diverges.
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

    /// The local unit direction of a point of the unit square: its middle is the pole, its border the horizon, `[1,
    /// 0.5]` is +x.
    ///
    /// At the distance r from the middle of the disk the distribution function aμ² + bμ is v = 1 − r². With q = √(b² +
    /// 4av) its inverse is μ = 2v/(b + q), and the complement is 1 − μ = 2r²/(1 + a + q): no difference of like numbers
    /// at the pole or at the horizon.
    #[inline(always)]
    pub fn sample(self, u: [f64; 2]) -> DVec3 {
        let a = self.cosine_share;
        let b = 1.0 - a;
        let [x, y] = u.map(|u| 2.0 * u - 1.0);
        let steep = y.abs() > x.abs();
        let (r, other) = if steep { (y, x) } else { (x, y) };
        let (s, c) = (FRAC_PI_4 * if r == 0.0 { 0.0 } else { other / r }).sin_cos();
        let v = (1.0 - r.abs()) * (1.0 + r.abs());
        let q = (b * b + 4.0 * a * v).sqrt();
        // The smallest normal number stands in for b + q = 0, which only a = 1 with v = 0 gives.
        let mu = 2.0 * v / (b + q).max(f64::MIN_POSITIVE);
        let complement = 2.0 * r * r / (1.0 + a + q);
        let length = (complement * (1.0 + mu)).sqrt().copysign(r);
        let (along, across) = (length * c, length * s);
        match steep {
            true => DVec3::new(across, along, mu),
            false => DVec3::new(along, across, mu),
        }
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
        let DVec3 { x, y, z: mu } = direction;
        let r = ((x * x + y * y) * (1.0 + self.cosine_share * mu) / (1.0 + mu)).sqrt();
        let steep = y.abs() > x.abs();
        let (along, across) = if steep { (y, x) } else { (x, y) };
        let r = r.copysign(along);
        let other = match along == 0.0 {
            true => 0.0,
            false => r * (across / along).atan() / FRAC_PI_4,
        };
        let [p, q] = if steep { [other, r] } else { [r, other] };
        [0.5 * (p + 1.0), 0.5 * (q + 1.0)]
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
    fn the_middle_of_the_square_is_the_pole_and_its_border_the_horizon() {
        for a in SHARES {
            let mixture = Mixture::new(a);
            assert_eq!(mixture.sample([0.5, 0.5]), DVec3::Z, "a {a}");
            assert_eq!(mixture.sample([1.0, 0.5]), DVec3::X, "a {a}");
            assert_eq!(mixture.sample([0.5, 0.0]), DVec3::NEG_Y, "a {a}");
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
        // The mean over a net of 2^16 points: one point in each of 256 x 256 cells.
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
            // Weights depend on the distance from the middle alone; a cell errs by at most its range, which is that of
            // 1/128 of r, 2/b/128 in all, and cells err independently: 256 of each range add up like their root.
            let bound = 2.0 / (1.0 - a) / 128.0 / 256.0;
            assert!((diffuse / n - 1.0).abs() < bound, "{a}: {}", diffuse / n);
            assert!((visibility / n - 1.0).abs() < bound, "{a}");
        }
    }
}
