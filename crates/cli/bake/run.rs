//! `ambake bake`: scene in, lightmaps out.

use super::args::Bake as Args;
use super::prepare::prepare_for;
use super::summary::summary;
use crate::outcome::{Outcome, say, say_json_text, tell};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use report::Output;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    // A directory that cannot be written, or is another bake's, is found before the scene is loaded.
    drop(Output::exclusive(&args.output)?);
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
                tell("stopped; continue with the same command and --resume");
            }
            return Ok(stop.outcome());
        }
        other => other?,
    };
    if args.common.json {
        say_json_text(&written.report.to_json())?;
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
