//! From arguments to a bake that is ready to run.

use super::args::Job;
use super::options;
use crate::common::Common;
use crate::host;
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    prepare_in(None, file, job, common, &[])
}

/// The same of a bake that also writes files for engines; a layout that `ambake layout` left in `dir` is taken.
pub fn prepare_in(
    dir: Option<&Path>,
    file: &Path,
    job: &Job,
    common: &Common,
    engines: &[ambake::Engine],
) -> anyhow::Result<ambake::Job> {
    host::set_threads(common.threads)?;
    let started = Instant::now();
    let scene = ambake::load_with(file, common.files())?;
    let loading = started.elapsed().as_secs_f64();
    let mut bake = options::bake(&scene, job, common)?.for_engines(engines.iter().copied());
    if let Some(dir) = dir {
        bake = bake.layout_file(ambake::Layout::path(dir, &scene));
    }
    let mut prepared = bake.prepare()?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
