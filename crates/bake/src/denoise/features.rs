//! What of a bent surface tells how its light changes from texel to texel: where each texel faces, and how far it stands out.
//!
//! Light on a bent surface follows its normals more closely than any polynomial of the place, and hollows are darker than what stands
//! out beside them. Neither has noise. Fits over charts that bend therefore have the components of the normal, and the height above
//! the texels about, as functions beside those of the place. After B. Moon, N. Carr, S.-E. Yoon, "Adaptive Rendering Based on Weighted
//! Local Regression", 2014, who fit images linearly in what is known of the geometry.

use super::charts::{Band, Chart, Charts};
use super::field::Field;
use super::fit::FEATURES;
use super::plane::{Plane, TASK};
use super::{FEWEST, at_least};
use glam::Vec3;
use rayon::prelude::*;

/// A chart is bent when the mean square of what its normals are off their mean is above this, the square of 0.2 degrees.
const BENT: f32 = 1e-5;

/// Heights below this share of a texel's edge are rounding.
const FLAT: f32 = 1e-3;

/// What the numbers are stored in; a height stands for 8 texels at most.
const UNITS: [f32; FEATURES] = [1.0 / 32767.0, 1.0 / 32767.0, 1.0 / 32767.0, 8.0 / 32767.0];

/// The features of a page's texels.
#[derive(Debug)]
pub(super) struct Features {
    /// Of each texel the three components of its normal and its height in texels, in [`UNITS`]; of none where no chart is bent.
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
            true => stored(field.normal(texel).as_vec3().extend(0.0).to_array()),
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
            for (&texel, &height) in chart.texels.iter().zip(heights) {
                texels[texel as usize][3] = stored([0.0, 0.0, 0.0, height])[3];
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
    let texels = || chart.texels.iter();
    let normal = |&texel: &u32| field.normal(texel as usize).as_vec3();
    let count = texels().len() as f32;
    let mean = texels().map(normal).sum::<Vec3>() / count;
    let squares = || texels().map(|texel| normal(texel).distance_squared(mean));
    texels().len() >= FEWEST && squares().sum::<f32>() > BENT * count
}

/// How far each texel of a band stands out above the mean of the 11 x 11 texels about it that are of its chart, along their mean normal, in
/// edges of a texel.
fn heights(field: &Field<'_>, chart: &Chart, band: &Band) -> Vec<f32> {
    let width = chart.area.size[0];
    let local = |texel: u32| chart.area.local(texel, &band.about, field.size);
    let about = chart.texels_of(&chart.area, &band.about, field.size);
    let home = field.position(chart.texels[0] as usize);
    let plane = |of: &dyn Fn(usize) -> f32| {
        let mut plane = Plane::new([width, band.about.len()]);
        about
            .iter()
            .for_each(|&texel| plane.values[local(texel)] = of(texel as usize));
        plane
    };
    let sums = |of: &Plane| {
        let mut sums = Plane::like(of);
        sums.set_sums(|i| of.values[i]);
        sums
    };
    let mask = plane(&|_| 1.0);
    let count = sums(&mask);
    let place =
        [0, 1, 2].map(|k: usize| plane(&|texel| (field.position(texel)[k] - home[k]) as f32));
    let places = place.each_ref().map(sums);
    let normals = [0, 1, 2].map(|k: usize| sums(&plane(&|texel| field.normal[k][texel])));
    let at = |of: &[Plane; 3], i: usize| Vec3::from(of.each_ref().map(|plane| plane.values[i]));
    let height = |&texel: &u32| {
        let i = local(texel);
        let own = at(&place, i);
        let column = i % width;
        let beside = [
            (column > 0).then(|| i - 1),
            (column + 1 < width).then_some(i + 1),
            i.checked_sub(width),
            Some(i + width),
        ];
        let beside = beside.into_iter().flatten();
        let beside = beside.filter(|&j| mask.values.get(j).is_some_and(|mask| *mask > 0.0));
        let edge = beside.map(|j| own.distance(at(&place, j)));
        let edge = edge.fold(f32::INFINITY, f32::min);
        let up = at(&normals, i).normalize_or_zero();
        let height = up.dot(own - at(&places, i) / count.values[i]) / edge;
        if height.abs() < FLAT { 0.0 } else { height }
    };
    let own = chart.texels_of(&chart.area, &band.rows, field.size);
    own.iter().map(height).collect()
}
