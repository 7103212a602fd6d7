//! `ambake probes --shard I/N`: one part of the probes; and all parts into their files.

use super::args::Args;
use super::run::{Asked, show, write};
use crate::args::Verb;
use crate::bake::args::Merge;
use crate::bake::merge::{typed, verb};
use crate::bake::shard::{finish, given, unless_stopped};
use crate::outcome::{Outcome, tell};
use crate::progress::watch;
use crate::project::with_own_table;
use crate::stop::Stop;
use ambake::flags::common::Common;
use ambake::{ProbeParts, Probes, Shard};
use anyhow::bail;
use serde_json::json;
use std::path::Path;
use std::time::Instant;

/// Gathers the part.
pub fn run(args: &Args, asked: &Asked, shard: Shard, stop: &Stop) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let given = given()?;
    let place = (args.output.as_path(), shard, &given);
    let part = watch(show(&args.common), stop, |progress| {
        Probes::gather_shard(&asked.scene, &asked.places, &asked.options, place, progress)
    });
    let Some(part) = unless_stopped(part, &args.common)? else {
        return Ok(stop.outcome());
    };
    let facts = json!({"places": part.places, "faces": part.faces});
    let words = format!("{} places, {} faces", part.places, part.faces);
    let of = (shard, part.path.as_path(), part.already);
    finish(&args.common, of, (facts, &words), started)
}

/// Writes the files of all parts.
pub fn merge(merge: &Merge, dir: &Path, stop: &Stop) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let parts = ProbeParts::find(dir)?;
    // The words may name files from the folder that they were given in. Where that is absent here, so are the files,
    // and the scene's error says so.
    if let Some(folder) = parts.given()["folder"].as_str() {
        let _ = std::env::set_current_dir(folder);
    }
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
