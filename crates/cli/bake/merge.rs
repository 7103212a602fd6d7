//! `ambake merge`: the parts of a bake into its files.

use super::args::Merge as Args;
use super::prepare::{Target, prepare_in};
use super::run::{report, tell_written};
use super::shard::{typed, verb};
use crate::args::Verb;
use crate::outcome::{Outcome, tell};
use crate::probes::merge;
use crate::progress::{Show, watch};
use crate::project;
use crate::stop::Stop;
use ambake::flags::common::Common;
use ambake::{Parts, ProbeParts};
use anyhow::{Context, bail};
use std::path::Path;

/// Runs the verb. Probes come after the bake, whose pages they may look up.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    let dir = std::path::absolute(&args.dir).context("cannot tell the current folder")?;
    let has_probes = ProbeParts::are_in(&dir);
    if !has_probes || Parts::are_in(&dir) {
        let outcome = bake(args, &dir, &stop)?;
        if !has_probes || !matches!(outcome, Outcome::Done) {
            return Ok(outcome);
        }
    }
    merge::run(args, &dir, &stop)
}

/// Merges the parts of a bake.
fn bake(args: &Args, dir: &Path, stop: &Stop) -> anyhow::Result<Outcome> {
    let parts = Parts::find(dir)?;
    let typed = typed(parts.given())?;
    let Verb::Bake(bake) = verb(&typed)? else {
        bail!("the parts were not made by `ambake bake`");
    };
    let [scene] = bake.scene.as_slice() else {
        bail!("the parts were made of several scenes; bake them with this program");
    };
    let completed = project::completed(scene, &typed)?;
    let bake = match &completed {
        Some(Verb::Bake(bake)) => bake,
        _ => &bake,
    };
    let common = Common {
        threads: args.common.threads,
        seed: bake.common.seed,
        allow_outside: bake.common.allow_outside,
        quiet: args.common.quiet,
        json: args.common.json,
        verbose: args.verbose,
    };
    let target = Target {
        dir,
        parts: false,
        engines: &bake.engines,
        update: None,
        verify: false,
    };
    let job = prepare_in(&target, scene, &bake.job, &common)?;
    let show = Show {
        unit: "texels",
        quiet: args.common.quiet,
    };
    let written = watch(show, stop, |progress| job.merge(parts, progress));
    match written {
        Err(ambake::Error::Cancelled) => {
            if !args.common.quiet {
                tell("stopped; the parts are still there, merge again");
            }
            Ok(stop.outcome())
        }
        other => {
            let mut written = other?;
            if bake.report {
                report(&mut written, dir)?;
            }
            tell_written(&written, &common, &args.dir)
        }
    }
}
