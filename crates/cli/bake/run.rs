//! `ambake bake`: scene in, lightmaps out.

use super::args::Bake as Args;
use super::prepare::prepare_in;
use super::shard;
use super::summary::summary;
use crate::common::Common;
use crate::outcome::{Outcome, say};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use ambake::Written;
use report::Output;
use std::path::Path;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    // A directory that cannot be written is found before the scene is loaded.
    Output::create(&args.output)?;
    let job = prepare_in(
        &args.output,
        args.shard.is_some(),
        &args.scene,
        &args.job,
        &args.common,
    )?;
    if let Some(part) = args.shard {
        return shard::run(args, &job, part, &stop);
    }
    let show = Show {
        unit: "texels",
        quiet: args.common.quiet,
    };
    let written = watch(show, &stop, |progress| {
        job.run_into(&args.output, args.resume, progress)
    });
    let written = match written {
        Err(ambake::Error::Cancelled) => {
            if !args.common.quiet {
                eprintln!("ambake: stopped; continue with the same command and --resume");
            }
            return Ok(stop.outcome());
        }
        other => other?,
    };
    tell(&written, &args.common, &args.output)
}

/// Says what was written.
pub fn tell(written: &Written, common: &Common, dir: &Path) -> anyhow::Result<Outcome> {
    if common.json {
        say(&(written.report.to_json() + "\n"))?;
    } else if !common.quiet {
        let files = written.files.len();
        say(&summary(&written.report, common.verbose, files, dir))?;
    }
    Ok(Outcome::Done)
}
