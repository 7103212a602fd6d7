//! `ambake render`: the scene is loaded, then a picture, frames or a figure are made.

use super::args::Args;
use super::{figures, file, frames, options, picture};
use crate::common::build;
use crate::host;
use crate::outcome::Outcome;
use crate::stop::Stop;
use ::render::Lightmap;
use std::time::Instant;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let stop = Stop::listen()?;
    let threads = host::set_threads(args.common.threads)?;
    if args.figure.is_none() {
        for path in &args.output {
            file::ending(path)?;
        }
    }
    let (scene, lightmap) = match &args.bake {
        None => (scene::load_with(&args.scene, args.common.files())?, None),
        Some(dir) => {
            let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy();
            let layer = options::model(args.model).name();
            let (scene, map) = Lightmap::load(dir, &stem, layer)?;
            (scene, Some(map))
        }
    };
    let (world, backend) = build(scene, args.backend, threads)?;
    let backend = backend.as_ref();
    if let Some(figure) = args.figure {
        return figures::draw(figure, args, &world, backend, &stop);
    }
    if args.tables.asked() {
        return frames::draw(args, &world, backend, &stop, started);
    }
    picture::draw(args, &world, backend, lightmap.as_ref(), &stop, started)
}
