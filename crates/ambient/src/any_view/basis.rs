//! Spherical harmonics that are even about the plane of the surface, as polynomials of the tangential coordinates.

use std::array::from_fn;

/// Largest order.
pub const ORDER: usize = 8;

/// Harmonics of the largest order.
pub const COUNT: usize = count(ORDER);

/// Pairs (l, m) with m >= 0 of the largest order.
pub const PAIRS: usize = pair(ORDER, ORDER) + 1;

/// How many harmonics with l + m even there are up to an order: 15 up to 4, 45 up to 8.
pub const fn count(order: usize) -> usize {
    (order + 1) * (order + 2) / 2
}

/// Where the harmonic (l, m) stands, `l + m` even: by l, then by m from -l to l.
pub const fn index(l: usize, m: isize) -> usize {
    l * (l + 1) / 2 + ((l as isize + m) / 2) as usize
}

/// Where the pair (l, m) stands among those with m >= 0.
pub const fn pair(l: usize, m: usize) -> usize {
    (l + 1) * (l + 1) / 4 + m / 2
}

/// All pairs (l, m) with m >= 0 and l + m even up to an order, in the order of [`pair`].
pub fn pairs(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=order).flat_map(|l| (l % 2..=l).step_by(2).map(move |m| (l, m)))
}

/// The real harmonics y(l, m), l + m even, scaled so that the mean of y² over the hemisphere is 1; y(0, 0) = 1.
///
/// With s = x² + y² = sin², y(l, m) = q(1 - s) Re (x + iy)^m for m >= 0 and q(1 - s) Im (x + iy)^-m for m < 0; q has a
/// degree of (l - m) / 2, at most 4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis<T> {
    /// Coefficients of q by [`pair`], the constant one first.
    pub polynomials: [[T; ORDER / 2 + 1]; PAIRS],
}

impl Basis<f64> {
    /// The basis in double precision.
    pub fn new() -> Self {
        let mut polynomials = [[0.0; ORDER / 2 + 1]; PAIRS];
        for (l, m) in pairs(ORDER) {
            let mut factorials = 1.0;
            for k in l - m + 1..=l + m {
                factorials *= k as f64;
            }
            let twice = if m > 0 { 2.0 } else { 1.0 };
            let scale = (twice * (2 * l + 1) as f64 / factorials).sqrt();
            // The m-th derivative of the Legendre polynomial P_l: what P_l^m is without its sin^m.
            let legendre = legendre(l);
            let q = &mut polynomials[pair(l, m)];
            for (k, coefficient) in q.iter_mut().enumerate().take((l - m) / 2 + 1) {
                let power = 2 * k + m;
                let derived: f64 = (2 * k + 1..=power).map(|k| k as f64).product();
                *coefficient = scale * derived * legendre[power];
            }
        }
        Self { polynomials }
    }

    /// All harmonics up to the largest order at a direction with these tangential coordinates.
    pub fn at(&self, x: f64, y: f64) -> [f64; COUNT] {
        let mut values = [0.0; COUNT];
        let square = (1.0 - x * x - y * y).max(0.0);
        let mut powers = [(1.0, 0.0); ORDER + 1];
        for m in 1..=ORDER {
            let (c, s) = powers[m - 1];
            powers[m] = (c * x - s * y, c * y + s * x);
        }
        for (l, m) in pairs(ORDER) {
            let q = self.polynomials[pair(l, m)];
            let q = q.iter().rev().fold(0.0, |sum, c| sum * square + c);
            values[index(l, -(m as isize))] = q * powers[m].1;
            values[index(l, m as isize)] = q * powers[m].0;
        }
        values
    }

    /// The harmonics with m >= 0 alone, by [`pair`].
    pub fn even_at(&self, x: f64, y: f64) -> [f64; PAIRS] {
        let mut values = [0.0; PAIRS];
        let square = (1.0 - x * x - y * y).max(0.0);
        let mut power = (1.0, 0.0);
        for m in 0..=ORDER {
            for l in (m..=ORDER).step_by(2) {
                let mut q = 0.0;
                for c in self.polynomials[pair(l, m)][..=(l - m) / 2].iter().rev() {
                    q = q * square + c;
                }
                values[pair(l, m)] = q * power.0;
            }
            power = (power.0 * x - power.1 * y, power.0 * y + power.1 * x);
        }
        values
    }

    /// The basis in single precision.
    pub fn single(&self) -> Basis<f32> {
        Basis {
            polynomials: self.polynomials.map(|q| q.map(|c| c as f32)),
        }
    }
}

impl Default for Basis<f64> {
    fn default() -> Self {
        Self::new()
    }
}

/// Coefficients of the Legendre polynomial P_l, the constant one first.
fn legendre(l: usize) -> [f64; ORDER + 1] {
    let (mut before, mut now) = ([0.0; ORDER + 1], from_fn(|k| f64::from(u8::from(k == 0))));
    for k in 0..l {
        // (k + 1) P_(k+1) = (2k + 1) z P_k - k P_(k-1).
        let next = from_fn(|power| {
            let raised = if power > 0 { now[power - 1] } else { 0.0 };
            ((2 * k + 1) as f64 * raised - k as f64 * before[power]) / (k + 1) as f64
        });
        (before, now) = (now, next);
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;
    use std::f64::consts::TAU;

    #[test]
    fn harmonics_are_orthonormal_over_the_hemisphere() {
        let basis = Basis::new();
        let mut products = vec![[0.0; COUNT]; COUNT];
        let turns = 20;
        for (node, weight) in gauss_legendre(12) {
            let z = 0.5 * (node + 1.0);
            let r = (1.0 - z * z).sqrt();
            for turn in 0..turns {
                let (s, c) = (TAU * f64::from(turn) / f64::from(turns)).sin_cos();
                let y = basis.at(r * c, r * s);
                for (k, (l, m)) in pairs(ORDER).enumerate() {
                    let even = basis.even_at(r * c, r * s)[k];
                    assert!((even - y[index(l, m as isize)]).abs() < 1e-12);
                }
                for (row, a) in products.iter_mut().zip(y) {
                    for (sum, b) in row.iter_mut().zip(y) {
                        *sum += 0.5 * weight * a * b / f64::from(turns);
                    }
                }
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (k, product) in row.iter().enumerate() {
                let exact = f64::from(u8::from(i == k));
                assert!((product - exact).abs() < 1e-12, "{i} {k}: {product}");
            }
        }
    }

    #[test]
    fn places_are_dense_and_in_order() {
        assert_eq!([count(4), count(8), PAIRS], [15, 45, 25]);
        let mut next = 0;
        for l in 0..=ORDER {
            for m in (-(l as isize)..=l as isize).step_by(2) {
                assert_eq!(index(l, m), next);
                next += 1;
            }
        }
        for (at, (l, m)) in pairs(ORDER).enumerate() {
            assert_eq!(pair(l, m), at);
        }
    }
}
