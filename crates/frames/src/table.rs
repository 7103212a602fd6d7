//! A polar map ready for many look-ups: four floats a texel, one texel of margin, no branches.
//!
//! The margin repeats the other side of the longitude seam, and beyond a pole the row next to it turned by half.
//! Directions go to places by a polynomial arctangent in f32 that compilers vectorise; there is no resampled copy, so
//! bilinear look-up differs from [`environment::IlluminationMap::bilinear`] by rounding alone: places err by at most
//! 1.3e-7 of the map's width or height for each radian (tested), values by that times the slope of the map.

use crate::summed::Summed;
use ambient::lanes::atan2;
use environment::{Error, IlluminationMap, Projection};
use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Pixels that are shaded in step.
pub(super) const LANES: usize = 64;

/// One number for each of [`LANES`] pixels.
pub(super) type Lanes = [f32; LANES];

/// A table of radiance by direction: D, S or I of the 1984 text.
#[derive(Debug)]
pub struct Table {
    width: usize,
    height: usize,
    /// Rows of `width + 2`, `height + 2` of them; the fourth number is 0.
    texels: Vec<[f32; 4]>,
    summed: OnceLock<Summed>,
}

/// Where to read a block of pixels: upper left texel and the shares of its right and lower neighbours.
struct Places {
    at: [u32; LANES],
    right: Lanes,
    low: Lanes,
}

impl Table {
    /// The table of a polar map in ambake's axes.
    ///
    /// # Errors
    /// [`Error::Shape`] for another projection.
    pub fn new(map: &IlluminationMap) -> Result<Table, Error> {
        let (width, height) = map.size();
        if map.projection() != Projection::Polar {
            return Err(Error::Shape(format!(
                "a table is a polar map, this one is {}; convert it with ambake map convert --to polar",
                map.projection().name()
            )));
        }
        assert!((width + 2) * (height + 2) < 1 << 32, "{width} x {height}");
        let mut texels = Vec::with_capacity((width + 2) * (height + 2));
        for y in 0..height + 2 {
            let beyond = y == 0 || y == height + 1;
            let row = y.clamp(1, height) - 1;
            let turn = if beyond { width / 2 } else { 0 };
            for x in 0..width + 2 {
                let [r, g, b] = map.image().at((x + width - 1 + turn) % width, row);
                texels.push([r, g, b, 0.0]);
            }
        }
        Ok(Table {
            width,
            height,
            texels,
            summed: OnceLock::new(),
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The texel in column `x` and row `y`.
    ///
    /// # Panics
    /// Outside the map.
    pub fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        assert!(x < self.width && y < self.height, "texel ({x}, {y})");
        let [r, g, b, _] = self.texels[(y + 1) * (self.width + 2) + x + 1];
        [r, g, b]
    }

    /// The table of sums over rectangles; made at the first call.
    pub fn summed(&self) -> &Summed {
        let texel = |x, y| self.texel(x, y);
        self.summed.get_or_init(|| Summed::of(self.size(), texel))
    }

    /// The place of a direction of any length but 0, in texels from the upper left corner.
    #[inline(always)]
    pub fn place(&self, [x, y, z]: [f32; 3]) -> [f32; 2] {
        let across = (x * x + z * z).sqrt();
        let longitude = atan2(x, z);
        let polar = atan2(across, y);
        [
            (longitude * (0.5 * FRAC_1_PI) + 0.5) * self.width as f32,
            polar * FRAC_1_PI * self.height as f32,
        ]
    }

    /// The texel that shows this direction.
    pub fn nearest(&self, direction: [f32; 3]) -> [f32; 3] {
        let [x, y] = self.place(direction);
        self.texel(
            (x as usize).min(self.width - 1),
            (y as usize).min(self.height - 1),
        )
    }

    /// Bilinear interpolation between the centres of four texels, over the seam and the poles.
    pub fn bilinear(&self, direction: [f32; 3]) -> [f32; 3] {
        let (at, right, low) = self.corner(direction, false);
        let [r, g, b, _] = self.blend(at as usize, right, low);
        [r, g, b]
    }

    /// Upper left of the four texels, and the shares of the others; `nearest` takes one texel whole.
    #[inline(always)]
    fn corner(&self, direction: [f32; 3], nearest: bool) -> (u32, f32, f32) {
        let [x, y] = self.place(direction);
        let stride = self.width as u32 + 2;
        if nearest {
            let column = floor(x).min(self.width as f32 - 1.0);
            let row = floor(y).min(self.height as f32 - 1.0);
            return ((whole(row) + 1) * stride + whole(column) + 1, 0.0, 0.0);
        }
        // From 0 on: the margin begins half a texel before the map's centres do.
        let (x, y) = (x + 0.5, y + 0.5);
        let (column, row) = (floor(x), floor(y));
        (whole(row) * stride + whole(column), x - column, y - row)
    }

    /// [`Table::place`] of a block of directions: columns and rows.
    #[inline(always)]
    pub(super) fn block(&self, [x, y, z]: &[Lanes; 3]) -> [Lanes; 2] {
        let mut places = [[0.0; LANES]; 2];
        for k in 0..LANES {
            [places[0][k], places[1][k]] = self.place([x[k], y[k], z[k]]);
        }
        places
    }

    /// Texels of a block of directions.
    #[inline(always)]
    fn places(&self, [x, y, z]: &[Lanes; 3], nearest: bool) -> Places {
        let mut places = Places {
            at: [0; LANES],
            right: [0.0; LANES],
            low: [0.0; LANES],
        };
        for k in 0..LANES {
            let (at, right, low) = self.corner([x[k], y[k], z[k]], nearest);
            places.at[k] = at;
            places.right[k] = right;
            places.low[k] = low;
        }
        places
    }

    /// Adds the values in a block of directions, each times its factor.
    #[inline(always)]
    pub(super) fn add(
        &self,
        directions: &[Lanes; 3],
        nearest: bool,
        factors: &[[f32; 4]; LANES],
        sums: &mut [[f32; 4]; LANES],
    ) {
        let places = self.places(directions, nearest);
        for k in 0..LANES {
            let value = self.blend(places.at[k] as usize, places.right[k], places.low[k]);
            sums[k] = std::array::from_fn(|c| sums[k][c] + factors[k][c] * value[c]);
        }
    }

    #[inline(always)]
    fn blend(&self, at: usize, right: f32, low: f32) -> [f32; 4] {
        let below = at + self.width + 2;
        let (upper, lower) = (&self.texels[at..at + 2], &self.texels[below..below + 2]);
        let [a, b, c, d] = [upper[0], upper[1], lower[0], lower[1]];
        std::array::from_fn(|i| {
            let upper = a[i] + right * (b[i] - a[i]);
            let lower = c[i] + right * (d[i] - c[i]);
            upper + low * (lower - upper)
        })
    }
}

/// From here to twice this, floats are the whole numbers.
const WHOLE: f32 = 8_388_608.0;

/// The integer part of a number in 0..2²²: without a call where processors have no instruction for it.
#[inline(always)]
fn floor(v: f32) -> f32 {
    let near = (v + WHOLE) - WHOLE;
    if near > v { near - 1.0 } else { near }
}

/// A whole number in 0..2²³ as an integer: a conversion that needs no care for other values, so it vectorises.
#[inline(always)]
fn whole(v: f32) -> u32 {
    (v + WHOLE).to_bits() - WHOLE.to_bits()
}
