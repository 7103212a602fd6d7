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
    let texels = field.size * field.size;
    let inexact = |&texel: &usize| field.has_data(texel) && term.std_err[texel] > 0.0;
    let changed: Vec<usize> = (0..texels).filter(inexact).collect();
    let run = |&texel: &usize| Run {
        first: texel as u32,
        count: 1,
    };
    // A picture of the values, and one of each rider.
    let pictures = std::iter::once(&term.values[..]).chain(term.riders.chunks(1));
    let lines =
        pictures.flat_map(|planes| picture(planes, field.size, &filled, term.largest, &changed));
    vec![Denoised {
        values: lines.collect(),
        std_err: Vec::new(),
        runs: changed.iter().map(run).collect(),
    }]
}

/// The texels that change of one to three planes.
fn picture(
    planes: &[&[f32]],
    size: usize,
    filled: &Dilation,
    largest: f32,
    changed: &[usize],
) -> Vec<Vec<f32>> {
    let fill = |values: &&[f32]| {
        let mut plane = values.to_vec();
        filled.apply(&mut plane);
        plane
    };
    let planes: Vec<Vec<f32>> = planes.iter().map(fill).collect();
    let of = |texel: usize| [0, 1, 2].map(|channel| planes[channel.min(planes.len() - 1)][texel]);
    let picture: Vec<[f32; 3]> = (0..size * size).map(of).collect();
    let denoised = oidn::load()
        .and_then(|library| library.denoise(&picture, [size; 2], rayon::current_num_threads()));
    let denoised = denoised.unwrap_or_else(|error| panic!("{error}"));
    let value = |channel: usize, value: [f32; 3]| match planes.len() {
        1 => value.iter().sum::<f32>() / 3.0,
        _ => value[channel],
    };
    let line = |channel: usize| {
        let values = changed.iter().map(|&texel| denoised[texel]);
        values
            .map(|of| value(channel, of).clamp(0.0, largest))
            .collect()
    };
    (0..planes.len()).map(line).collect()
}
