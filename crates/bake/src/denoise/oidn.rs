//! Terms through Intel's denoiser: the page as one picture, its gutters filled, since void would bleed into charts.

use super::{Denoised, Field, Run, Term};
use atlas::Dilation;

/// Rings of the void that are filled for the picture.
const RINGS: u32 = 32;

/// The texels of the term that change. Standard errors stay those of the plain values: the library states none.
///
/// # Panics
/// If the library fails, which took a picture before the bake began ([`oidn::load`]).
pub(crate) fn denoise(field: &Field<'_>, term: &Term<'_>) -> Vec<Denoised> {
    let filled = Dilation::new(field.coverage, field.size as u32, RINGS);
    let planes: Vec<Vec<f32>> = term
        .values
        .iter()
        .map(|values| {
            let mut plane = values.to_vec();
            filled.apply(&mut plane);
            plane
        })
        .collect();
    let texels = field.size * field.size;
    let of = |texel: usize| [0, 1, 2].map(|channel| planes[channel.min(planes.len() - 1)][texel]);
    let picture: Vec<[f32; 3]> = (0..texels).map(of).collect();
    let denoised = oidn::load().and_then(|library| {
        library.denoise(&picture, [field.size; 2], rayon::current_num_threads())
    });
    let denoised = denoised.unwrap_or_else(|error| panic!("{error}"));
    let inexact = |&texel: &usize| field.has_data(texel) && term.std_err[texel] > 0.0;
    let texels: Vec<usize> = (0..texels).filter(inexact).collect();
    let value = |channel: usize, value: [f32; 3]| match planes.len() {
        1 => value.iter().sum::<f32>() / 3.0,
        _ => value[channel],
    };
    let line = |channel: usize| {
        let values = texels.iter().map(|&texel| denoised[texel]);
        values
            .map(|of| value(channel, of).clamp(0.0, term.largest))
            .collect()
    };
    let run = |&texel: &usize| Run {
        first: texel as u32,
        count: 1,
    };
    vec![Denoised {
        values: (0..planes.len()).map(line).collect(),
        std_err: Vec::new(),
        runs: texels.iter().map(run).collect(),
    }]
}
