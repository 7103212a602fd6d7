//! The charts of a mesh that stands in several places: one arrangement, of which each place has a rectangle.

use crate::pack::{Frame, Shape, Spot, pack};
use crate::share::Limits;
use crate::sheet::Sheet;
use glam::DVec2;

/// Instances of one mesh differ at most so much in their texels: smaller ones are laid out larger than asked, for all
/// share one layout, whose gutter is wide enough for the smallest and this much wider in the largest.
const SPREAD: f64 = 16.0;
/// Smallest texels that are tried, from those of the largest instance down, and the step from one to the next.
const TRIES: i32 = 8;
const STEP: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Beyond four times the density of others they have it only where all then take less than this share of the texels.
const SAVED: f64 = 0.97;

/// The charts of a mesh that stands in several places, arranged once for all of them.
pub(crate) struct Tile {
    /// Texels per mesh unit at which it was arranged: that of the smallest instance.
    pub scale: f64,
    /// Texels per mesh unit of each instance.
    pub scales: Vec<f64>,
    pub spots: Vec<Spot>,
    /// Texels in use at `scale`.
    pub extent: DVec2,
}

impl Tile {
    /// Of a sheet whose instances have these limits.
    pub fn of(sheet: &Sheet, gutter: u32, limits: impl Fn(u32) -> Limits) -> Tile {
        let limits: Vec<Limits> = sheet.instances.iter().map(|&i| limits(i)).collect();
        let all = || sheet.scales.iter().zip(&limits);
        let mut scales: Vec<f64> = all().map(|(scale, own)| scale * own.density).collect();
        let most = all().map(|(scale, own)| scale * own.most);
        let last = all().map(|(scale, own)| scale * own.last);
        let [most, last] = [
            most.fold(f64::INFINITY, f64::min),
            last.fold(f64::INFINITY, f64::min),
        ];
        let scale = sheet.least_scale(gutter, &scales, [most, last]);
        for own in &mut scales {
            *own = own.max(scale);
        }
        let shapes = sheet.shapes(scale, false);
        let all: Vec<usize> = (0..shapes.len()).collect();
        let area: u64 = shapes.iter().map(|s| s[0].grown_area(gutter)).sum();
        let widest = shapes
            .iter()
            .map(|s| s[0].width.max(s[0].height))
            .max()
            .unwrap_or(1);
        let mut edge = ((area as f64).sqrt() as u32)
            .saturating_sub(2 * gutter)
            .max(1);
        let spots = loop {
            let (width, height) = (edge.max(widest), edge.max(widest));
            match pack(
                &shapes,
                &all,
                Frame {
                    width,
                    height,
                    gutter,
                    border: 0,
                },
            ) {
                Ok(spots) => break spots,
                Err(_) => edge += 1 + edge / 32,
            }
        };
        let end = |(spot, shape): (&Spot, &Shape)| {
            let mask = &shape[spot.turn as usize];
            DVec2::new(
                f64::from(spot.x + mask.width),
                f64::from(spot.y + mask.height),
            )
        };
        let extent = spots
            .iter()
            .zip(&shapes)
            .map(end)
            .fold(DVec2::ONE, DVec2::max);
        Tile {
            scale,
            scales,
            spots,
            extent,
        }
    }
}

impl Sheet {
    /// The texels per mesh unit that an instance gets at least, so that all take the least area together. The gutter of
    /// the smallest grows with the instance; so one that is small beside the others had better be laid out larger than
    /// asked: up to `most`, up to `last` where that saves enough, and in any case at a sixteenth of the largest.
    fn least_scale(&self, gutter: u32, scales: &[f64], [most, last]: [f64; 2]) -> f64 {
        let limits = (f64::INFINITY, 0.0f64);
        let around = |(low, high): (f64, f64), &scale: &f64| (low.min(scale), high.max(scale));
        let (smallest, largest) = scales.iter().fold(limits, around);
        let smallest = smallest.max(largest / SPREAD);
        let area = |least: f64| {
            let grown = |chart: usize| {
                let sides = self.size(chart, least);
                sides
                    .map(|side| f64::from(side + gutter))
                    .iter()
                    .product::<f64>()
            };
            let one: f64 = (0..self.charts.len()).map(grown).sum();
            let times = scales
                .iter()
                .map(|scale| (scale.max(least) / least).powi(2));
            one * times.sum::<f64>()
        };
        let best = |limit: f64| {
            let steps = (0..TRIES).map(|k| largest * STEP.powi(k));
            let tried = steps.chain([limit.min(largest)]);
            let tried = tried.filter(|&least| least > smallest && least <= limit);
            let measured = std::iter::once(smallest)
                .chain(tried)
                .map(|least| (area(least), least));
            measured
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap_or((0.0, smallest))
        };
        let (within, beyond) = (best(most), best(last));
        if beyond.0 < SAVED * within.0 {
            beyond.1
        } else {
            within.1
        }
    }
}
