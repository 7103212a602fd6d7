//! Sixteen lanes at once: points, hemisphere directions and lobe directions in f32.
//!
//! Plain loops over arrays without branches or library calls, which the compiler turns into vector code of whatever
//! width it may use; no fused operation is written, so every width gives the same bits. The scalar f64 samplers beside
//! this file say what is computed; tests hold these to them.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::joint::first;
use super::lattice::lattice;
use super::sobol::{CELLS, DIMENSIONS, LARGEST_BLOCK, scramble, sobol, sobol16};
use super::stream::mix;
use super::{Lobe, Mixture, Stream};
use crate::lanes::{LANES, Wide, exp_m1, ln, turn_sin_cos};
use std::ops::Range;

/// Where the points of a texel come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PointSet {
    /// A rank-1 lattice sequence under a random shift: up to a tenth less error than Owen-Sobol at 64 to 256 rays, but
    /// erratic: a straight edge along the lattice doubles it.
    Lattice,
    /// Owen-scrambled Sobol points: as good at every number of points, in two dimensions and with a footprint in four.
    #[default]
    Sobol,
    /// Independent random points: the plain baseline.
    Random,
}

/// Sixteen streams side by side, read in step.
///
/// Points are read block by block ([`Streams::blocks`]). Within a block of Sobol points every step gives each lane its
/// own point of one elementary cell of the first two dimensions, which all lanes share: the lanes' directions are
/// independent, yet nearly parallel, so that a packet of rays holds together.
#[derive(Clone, Debug)]
pub struct Streams {
    set: PointSet,
    /// Low and high halves of each key; the high half is also the lattice's shift.
    low: [[u32; LANES]; DIMENSIONS],
    high: [[u32; LANES]; DIMENSIONS],
    /// Coordinates of each lane's first point, bit-reversed.
    base: [[u32; LANES]; DIMENSIONS],
    first: u32,
    /// Bits of the zenith and azimuth cells of the block.
    bits: [u32; 2],
    /// Parts of the coordinates by zenith and by azimuth cell, as many as the largest block had.
    parts: [Vec<[[u32; LANES]; DIMENSIONS]>; 2],
}

/// An aligned block of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    first: u32,
    log2: u32,
}

impl Block {
    /// Points, and so steps, of the block.
    pub fn steps(self) -> u32 {
        1 << self.log2
    }
}

impl Streams {
    /// Streams whose lanes are all labelled by zero keys until they are set.
    pub fn new(set: PointSet) -> Streams {
        Streams {
            set,
            low: [[0; LANES]; DIMENSIONS],
            high: [[0; LANES]; DIMENSIONS],
            base: [[0; LANES]; DIMENSIONS],
            first: 0,
            bits: [0; 2],
            parts: [Vec::new(), Vec::new()],
        }
    }

    /// Puts a stream into a lane. It counts from the next block on.
    ///
    /// # Panics
    ///
    /// If `lane` is not below [`LANES`].
    pub fn set(&mut self, lane: usize, stream: &Stream) {
        let base = stream.base();
        for d in 0..DIMENSIONS {
            let key = stream.key(d);
            self.low[d][lane] = key as u32;
            self.high[d][lane] = (key >> 32) as u32;
            self.base[d][lane] = base[d];
        }
    }

    /// Puts into each lane the stream of one of two squares of texels, the second where its bit of `which` is set, as a
    /// texel of the square takes it ([`Stream::joint`]). They count from the next block on.
    #[inline(always)]
    pub fn join(
        &mut self,
        squares: [&Stream; 2],
        which: u32,
        [x, y]: [&[u32; LANES]; 2],
        edge_log2: u32,
        net: &Range<u32>,
    ) {
        let of = |lane: usize, [first, second]: [u64; 2]| match which >> lane & 1 {
            0 => first,
            _ => second,
        };
        for d in 0..DIMENSIONS {
            let keys = squares.map(|stream| stream.key(d));
            for l in 0..LANES {
                let key = of(l, keys);
                (self.low[d][l], self.high[d][l]) = (key as u32, (key >> 32) as u32);
            }
        }
        let shuffles = squares.map(|stream| mix(stream.key(0)));
        let turns = squares.map(|stream| stream.key(1));
        let mut start = [0; LANES];
        for l in 0..LANES {
            start[l] = first(
                [x[l], y[l]],
                [of(l, shuffles), of(l, turns)],
                edge_log2,
                net,
            );
        }
        self.base = sobol16(&start);
    }

    /// Cuts a range of points into the fewest aligned blocks.
    pub fn blocks(range: Range<u32>) -> impl Iterator<Item = Block> {
        let mut first = range.start;
        std::iter::from_fn(move || {
            let left = range.end.saturating_sub(first);
            if left == 0 {
                return None;
            }
            let log2 = first.trailing_zeros().min(left.ilog2()).min(LARGEST_BLOCK);
            let block = Block { first, log2 };
            first += block.steps();
            Some(block)
        })
    }

    /// Goes to a block.
    #[inline(always)]
    pub fn enter(&mut self, block: Block) {
        self.first = block.first;
        if self.set != PointSet::Sobol {
            return;
        }
        let cells = &CELLS[block.log2 as usize];
        self.bits = [cells.zenith_bits, cells.azimuth_bits];
        let first = sobol(block.first);
        for (d, table) in [&cells.zenith, &cells.azimuth].into_iter().enumerate() {
            let mask = (1_u32 << self.bits[d]) - 1;
            let cells = self.parts[d].len().max(mask as usize + 1);
            self.parts[d].resize(cells, [[0; LANES]; DIMENSIONS]);
            for digits in 0..=mask {
                let part = table[digits as usize];
                for lane in 0..LANES {
                    let key = u64::from(self.high[d][lane]) << 32 | u64::from(self.low[d][lane]);
                    let digits = digits ^ first[d] ^ self.base[d][lane];
                    let cell = (scramble(digits, key) & mask) as usize;
                    for k in 0..DIMENSIONS {
                        let base = if d == 0 {
                            first[k] ^ self.base[k][lane]
                        } else {
                            0
                        };
                        self.parts[d][cell][k][lane] = part[k] ^ base;
                    }
                }
            }
        }
    }

    /// One point of every lane, one array a dimension: odd multiples of 2^-24, strictly inside (0, 1). The steps of a
    /// block give each of its points once.
    #[inline(always)]
    pub fn point(&self, step: u32) -> [Wide; DIMENSIONS] {
        let mut out = [[0.0; LANES]; DIMENSIONS];
        match self.set {
            PointSet::Lattice => {
                for d in 0..DIMENSIONS {
                    let base = lattice(d, self.first + step);
                    for l in 0..LANES {
                        out[d][l] = unit(base.wrapping_add(self.high[d][l]));
                    }
                }
            }
            PointSet::Sobol => {
                // Neighbouring steps take neighbouring cells: cells are numbered by reversed digits.
                let [zenith, azimuth] = [step >> self.bits[1], step & ((1 << self.bits[1]) - 1)];
                let cell = |k: u32, bits: u32| (k.reverse_bits() >> (31 - bits) >> 1) as usize;
                let a = &self.parts[0][cell(zenith, self.bits[0])];
                let b = &self.parts[1][cell(azimuth, self.bits[1])];
                for d in 0..DIMENSIONS {
                    for l in 0..LANES {
                        let key = u64::from(self.high[d][l]) << 32 | u64::from(self.low[d][l]);
                        out[d][l] = unit(scramble(a[d][l] ^ b[d][l], key).reverse_bits());
                    }
                }
            }
            PointSet::Random => {
                for d in 0..DIMENSIONS {
                    for l in 0..LANES {
                        let key = u64::from(self.high[d][l]) << 32 | u64::from(self.low[d][l]);
                        let index = u64::from(self.first + step) << 20;
                        out[d][l] = unit((mix(key.wrapping_add(index)) >> 32) as u32);
                    }
                }
            }
        }
        out
    }
}

/// The middle of the cell of 2^-23 that a fixed-point coordinate lies in. Exact.
#[inline(always)]
fn unit(fixed: u32) -> f32 {
    ((fixed >> 9) as i32 as f32 + 0.5) * (1.0 / 8_388_608.0)
}

impl Mixture {
    /// [`Mixture::sample`] of sixteen points, within 1e-6 of it, and their [`Mixture::diffuse_weight`] and
    /// [`Mixture::visibility_weight`]. With q = √(b² + 4a·u₀) = 2aμ + b, one division serves them all.
    #[inline(always)]
    pub fn sample16(self, u0: &Wide, u1: &Wide) -> ([Wide; 3], [Wide; 2]) {
        let a = self.cosine_share() as f32;
        let b = 1.0 - a;
        let (mut directions, mut weights) = ([[0.0; LANES]; 3], [[0.0; LANES]; 2]);
        for l in 0..LANES {
            let (x, y) = (2.0 * u0[l] - 1.0, 2.0 * u1[l] - 1.0);
            let steep = y.abs() > x.abs();
            let (r, other) = if steep { (y, x) } else { (x, y) };
            // An eighth of a turn at most.
            let (s, c) = turn_sin_cos(0.125 * (other / if r == 0.0 { 1.0 } else { r }));
            // A point that was moved to the border stays a little above the horizon.
            let v = ((1.0 - r.abs()) * (1.0 + r.abs())).max(f32::EPSILON);
            let q = (b * b + 4.0 * a * v).sqrt();
            let (near, far) = (b + q, 1.0 + a + q);
            let inverse = 1.0 / (q * near * far);
            let mu = 2.0 * v * (q * far * inverse);
            let complement = 2.0 * r * r * (q * near * inverse);
            let length = (complement * (1.0 + mu)).sqrt().copysign(r);
            let (along, across) = (length * c, length * s);
            directions[0][l] = if steep { across } else { along };
            directions[1][l] = if steep { along } else { across };
            directions[2][l] = mu;
            let visibility = near * far * inverse;
            weights[0][l] = 2.0 * mu * visibility;
            weights[1][l] = visibility;
        }
        (directions, weights)
    }
}

impl Lobe {
    /// Sixteen lobes' [`Lobe::sample`], with `scale[l] = 1 / (n + 1)`, within 1e-6 of it relative to the lobe's width.
    #[inline(always)]
    pub fn sample16(scale: &Wide, u0: &Wide, u1: &Wide) -> [Wide; 3] {
        let mut out = [[0.0; LANES]; 3];
        for l in 0..LANES {
            // 1 - cos and cos from one exponential: no difference of like numbers near the axis.
            let drop = -exp_m1(ln(u0[l]) * scale[l]);
            let r = (drop * (2.0 - drop)).sqrt();
            let (s, c) = turn_sin_cos(u1[l]);
            out[0][l] = r * c;
            out[1][l] = r * s;
            out[2][l] = 1.0 - drop;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square;
    use glam::DVec3;

    fn each_point(set: PointSet, mut job: impl FnMut([f32; 4])) {
        let mut streams = Streams::new(set);
        for lane in 0..LANES {
            streams.set(lane, &Stream::new(1, 0, lane as u32, 0, 0));
        }
        for block in Streams::blocks(0..512) {
            streams.enter(block);
            for step in 0..block.steps() {
                let points = streams.point(step);
                for lane in 0..LANES {
                    job(points.map(|row| row[lane]));
                }
            }
        }
    }

    fn lane0(d: &[Wide; 3]) -> DVec3 {
        DVec3::new(d[0][0].into(), d[1][0].into(), d[2][0].into())
    }

    #[test]
    fn points_of_every_set_lie_strictly_inside_the_unit_cube() {
        for set in [PointSet::Lattice, PointSet::Sobol, PointSet::Random] {
            each_point(set, |p| {
                assert!(p.iter().all(|&x| x > 0.0 && x < 1.0), "{set:?}: {p:?}");
            });
        }
    }

    #[test]
    fn blocks_are_aligned_and_cover_the_range() {
        for (range, expected) in [
            (0..64, vec![(0, 6)]),
            (0..25, vec![(0, 4), (16, 3), (24, 0)]),
            (4..6, vec![(4, 1)]),
            (24..32, vec![(24, 3)]),
            (
                0..3000,
                vec![
                    (0, 10),
                    (1024, 10),
                    (2048, 9),
                    (2560, 8),
                    (2816, 7),
                    (2944, 5),
                    (2976, 4),
                    (2992, 3),
                ],
            ),
            (5..5, vec![]),
        ] {
            let blocks: Vec<_> = Streams::blocks(range).map(|b| (b.first, b.log2)).collect();
            assert_eq!(blocks, expected);
        }
    }

    #[test]
    fn lanes_join_squares_as_single_streams_do() {
        let squares = [Stream::new(7, 1, 3, 3, 1), Stream::new(7, 1, 3, 3, 2)];
        let [x, y] = [3, 7].map(|step: u32| std::array::from_fn(|l| (l as u32 * step) % 16));
        for net in [0..1, 0..4, 4..8, 0..64, 96..128] {
            let mut joined = Streams::new(PointSet::Sobol);
            joined.join([&squares[0], &squares[1]], 0xf0f0, [&x, &y], 4, &net);
            let mut single = Streams::new(PointSet::Sobol);
            for l in 0..LANES {
                let square = squares[usize::from(0xf0f0 >> l & 1 == 1)];
                single.set(l, &square.joint([x[l], y[l]], 4, &net));
            }
            assert_eq!(joined.base, single.base, "{net:?}");
            assert_eq!((joined.low, joined.high), (single.low, single.high));
        }
    }

    #[test]
    fn steps_give_the_scalar_stream_s_points_in_shared_cells() {
        let joint = Stream::new(7, 1, 3, 3, 1).joint([5, 14], 4, &(0..4096));
        let labels = [Stream::new(7, 1, 2, 3, 0), joint];
        let mut streams = Streams::new(PointSet::Sobol);
        streams.set(5, &labels[0]);
        streams.set(11, &labels[1]);
        // From 0 on, as a bake begins, and from within a block, as it goes on.
        for block in Streams::blocks(0..1024).chain(Streams::blocks(48..3000)) {
            streams.enter(block);
            let cells = &CELLS[block.log2 as usize];
            let mut seen = [Vec::new(), Vec::new()];
            for step in 0..block.steps() {
                let points = streams.point(step);
                let cell = |lane: usize| {
                    let digits =
                        |d: usize, bits: u32| (points[d][lane] * (1 << bits) as f32) as u32;
                    (digits(0, cells.zenith_bits), digits(1, cells.azimuth_bits))
                };
                assert_eq!(cell(5), cell(11), "{block:?}, step {step}");
                seen[0].push(points.map(|row| row[5]));
                seen[1].push(points.map(|row| row[11]));
            }
            for (mut seen, stream) in seen.into_iter().zip(labels) {
                let mut exact: Vec<[f32; 4]> = (block.first..block.first + block.steps())
                    .map(|i| stream.point(i).map(|x| unit((x * 4_294_967_296.0) as u32)))
                    .collect();
                let order = |a: &[f32; 4], b: &[f32; 4]| a[0].total_cmp(&b[0]);
                seen.sort_by(order);
                exact.sort_by(order);
                assert_eq!(seen, exact, "{block:?}");
            }
        }
    }

    #[test]
    fn extreme_coordinates_stay_inside() {
        assert_eq!(unit(0), 0.5 / 8_388_608.0);
        assert_eq!(unit(u32::MAX), 1.0 - 0.5 / 8_388_608.0);
    }

    #[test]
    fn hemisphere_directions_agree_with_f64_and_invert() {
        for share in [0.0, 0.5, 1.0] {
            let mixture = Mixture::new(share);
            each_point(PointSet::Lattice, |[u0, u1, ..]| {
                let (d, [diffuse, visibility]) = mixture.sample16(&[u0; LANES], &[u1; LANES]);
                let exact = mixture.sample([u0.into(), u1.into()]);
                assert!(
                    (lane0(&d) - exact).length() < 6e-7,
                    "{u0} {u1}: {d:?} {exact}"
                );
                let back = mixture.invert(lane0(&d));
                assert!((back[0] - f64::from(u0)).abs() < 6e-7);
                let mu = f64::from(d[2][0]);
                assert!((f64::from(diffuse[0]) / mixture.diffuse_weight(mu) - 1.0).abs() < 1e-6);
                assert!(
                    (f64::from(visibility[0]) / mixture.visibility_weight(mu) - 1.0).abs() < 1e-6
                );
            });
        }
    }

    #[test]
    fn lobe_directions_agree_with_f64_relative_to_their_width() {
        for n in [0.0, 0.5, 1.0, 2.5, 10.0, 200.0, 1e4, 1e6] {
            let lobe = Lobe::new(n);
            let width = (2.0 / (n + 1.0)).sqrt().min(1.0);
            each_point(PointSet::Lattice, |[u0, u1, ..]| {
                let scale = (1.0 / (n + 1.0)) as f32;
                let d = Lobe::sample16(&[scale; LANES], &[u0; LANES], &[u1; LANES]);
                let exact = lobe.sample([u0.into(), u1.into()]);
                let sine = |d: DVec3| d.truncate().length();
                assert!(
                    (sine(lane0(&d)) - sine(exact)).abs() < 2e-6 * width,
                    "n {n}, {u0}: {d:?} {exact}"
                );
                assert!((lane0(&d).z - exact.z).abs() < 3e-7, "n {n}, {u0}");
            });
        }
    }

    #[test]
    fn histograms_match_the_pdf() {
        let wide = |u: [f64; 2]| {
            u.map(|x| [(((x * 8_388_608.0).floor() + 0.5) / 8_388_608.0) as f32; LANES])
        };
        for share in [0.0, 0.5, 1.0] {
            let mixture = Mixture::new(share);
            let sample = |u| {
                let [u0, u1] = wide(u);
                lane0(&mixture.sample16(&u0, &u1).0)
            };
            chi_square::check(1.0, sample, |d| mixture.pdf(d));
        }
        for n in [1.0, 50.0, 1e6] {
            let edge = (-(-24.0_f64 / (n + 1.0)).exp_m1()).sqrt();
            let sample = |u| {
                let [u0, u1] = wide(u);
                lane0(&Lobe::sample16(
                    &[(1.0 / (n + 1.0)) as f32; LANES],
                    &u0,
                    &u1,
                ))
            };
            chi_square::check(edge, sample, |d| Lobe::new(n).pdf(d));
        }
    }
}
