//! Charts that nobody sees.

use crate::measure::triangle_area;
use crate::sheet::Sheet;
use crate::{Seen, SurfacePoint};
use rayon::prelude::*;
use scene::Scene;
use std::collections::{HashMap, HashSet};

/// Points of a chart that are asked for, at least: one that is not seen in so many is taken for hidden.
const POINTS: f64 = 256.0;

/// Of a chart that is seen in part, triangles that are not are cut off where they are this share of its area.
const LEAST_CUT: f64 = 0.125;

/// Marks the charts of which no point is seen in any place where their mesh stands.
///
/// * `cuts`: what is not seen of other charts becomes a chart of its own.
pub(crate) fn hide(sheets: &mut [Sheet], seen: &Seen<'_>, cuts: bool) {
    sheets.par_iter_mut().for_each(|sheet| {
        let of: &Sheet = sheet;
        let unseen = |chart: usize| -> Vec<u32> {
            let (whole, all) = (of.area(chart), &of.charts[chart]);
            let is_unseen =
                |triangle: &&u32| !points(of, whole, **triangle).any(|points| seen(&points));
            match cuts {
                true => all.iter().filter(is_unseen).copied().collect(),
                false if all.iter().all(|triangle| is_unseen(&triangle)) => all.clone(),
                false => Vec::new(),
            }
        };
        let unseen: Vec<Vec<u32>> = (0..of.charts.len()).into_par_iter().map(unseen).collect();
        for (chart, unseen) in unseen.into_iter().enumerate() {
            let area: f64 = unseen.iter().map(|&t| sheet.triangle_area(t)).sum();
            if unseen.len() == sheet.charts[chart].len() {
                sheet.hidden[chart] = true;
            } else if area > 0.0 && area >= LEAST_CUT * sheet.area(chart) {
                sheet.cut_off(chart, unseen);
            }
        }
    });
}

/// Points spread over a triangle of a chart of area `whole`, by place where it stands: as many as its area asks
/// for, one at least.
fn points(
    sheet: &Sheet,
    whole: f64,
    triangle: u32,
) -> impl Iterator<Item = Vec<SurfacePoint>> + '_ {
    let share = sheet.triangle_area(triangle) / whole;
    let count = (share * POINTS).ceil().clamp(1.0, POINTS) as u32;
    let point = move |instance: u32, k: u32| SurfacePoint {
        instance,
        triangle,
        weights: spread(k, count),
    };
    let places = sheet.instances.iter();
    places.map(move |&instance| (0..count).map(|k| point(instance, k)).collect())
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
    /// Scales the charts, or for each instance of several what it has of them, so that of what is seen they have the
    /// area that it has in the world: a file's coordinates may give one chart more than another. The surface in the
    /// world that somebody sees, by instance.
    pub fn fit_seen(&mut self, scene: &Scene) -> Vec<f64> {
        let shown = (0..self.charts.len()).filter(|&chart| !self.hidden[chart]);
        let shown: Vec<u32> = shown
            .flat_map(|chart| &self.charts[chart])
            .copied()
            .collect();
        let flat: f64 = shown.iter().map(|&t| self.triangle_area(t)).sum();
        let surface = |&instance: &u32| -> f64 {
            let areas = shown
                .iter()
                .map(|&t| triangle_area(scene, instance as usize, t as usize));
            areas.sum()
        };
        let surfaces: Vec<f64> = self.instances.iter().map(surface).collect();
        let scales = surfaces.iter().map(|surface| (surface / flat).sqrt());
        let scales: Vec<f64> = scales.collect();
        let are_usable = scales.iter().all(|&scale| scale.is_finite() && scale > 0.0);
        match scales[..] {
            // Where all is seen, the charts have its area as they were made.
            _ if !are_usable || !self.hidden.contains(&true) => {}
            [only] => self.points.iter_mut().for_each(|point| *point *= only),
            _ => self.scales = scales,
        }
        surfaces
    }

    /// Area of all hidden charts on the pages, in texels.
    pub fn hidden_texels(&self) -> f64 {
        let hidden = (0..self.charts.len()).filter(|&c| self.hidden[c]);
        let texels = |chart| self.area(chart) * self.scale(chart, f64::INFINITY).powi(2);
        hidden.map(texels).sum()
    }

    /// Makes a hidden chart of some triangles of another.
    fn cut_off(&mut self, chart: usize, triangles: Vec<u32>) {
        let mut numbers = HashMap::new();
        for &t in &triangles {
            for corner in &mut self.triangles[t as usize] {
                let own = *corner as usize;
                *corner = *numbers.entry(own).or_insert_with(|| {
                    self.points.push(self.points[own]);
                    self.sources.push(self.sources[own]);
                    self.points.len() as u32 - 1
                });
            }
        }
        let off: HashSet<u32> = triangles.iter().copied().collect();
        self.charts[chart].retain(|t| !off.contains(t));
        self.charts.push(triangles);
        self.hidden.push(true);
        self.move_to_origin(chart);
        self.move_to_origin(self.charts.len() - 1);
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
