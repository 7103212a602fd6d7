//! `ambake map`: which sub-verb runs.

use super::args::Args;
use super::{ball, capture, convert, merge, mosaic, reflect, stats};
use crate::outcome::Outcome;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match args {
        Args::Convert(args) => convert::run(args),
        Args::Stats(args) => stats::run(args),
        Args::Diffuse(args) => reflect::diffuse(args),
        Args::Specular(args) => reflect::specular(args),
        Args::Ball(args) => ball::run(args),
        Args::Mosaic(args) => mosaic::run(args),
        Args::Merge(args) => merge::run(args),
        Args::Capture(args) => return capture::run(args),
    }?;
    Ok(Outcome::Done)
}
