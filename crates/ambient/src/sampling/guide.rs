//! A warp of the square of sample points that sends more of them where they are known to matter.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::{LANES, Wide};

/// Cells of a guide along each axis.
const EDGE: usize = 16;

/// Cells of a guide.
const CELLS: usize = EDGE * EDGE;

/// Digits of a cell's number along an axis.
const DIGITS: u32 = EDGE.ilog2();

/// Share of the points that go everywhere alike, so that no weight is above its inverse.
const EVEN: f32 = 0.3;

/// Hits below which cells share theirs more widely.
const FEW: u64 = 16;

/// How often points of each cell of the square were seen to count.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Points of each cell that count, and all; rows of `u0`.
    hits: [[u32; EDGE]; EDGE],
    points: [[u32; EDGE]; EDGE],
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            hits: [[0; EDGE]; EDGE],
            points: [[0; EDGE]; EDGE],
        }
    }
}

impl Counts {
    /// Notes the point `[u0, u1]`, both inside (0, 1), and whether it counts.
    #[inline(always)]
    pub fn add(&mut self, [u0, u1]: [f32; 2], hit: bool) {
        let cell = |u: f32| (u * EDGE as f32) as usize & (EDGE - 1);
        let (row, column) = (cell(u0), cell(u1));
        self.hits[row][column] += u32::from(hit);
        self.points[row][column] += 1;
    }

    /// Points that count.
    pub fn hits(&self) -> u64 {
        self.hits.as_flattened().iter().map(|&n| u64::from(n)).sum()
    }

    /// Share of the points that count; 0 without points.
    pub fn share(&self) -> f64 {
        let points = self.points.as_flattened().iter().map(|&n| u64::from(n));
        self.hits() as f64 / points.sum::<u64>().max(1) as f64
    }

    /// The share of each cell and those about it.
    fn shares(&self) -> [[f32; EDGE]; EDGE] {
        // A cell weighs as much as the ring about it. Where hits are few they say no more than whereabouts it is open.
        let (around, own) = match self.hits() < FEW {
            true => (2, 1),
            false => (1, 8),
        };
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let (mut hits, mut points) = (0, 0);
                for r in row.saturating_sub(around)..(row + around + 1).min(EDGE) {
                    for c in column.saturating_sub(around)..(column + around + 1).min(EDGE) {
                        let weight = match r == row && c == column {
                            true => own,
                            false => 1,
                        };
                        hits += weight * self.hits[r][c];
                        points += weight * self.points[r][c];
                    }
                }
                hits as f32 / points.max(1) as f32
            })
        })
    }
}

/// A piecewise constant density over the square, and the map that draws from it.
///
/// The map is monotone along each axis, so that well-spread points stay so. The density of a cell is proportional to
/// the root of the share that counts there, which gives the sum of weighted hits the least variance where hits inside a
/// cell are left to chance; a share of the points goes everywhere alike. After the warps of M. Pharr, W. Jakob, G.
/// Humphreys, "Physically Based Rendering", section 13.6.7.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Where each row begins, and 1 over how wide it is, in points.
    rows: [[f32; EDGE]; 2],
    /// The same of each column, row by row, and what a search by halves compares with.
    columns: [[f32; CELLS]; 2],
    middles: [f32; CELLS],
    /// What a hit without a guide has of variance, over what it has with it.
    gain: f64,
}

/// Where the cells along an axis begin, and 1 over their widths.
fn axis(weights: &[f32; EDGE]) -> [[f32; EDGE]; 2] {
    let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    let (mut begins, mut before) = ([0.0; EDGE], 0.0);
    for (begin, weight) in begins.iter_mut().zip(weights) {
        *begin = (before / sum) as f32;
        before += f64::from(*weight);
    }
    let width = |k: usize| begins.get(k + 1).unwrap_or(&1.0) - begins[k];
    [begins, std::array::from_fn(|k| 1.0 / width(k))]
}

/// Where cells begin, in the order of a search by halves; the first is not read.
fn middles(begins: &[f32; EDGE]) -> [f32; EDGE] {
    std::array::from_fn(|node| {
        let level = node.max(1).ilog2();
        let step = EDGE >> level;
        match node {
            0 => 0.0,
            _ => begins[(node - (1 << level)) * step + step / 2],
        }
    })
}

/// Where a point of a cell goes that is so far in it, 0..1.
#[inline(always)]
fn moved(cell: u32, within: f32) -> f32 {
    let most = 1.0 - f32::EPSILON;
    ((cell as f32 + within) * (1.0 / EDGE as f32)).min(most)
}

impl Guide {
    /// The guide to where points were seen to count.
    pub fn new(counts: &Counts) -> Self {
        let shares = counts.shares();
        let roots = shares.map(|row| row.map(f32::sqrt));
        let sum: f32 = roots.as_flattened().iter().sum();
        let cells = CELLS as f32;
        let density = |root: f32| match sum > 0.0 {
            true => EVEN + (1.0 - EVEN) * root * cells / sum,
            false => 1.0,
        };
        let densities = roots.map(|row| row.map(density));
        let rows = densities.map(|row| row.iter().sum());
        let second: f32 = shares
            .as_flattened()
            .iter()
            .zip(densities.as_flattened())
            .map(|(share, density)| share / density)
            .sum();
        let first: f32 = shares.as_flattened().iter().sum();
        let (first, second) = (f64::from(first / cells), f64::from(second / cells));
        let columns = densities.each_ref().map(axis);
        let flat = |of: &dyn Fn(usize) -> [f32; EDGE]| {
            std::array::from_fn(|cell| of(cell / EDGE)[cell % EDGE])
        };
        Self {
            rows: axis(&rows),
            columns: [0, 1].map(|k: usize| flat(&|row| columns[row][k])),
            middles: flat(&|row| middles(&columns[row][0])),
            gain: match second > first * first {
                true => (first - first * first) / (second - first * first),
                false => 1.0,
            },
        }
    }

    /// The variance of the mean of hits without the guide, over that with it, by what the guide was made of.
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// The density of the warped points at a point of the square, 0..=1 along both axes; it is 1 where they go
    /// everywhere alike.
    pub fn density(&self, u: [f64; 2]) -> f64 {
        let [row, column] = u.map(|u| ((u * EDGE as f64) as usize).min(EDGE - 1));
        let inverse = self.rows[1][row] * self.columns[1][row * EDGE + column];
        CELLS as f64 / f64::from(inverse)
    }

    /// Where the points of `u0` and `u1` go, and the inverse of the density there: what each of them weighs.
    #[inline(always)]
    pub fn warp16(&self, u0: &mut Wide, u1: &mut Wide) -> Wide {
        // All lanes compare with the same rows, but each with columns of its own.
        let mut rows = [0; LANES];
        for begin in &self.rows[0][1..] {
            for l in 0..LANES {
                rows[l] += u32::from(u0[l] >= *begin);
            }
        }
        let mut nodes = [1; LANES];
        for _ in 0..DIGITS {
            for l in 0..LANES {
                let at = EDGE as u32 * rows[l] + nodes[l];
                let after = u1[l] >= self.middles[at as usize % CELLS];
                nodes[l] = 2 * nodes[l] + u32::from(after);
            }
        }
        let mut weights = [0.0; LANES];
        for l in 0..LANES {
            let (row, column) = (rows[l], nodes[l] % EDGE as u32);
            let cell = (EDGE as u32 * row + column) as usize % CELLS;
            let [begin, inverse] = [0, 1].map(|k: usize| self.rows[k][row as usize % EDGE]);
            let [left, across] = [0, 1].map(|k: usize| self.columns[k][cell]);
            u0[l] = moved(row, (u0[l] - begin) * inverse);
            u1[l] = moved(column, (u1[l] - left) * across);
            weights[l] = inverse * across * (1.0 / CELLS as f32);
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Stream;

    /// Points that count inside a disc.
    fn disc([u0, u1]: [f32; 2]) -> bool {
        (u0 - 0.3).hypot(u1 - 0.7) < 0.12
    }

    fn counts_of(hit: fn([f32; 2]) -> bool) -> Counts {
        let mut counts = Counts::default();
        let stream = Stream::new(3, 0, 0, 0, 0);
        for i in 0..2048 {
            let [u0, u1, ..] = stream.point(i).map(|u| u as f32);
            counts.add([u0, u1], hit([u0, u1]));
        }
        counts
    }

    fn counts() -> Counts {
        counts_of(disc)
    }

    /// Mean of weighted hits and of weights over the points of a stream, and the second moment of weighted hits.
    fn means(guide: &Guide, texel: u32, points: u32) -> [f64; 3] {
        let stream = Stream::new(9, 0, texel, 0, 0);
        let mut sums = [0.0; 3];
        for i in 0..points {
            let [u0, u1, ..] = stream.point(i).map(|u| u as f32);
            let (mut u0, mut u1) = ([u0; LANES], [u1; LANES]);
            let weight = f64::from(guide.warp16(&mut u0, &mut u1)[0]);
            assert!(u0[0] > 0.0 && u0[0] < 1.0 && u1[0] > 0.0 && u1[0] < 1.0);
            assert!(weight <= f64::from(1.0 / EVEN) * 1.0001);
            let hit = f64::from(u8::from(disc([u0[0], u1[0]])));
            sums[0] += weight * hit;
            sums[1] += weight;
            sums[2] += weight * weight * hit;
        }
        sums.map(|sum| sum / f64::from(points))
    }

    /// One of many points counts.
    fn one_hit() -> Counts {
        let mut counts = counts_of(|_| false);
        counts.add([0.3, 0.99], true);
        counts
    }

    #[test]
    fn one_hit_leads_to_the_cells_about_it() {
        let guide = Guide::new(&one_hit());
        let cell = |k: f64| (k + 0.5) / EDGE as f64;
        // Rows 2 to 6 of 16 and the last three columns.
        for (row, column, near) in [
            (4.0, 15.0, true),
            (2.0, 13.0, true),
            (6.0, 1.0, false),
            (7.0, 15.0, false),
            (4.0, 2.0, false),
            (12.0, 8.0, false),
        ] {
            let density = guide.density([cell(row), cell(column)]);
            assert_eq!(density > 5.0, near, "{row} {column}: {density}");
            assert!(density >= 0.999 * f64::from(EVEN), "{density}");
        }
    }

    #[test]
    fn weighted_points_keep_areas() {
        let area = std::f64::consts::PI * 0.12 * 0.12;
        for counts in [counts(), one_hit(), Counts::default()] {
            let guide = Guide::new(&counts);
            let [hits, all, _] = means(&guide, 1, 1 << 19);
            assert!((hits - area).abs() < 3e-4, "{hits} {area}");
            assert!((all - 1.0).abs() < 1e-3, "{all}");
        }
    }

    #[test]
    fn a_warped_point_weighs_the_inverse_of_the_density_where_it_goes() {
        let guide = Guide::new(&counts());
        for i in 0..1000 {
            let [a, b, ..] = Stream::new(5, 0, 0, 0, 0).point(i).map(|u| u as f32);
            let (mut u0, mut u1) = ([a; LANES], [b; LANES]);
            let weight = f64::from(guide.warp16(&mut u0, &mut u1)[0]);
            let density = guide.density([u0[0].into(), u1[0].into()]);
            // One rounding of f32.
            assert!((weight * density - 1.0).abs() < 1e-6, "{weight} {density}");
        }
    }

    #[test]
    fn a_guide_lowers_the_variance_as_it_says() {
        let counts = counts();
        let guide = Guide::new(&counts);
        let area = counts.share();
        let [_, _, second] = means(&guide, 2, 1 << 16);
        let gain = (area - area * area) / (second - area * area);
        assert!(gain > 4.0, "{gain}");
        assert!(
            (guide.gain() / gain - 1.0).abs() < 0.3,
            "{} {gain}",
            guide.gain()
        );
    }

    #[test]
    fn nothing_known_changes_nothing() {
        let guide = Guide::new(&Counts::default());
        for i in 0..100 {
            let [a, b, ..] = Stream::new(1, 0, 0, 0, 0).point(i).map(|u| u as f32);
            let (mut u0, mut u1) = ([a; LANES], [b; LANES]);
            let weights = guide.warp16(&mut u0, &mut u1);
            assert!((u0[3] - a).abs() < 1e-6 && (u1[3] - b).abs() < 1e-6);
            assert!((weights[3] - 1.0).abs() < 1e-6);
        }
    }
}
