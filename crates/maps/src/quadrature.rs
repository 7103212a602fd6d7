//! Gauss-Legendre rules.

use std::f64::consts::PI;

/// Positive nodes and weights of the 8-point rule on -1..1.
pub(crate) const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_78, 0.362_683_783_378_361_66),
    (0.525_532_409_916_329, 0.313_706_645_877_886_9),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_43),
    (0.960_289_856_497_536_2, 0.101_228_536_290_377_06),
];

/// Nodes in ascending order and weights of the `count`-point rule on -1..1, to rounding.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let rule = (0..count).map(|k| {
        // Newton's method from the asymptotic place of the zero.
        let mut x = -(PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..64 {
            let (mut p, mut last) = (1.0, 0.0);
            for l in 0..count {
                let l = l as f64;
                (p, last) = (((2.0 * l + 1.0) * x * p - l * last) / (l + 1.0), p);
            }
            slope = n * (x * p - last) / (x * x - 1.0);
            let step = p / slope;
            x -= step;
            if step.abs() <= 1e-16 {
                break;
            }
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_exactly() {
        for count in [1, 2, 3, 5, 16, 200] {
            let rule = gauss_legendre(count);
            for power in (0..(2 * count as i32).min(40)).step_by(2) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
                let exact = 2.0 / f64::from(power + 1);
                // The sum of `count` positive terms, each with a few roundings.
                assert!(
                    (sum - exact).abs() < 1e-14 * count as f64,
                    "{count} {power}: {sum}"
                );
            }
        }
        for ((x, w), (a, b)) in GAUSS_8.iter().zip(&gauss_legendre(8)[4..]) {
            assert!((x - a).abs() < 1e-15 && (w - b).abs() < 1e-14);
        }
    }
}
