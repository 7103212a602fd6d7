//! From arguments to a bake that is ready to run.

use super::args::Job;
use super::options;
use crate::common::Common;
use crate::host;
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    prepare_for(file, job, common, &[])
}

/// The same of a bake that also writes files for engines.
pub fn prepare_for(
    file: &Path,
    job: &Job,
    common: &Common,
    engines: &[ambake::Engine],
) -> anyhow::Result<ambake::Job> {
    host::set_threads(common.threads)?;
    let started = Instant::now();
    let scene = ambake::load_with(file, common.files())?;
    let loading = started.elapsed().as_secs_f64();
    let bake = options::bake(&scene, job, common)?.for_engines(engines.iter().copied());
    let mut prepared = bake.prepare()?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
