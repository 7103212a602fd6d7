//! A fine polar grid that stands between spherical harmonics and any other layout.
//!
//! A function of order L on a grid of spacing π/4L is interpolated by eight points each way to some 1e-8. Spreading a
//! point onto the grid is the adjoint: afterwards the grid has the same I_lm as the point.

use super::rings::Rings;
use super::tiles;
use environment::{IlluminationMap, Image, Projection};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Points of interpolation each way.
const POINTS: usize = 8;

/// 1 / Π (k - j) over the other points j: (-1)^(7-k) / k! (7-k)!.
const INVERSE: [f64; POINTS] = [
    -1.0 / 5040.0,
    1.0 / 720.0,
    -1.0 / 240.0,
    1.0 / 144.0,
    -1.0 / 144.0,
    1.0 / 240.0,
    -1.0 / 720.0,
    1.0 / 5040.0,
];

/// Rows that are filled together.
const BAND: usize = 32;

/// Values on rings; each ring's first value lies at half a step from φ = -π.
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
    pub values: Vec<[f64; 3]>,
}

impl Grid {
    /// Width and height for functions up to an order. High orders carry little, so their grid is coarser.
    pub(super) fn size(order: usize) -> (usize, usize) {
        let height = (4 * order)
            .min((2 * order).max(1024))
            .max(32)
            .next_multiple_of(16);
        (2 * height, height)
    }

    /// The map's texels as point weights.
    pub(super) fn spread(map: &IlluminationMap, order: usize) -> Grid {
        let (width, height) = Self::size(order);
        let points = tiles::points(map, order);
        let bands = height.div_ceil(BAND);
        // Every point goes to the bands that its eight rows touch, in the order of the points.
        let mut lists = vec![Vec::new(); bands];
        for (index, direction) in points.directions.iter().enumerate() {
            let stencil = Stencil::at(*direction, width, height);
            let mut touched: Vec<usize> = (0..POINTS)
                .map(|k| stencil.row(k, height).0 / BAND)
                .collect();
            touched.dedup();
            touched.sort_unstable();
            touched.dedup();
            touched
                .iter()
                .for_each(|band| lists[*band].push((index as u32, stencil)));
        }
        let mut values = vec![[0.0; 3]; width * height];
        values
            .par_chunks_mut(BAND * width)
            .zip(&lists)
            .enumerate()
            .for_each(|(band, (values, list))| {
                let rows = band * BAND..band * BAND + values.len() / width;
                for (index, stencil) in list {
                    let flux = points.flux[*index as usize];
                    let [down, across] = stencil.weights();
                    for (k, down) in down.into_iter().enumerate() {
                        let (row, over) = stencil.row(k, height);
                        if !rows.contains(&row) {
                            continue;
                        }
                        let row = &mut values[(row - rows.start) * width..][..width];
                        for (i, across) in across.into_iter().enumerate() {
                            let value = &mut row[stencil.column(i, width, over)];
                            *value = std::array::from_fn(|c| value[c] + flux[c] * (down * across));
                        }
                    }
                }
            });
        Grid {
            width,
            height,
            values,
        }
    }

    /// Calls `analyse` with the grid as rings of points.
    pub(super) fn analyse<T>(&self, analyse: impl FnOnce(&Rings) -> T) -> T {
        let row = |j: usize, channels: &mut [Vec<f64>; 3]| {
            for (i, value) in self.values[j * self.width..(j + 1) * self.width]
                .iter()
                .enumerate()
            {
                for c in 0..3 {
                    channels[c][i] = value[c];
                }
            }
        };
        analyse(&Rings {
            height: self.height,
            width: self.width,
            row: &row,
            nodes: 0,
        })
    }

    /// The values at the centres of a picture's texels.
    pub(super) fn gather(&self, projection: Projection, size: (usize, usize)) -> Image {
        let pixel = |at: usize| {
            let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
            let Some(direction) = projection.direction(size, x, y) else {
                return [0.0; 3];
            };
            let stencil = Stencil::at(direction, self.width, self.height);
            let [down, across] = stencil.weights();
            let mut sum = [0.0; 3];
            for (k, down) in down.into_iter().enumerate() {
                let (row, over) = stencil.row(k, self.height);
                let row = &self.values[row * self.width..][..self.width];
                let mut line = [0.0; 3];
                for (i, across) in across.into_iter().enumerate() {
                    let value = row[stencil.column(i, self.width, over)];
                    line = std::array::from_fn(|c| line[c] + across * value[c]);
                }
                sum = std::array::from_fn(|c| sum[c] + down * line[c]);
            }
            sum.map(|v| v.max(0.0) as f32)
        };
        Image {
            width: size.0,
            height: size.1,
            pixels: (0..size.0 * size.1).into_par_iter().map(pixel).collect(),
        }
    }
}

/// The eight rows and columns around a direction.
#[derive(Clone, Copy)]
struct Stencil {
    top: isize,
    left: isize,
    /// Place between the fourth and the fifth point, 0..1, down and across.
    between: [f64; 2],
}

impl Stencil {
    fn at([x, y, z]: [f64; 3], width: usize, height: usize) -> Stencil {
        let down = x.hypot(z).atan2(y) / PI * height as f64 - 0.5;
        let across = (x.atan2(z) / TAU + 0.5) * width as f64 - 0.5;
        let before = POINTS as isize / 2 - 1;
        Stencil {
            top: down.floor() as isize - before,
            left: across.floor() as isize - before,
            between: [down - down.floor(), across - across.floor()],
        }
    }

    /// Lagrange's weights down and across.
    fn weights(&self) -> [[f64; POINTS]; 2] {
        self.between.map(|t| {
            // Products of the distances to the points before and after each.
            let distance = |k: usize| t - (k as f64 - (POINTS / 2 - 1) as f64);
            let mut weights = INVERSE;
            let (mut before, mut after) = (1.0, 1.0);
            for k in 0..POINTS {
                weights[k] *= before;
                before *= distance(k);
                let k = POINTS - 1 - k;
                weights[k] *= after;
                after *= distance(k);
            }
            weights
        })
    }

    /// A row, and whether it was reached over a pole.
    fn row(&self, k: usize, height: usize) -> (usize, bool) {
        let (row, height) = (self.top + k as isize, height as isize);
        if row < 0 {
            ((-1 - row) as usize, true)
        } else if row >= height {
            ((2 * height - 1 - row) as usize, true)
        } else {
            (row as usize, false)
        }
    }

    /// A column; over a pole it lies half a turn away.
    fn column(&self, k: usize, width: usize, over: bool) -> usize {
        let column = self.left + k as isize + if over { width as isize / 2 } else { 0 };
        column.rem_euclid(width as isize) as usize
    }
}
