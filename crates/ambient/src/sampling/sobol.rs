//! Four dimensions of the Sobol sequence, and hash-based Owen scrambling.
//!
//! Direction numbers: S. Joe, F. Kuo, "Constructing Sobol Sequences with Better Two-Dimensional Projections", SIAM J.
//! Sci. Comput. 2008. Nested uniform scrambling: A. Owen, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences", 1995.
//! Scrambling by an arithmetic hash: S. Laine, T. Karras, "Stratified Sampling for Stochastic Transparency", 2011;
//! B. Burley, "Practical Hash-based Owen Scrambling", JCGT 2020.
//!
//! Coordinates are kept bit-reversed until the end: bit 0 is then the most significant binary digit of the point, a
//! carry runs from leading digits to trailing ones, and any mix of additions, odd products and `x ^= x * even` is a
//! nested scramble, because each digit changes by a function of the digits before it.

/// Dimensions of a point.
pub(super) const DIMENSIONS: usize = 4;

/// Degree, inner polynomial coefficients and first odd multipliers of dimensions 1 to 3; dimension 0 is van der Corput.
const JOE_KUO: [(usize, u32, [u32; 3]); DIMENSIONS - 1] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Bit-reversed direction numbers: bit `k` of the index adds `MATRICES[dimension][k]`.
const MATRICES: [[u32; 32]; DIMENSIONS] = {
    let mut columns = [[0; 32]; DIMENSIONS];
    let mut k = 0;
    while k < 32 {
        columns[0][k] = 1 << k;
        k += 1;
    }
    let mut d = 1;
    while d < DIMENSIONS {
        columns[d] = direction_numbers(JOE_KUO[d - 1]);
        d += 1;
    }
    columns
};

const fn direction_numbers((degree, inner, first): (usize, u32, [u32; 3])) -> [u32; 32] {
    // v[k] = m[k] / 2^(k+1) as 32 binary digits; the recurrence on m reads the same on v with a shift by the degree.
    let mut v = [0_u32; 32];
    let mut k = 0;
    while k < 32 {
        if k < degree {
            v[k] = first[k] << (31 - k);
        } else {
            let mut x = v[k - degree] ^ (v[k - degree] >> degree);
            let mut j = 1;
            while j < degree {
                if (inner >> (degree - 1 - j)) & 1 == 1 {
                    x ^= v[k - j];
                }
                j += 1;
            }
            v[k] = x;
        }
        k += 1;
    }
    let mut k = 0;
    while k < 32 {
        v[k] = v[k].reverse_bits();
        k += 1;
    }
    v
}

/// Bit-reversed coordinate of point `index`.
pub(super) const fn sobol(dimension: usize, index: u32) -> u32 {
    let mut x = 0;
    let mut rest = index;
    while rest != 0 {
        x ^= MATRICES[dimension][rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    x
}

/// Nested uniform scramble of a bit-reversed coordinate. `key` chooses the scramble; its bits are well mixed.
#[inline(always)]
pub(super) fn scramble(mut x: u32, key: u64) -> u32 {
    let (sum, product) = (key as u32, (key >> 32) as u32 | 1);
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(sum);
    x = x.wrapping_mul(product);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_points_are_those_of_the_published_sequence() {
        // The first eight points of new-joe-kuo-6, in eighths, dimensions 1 to 4 (natural, not Gray-code, order).
        let eighths = [
            [0, 4, 2, 6, 1, 5, 3, 7],
            [0, 4, 6, 2, 5, 1, 3, 7],
            [0, 4, 6, 2, 3, 7, 5, 1],
            [0, 4, 6, 2, 1, 5, 7, 3],
        ];
        for (d, row) in eighths.iter().enumerate() {
            for (i, &value) in row.iter().enumerate() {
                let x = sobol(d, i as u32).reverse_bits();
                assert_eq!(x, value << 29, "dimension {d}, point {i}");
            }
        }
    }

    #[test]
    fn scrambling_permutes_each_digit_by_the_digits_before_it() {
        for key in [0, 1, 0x9e37_79b9_7f4a_7c15, u64::MAX] {
            for bits in 0..=16 {
                let mask = ((1_u64 << bits) - 1) as u32;
                // Equal leading digits stay equal, whatever follows.
                for x in [0_u32, 1, 77, 0x1234_5678, 0xffff_ffff] {
                    let a = scramble(x & mask, key) & mask;
                    let b = scramble(x, key) & mask;
                    assert_eq!(a, b, "key {key:x}, {bits} digits of {x:x}");
                }
            }
            let mut seen = vec![false; 1 << 16];
            for x in 0..1 << 16 {
                let y = (scramble(x, key) & 0xffff) as usize;
                assert!(!std::mem::replace(&mut seen[y], true));
            }
        }
    }
}
