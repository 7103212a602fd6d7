//! Directions drawn from an illumination map, and its radiance along any direction.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use ambient::convention::SPHERE;
use ambient::lanes::{LANES, Wide, atan2, turn_sin_cos};
use std::f64::consts::{PI, TAU};

/// Radiance from every direction, constant over each texel of a polar map: a uniform floor and what stands out of it.
///
/// Row 0 looks up (+y), rows are equal in the polar angle; columns are equal in `atan2(x, z)`, +z in the middle, growing toward
/// +x. The floor is the least value of each channel, so that a constant map is a floor alone and needs no samples. What stands
/// out is kept divided by [`SkyMap::scale`], its flux over the sphere summed over the channels: then the sum of a texel's three
/// channels is the probability per steradian with which [`SkyMap::sample16`] draws directions of the texel.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyMap {
    width: usize,
    floor: [f64; 3],
    scale: f64,
    mean: [f64; 3],
    /// Row by row.
    excess: Vec<[f32; 3]>,
    rows: Vec<Row>,
    /// Share of the map that a row and those above it hold.
    row_ends: Vec<f32>,
    /// Share of its row that a texel and those left of it hold.
    ends: Vec<f32>,
    /// [`guide`] of the rows, and of each row's columns.
    row_guide: Vec<u16>,
    guide: Vec<u16>,
}

/// A row of texels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    /// `1 - |y|` at the upper and at the lower edge, counted from the pole of the row's side.
    complement: [f32; 2],
    /// 1 for the upper side, -1 for the lower.
    side: f32,
}

impl SkyMap {
    /// The map of a picture, row by row from the top.
    ///
    /// # Panics
    /// Where there are not `width` times some rows of pixels, a side is above 65,536, or a value is not finite or negative.
    pub fn new(width: usize, pixels: &[[f32; 3]]) -> SkyMap {
        assert!(width > 0 && !pixels.is_empty() && pixels.len().is_multiple_of(width));
        let valid = |p: &[f32; 3]| p.iter().all(|v| v.is_finite() && *v >= 0.0);
        assert!(pixels.iter().all(valid), "a sky has an invalid pixel");
        let height = pixels.len() / width;
        assert!(width.max(height) <= 1 << 16, "a sky of {width} x {height}");
        let floor = pixels.iter().fold([f32::INFINITY; 3], |least, pixel| {
            std::array::from_fn(|c| least[c].min(pixel[c]))
        });
        let floor = floor.map(f64::from);
        let above = |pixel: &[f32; 3]| -> [f64; 3] {
            std::array::from_fn(|c| f64::from(pixel[c]) - floor[c])
        };
        // Solid angle of a texel of each row: 2 sin(middle) sin(half a step) times the step in longitude.
        let step = PI / height as f64;
        let omega = |row: usize| {
            2.0 * ((row as f64 + 0.5) * step).sin() * (0.5 * step).sin() * TAU / width as f64
        };
        let mut flux = [0.0; 3];
        let mut of_rows = Vec::with_capacity(height);
        for (row, texels) in pixels.chunks_exact(width).enumerate() {
            let mut sum = [0.0; 3];
            for texel in texels {
                let excess = above(texel);
                sum = std::array::from_fn(|c| sum[c] + excess[c]);
            }
            let sum = sum.map(|v| v * omega(row));
            flux = std::array::from_fn(|c| flux[c] + sum[c]);
            of_rows.push(sum.iter().sum::<f64>());
        }
        let scale: f64 = flux.iter().sum();
        let inverse = if scale > 0.0 { 1.0 / scale } else { 0.0 };
        let mut before = 0.0;
        let row_ends: Vec<f32> = of_rows
            .iter()
            .map(|of_row| {
                before += of_row * inverse;
                before as f32
            })
            .collect();
        let rows = (0..height)
            .map(|row| {
                let upper = 2 * row < height;
                let complement = |edge: usize| {
                    let from_pole = if upper { edge } else { height - edge } as f64;
                    (2.0 * (0.5 * from_pole * step).sin().powi(2)) as f32
                };
                Row {
                    complement: [complement(row), complement(row + 1)],
                    side: if upper { 1.0 } else { -1.0 },
                }
            })
            .collect();
        let mut ends: Vec<f32> = Vec::with_capacity(pixels.len());
        for texels in pixels.chunks_exact(width) {
            let of_texel = |texel: &[f32; 3]| above(texel).iter().sum::<f64>();
            let total: f64 = texels.iter().map(of_texel).sum();
            let mut before = 0.0;
            ends.extend(texels.iter().map(|texel| {
                before += of_texel(texel);
                (before / total.max(f64::MIN_POSITIVE)) as f32
            }));
        }
        let excess = |pixel: &[f32; 3]| above(pixel).map(|v| (v * inverse) as f32);
        SkyMap {
            width,
            floor,
            scale,
            mean: std::array::from_fn(|c| floor[c] + flux[c] / SPHERE),
            excess: pixels.iter().map(excess).collect(),
            rows,
            row_guide: guide(&row_ends).collect(),
            guide: ends.chunks_exact(width).flat_map(guide).collect(),
            row_ends,
            ends,
        }
    }

    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.rows.len())
    }

    /// The uniform radiance below everything, linear RGB.
    pub fn floor(&self) -> [f64; 3] {
        self.floor
    }

    /// What [`SkyMap::excess`] is to be multiplied with; 0 for a constant map.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Mean radiance over the sphere, linear RGB.
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// Radiance of a texel above the floor, divided by the scale. The sum of the channels is the probability density per steradian.
    #[inline(always)]
    pub fn excess(&self, texel: u32) -> [f32; 3] {
        self.excess[texel as usize]
    }

    /// The texels that sixteen directions of unit length meet.
    #[inline(always)]
    pub fn texels16(&self, directions: &[Wide; 3]) -> [u32; LANES] {
        let (width, height) = (self.width as f32, self.rows.len() as f32);
        let mut out = [0; LANES];
        for l in 0..LANES {
            let [x, y, z] = [directions[0][l], directions[1][l], directions[2][l]];
            let polar = atan2((x * x + z * z).sqrt(), y) * (height / std::f32::consts::PI);
            let turns = atan2(x, z) * (1.0 / std::f32::consts::TAU) + 0.5;
            let row = polar.min(height - 1.0) as i32;
            let column = (turns * width).min(width - 1.0) as i32;
            out[l] = (row * self.width as i32 + column) as u32;
        }
        out
    }

    /// Sixteen unit directions, uniform over their texels, and these, for points of the unit square; `u0` chooses the row, `u1` the
    /// column. The map must not be constant.
    #[inline(always)]
    pub fn sample16(&self, u0: &Wide, u1: &Wide) -> ([Wide; 3], [u32; LANES]) {
        let (mut directions, mut texels) = ([[0.0; LANES]; 3], [0; LANES]);
        for l in 0..LANES {
            let row = find(&self.row_ends, &self.row_guide, u0[l]);
            let texels_of_row = row * self.width..(row + 1) * self.width;
            let column = find(
                &self.ends[texels_of_row.clone()],
                &self.guide[texels_of_row],
                u1[l],
            );
            let texel = row * self.width + column;
            let upper = if row == 0 {
                0.0
            } else {
                self.row_ends[row - 1]
            };
            let left = if column == 0 {
                0.0
            } else {
                self.ends[texel - 1]
            };
            let s = ((u0[l] - upper) / (self.row_ends[row] - upper)).clamp(0.0, 1.0);
            let t = ((u1[l] - left) / (self.ends[texel] - left)).clamp(0.0, 1.0);
            let Row {
                complement: [from, to],
                side,
            } = self.rows[row];
            let complement = from + (to - from) * s;
            directions[0][l] = (complement * (2.0 - complement)).sqrt();
            directions[1][l] = side * (1.0 - complement);
            directions[2][l] = (column as f32 + t) / self.width as f32;
            texels[l] = texel as u32;
        }
        for l in 0..LANES {
            // Turns from the seam, which is half a turn from +z.
            let (sin, cos) = turn_sin_cos(directions[2][l]);
            let radius = directions[0][l];
            directions[0][l] = -radius * sin;
            directions[2][l] = -radius * cos;
        }
        (directions, texels)
    }
}

/// A table from which the inverse of a distribution over `ends.len()` places is found in a step or two: for each of as many equal parts of
/// 0..1, the first place whose end exceeds the part's start. H.-C. Chen, Y. Asau, "On Generating Random Variates from an Empirical
/// Distribution", 1974.
fn guide(ends: &[f32]) -> impl Iterator<Item = u16> {
    let count = ends.len() as f32;
    let mut place = 0;
    (0..ends.len()).map(move |part| {
        while place + 1 < ends.len() && ends[place] <= part as f32 / count {
            place += 1;
        }
        place as u16
    })
}

/// The first place whose end exceeds `u` in 0..1; the last where none does.
#[inline(always)]
fn find(ends: &[f32], guide: &[u16], u: f32) -> usize {
    let part = (u * ends.len() as f32) as usize;
    // One part back: the product above is rounded.
    let mut place = usize::from(guide[part.clamp(1, guide.len()) - 1]);
    while place + 1 < ends.len() && ends[place] <= u {
        place += 1;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambient::sampling::Stream;

    /// Any map: values between 0 and 1 by a fixed rule, and one texel a thousand times as bright.
    fn map(width: usize, height: usize) -> (SkyMap, Vec<[f32; 3]>) {
        let value = |i: usize, c: usize| ((i * 37 + c * 11) % 101) as f32 / 100.0;
        let mut pixels: Vec<[f32; 3]> = (0..width * height)
            .map(|i| [value(i, 0), value(i, 1), value(i, 2)])
            .collect();
        pixels[width * (height / 3) + 2] = [900.0, 1000.0, 1100.0];
        (SkyMap::new(width, &pixels), pixels)
    }

    /// Samples for sixteen points of a stream.
    fn draw(map: &SkyMap, stream: &Stream, first: u32) -> ([Wide; 3], [u32; LANES]) {
        let coordinate =
            |d: usize| std::array::from_fn(|l| stream.point(first + l as u32)[d] as f32);
        map.sample16(&coordinate(0), &coordinate(1))
    }

    #[test]
    fn a_constant_map_is_a_floor_alone() {
        let map = SkyMap::new(8, &[[0.3, 2.0, 0.0]; 32]);
        assert_eq!(map.floor(), [0.3_f32, 2.0, 0.0].map(f64::from));
        assert_eq!(map.mean(), map.floor());
        assert_eq!(map.scale(), 0.0);
    }

    #[test]
    fn floor_and_excess_give_back_the_picture_and_density_adds_up_to_one() {
        let (map, pixels) = map(16, 9);
        for (i, pixel) in pixels.iter().enumerate() {
            let excess = map.excess(i as u32);
            for c in 0..3 {
                let value = map.floor()[c] + map.scale() * f64::from(excess[c]);
                // Roundings of the excess to f32.
                let close = 2e-7 * f64::from(pixel[c]);
                assert!((value - f64::from(pixel[c])).abs() <= close, "{i}, {c}");
            }
        }
        let mut density = 0.0;
        for i in 0..16 * 9 {
            let (top, bottom) = ((i / 16) as f64 / 9.0 * PI, (i / 16 + 1) as f64 / 9.0 * PI);
            let omega = (top.cos() - bottom.cos()) * TAU / 16.0;
            density += omega * map.excess(i).iter().map(|&v| f64::from(v)).sum::<f64>();
        }
        assert!((density - 1.0).abs() < 1e-6, "{density}");
    }

    #[test]
    fn directions_lie_in_their_texels() {
        for (width, height) in [(16, 9), (1, 1), (3, 2), (64, 33)] {
            let (map, _) = map(width.max(3), height);
            let stream = Stream::new(0, 0, 0, 0, 0);
            let mut outside = 0;
            for first in (0..4096).step_by(LANES) {
                let (directions, texels) = draw(&map, &stream, first);
                let found = map.texels16(&directions);
                for l in 0..LANES {
                    let square: f32 = directions.iter().map(|axis| axis[l] * axis[l]).sum();
                    assert!((square - 1.0).abs() < 1e-6, "{square}");
                    outside += u32::from(found[l] != texels[l]);
                }
            }
            // Rounding may take a direction over an edge: within 1e-6 of one, which few of 4,096 are.
            assert!(outside <= 2, "{width} x {height}: {outside}");
        }
    }

    #[test]
    fn texels_are_drawn_by_their_flux() {
        let (map, _) = map(16, 9);
        let n = 1 << 18;
        let stream = Stream::new(3, 0, 0, 0, 0);
        let mut counts = vec![0.0; 16 * 9];
        for first in (0..n).step_by(LANES) {
            for texel in draw(&map, &stream, first).1 {
                counts[texel as usize] += 1.0 / f64::from(n);
            }
        }
        for (i, count) in counts.iter().enumerate() {
            let (top, bottom) = ((i / 16) as f64 / 9.0 * PI, (i / 16 + 1) as f64 / 9.0 * PI);
            let omega = (top.cos() - bottom.cos()) * TAU / 16.0;
            let share = omega
                * map
                    .excess(i as u32)
                    .iter()
                    .map(|&v| f64::from(v))
                    .sum::<f64>();
            // Star discrepancy of a (0, m, 2)-net, H. Niederreiter (1987): (m / 3 + 19 / 9) / 2^m; four times for a box anywhere.
            let bound = 4.0 * (18.0 / 3.0 + 19.0 / 9.0) / f64::from(n) + 2e-6;
            assert!((count - share).abs() < bound, "{i}: {count} for {share}");
        }
    }
}
