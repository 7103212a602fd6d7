//! From arguments to a bake that is ready to run.

use super::stdin;
use crate::args::{Verb, words};
use crate::progress::Phases;
use crate::{host, project};
use ambake::flags::bake::{Engines, Job};
use ambake::flags::common::Common;
use ambake::{Bake, Progress, Scene};
use std::path::Path;
use std::time::Instant;

/// Loads the scene, plans its bake, lays its texels out and builds its ray scene. `-` is standard input. A project file
/// beside the scene completes what was typed.
pub fn prepare(file: &Path, job: &Job, common: &Common) -> anyhow::Result<ambake::Job> {
    let completed = project::completed(file, &words())?;
    let completed = completed.as_ref().and_then(Verb::options);
    let (job, common) = completed.unwrap_or((job, common));
    host::set_threads(common.threads)?;
    loaded(|bake, _| bake, file, job, common)
}

/// What a bake into a directory says beside its options.
pub struct Target<'a> {
    pub dir: &'a Path,
    /// True for one part of a bake.
    pub parts: bool,
    pub engines: &'a Engines,
    /// A finished bake that this one updates, and whether what is kept of it is tried.
    pub update: Option<&'a Path>,
    pub verify: bool,
}

/// The same for a bake into a directory, by arguments that the project file has completed: a layout that `ambake
/// layout` left there is taken, and what does not fit into memory is refused.
pub fn prepare_in(
    target: &Target<'_>,
    file: &Path,
    job: &Job,
    common: &Common,
) -> anyhow::Result<ambake::Job> {
    host::set_threads(common.threads)?;
    let with = |bake: Bake, scene: &Scene| target.complete(bake, scene);
    loaded(with, file, job, common)
}

impl Target<'_> {
    fn complete(&self, bake: Bake, scene: &Scene) -> Bake {
        let bake = bake
            .for_engines(self.engines.engines.iter().copied())
            .compress(self.engines.compress)
            .layout_file(ambake::Layout::path(self.dir, scene))
            .verify(self.verify);
        let bake = match self.update {
            Some(dir) => bake.update(dir),
            None => bake,
        };
        match self.parts {
            true => bake.within_memory().in_parts(),
            false => bake.within_memory(),
        }
    }
}

fn loaded(
    with: impl FnOnce(Bake, &Scene) -> Bake,
    file: &Path,
    job: &Job,
    common: &Common,
) -> anyhow::Result<ambake::Job> {
    let started = Instant::now();
    let phases = Phases::new(common.quiet);
    phases.phase("reading");
    let scene = match file == Path::new("-") {
        true => stdin::load()?,
        false => ambake::load_with(file, common.files())?,
    };
    let loading = started.elapsed().as_secs_f64();
    let bake = job.bake(&scene, common)?;
    let mut prepared = with(bake, &scene).prepare_with(&phases)?;
    prepared.add_phase("load", loading);
    Ok(prepared)
}
