//! From arguments to a bake that is ready to run.

use super::args::Job;
use super::{options, stdin};
use crate::common::Common;
use crate::{host, project};
use std::ffi::OsString;
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene. `-` is standard input. A project file beside
/// the scene completes what was typed.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    let typed: Vec<OsString> = std::env::args_os().collect();
    prepare_in(None, &typed, file, job, common, &[])
}

/// The same of a bake that also writes files for engines; a layout that `ambake layout` left in `dir` is taken. `typed` is the command
/// line that asks for it.
pub fn prepare_in(
    dir: Option<&Path>,
    typed: &[OsString],
    file: &Path,
    job: &Job,
    common: &Common,
    engines: &[ambake::Engine],
) -> anyhow::Result<ambake::Job> {
    let completed = project::completed(file, typed)?;
    let (job, common) = match &completed {
        Some((job, common)) => (job, common),
        None => (job, common),
    };
    host::set_threads(common.threads)?;
    let started = Instant::now();
    let scene = match file == Path::new("-") {
        true => stdin::load()?,
        false => ambake::load_with(file, common.files())?,
    };
    let loading = started.elapsed().as_secs_f64();
    let mut bake = options::bake(&scene, job, common)?.for_engines(engines.iter().copied());
    if let Some(dir) = dir {
        bake = bake.layout_file(ambake::Layout::path(dir, &scene));
    }
    let mut prepared = bake.prepare()?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
