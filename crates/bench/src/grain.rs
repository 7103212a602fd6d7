//! Grain: bakes of few rays, plain and denoised, against one of many rays.

use crate::Subject;
use crate::clock::time;
use bake::{BakedPage, Denoise, Effort, Options};
use layers::Layer;
use rays::RayBackend;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rays of the reference, and its seed.
const REFERENCE: (u32, u64) = (4096, 0x5eed);

/// Rays of the rows.
const RAYS: [u32; 6] = [16, 32, 64, 128, 256, 1024];

/// Edge of the blocks whose means show stains, and the least texels of one object that a mean is taken of.
const BLOCK: usize = 8;
const LEAST: f64 = 32.0;

/// One bake held against the reference, all of the diffuse term.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Row {
    /// Rays a texel.
    pub rays: u32,
    /// Whether the page was denoised.
    pub denoised: bool,
    /// Root mean square error, without what the reference adds by its own.
    pub rmse: f64,
    /// Root mean square of the stated standard errors.
    pub stated: f64,
    /// Share of the texels within 1.96 standard errors of texel and reference.
    pub covered: f64,
    /// Mean error.
    pub bias: f64,
    /// Root mean square error of the means over blocks of 8 x 8 texels of one object: stains.
    pub blocks: f64,
    /// Error that one texel in a thousand exceeds.
    pub thousandth: f64,
    /// The largest error.
    pub worst: f64,
    /// CPU seconds of the bake.
    pub cpu_seconds: f64,
}

/// Bakes page 0 with few rays, plain and denoised.
pub fn grain(subject: Subject<'_>, backend: &dyn RayBackend, options: &Options) -> Vec<Row> {
    let bake = |denoise, rays, seed| {
        let options = Options {
            effort: Effort::Rays(rays),
            denoise,
            seed,
            layers: vec![
                Layer::Coverage,
                Layer::Diffuse,
                Layer::StdErrDiffuse,
                Layer::Object,
                Layer::Validity,
            ],
            ..options.clone()
        };
        time(|| subject.bake(backend, &options))
    };
    let (reference, _) = bake(Denoise::Off, REFERENCE.0, REFERENCE.1);
    let mut rows = Vec::new();
    for rays in RAYS {
        for denoise in [Denoise::Off, Denoise::Regression] {
            let (page, spent) = bake(denoise, rays, options.seed);
            rows.push(Row {
                rays,
                denoised: denoise != Denoise::Off,
                cpu_seconds: spent.cpu,
                ..judge(&page, &reference)
            });
        }
    }
    rows
}

/// The errors of a page against the reference, over texels that can be seen.
fn judge(page: &BakedPage, reference: &BakedPage) -> Row {
    let plane = |page: &'_ BakedPage, layer| page.layer(layer).unwrap_or_default().to_vec();
    let [coverage, value, std_err, object, validity] = [
        Layer::Coverage,
        Layer::Diffuse,
        Layer::StdErrDiffuse,
        Layer::Object,
        Layer::Validity,
    ]
    .map(|layer| plane(page, layer));
    let [truth, own] = [Layer::Diffuse, Layer::StdErrDiffuse].map(|layer| plane(reference, layer));
    let size = page.size as usize;
    let (mut squares, mut stated, mut inside, mut sum) = (0.0, 0.0, 0.0, 0.0);
    let mut errors = Vec::new();
    // Sums of errors, of texels and of the reference's variances.
    let mut blocks: BTreeMap<(usize, usize, u32), [f64; 3]> = BTreeMap::new();
    let seen = |i: &usize| coverage[*i] > 0.0 && validity[*i] > 0.0;
    for i in (0..size * size).filter(seen) {
        let error = f64::from(value[i]) - f64::from(truth[i]);
        let [std_err, own] = [std_err[i], own[i]].map(f64::from);
        squares += error * error - own * own;
        stated += std_err * std_err;
        inside += f64::from(u8::from(error.abs() <= 1.96 * std_err.hypot(own)));
        sum += error;
        errors.push(error.abs());
        let place = (i / size / BLOCK, i % size / BLOCK, object[i] as u32);
        let block = blocks.entry(place).or_default();
        for (total, part) in block.iter_mut().zip([error, 1.0, own * own]) {
            *total += part;
        }
    }
    errors.sort_by(f64::total_cmp);
    let count = errors.len().max(1) as f64;
    let whole: Vec<f64> = blocks
        .values()
        .filter(|block| block[1] >= LEAST)
        .map(|[error, texels, own]| (error * error - own) / (texels * texels))
        .collect();
    let root = |mean: f64| mean.max(0.0).sqrt();
    Row {
        rays: 0,
        denoised: false,
        rmse: root(squares / count),
        stated: root(stated / count),
        covered: inside / count,
        bias: sum / count,
        blocks: root(whole.iter().sum::<f64>() / whole.len().max(1) as f64),
        thousandth: errors
            .get(errors.len() * 999 / 1000)
            .copied()
            .unwrap_or(0.0),
        worst: errors.last().copied().unwrap_or(0.0),
        cpu_seconds: 0.0,
    }
}

/// The rows as a Markdown table: a line for each number of rays, the plain bake before the denoised one.
pub fn markdown(title: &str, rows: &[Row]) -> String {
    let mut text = format!(
        "{title}; plain > denoised, against {} rays\n\n\
         | rays | RMSE | stated | within 1.96 errors | mean error | means of 8 x 8 | 1 in 1,000 above | worst \
         | CPU s |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        REFERENCE.0
    );
    for pair in rows.chunks(2) {
        let both =
            |of: &dyn Fn(&Row) -> String| pair.iter().map(of).collect::<Vec<_>>().join(" > ");
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
            pair[0].rays,
            both(&|row| format!("{:.4}", row.rmse)),
            both(&|row| format!("{:.4}", row.stated)),
            both(&|row| format!("{:.3}", row.covered)),
            both(&|row| format!("{:+.5}", row.bias)),
            both(&|row| format!("{:.5}", row.blocks)),
            both(&|row| format!("{:.3}", row.thousandth)),
            both(&|row| format!("{:.2}", row.worst)),
            both(&|row| format!("{:.2}", row.cpu_seconds)),
        );
    }
    text
}
