//! A rank-1 lattice sequence in four dimensions, randomised by a shift of the torus.
//!
//! Point i has the coordinates `frac(φ₂(i) z_d + shift_d)`, φ₂ the radical inverse in base 2: the first 2^m points are
//! a rank-1 lattice for every m (F. Hickernell, H. Hong, P. L'Écuyer, C. Lemieux, "Extensible Lattice Sequences for
//! Quasi-Monte Carlo Quadrature", SIAM J. Sci. Comput. 2000). Random shifts: R. Cranley, T. Patterson, "Randomization
//! of Number Theoretic Methods for Multiple Integration", 1976.
//!
//! **Choice of z.** Visibility jumps across curves, so its Fourier coefficients fall like `|k|^-3/2` and the variance
//! of a shifted lattice is a sum over its dual lattice of `|k|^-3` (in two dimensions). `z_1` was found bit by bit, by
//! a beam search that keeps `N^3/2 Σ |k|^-3` small for every N = 2^m at once: it is 8.2 to 10.2 for m = 3..12, where
//! Fibonacci lattices have 8.5 to 8.8 and the least possible value is that of the hexagonal lattice. `z_2`, `z_3`
//! (positions in the footprint) keep `N^5/4 Σ (k_0² + k_1² + 4 k_2² + 4 k_3²)^-5/2` small over m = 3..9 among random
//! pairs.

use super::sobol::DIMENSIONS;

/// Generating vector; dimension 0 is van der Corput's sequence.
const GENERATOR: [u32; DIMENSIONS] = [1, 95_259, 7_187, 3_177];

/// Coordinate of point `index` before the shift, in units of 2^-32.
#[inline(always)]
pub(super) fn lattice(dimension: usize, index: u32) -> u32 {
    index.reverse_bits().wrapping_mul(GENERATOR[dimension])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `N^3/2 Σ |k|^-3` over the dual lattice of the first `2^m` points in dimensions 0 and 1.
    fn merit(m: u32) -> f64 {
        let n = f64::from(1_u32 << m);
        let z = i64::from(GENERATOR[1]);
        let mut sum = 0.0;
        for k1 in -256_i64..=256 {
            let first = (-z * k1).rem_euclid(1 << m);
            for wrap in -2..=2 {
                let k0 = (first + (wrap << m)) as f64;
                let square = k0 * k0 + (k1 * k1) as f64;
                if square > 0.0 {
                    sum += square.powf(-1.5);
                }
            }
        }
        sum * n.powf(1.5)
    }

    #[test]
    fn every_power_of_two_is_a_good_lattice() {
        for m in 3..=12 {
            let merit = merit(m);
            assert!(merit < 10.3, "2^{m} points: {merit}");
        }
    }

    #[test]
    fn each_dimension_of_a_full_lattice_is_a_regular_grid() {
        for d in 0..DIMENSIONS {
            for m in 0..=10 {
                let mut cells: Vec<u32> = (0..1 << m).map(|i| lattice(d, i)).collect();
                cells.sort_unstable();
                for (k, cell) in cells.into_iter().enumerate() {
                    assert_eq!(u64::from(cell), (k as u64) << (32 - m), "dimension {d}");
                }
            }
        }
    }
}
