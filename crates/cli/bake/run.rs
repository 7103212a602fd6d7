//! `ambake bake`: scene in, lightmaps out.

use super::args::Bake as Args;
use super::prepare::prepare_for;
use super::summary::summary;
use crate::outcome::{Outcome, say};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use report::Output;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    // A directory that cannot be written is found before the scene is loaded.
    Output::create(&args.output)?;
    let job = prepare_for(&args.scene, &args.job, &args.common, &args.engines)?;
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
    if args.common.json {
        say(&(written.report.to_json() + "\n"))?;
    } else if !args.common.quiet {
        say(&summary(
            &written.report,
            args.common.verbose,
            written.files.len(),
            &args.output,
        ))?;
    }
    Ok(Outcome::Done)
}
