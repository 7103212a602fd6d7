//! `ambake merge`: the parts of `ambake probes` into their files.

use super::run::{Asked, show, write};
use crate::args::Verb;
use crate::bake::args::Merge;
use crate::bake::shard::{typed, verb};
use crate::outcome::{Outcome, tell};
use crate::progress::watch;
use crate::project::with_own_table;
use crate::stop::Stop;
use ambake::flags::common::Common;
use ambake::{ProbeParts, Probes};
use anyhow::bail;
use std::path::Path;
use std::time::Instant;

/// Writes the files of all parts.
pub fn run(merge: &Merge, dir: &Path, stop: &Stop) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let parts = ProbeParts::find(dir)?;
    let words = with_own_table(typed(parts.given())?)?;
    let Verb::Probes(args) = verb(&words)? else {
        bail!("the parts were not made by `ambake probes`");
    };
    let common = Common {
        threads: merge.common.threads,
        quiet: merge.common.quiet,
        json: merge.common.json,
        verbose: merge.verbose,
        ..args.common
    };
    let asked = Asked::of(&args, &common)?;
    let Asked {
        scene,
        places,
        options,
    } = &asked;
    let merged = watch(show(&common), stop, |progress| {
        Probes::merge(scene, places, options, parts, progress)
    });
    match merged {
        Err(ambake::Error::Cancelled) => {
            if !common.quiet {
                tell("stopped; the parts are still there, merge again");
            }
            Ok(stop.outcome())
        }
        probes => write(&args, &common, dir, probes?, started),
    }
}
