//! `ambake map convert`: any projection to any.

use super::args::Convert;
use super::file::{Source, Target, picture_size, summary, write};
use crate::host;
use anyhow::Context;
use environment::MapLayout;

/// Runs the sub-verb.
pub fn run(args: &Convert) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let source = Source::read(&args.input)?;
    let size = match args.size {
        Some(size) => picture_size(args.to, size),
        None => args.to.size(source.texels()),
    };
    let to = MapLayout {
        projection: args.to,
        orientation: args.orientation,
        size,
    };
    let image = environment::convert_image(&source.image, source.layout, to)
        .with_context(|| args.input.input.display().to_string())?;
    let normalisation = source.normalisation.as_deref().unwrap_or("radiance");
    let target = Target {
        path: &args.output,
        inputs: &source.inputs,
    };
    let written = write(&target, &[(None, &image)], to, normalisation)?;
    summary(&args.common, &args.input.input, &source, &written)
}
