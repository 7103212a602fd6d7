//! The pre-integrated table of section 8.3: sums over any rectangle from four look-ups, exact.
//!
//! A texel's entry is its radiance times its solid angle, and the solid angle itself, as whole numbers of a fixed unit:
//! 62 bits hold the sum over the whole map, so sums do not depend on their order and differences lose nothing. The text
//! asks for "enough precision to accurately store the highest value times the number of pixels"; a sun of 10⁶ in 2²¹
//! texels takes 45 bits with a sky of 1, which leaves 17 for the sky.

use environment::Projection;

/// A summed-area table of a polar map.
#[derive(Debug)]
pub struct Summed {
    width: usize,
    height: usize,
    /// Sums over all texels above and to the left of a corner: rows of `width + 1`, `height + 1` of them.
    corners: Vec<[u64; 4]>,
    /// Units of a channel in one.
    units: [f64; 4],
}

/// Bits that hold the largest sum.
const BITS: f64 = 62.0;

impl Summed {
    /// The sums of a map of `width` by `height` texels, told by column and row.
    pub(super) fn of(
        size @ (width, height): (usize, usize),
        texel: impl Fn(usize, usize) -> [f32; 3],
    ) -> Summed {
        let entry = |x: usize, y: usize, omega: f64| {
            let [r, g, b] = texel(x, y).map(|v| f64::from(v) * omega);
            [r, g, b, omega]
        };
        let omega: Vec<f64> = (0..height)
            .map(|y| Projection::Polar.solid_angle(size, 0, y))
            .collect();
        let mut total = [0.0f64; 4];
        for (y, &omega) in omega.iter().enumerate() {
            for x in 0..width {
                let entry = entry(x, y, omega);
                total = std::array::from_fn(|c| total[c] + entry[c]);
            }
        }
        let units = total.map(|sum| {
            let fits = (BITS - sum.max(f64::MIN_POSITIVE).log2()).floor();
            2f64.powf(fits.min(1000.0))
        });
        let mut corners = vec![[0u64; 4]; (width + 1) * (height + 1)];
        for (y, &omega) in omega.iter().enumerate() {
            let mut row = [0u64; 4];
            for x in 0..width {
                let entry = entry(x, y, omega);
                row = std::array::from_fn(|c| row[c] + (entry[c] * units[c]).round() as u64);
                let above = corners[y * (width + 1) + x + 1];
                corners[(y + 1) * (width + 1) + x + 1] = std::array::from_fn(|c| above[c] + row[c]);
            }
        }
        Summed {
            width,
            height,
            corners,
            units,
        }
    }

    /// Sum over whole texels: columns `left..right`, which may lie beyond the seam on either side, rows `top..bottom`.
    /// Red, green, blue times solid angle, and solid angle, each in its own unit.
    ///
    /// # Panics
    /// Where the rows are not ascending rows of the map.
    pub fn rectangle(&self, [left, right]: [i64; 2], [top, bottom]: [usize; 2]) -> [u64; 4] {
        assert!(top <= bottom && bottom <= self.height, "{top}..{bottom}");
        let columns = [right, left].map(|x| self.column(x));
        let [[a, b], [c, d]] = [bottom, top].map(|y| self.corners(&columns, y));
        difference(a, b, c, d)
    }

    /// The column of a corner within the map, and how many times round it lies.
    fn column(&self, x: i64) -> (usize, u64) {
        let width = self.width as i64;
        (x.rem_euclid(width) as usize, x.div_euclid(width) as u64)
    }

    /// Sums above and to the left of corners in one row; columns repeat, the sum goes on.
    fn corners<const N: usize>(&self, columns: &[(usize, u64); N], y: usize) -> [[u64; 4]; N] {
        let row = &self.corners[y * (self.width + 1)..][..self.width + 1];
        let whole = row[self.width];
        let mut found = [[0; 4]; N];
        for (sum, (column, rounds)) in found.iter_mut().zip(columns) {
            *sum = row[*column];
            if *rounds != 0 {
                for c in 0..4 {
                    sum[c] = sum[c].wrapping_add(rounds.wrapping_mul(whole[c]));
                }
            }
        }
        found
    }

    /// Mean radiance over a rectangle with borders anywhere, in texels: columns may lie beyond the seam, rows are cut
    /// at the poles. A rectangle one texel wide and high gives what bilinear interpolation gives, weighted by solid
    /// angle.
    pub fn mean(&self, across: [f32; 2], down: [f32; 2]) -> [f32; 3] {
        let sum = self.sum(across, down);
        std::array::from_fn(|c| (sum[c] / sum[3]) as f32)
    }

    /// Radiance times solid angle, and solid angle, summed over such a rectangle.
    pub(super) fn sum(&self, across: [f32; 2], down: [f32; 2]) -> [f64; 4] {
        let down = down.map(|y| y.clamp(0.0, self.height as f32));
        let (xs, x_shares) = borders(across);
        let (ys, y_shares) = borders(down);
        let limit = self.height as i64;
        let columns = xs.map(|x| self.column(x));
        let mut above = self.corners(&columns, ys[0] as usize);
        let mut sum = [0.0; 4];
        for j in 0..3 {
            let below = self.corners(&columns, ys[j + 1].min(limit) as usize);
            for i in 0..3 {
                let share = x_shares[i] * y_shares[j];
                if share > 0.0 {
                    let part = difference(below[i + 1], below[i], above[i + 1], above[i]);
                    for c in 0..4 {
                        // Sums stay below 2⁶², so the sign is that of a plain integer.
                        sum[c] += share * part[c] as i64 as f64;
                    }
                }
            }
            above = below;
        }
        std::array::from_fn(|c| sum[c] / self.units[c])
    }
}

fn difference(a: [u64; 4], b: [u64; 4], c: [u64; 4], d: [u64; 4]) -> [u64; 4] {
    let mut part = [0; 4];
    for i in 0..4 {
        let (right, left) = (a[i].wrapping_sub(b[i]), c[i].wrapping_sub(d[i]));
        part[i] = right.wrapping_sub(left);
    }
    part
}

/// Whole-numbered borders of the first, the inner and the last texels of a range, and what share of each is inside.
fn borders([from, to]: [f32; 2]) -> ([i64; 4], [f64; 3]) {
    let (from, to) = (f64::from(from), f64::from(to));
    let first = from.floor();
    let last = to.floor();
    if first == last {
        // One texel; the others are empty.
        let at = first as i64;
        return ([at, at + 1, at + 1, at + 1], [to - from, 0.0, 0.0]);
    }
    (
        [first as i64, first as i64 + 1, last as i64, last as i64 + 1],
        [first + 1.0 - from, 1.0, to - last],
    )
}
