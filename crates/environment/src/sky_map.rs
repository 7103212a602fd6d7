//! An illumination map as a sky: its radiance along any direction, and directions drawn by it.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use crate::{Error, IlluminationMap, Projection, Up};
use ambient::convention::SPHERE;
use ambient::lanes::{LANES, Wide, atan2, turn_sin_cos};
use std::f64::consts::{PI, TAU};
use std::ops::Neg;
use std::path::Path;

/// Radiance from every direction, constant over each texel of a polar map: a uniform floor and what stands out of it.
///
/// Texels lie as in [`Projection::Polar`]. The floor is the least value of each channel, so that a constant map is a
/// floor alone and needs no samples. What stands out is kept divided by [`SkyMap::scale`], its flux over the sphere
/// summed over the channels: then the sum of a texel's three channels is the probability per steradian with which
/// [`SkyMap::sample16`] draws directions of the texel.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyMap {
    up: Up,
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
    /// The sky that a polar map shows.
    ///
    /// ```
    /// use ambake_environment::{IlluminationMap, Image, Projection, SkyMap};
    /// let mut image = Image::filled(64, 32, [0.25; 3]);
    /// image.pixels[64 * 8 + 20] = [1000.0; 3];
    /// let sky = SkyMap::new(&IlluminationMap::new(image, Projection::Polar)?)?;
    /// assert_eq!(sky.floor(), [0.25; 3]);
    /// // All directions are drawn from the one texel that stands out.
    /// let (directions, texels) = sky.sample16(&[0.3; 16], &[0.7; 16]);
    /// assert_eq!(texels, [64 * 8 + 20; 16]);
    /// assert_eq!(sky.texels16(&directions), texels);
    /// # Ok::<(), ambake_environment::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] for another projection, which [`crate::convert`] makes polar, and for a side above 65,536;
    /// [`Error::Pixel`] for a radiance that is not finite or negative.
    pub fn new(map: &IlluminationMap) -> Result<SkyMap, Error> {
        let (width, height) = map.size();
        if map.projection() != Projection::Polar {
            let name = map.projection().name();
            return Err(Error::Shape(format!(
                "a sky is a polar map, this one is {name}; convert it"
            )));
        }
        // Places in a row or a column are kept in 16 bits.
        if width.max(height) > 1 << 16 {
            return Err(Error::Shape(format!(
                "a sky of {width} x {height} texels; at most 65536 a side are drawn from, make it smaller"
            )));
        }
        map.image().check(Path::new("the sky"))?;
        let pixels = &map.image().pixels[..];
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
        Ok(SkyMap {
            up: Up::Y,
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
        })
    }

    /// The same map over a scene in which that axis points upward: directions are the scene's from here on.
    pub fn with_up(self, up: Up) -> SkyMap {
        SkyMap { up, ..self }
    }

    /// The axis that points upward.
    pub fn up(&self) -> Up {
        self.up
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

    /// Radiance of a texel above the floor, divided by the scale. The sum of the channels is the probability density
    /// per steradian.
    #[inline(always)]
    pub fn excess(&self, texel: u32) -> [f32; 3] {
        self.excess[texel as usize]
    }

    /// Radiance of a texel above the floor, and the density per steradian with which it is drawn.
    pub fn above(&self, texel: u32) -> ([f64; 3], f64) {
        let excess = self.excess(texel).map(f64::from);
        (excess.map(|v| v * self.scale), excess.iter().sum())
    }

    /// Radiance in a unit direction, linear between the middles of texels. Above the highest and below the lowest row
    /// it is theirs.
    pub fn seen(&self, direction: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.up.to_map(direction);
        let (width, height) = (self.width, self.rows.len());
        let polar = x.hypot(z).atan2(y) / PI * height as f64 - 0.5;
        let turns = (x.atan2(z) / TAU + 0.5) * width as f64 - 0.5;
        let mut sum = self.floor;
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let weight = |at: f64, next: usize| match next {
                0 => 1.0 - (at - at.floor()),
                _ => at - at.floor(),
            };
            let weight = weight(polar, row) * weight(turns, column);
            let row = (polar.floor() as i64 + row as i64).clamp(0, height as i64 - 1) as usize;
            let column = (turns.floor() as i64 + column as i64).rem_euclid(width as i64) as usize;
            let excess = self.excess[row * width + column].map(f64::from);
            sum = std::array::from_fn(|c| sum[c] + weight * self.scale * excess[c]);
        }
        sum
    }

    /// The texels that sixteen directions of unit length meet.
    #[inline(always)]
    pub fn texels16(&self, directions: &[Wide; 3]) -> [u32; LANES] {
        let (width, height) = (self.width as f32, self.rows.len() as f32);
        let mut out = [0; LANES];
        let turned: [Wide; 3];
        let directions = match self.up {
            Up::Y => directions,
            Up::Z => {
                let [x, y, z] = *directions;
                turned = [x, z, y.map(f32::neg)];
                &turned
            }
        };
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

    /// Sixteen unit directions, uniform over their texels, and these, for points of the unit square; `u0` chooses the
    /// row, `u1` the column. The map must not be constant.
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
        if self.up == Up::Z {
            let [x, y, z] = directions;
            directions = [x, z.map(f32::neg), y];
        }
        (directions, texels)
    }
}

/// A table from which the inverse of a distribution over `ends.len()` places is found in a step or two: for each of as
/// many equal parts of 0..1, the first place whose end exceeds the part's start. H.-C. Chen, Y. Asau, "On Generating
/// Random Variates from an Empirical Distribution", 1974.
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
mod tests;
