//! Fig. 3 of X. Zhang, Y. Gao, ICIP 2009: one scene in ambient light only, by its three ambient models; beside them the
//! closed form of their section 4 times occlusion, and the microfacets that they name as future work.

use environment::{Format, Image, Labels};
use glam::DVec3;
use layers::Progress;
use render::{Camera, Direct, Error, Model, Part, Sample, picture};
use std::fmt::Write;

/// The pictures of the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Fig3 {
    /// Traditional, Lambert, Phong, traditional with the closed form, microfacets.
    pub models: [Image; MODELS.len()],
    /// Lambert - traditional, Phong - Lambert, Phong - closed form, microfacets - Phong, signed.
    pub differences: [Image; DIFFERENCES.len()],
    /// Share of each pixel's camera samples that meet a surface.
    pub coverage: Vec<f32>,
}

/// The models of the figure.
const MODELS: [Model; 5] = [
    Model::Traditional,
    Model::Lambert,
    Model::Phong,
    Model::TraditionalClosed,
    Model::Ggx,
];

/// Which pictures are subtracted, the second from the first, as places in [`MODELS`].
const DIFFERENCES: [[usize; 2]; 4] = [[1, 0], [2, 1], [2, 3], [4, 2]];

/// The figure as `direct` sees it: its model is replaced, its lights are left out.
///
/// All models get the same sample streams, so that Phong - Lambert is the specular term alone. `progress` hears of the
/// pixels of the models and of the coverage.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn fig3(
    direct: &mut Direct<'_>,
    camera: &Camera,
    grid: u32,
    progress: &dyn Progress,
) -> Result<Fig3, Error> {
    direct.lights = &[];
    let part = |index| Part {
        whole: progress,
        index,
        count: MODELS.len() as u64 + 1,
    };
    let mut shot = |model, index| {
        direct.model = model;
        picture(camera, grid, &part(index), |sample| direct.radiance(sample))
    };
    let [a, b, c, d, e] = MODELS;
    let models = [
        shot(a, 0)?,
        shot(b, 1)?,
        shot(c, 2)?,
        shot(d, 3)?,
        shot(e, 4)?,
    ];
    let coverage = |sample: &Sample| DVec3::splat(f64::from(direct.coverage(sample)));
    let coverage = picture(camera, grid, &part(5), coverage)?.pixels;
    Ok(Fig3 {
        differences: DIFFERENCES.map(|[more, less]| minus(&models[more], &models[less])),
        coverage: coverage.into_iter().map(|[share, ..]| share).collect(),
        models,
    })
}

impl Fig3 {
    /// Every picture with its name.
    pub fn pictures(&self) -> impl Iterator<Item = (String, &Image)> {
        let models = MODELS.map(|model| model.name().to_owned());
        let differences = DIFFERENCES.map(|pair| pair.map(|at| MODELS[at].name()).join("-"));
        let all = self.models.iter().chain(&self.differences);
        models.into_iter().chain(differences).zip(all)
    }

    /// The files of the figure, names and bytes: every picture as EXR with these labels, the models as PNG in sRGB, the
    /// differences as PNG in colours about white with a scale, and the table of [`Fig3::csv`].
    ///
    /// # Errors
    /// [`environment::Error::Encode`] where a value is not finite, which would be a fault of ours.
    pub fn files(&self, labels: &Labels) -> Result<Vec<(String, Vec<u8>)>, environment::Error> {
        let mut files = vec![("fig3.csv".to_owned(), self.csv().into_bytes())];
        for (number, (name, image)) in self.pictures().enumerate() {
            let exr = environment::encode(image, Format::Exr, labels)?;
            files.push((format!("fig3_{name}.exr"), exr));
            let png = match number < self.models.len() {
                true => report::picture_png(image.width, &image.pixels),
                false => difference_png(&name, image),
            };
            files.push((format!("fig3_{name}.png"), png));
        }
        Ok(files)
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

/// Of each pixel the channel that differs most.
fn difference_png(name: &str, image: &Image) -> Vec<u8> {
    let farther = |most: f32, &v: &f32| if v.abs() > most.abs() { v } else { most };
    let value = |pixel: &[f32; 3]| f64::from(pixel.iter().fold(0.0, farther));
    let most = image.pixels.iter().map(|p| value(p).abs());
    let limit = report::nice_limit(most.fold(0.0, f64::max));
    let title = name.replace('-', " - ");
    let size = [image.width as u32, image.height as u32];
    report::difference_picture(size, &title, limit, |at| Some(value(&image.pixels[at])))
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
