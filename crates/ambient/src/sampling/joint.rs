//! Points of neighbouring texels that are well spread together.
//!
//! The texels of a square take the parts of one sequence in turn, quarter by quarter (Morton order), so that each
//! aligned square of texels holds an aligned block of points: what such a square gathers as a whole has less error than
//! its texels' own errors would make of it, and a smoothed page gains. After A. Ahmed, P. Wonka, "Screen-Space
//! Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020, with two differences.
//! The four quarters of each square are shuffled by their own key, or the same places of neighbouring squares would
//! share leading digits, and what should be noise would repeat. And the points of each part are turned by their own
//! number, or texels that take a share of their points would all leave out the same.

use super::Stream;
use super::sobol::scramble;
use super::stream::mix;
use std::ops::Range;

impl Stream {
    /// This stream as texel (x, y) of a square of `2^edge_log2` texels, at most 2^15 on its edge, takes its points
    /// `net`, counted from 0: a power of two, aligned to itself. Texels of the square have this stream and `net` in
    /// common; x and y count modulo its edge.
    ///
    /// Points are those of an Owen-scrambled Sobol sequence, however many of them are taken. All points of all texels
    /// of an aligned square are a net, and nets that follow each other continue one sequence, so that the second falls
    /// between the points of the first.
    ///
    /// ```
    /// use ambake_ambient::sampling::Stream;
    /// let square = Stream::new(0, 0, 17, 0, 0);
    /// // One point of each of 2 x 2 texels: one in each quarter of the first two dimensions.
    /// let quarter = |x, y| square.joint([x, y], 1, &(0..1)).point(0).map(|u| u >= 0.5);
    /// let mut quarters = [quarter(0, 0), quarter(1, 0), quarter(0, 1), quarter(1, 1)].map(|q| [q[0], q[1]]);
    /// quarters.sort();
    /// assert_eq!(quarters, [[false, false], [false, true], [true, false], [true, true]]);
    /// ```
    pub fn joint(self, [x, y]: [u32; 2], edge_log2: u32, net: &Range<u32>) -> Stream {
        let keys = [mix(self.key(0)), self.key(1)];
        self.starting_at(first([x, y], keys, edge_log2, net))
    }
}

/// The number of the point that counts as the first of texel (x, y).
#[inline(always)]
pub(super) fn first(
    [x, y]: [u32; 2],
    [shuffles, turns]: [u64; 2],
    edge_log2: u32,
    net: &Range<u32>,
) -> u32 {
    let bits = 2 * edge_log2;
    let mask = (1_u32 << bits) - 1;
    // The number of its part: its place in Morton order after the children of each node of the tree are shuffled, from
    // the coarsest digit to the finest, as `scramble` takes them.
    let digits = ((spread(y) | spread(x) << 1) & mask).reverse_bits() >> 1 >> (31 - bits);
    let part = (scramble(digits, shuffles) & mask).reverse_bits() >> 1 >> (31 - bits);
    let points = net.end.saturating_sub(net.start).max(1);
    // The last bits of a scramble depend on all before them.
    let turn = scramble(part, turns) >> 1 >> (31 - points.ilog2());
    let before = net.start.wrapping_mul(1 << bits);
    before.wrapping_add(part.wrapping_mul(points)) | turn
}

/// The last sixteen bits of a number, each followed by a 0 above it.
#[inline(always)]
fn spread(bits: u32) -> u32 {
    let bits = bits & 0xffff;
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE_LOG2: u32 = 4;

    /// The points of a square of texels, counted from (x, y).
    fn points(square: Stream, [x, y]: [u32; 2], edge: u32, each: u32) -> Vec<[f64; 4]> {
        let texels = (0..edge).flat_map(|b| (0..edge).map(move |a| [x + a, y + b]));
        texels
            .flat_map(|at| {
                let texel = square.joint(at, EDGE_LOG2, &(0..each));
                (0..each).map(move |i| texel.point(i))
            })
            .collect()
    }

    #[test]
    fn each_aligned_square_of_texels_holds_a_net() {
        let square = Stream::new(3, 1, 5, 0, 2);
        for each_log2 in [0, 2, 3, 6] {
            for edge_log2 in 0..=3 {
                let edge = 1 << edge_log2;
                for at in [[0, 0], [8, 0], [0, 8], [8, 8], [16 - edge, 16 - edge]] {
                    let points = points(square, at, edge, 1 << each_log2);
                    let m = each_log2 + 2 * edge_log2;
                    for k in 0..=m {
                        let mut boxes = vec![0; 1 << m];
                        for p in &points {
                            let [a, b] = [(p[0], k), (p[1], m - k)]
                                .map(|(u, k)| (u * f64::from(1 << k)) as usize);
                            boxes[a << (m - k) | b] += 1;
                        }
                        assert!(
                            boxes.iter().all(|&n| n == 1),
                            "2^{each_log2} of {edge}: 2^{k}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn texels_have_points_of_their_own() {
        let square = Stream::new(3, 1, 5, 0, 2);
        let mut points = points(square, [0, 0], 16, 8);
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(points.windows(2).all(|p| p[0][0] < p[1][0]));
    }

    /// The same points at the same places of neighbouring squares would repeat as a pattern.
    #[test]
    fn neighbouring_squares_do_not_repeat() {
        let square = Stream::new(3, 1, 5, 0, 2);
        let leading = |x, y| (square.joint([x, y], EDGE_LOG2, &(0..4)).point(0)[0] * 64.0) as u32;
        let repeats = (0..12_u32)
            .flat_map(|y| (0..12).map(move |x| (x, y)))
            .filter(|&(x, y)| leading(x, y) == leading(x + 4, y))
            .count();
        // Without shuffles all 144; by chance 144 / 64.
        assert!(repeats < 12, "{repeats}");
    }

    /// Six of eight points: were they the first six of each part, one eighth of the leading digits would go without.
    #[test]
    fn texels_that_take_some_of_their_points_leave_out_different_ones() {
        let square = Stream::new(9, 0, 2, 0, 0);
        let mut boxes = [0_u32; 8];
        for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
            let texel = square.joint([x, y], EDGE_LOG2, &(0..8));
            for i in 0..6 {
                boxes[(texel.point(i)[0] * 8.0) as usize] += 1;
            }
        }
        // 192 each; a texel leaves out two of eight, a standard deviation of 6.9 over 256 texels.
        assert!(boxes.iter().all(|n| n.abs_diff(192) < 30), "{boxes:?}");
    }

    /// Eight points each and then four are the first twelve of sixteen: none of the boxes that sixteen would fill has
    /// two.
    #[test]
    fn nets_continue_each_other() {
        let square = Stream::new(9, 0, 2, 0, 0);
        let mut boxes = [0_u32; 16 << (2 * EDGE_LOG2)];
        for y in 0..16 {
            for x in 0..16 {
                for (net, each) in [(0..8, 8), (8..12, 4)] {
                    let texel = square.joint([x, y], EDGE_LOG2, &net);
                    for point in (0..each).map(|i| texel.point(i)) {
                        boxes[(point[0] * boxes.len() as f64) as usize] += 1;
                    }
                }
            }
        }
        assert_eq!(boxes.iter().sum::<u32>(), 12 << (2 * EDGE_LOG2));
        assert!(boxes.iter().all(|&n| n <= 1));
    }
}
