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

use crate::lanes::LANES;

/// Dimensions of a point.
pub(super) const DIMENSIONS: usize = 4;

/// Degree, inner polynomial coefficients and first odd multipliers of dimensions 1 to 3; dimension 0 is van der Corput.
const JOE_KUO: [(usize, u32, [u32; 3]); DIMENSIONS - 1] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Bit-reversed direction numbers: bit `k` of the index adds `MATRICES[k]`, one number for each dimension.
const MATRICES: [[u32; DIMENSIONS]; 32] = {
    let mut rows = [[0; DIMENSIONS]; 32];
    let mut d = 0;
    while d < DIMENSIONS {
        let mut k = 0;
        while k < 32 {
            rows[k][d] = match d {
                0 => 1 << k,
                _ => direction_numbers(JOE_KUO[d - 1])[k],
            };
            k += 1;
        }
        d += 1;
    }
    rows
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

/// Bit-reversed coordinates of point `index`.
pub(super) const fn sobol(index: u32) -> [u32; DIMENSIONS] {
    let mut point = [0; DIMENSIONS];
    let mut rest = index;
    while rest != 0 {
        let row = &MATRICES[rest.trailing_zeros() as usize];
        let mut d = 0;
        while d < DIMENSIONS {
            point[d] ^= row[d];
            d += 1;
        }
        rest &= rest - 1;
    }
    point
}

/// [`sobol`] of sixteen indices.
#[inline(always)]
pub(super) fn sobol16(index: &[u32; LANES]) -> [[u32; LANES]; DIMENSIONS] {
    let mut points = [[0; LANES]; DIMENSIONS];
    let bits = index.iter().fold(0, |bits, index| bits | index);
    for k in 0..u32::BITS - bits.leading_zeros() {
        for (point, row) in points.iter_mut().zip(MATRICES[k as usize]) {
            for l in 0..LANES {
                point[l] ^= row & 0_u32.wrapping_sub(index[l] >> k & 1);
            }
        }
    }
    points
}

/// Most points of a block that [`CELLS`] can order, as a power of two.
pub(super) const LARGEST_BLOCK: u32 = 10;

/// How to find the one point of an aligned block of `2^m` that lies in an elementary cell of the first two dimensions.
///
/// The block is a (0, m, 2)-net: each cell of `2^-zenith_bits` by `2^-azimuth_bits` holds one point. Everything is
/// linear over GF(2): the point whose leading digits are `(p, q)` has the coordinates `zenith[p] ^ azimuth[q]`, before
/// scrambling and counted from the block's first point.
#[derive(Clone, Copy)]
pub(super) struct Cells {
    pub zenith_bits: u32,
    pub azimuth_bits: u32,
    pub zenith: [[u32; DIMENSIONS]; 32],
    pub azimuth: [[u32; DIMENSIONS]; 32],
}

/// By the block's power of two.
pub(super) static CELLS: [Cells; LARGEST_BLOCK as usize + 1] = {
    let mut all = [cells(0); LARGEST_BLOCK as usize + 1];
    let mut m = 1;
    while m <= LARGEST_BLOCK {
        all[m as usize] = cells(m);
        m += 1;
    }
    all
};

const fn cells(m: u32) -> Cells {
    let zenith_bits = m / 2;
    let azimuth_bits = m - zenith_bits;
    let mask = (1 << azimuth_bits) - 1;
    // Leading digits of dimension 0 are the index's last bits; the index's other bits follow from dimension 1.
    let mut high = [0; 32];
    let mut h = 0;
    while h < 1 << azimuth_bits {
        high[(sobol(h << zenith_bits)[1] & mask) as usize] = h << zenith_bits;
        h += 1;
    }
    let mut cells = Cells {
        zenith_bits,
        azimuth_bits,
        zenith: [[0; DIMENSIONS]; 32],
        azimuth: [[0; DIMENSIONS]; 32],
    };
    let mut p = 0;
    while p < 32 {
        if p < 1 << zenith_bits {
            let index = p | high[(sobol(p)[1] & mask) as usize];
            cells.zenith[p as usize] = sobol(index);
        }
        if p < 1 << azimuth_bits {
            cells.azimuth[p as usize] = sobol(high[p as usize]);
        }
        p += 1;
    }
    cells
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
                let x = sobol(i as u32)[d].reverse_bits();
                assert_eq!(x, value << 29, "dimension {d}, point {i}");
            }
        }
    }

    #[test]
    fn cells_hold_each_point_of_a_block_once() {
        for m in 0..=LARGEST_BLOCK {
            let cells = &CELLS[m as usize];
            let mut points: Vec<[u32; DIMENSIONS]> = (0..1 << m).map(sobol).collect();
            let mut found = Vec::new();
            for p in 0..1_u32 << cells.zenith_bits {
                for q in 0..1_u32 << cells.azimuth_bits {
                    let (a, b) = (cells.zenith[p as usize], cells.azimuth[q as usize]);
                    let point: [u32; DIMENSIONS] = std::array::from_fn(|d| a[d] ^ b[d]);
                    assert_eq!(point[0] & ((1 << cells.zenith_bits) - 1), p, "2^{m}");
                    assert_eq!(point[1] & ((1 << cells.azimuth_bits) - 1), q, "2^{m}");
                    found.push(point);
                }
            }
            points.sort_unstable();
            found.sort_unstable();
            assert_eq!(points, found, "2^{m}");
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
