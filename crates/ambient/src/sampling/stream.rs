//! The sample points of one texel: a pure function of what is baked, never of the order of baking.

use super::sobol::{DIMENSIONS, scramble, sobol};

/// Owen-scrambled Sobol points in four dimensions, for one texel, term and replicate.
///
/// Dimensions 0 and 1 form a (0,2)-sequence: any aligned block of 2^m points has exactly one point in each of the 2^m
/// elementary intervals of every shape. Use them for the direction. Every single dimension is stratified the same way.
/// Two streams whose arguments differ anywhere are independent randomisations of the same sequence, so that the mean of
/// a stream is unbiased and the spread between replicates estimates its error.
///
/// ```
/// use ambake_ambient::sampling::Stream;
/// let (a, b) = (Stream::new(0, 0, 17, 0, 0), Stream::new(0, 0, 18, 0, 0));
/// assert_ne!(a.point(40), b.point(40));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    keys: [u64; DIMENSIONS],
    /// Number of the point that counts as the first.
    first: u32,
}

impl Stream {
    /// The stream of a texel. The arguments are labels: any values do, and only their equality matters.
    ///
    /// * `term`: which integral the points serve, so that two terms of a texel do not share their errors.
    /// * `replicate`: which of several independent randomisations.
    pub fn new(seed: u64, page: u32, texel: u32, term: u32, replicate: u32) -> Stream {
        let place = u64::from(page) << 32 | u64::from(texel);
        let role = u64::from(term) << 32 | u64::from(replicate);
        let key = mix(mix(mix(seed).wrapping_add(place)).wrapping_add(role));
        Stream {
            keys: [0, 1, 2, 3].map(|d: u64| mix(key ^ d)),
            first: 0,
        }
    }

    /// This stream with point `first ^ i` in place of each point `i`.
    pub(super) fn starting_at(self, first: u32) -> Stream {
        Stream { first, ..self }
    }

    /// Coordinates of point `index`: odd multiples of 2^-33, so strictly inside (0, 1). No period short of 2^32.
    pub fn point(&self, index: u32) -> [f64; DIMENSIONS] {
        let point = sobol(self.first ^ index);
        std::array::from_fn(|d| unit(scramble(point[d], self.keys[d])))
    }

    /// What randomises a dimension.
    #[inline]
    pub(super) fn key(&self, dimension: usize) -> u64 {
        self.keys[dimension]
    }

    /// Bit-reversed coordinates of the first point, before they are randomised.
    pub(super) fn base(&self) -> [u32; DIMENSIONS] {
        sobol(self.first)
    }
}

/// The middle of the cell of 2^-32 that a bit-reversed coordinate names. Exact.
#[inline(always)]
fn unit(reversed: u32) -> f64 {
    (f64::from(reversed.reverse_bits()) + 0.5) * (1.0 / 4_294_967_296.0)
}

/// A bijection of 64 bits in which each input bit flips each output bit about half the time: the finaliser of G.
/// Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom Number Generators", 2014, with the increment that keeps 0
/// from 0.
#[inline]
pub(super) fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest number of points of a block of 2^m in one of the boxes 2^-k0 by 2^-k1 of two dimensions.
    fn fullest_box(stream: &Stream, dims: [usize; 2], first: u32, k: [u32; 2]) -> u32 {
        let mut counts = vec![0; 1 << (k[0] + k[1])];
        for i in 0..1 << (k[0] + k[1]) {
            let p = stream.point(first + i);
            let [x, y] = [0, 1].map(|j| (p[dims[j]] * f64::from(1 << k[j])) as usize);
            counts[x << k[1] | y] += 1;
        }
        counts.into_iter().max().unwrap_or(0)
    }

    #[test]
    fn every_elementary_interval_of_the_first_two_dimensions_gets_one_point() {
        for (texel, first) in [(0, 0), (1, 1 << 12), (2, 77 << 12), (3, 0xfff0_0000)] {
            let stream = Stream::new(5, 2, texel, 1, 3);
            for m in 0..=12 {
                for k in 0..=m {
                    assert_eq!(fullest_box(&stream, [0, 1], first, [k, m - k]), 1);
                }
            }
        }
    }

    #[test]
    fn every_single_dimension_is_stratified() {
        let stream = Stream::new(9, 0, 1, 0, 0);
        for d in 0..4 {
            assert_eq!(fullest_box(&stream, [d, (d + 1) % 4], 1 << 20, [10, 0]), 1);
        }
    }

    #[test]
    fn other_pairs_of_dimensions_are_nets_of_their_known_quality() {
        // t of a pair: a box of volume 2^(t-m) holds 2^t points; the bound is the sum of the degrees less one each.
        let stream = Stream::new(9, 0, 2, 0, 0);
        for (dims, t) in [
            ([0, 2], 1),
            ([1, 2], 1),
            ([0, 3], 2),
            ([1, 3], 2),
            ([2, 3], 3),
        ] {
            let mut counts = [0; 9];
            for k in 0..=8 {
                let mut boxes = vec![0_u32; 256];
                for i in 0..256 << t {
                    let p = stream.point(i);
                    let x = (p[dims[0]] * f64::from(1 << k)) as usize;
                    let y = (p[dims[1]] * f64::from(1 << (8 - k))) as usize;
                    boxes[x << (8 - k) | y] += 1;
                }
                counts[k as usize] = boxes.into_iter().max().unwrap_or(0);
            }
            assert_eq!(counts, [1 << t; 9], "dimensions {dims:?}");
        }
    }

    #[test]
    fn each_argument_changes_the_stream() {
        let base = [7, 0, 0, 0, 0];
        let make = |a: [u32; 5]| Stream::new(u64::from(a[0]), a[1], a[2], a[3], a[4]);
        for i in 0..5 {
            let mut other = base;
            other[i] += 1;
            assert_ne!(make(base), make(other));
            assert_ne!(make(base).point(0), make(other).point(0));
        }
    }

    /// Flips of the digit that follows each prefix of `depth` digits of dimension 0, as one bit a prefix.
    fn flips(stream: &Stream, depth: u32) -> Vec<bool> {
        (0..1_u32 << depth)
            .map(|prefix| {
                let x = scramble(prefix, stream.keys[0]);
                (x >> depth) & 1 == 1
            })
            .collect()
    }

    #[test]
    fn scrambles_are_uniform_and_pairwise_independent() {
        // Over 16,384 texels, a fair bit deviates from one half by 5 standard errors of 1/256 once in 1.7 million.
        let texels = 1 << 14;
        let bound = 5.0 * 0.5 * f64::from(texels).sqrt();
        let rows: Vec<Vec<bool>> = (0..texels)
            .map(|t| {
                let stream = Stream::new(3, 0, t, 0, 0);
                (0..4).flat_map(|depth| flips(&stream, depth)).collect()
            })
            .collect();
        for i in 0..rows[0].len() {
            for j in 0..=i {
                let odd = rows.iter().filter(|r| r[i] ^ (i != j && r[j])).count() as f64;
                let excess = odd - f64::from(texels) / 2.0;
                assert!(excess.abs() < bound, "digits {i} and {j}: {excess}");
            }
        }
    }
}
