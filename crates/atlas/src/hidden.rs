//! Charts that nobody sees.

use crate::charts::Sheet;
use crate::{Seen, SurfacePoint};
use rayon::prelude::*;

/// Points of a chart that are asked for, at least: one that is not seen in so many is taken for hidden.
const POINTS: f64 = 256.0;

/// Marks the charts of which no point is seen in any place where their mesh stands.
pub(crate) fn hide(sheets: &mut [Sheet], seen: &Seen<'_>) {
    sheets.par_iter_mut().for_each(|sheet| {
        let of: &Sheet = sheet;
        let hidden = |chart: usize| !points(of, chart).any(|points| seen(&points));
        let hidden = (0..of.charts.len()).into_par_iter().map(hidden).collect();
        sheet.hidden = hidden;
    });
}

/// Points spread over a chart, by triangle and by place where it stands: as many in a triangle as its area asks for, one at least.
fn points(sheet: &Sheet, chart: usize) -> impl Iterator<Item = Vec<SurfacePoint>> + '_ {
    let whole = sheet.area(chart);
    sheet.charts[chart].iter().flat_map(move |&triangle| {
        let share = sheet.triangle_area(triangle) / whole;
        let count = (share * POINTS).ceil().clamp(1.0, POINTS) as u32;
        let point = move |instance: u32, k: u32| SurfacePoint {
            instance,
            triangle,
            weights: spread(k, count),
        };
        let places = sheet.instances.iter();
        places.map(move |&instance| (0..count).map(|k| point(instance, k)).collect())
    })
}

/// Weights of point `k` of `count`, spread evenly over a triangle: the sequence of the plastic number (M. Roberts, "The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018), folded; the middle where there is one.
fn spread(k: u32, count: u32) -> [f64; 3] {
    if count == 1 {
        return [1.0 / 3.0; 3];
    }
    let step = |a: f64| (0.5 + a * f64::from(k + 1)).fract();
    let (u, v) = (step(0.754_877_666_246_692_8), step(0.569_840_290_998_053_3));
    let (u, v) = if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    };
    [1.0 - u - v, u, v]
}

impl Sheet {
    /// Area of all hidden charts, in square mesh units.
    pub fn hidden_area(&self) -> f64 {
        let hidden = (0..self.charts.len()).filter(|&c| self.hidden[c]);
        hidden.map(|chart| self.area(chart)).sum()
    }

    fn area(&self, chart: usize) -> f64 {
        self.charts[chart]
            .iter()
            .map(|&t| self.triangle_area(t))
            .sum()
    }

    fn triangle_area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.triangles[triangle as usize].map(|v| self.points[v as usize]);
        0.5 * (b - a).perp_dot(c - a).abs()
    }
}
