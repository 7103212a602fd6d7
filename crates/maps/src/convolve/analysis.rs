//! From a map to spherical harmonics, with its radiance constant over every texel.

use super::grid::Grid;
use super::rings::{Rings, Series, analyse_rings, nodes};
use environment::{IlluminationMap, Projection};
use std::f64::consts::PI;

/// The coefficients of a map up to `order`.
pub(super) fn analyse(map: &IlluminationMap, order: usize) -> Series {
    let (width, height) = map.size();
    if map.projection() != Projection::Polar {
        let grid = Grid::spread(map, order);
        return grid.analyse(|rings| analyse_rings(rings, order));
    }
    let pixels = &map.image().pixels;
    let row = |j: usize, channels: &mut [Vec<f64>; 3]| {
        for (i, pixel) in pixels[j * width..(j + 1) * width].iter().enumerate() {
            for c in 0..3 {
                channels[c][i] = f64::from(pixel[c]);
            }
        }
    };
    let rings = Rings {
        height,
        width,
        row: &row,
        nodes: nodes(PI / height as f64 * order as f64),
    };
    analyse_rings(&rings, order)
}
