//! What of a bent surface tells how its light changes from texel to texel: where each texel faces, and how far it
//! stands out.
//!
//! Light on a bent surface follows its normals more closely than any polynomial of the place, and hollows are darker
//! than what stands out beside them. Neither has noise. Fits over charts that bend therefore have the components of the
//! normal, and the height above the texels about, as functions beside those of the place. After B. Moon, N. Carr, S.-E.
//! Yoon, "Adaptive Rendering Based on Weighted Local Regression", 2014, who fit images linearly in what is known of the
//! geometry.

use super::charts::{Band, Chart, Charts};
use super::field::Field;
use super::plane::{About, Room, Sheet, TASK, rows};
use super::surface::FEATURES;
use super::{FEWEST, at_least};
use glam::Vec3;
use rayon::prelude::*;

/// A chart is bent when the mean square of what its normals are off their mean is above this, the square of 0.2
/// degrees.
const BENT: f32 = 1e-5;

/// Heights below this share of a texel's edge are rounding.
const FLAT: f32 = 1e-3;

/// What the numbers are stored in; a height stands for 8 texels at most.
const UNITS: [f32; FEATURES] = [1.0 / 32767.0, 1.0 / 32767.0, 1.0 / 32767.0, 8.0 / 32767.0];

/// The features of a page's texels.
#[derive(Debug)]
pub(super) struct Features {
    /// Of each texel the three components of its normal and its height in texels, in [`UNITS`]; of none where no chart
    /// is bent.
    texels: Vec<[i16; FEATURES]>,
    /// Of each chart: whether it is bent.
    bent: Vec<bool>,
}

impl Features {
    /// Those of a page with these charts. `at_a_time`: texels of a chart that are looked at together.
    pub fn new(field: &Field<'_>, charts: &Charts, at_a_time: usize) -> Self {
        let charts = &charts.charts;
        let each = charts.par_iter().with_max_len(1);
        let each = each.with_min_len(at_least(field.size));
        let bent: Vec<bool> = each.clone().map(|chart| is_bent(field, chart)).collect();
        if !bent.contains(&true) {
            let texels = Vec::new();
            return Self { texels, bent };
        }
        let facing = |texel: usize| match field.has_data(texel) {
            true => stored(field.normal(texel).extend(0.0).to_array()),
            false => [0; FEATURES],
        };
        let all = (0..field.size * field.size).into_par_iter();
        let all = all.with_min_len(TASK).map(facing);
        let mut texels: Vec<[i16; FEATURES]> = all.collect();
        let heights = each.zip(&bent).map(|(chart, is_bent)| {
            let bands = chart.area.bands(at_a_time).into_iter();
            let bands = bands.filter(|_| *is_bent);
            bands
                .flat_map(|band| heights(field, chart, &band))
                .collect()
        });
        let heights: Vec<Vec<f32>> = heights.collect();
        for (chart, heights) in charts.iter().zip(&heights) {
            for (texel, &height) in chart.all().zip(heights) {
                texels[texel][3] = stored([0.0, 0.0, 0.0, height])[3];
            }
        }
        Self { texels, bent }
    }

    /// Whether a chart is bent. One that is flat has none.
    pub fn are_of(&self, chart: u32) -> bool {
        self.bent[chart as usize]
    }

    /// Feature `number` of a texel.
    pub fn at(&self, texel: usize, number: usize) -> f32 {
        f32::from(self.texels[texel][number]) * UNITS[number]
    }
}

fn stored(values: [f32; FEATURES]) -> [i16; FEATURES] {
    // Out of range is cut off, and what is no number becomes 0.
    [0, 1, 2, 3].map(|k| (values[k] / UNITS[k]).round() as i16)
}

fn is_bent(field: &Field<'_>, chart: &Chart) -> bool {
    let normals = || chart.all().map(|texel| field.normal(texel));
    let count = chart.texels as f32;
    let mean = normals().sum::<Vec3>() / count;
    let squares = normals().map(|normal| normal.distance_squared(mean));
    chart.texels >= FEWEST && squares.sum::<f32>() > BENT * count
}

/// How far each texel of a band stands out above the mean of the 11 x 11 texels about it that are of its chart, along
/// their mean normal, in edges of a texel.
fn heights(field: &Field<'_>, chart: &Chart, band: &Band) -> Vec<f32> {
    let area = chart.area.in_lanes();
    let size @ [width, height] = [area.size[0], band.about.len()];
    let home = field.position(chart.runs[0].first as usize);
    // Whether there is a texel, its position, its normal.
    let mut known = Sheet::new(size, 7);
    for run in chart.runs_of(&area, &band.about, field.size) {
        let [x, y] = area.local(run.first, &band.about, field.size);
        for (x, texel) in (x..).zip(run.texels()) {
            let place = field.position(texel) - home;
            let all = [1.0].into_iter().chain(place.to_array());
            let all = all.chain(field.normal(texel).to_array());
            all.enumerate()
                .for_each(|(plane, value)| known.row_mut(plane, y)[x] = value);
        }
    }
    let mut heights = Sheet::new(size, 1);
    rows(
        height,
        1,
        [&mut heights.values],
        #[inline(always)]
        |first, [heights]| {
            let mut room = Room::new(width);
            let mut sums = vec![0.0; 7 * width];
            for (row, heights) in heights.chunks_exact_mut(width).enumerate() {
                let y = first + row;
                for (plane, sums) in sums.chunks_exact_mut(width).enumerate() {
                    known.sums(plane, y, About::Eleven, &mut room, sums);
                }
                let place = |x: usize, y: usize| Vec3::from([1, 2, 3].map(|k| known.at(k, [x, y])));
                let sum = |x: usize, first: usize| {
                    Vec3::from([0, 1, 2].map(|k| sums[(first + k) * width + x]))
                };
                for (x, out) in heights.iter_mut().enumerate() {
                    if known.at(0, [x, y]) == 0.0 {
                        continue;
                    }
                    let own = place(x, y);
                    let beside = [
                        (x.wrapping_sub(1), y),
                        (x + 1, y),
                        (x, y.wrapping_sub(1)),
                        (x, y + 1),
                    ];
                    let is_there = |&(x, y): &(usize, usize)| {
                        x < width && y < height && known.at(0, [x, y]) > 0.0
                    };
                    let beside = beside.into_iter().filter(is_there);
                    let edges = beside.map(|(x, y)| own.distance_squared(place(x, y)));
                    let edge = edges.fold(f32::INFINITY, f32::min).sqrt();
                    let height =
                        sum(x, 4).normalize_or_zero().dot(own - sum(x, 1) / sums[x]) / edge;
                    *out = if height.abs() < FLAT { 0.0 } else { height };
                }
            }
        },
    );
    let own = chart.runs_of(&area, &band.rows, field.size).iter();
    let own = own.flat_map(|run| {
        let [x, y] = area.local(run.first, &band.about, field.size);
        heights.row(0, y)[x..x + run.count as usize].iter().copied()
    });
    own.collect()
}
