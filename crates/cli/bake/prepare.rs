//! From arguments to a bake that is ready to run.

use super::args::Job;
use super::options;
use crate::common::Common;
use crate::host;
use ambake::{Bake, Scene};
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    prepare_with(|bake, _| bake, file, job, common)
}

/// The same for a bake into `dir`: a layout that `ambake layout` left there is taken, and what does not fit into memory is refused.
pub fn prepare_in(
    dir: &Path,
    parts: bool,
    file: &Path,
    job: &Job,
    common: &Common,
) -> anyhow::Result<ambake::Job> {
    let with = |bake: Bake, scene: &Scene| {
        let bake = bake.layout_file(ambake::Layout::path(dir, scene));
        match parts {
            true => bake.within_memory().in_parts(),
            false => bake.within_memory(),
        }
    };
    prepare_with(with, file, job, common)
}

fn prepare_with(
    with: impl FnOnce(Bake, &Scene) -> Bake,
    file: &Path,
    job: &Job,
    common: &Common,
) -> anyhow::Result<ambake::Job> {
    host::set_threads(common.threads)?;
    let started = Instant::now();
    let scene = ambake::load(file)?;
    let loading = started.elapsed().as_secs_f64();
    let bake = options::bake(&scene, job, common)?;
    let mut prepared = with(bake, &scene).prepare()?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
