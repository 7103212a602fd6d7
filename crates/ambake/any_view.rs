//! The files that go with layers for any view.

use crate::error::Error;
use crate::job::Job;
use ::bake::{KernelTable, Model};
use layers::Layer;
use report::{AnyViewReport, Output};

/// Stages kernels and shaders where a layer for any view is asked for, and returns what `bake.json` says of it.
pub(crate) fn stage(
    job: &Job,
    output: &mut Output,
    stem: &str,
) -> Result<Option<AnyViewReport>, Error> {
    let options = job.baker_options();
    let errors = options.any_view_errors(&job.scene().0);
    let (Some(order), Some(errors)) = (options.any_view(), errors) else {
        return Ok(None);
    };
    let microfacets = job.options().model == Some(Model::Ggx);
    let table = KernelTable::new(order, microfacets);
    report::stage_any_view(output, stem, order as u32, table.columns(), table.values)?;
    let layers = job.options().layers.iter();
    let numbers: usize = layers
        .filter(|layer| layer.is_any_view())
        .map(|layer| layer.channels().len())
        .sum();
    let [kernel, glsl, wgsl] = report::any_view_files(stem);
    let row = match microfacets {
        false => "4 log2(exponent + 1), 0..32",
        true => "32 sqrt(alpha), 0..32",
    };
    let harmonics = match order {
        8 => Layer::AnyView8,
        _ => Layer::AnyView,
    };
    Ok(Some(AnyViewReport {
        order: order as u32,
        numbers: harmonics.channels().len() as u32,
        exponent: errors.exponent,
        truncation: errors.truncation,
        noise: errors.noise,
        bytes_per_texel: 2 * numbers as u32,
        kernel,
        row: row.into(),
        shaders: vec![glsl, wgsl],
    }))
}
