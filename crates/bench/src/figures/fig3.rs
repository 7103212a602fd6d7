//! Fig. 3 of X. Zhang, Y. Gao, ICIP 2009: one scene in ambient light only, by the three ambient models.

use glam::DVec3;
use maps::Image;
use render::{Camera, Direct, Model, Sample, picture};
use std::fmt::Write;

/// The pictures of the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Fig3 {
    /// (a) traditional, (b) Lambert, (c) Phong.
    pub models: [Image; 3],
    /// b - a and c - b, signed.
    pub differences: [Image; 2],
    /// Share of each pixel's camera samples that meet a surface.
    pub coverage: Vec<f32>,
}

/// The names of the models, then of the differences.
const NAMES: [&str; 5] = [
    "traditional",
    "lambert",
    "phong",
    "lambert-traditional",
    "phong-lambert",
];

/// The figure as `direct` sees it: its model is replaced, its lights are left out.
///
/// All models get the same sample streams, so that c - b is the specular term alone.
pub fn fig3(direct: &mut Direct<'_>, camera: &Camera, grid: u32) -> Fig3 {
    direct.lights = &[];
    let models = [Model::Traditional, Model::Lambert, Model::Phong].map(|model| {
        direct.model = model;
        picture(camera, grid, |sample| direct.radiance(sample))
    });
    let meets = |sample: &Sample| DVec3::splat(f64::from(u8::from(direct.meets(sample))));
    let coverage = picture(camera, grid, meets).pixels;
    let [a, b, c] = &models;
    Fig3 {
        differences: [minus(b, a), minus(c, b)],
        coverage: coverage.into_iter().map(|[share, ..]| share).collect(),
        models,
    }
}

impl Fig3 {
    /// Every picture with its name.
    pub fn pictures(&self) -> impl Iterator<Item = (&'static str, &Image)> {
        let all = self.models.iter().chain(&self.differences);
        NAMES.into_iter().zip(all)
    }

    /// Mean, minimum and maximum of each picture over the pixels that surfaces fill, as CSV with a head.
    pub fn csv(&self) -> String {
        let mut text = String::from("picture,pixels,mean_r,mean_g,mean_b,minimum,maximum\n");
        for (name, image) in self.pictures() {
            let shown = image.pixels.iter().zip(&self.coverage);
            let shown: Vec<_> = shown.filter(|(_, c)| **c == 1.0).map(|(p, _)| p).collect();
            let count = shown.len();
            let mean = |channel: usize| {
                let sum: f64 = shown.iter().map(|p| f64::from(p[channel])).sum();
                sum / count.max(1) as f64
            };
            let values = shown.iter().flat_map(|p| p.iter().copied());
            let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            let [r, g, b] = [0, 1, 2].map(mean);
            let _ = writeln!(text, "{name},{count},{r:.6},{g:.6},{b:.6},{low},{high}");
        }
        text
    }
}

fn minus(a: &Image, b: &Image) -> Image {
    let pairs = a.pixels.iter().zip(&b.pixels);
    Image {
        width: a.width,
        height: a.height,
        pixels: pairs
            .map(|(a, b)| std::array::from_fn(|c| a[c] - b[c]))
            .collect(),
    }
}
