//! From arguments to a bake that is ready to run.

use super::args::Job;
use super::{options, stdin};
use crate::common::Common;
use crate::{host, project};
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene. `-` is standard input. A project file beside
/// the scene completes what was typed.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    let completed = project::completed(file)?;
    let (job, common) = match &completed {
        Some((job, common)) => (job, common),
        None => (job, common),
    };
    host::set_threads(common.threads)?;
    let started = Instant::now();
    let scene = match file == Path::new("-") {
        true => stdin::load()?,
        false => ambake::load(file)?,
    };
    let loading = started.elapsed().as_secs_f64();
    let mut prepared = options::bake(&scene, job, common)?.prepare()?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
