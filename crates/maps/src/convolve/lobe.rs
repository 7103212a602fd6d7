//! Reflectance functions and their zonal coefficients.

use crate::Error;
use ambient::convention::{LAMBERT_SCALE, MAP_1984, MEAN_SCALE, SPHERE, lobe_scale};
use ambient::quadrature::GAUSS_8;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A reflectance function of x, the cosine of the angle from the normal (D) or the mirror direction (S).
#[derive(Debug, Clone, PartialEq)]
pub enum Lobe {
    /// max(0, x), section 6.1 (1).
    Lambert,
    /// 1 everywhere, section 6.1 (2).
    Luminous,
    /// S = I, section 6.2 (1).
    Mirror,
    /// max(0, x)ⁿ for real n in 0..=1e5, section 6.2 (2).
    Phong(f64),
    /// The Phong lobe under a clear coat: half the mirrored map is added, section 6.2 (3).
    Varnish(f64),
    /// GGX with α = roughness² seen along the normal: D(√((1+x)/2)) max(0, x), as prefiltered maps of today's engines
    /// hold it (B. Karis 2013). Roughness in 0.06..=1.
    Ggx(f64),
    /// Linear between (x, value) pairs with x ascending in -1..=1; constant beyond the ends.
    Table(Vec<(f64, f64)>),
}

/// What the integral over the sphere is multiplied by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normalise {
    /// One over the integral of the lobe: a constant map of 1 gives 1 (Lambert 1/π, Phong (n+1)/2π).
    Radiance,
    /// 1/4π, as the 1984 text has it ([`ambient::convention::MAP_1984`]).
    Seed,
    /// This, for lobes whose values have a unit.
    Factor(f64),
}

/// Highest exponent.
const MAX_EXPONENT: f64 = 1e5;

/// What is left out of a series, relative to the lobe's peak: below the rounding of f32 results.
const REST: f64 = 1e-8;

/// Highest order. A lobe with a kink at the horizon needs more; see [`Lobe::zonal`]. Powers of a sine underflow only
/// where the functions themselves are negligible up to order 1900.
const MAX_ORDER: usize = 1023;
const MAX_PHONG_ORDER: usize = 1900;

impl Lobe {
    /// # Errors
    /// [`Error::Lobe`] for parameters outside their range.
    pub fn check(&self) -> Result<(), Error> {
        let fail = |text: String| Err(Error::Lobe(text));
        match self {
            Lobe::Phong(n) | Lobe::Varnish(n) if !(0.0..=MAX_EXPONENT).contains(n) => {
                fail(format!("exponent {n}; it lies in 0..1e5"))
            }
            Lobe::Ggx(r) if !(0.06..=1.0).contains(r) => fail(format!(
                "roughness {r}; it lies in 0.06..1, below that use the mirror"
            )),
            Lobe::Table(pairs) => {
                let sound =
                    |(x, v): &(f64, f64)| (-1.0..=1.0).contains(x) && v.is_finite() && *v >= 0.0;
                let ascending = pairs.windows(2).all(|p| p[0].0 < p[1].0);
                if pairs.is_empty() || !ascending || !pairs.iter().all(sound) {
                    return fail(
                        "a table has cosines ascending in -1..1 with values of at least 0".into(),
                    );
                }
                if self.zonal()?[0] <= 0.0 {
                    return fail("the table is 0 everywhere".into());
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The factor of a normalisation.
    pub(super) fn scale(&self, normalise: Normalise) -> f64 {
        match (normalise, self) {
            (Normalise::Seed, _) => MAP_1984,
            (Normalise::Factor(factor), _) => factor,
            (_, Lobe::Lambert) => LAMBERT_SCALE,
            (_, Lobe::Luminous | Lobe::Mirror) => MEAN_SCALE,
            (_, Lobe::Phong(n) | Lobe::Varnish(n)) => lobe_scale(*n),
            (_, Lobe::Ggx(_) | Lobe::Table(_)) => 1.0 / self.quadrature(0)[0],
        }
    }

    /// The lobe's value.
    pub fn value(&self, x: f64) -> f64 {
        match self {
            Lobe::Lambert => x.max(0.0),
            Lobe::Luminous => 1.0,
            Lobe::Mirror => f64::from(u8::from(x >= 1.0)),
            Lobe::Phong(n) | Lobe::Varnish(n) if x > 0.0 => x.powf(*n),
            Lobe::Phong(_) | Lobe::Varnish(_) => 0.0,
            Lobe::Ggx(roughness) => {
                let alpha2 = roughness.powi(4);
                let half = 0.5 * (1.0 + x) * (alpha2 - 1.0) + 1.0;
                alpha2 / (PI * half * half) * x.max(0.0)
            }
            Lobe::Table(pairs) => {
                let after = pairs.partition_point(|p| p.0 <= x);
                match (after.checked_sub(1).map(|k| pairs[k]), pairs.get(after)) {
                    (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
                    (Some(a), None) => a.1,
                    (None, Some(b)) => b.1,
                    (None, None) => 0.0,
                }
            }
        }
    }

    /// Zonal coefficients 2π ∫ k(x) P_l(x) dx from order 0 to where the rest is below 1e-8 of the peak.
    ///
    /// A kink at the horizon ends earlier, at order 1023: what is left is then at most 3e-4 of the peak for a point
    /// light and x¹, 2e-7 for x²; extended lights leave far less.
    pub(super) fn zonal(&self) -> Result<Vec<f64>, Error> {
        let mut zonal = match self {
            Lobe::Luminous => vec![SPHERE],
            Lobe::Lambert => powers(1.0, MAX_ORDER),
            Lobe::Phong(n) | Lobe::Varnish(n) => {
                let gauss = (2.0 * (n + 1.0) * -REST.ln()).sqrt().ceil() as usize;
                powers(*n, gauss.clamp(MAX_ORDER, MAX_PHONG_ORDER))
            }
            Lobe::Ggx(_) | Lobe::Table(_) => self.quadrature(MAX_ORDER),
            Lobe::Mirror => return Err(Error::Lobe("a mirror has no series".into())),
        };
        // The peak is Σ (2l+1)/4π c_l: cut where the rest of the sum of magnitudes no longer matters.
        let term = |(l, c): (usize, &f64)| (2 * l + 1) as f64 * c.abs();
        let peak: f64 = zonal.iter().enumerate().map(term).sum();
        let mut rest = 0.0;
        while zonal.len() > 1 {
            rest += term((zonal.len() - 1, &zonal[zonal.len() - 1]));
            if rest > REST * peak {
                break;
            }
            zonal.pop();
        }
        Ok(zonal)
    }

    /// The coefficients by Gauss-Legendre quadrature in the angle, between the places where the lobe may have kinks.
    fn quadrature(&self, order: usize) -> Vec<f64> {
        let mut cuts = vec![0.0, FRAC_PI_2, PI];
        if let Lobe::Table(pairs) = self {
            cuts.extend(pairs.iter().map(|p| p.0.acos()));
        }
        cuts.extend((1..16).map(|k| FRAC_PI_2 / f64::from(1 << k))); // towards the peak
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let longest = 2.0 / (order as f64 + 8.0); // eight nodes are exact to rounding on two radians of P_l
        let mut sums = vec![0.0; order + 1];
        for cut in cuts.windows(2) {
            let count = ((cut[1] - cut[0]) / longest).ceil();
            let half = 0.5 * (cut[1] - cut[0]) / count;
            for k in 0..count as usize {
                let middle = cut[0] + (2 * k + 1) as f64 * half;
                for (node, weight) in GAUSS_8 {
                    for angle in [middle - half * node, middle + half * node] {
                        let (sin, x) = angle.sin_cos();
                        let value = TAU * half * weight * sin * self.value(x);
                        let (mut p, mut last) = (1.0, 0.0);
                        for (l, sum) in sums.iter_mut().enumerate() {
                            *sum += value * p;
                            let l = l as f64;
                            (p, last) = (((2.0 * l + 1.0) * x * p - l * last) / (l + 1.0), p);
                        }
                    }
                }
            }
        }
        sums
    }
}

/// 2π ∫ max(0, x)ⁿ P_l: m_0 = 1/(n+1), m_1 = 1/(n+2), m_{l+2} = m_l (n-l) / (n+l+3), without cancellation.
fn powers(n: f64, order: usize) -> Vec<f64> {
    let mut m = vec![1.0 / (n + 1.0), 1.0 / (n + 2.0)];
    for l in 0..order.saturating_sub(1) {
        m.push(m[l] * (n - l as f64) / (n + l as f64 + 3.0));
    }
    m.truncate(order + 1);
    m.iter().map(|v| v * TAU).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_powers_are_those_of_quadrature() {
        for n in [0.0, 1.0, 2.0, 3.7, 10.0, 100.0, 1000.0] {
            let exact = powers(n, 60);
            let sums = Lobe::Phong(n).quadrature(60);
            for (l, (a, b)) in exact.iter().zip(&sums).enumerate() {
                // x^3.7 is not smooth at the horizon, where the rule converges slowly.
                let bound = if n.fract() == 0.0 { 1e-13 } else { 1e-9 };
                assert!((a - b).abs() < bound, "n = {n}, l = {l}: {a} {b}");
            }
        }
    }

    #[test]
    fn printed_coefficients_are_met() {
        let half = |n, l: usize| powers(n, 8)[l] / SPHERE;
        for (l, value) in [
            0.25,
            1.0 / 6.0,
            1.0 / 16.0,
            0.0,
            -1.0 / 96.0,
            0.0,
            1.0 / 256.0,
        ]
        .into_iter()
        .enumerate()
        {
            assert!((half(1.0, l) - value).abs() < 1e-16);
        }
        for (l, value) in [
            0.045454545,
            0.041666667,
            0.034965035,
            0.026785714,
            0.018648019,
        ]
        .into_iter()
        .enumerate()
        {
            assert!((half(10.0, l) - value).abs() < 6e-10);
        }
    }

    #[test]
    fn a_smooth_lobe_ends_early_and_a_kinked_one_at_the_limit() {
        let order = |lobe: Lobe| lobe.zonal().unwrap().len() - 1;
        assert_eq!(order(Lobe::Luminous), 0);
        assert_eq!(order(Lobe::Phong(0.5)), MAX_ORDER);
        for n in [10.0, 100.0, 1000.0, 10_000.0, 1e5] {
            // The coefficients fall like exp(-l²/2n).
            let most = (2.0 * (n + 1.0) * 1e8f64.ln()).sqrt() as usize + 6;
            let order = order(Lobe::Phong(n));
            assert!(
                order <= most && order > most * 3 / 4,
                "n = {n}: {order} {most}"
            );
        }
    }

    #[test]
    fn unusable_lobes_are_refused() {
        let table = |pairs: &[(f64, f64)]| Lobe::Table(pairs.to_vec());
        for lobe in [
            Lobe::Phong(-1.0),
            Lobe::Phong(f64::NAN),
            Lobe::Varnish(2e5),
            Lobe::Ggx(0.0),
            table(&[]),
            table(&[(0.5, 1.0), (0.2, 1.0)]),
            table(&[(0.5, -1.0)]),
            table(&[(0.0, 0.0), (1.0, 0.0)]),
        ] {
            assert!(matches!(lobe.check(), Err(Error::Lobe(_))), "{lobe:?}");
        }
    }
}
