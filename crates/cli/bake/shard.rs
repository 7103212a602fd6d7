//! `ambake bake --shard I/N`: one part of a bake.

use super::args::Bake as Args;
use crate::args::words;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use ambake::{Job, Shard};
use anyhow::Context;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Bakes the part.
pub fn run(
    args: &Args,
    output: &Path,
    job: &Job,
    shard: Shard,
    stop: &Stop,
) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let given = given()?;
    let show = Show {
        unit: "texels",
        quiet: args.common.quiet,
    };
    let part = watch(show, stop, |progress| {
        job.run_shard(output, shard, &given, progress)
    });
    let part = match part {
        Err(ambake::Error::Cancelled) => {
            if !args.common.quiet {
                tell("stopped; the same command continues");
            }
            return Ok(stop.outcome());
        }
        other => other?,
    };
    let seconds = started.elapsed().as_secs_f64();
    if args.common.json {
        say_json(&json!({
            "schema_version": 1,
            "shard": shard.index,
            "of": shard.of,
            "file": part.path.file_name().map(|name| name.to_string_lossy()),
            "already": part.already,
            "tiles": part.tiles,
            "texels": part.texels,
            "rays": part.rays,
            "share": part.share,
            "seconds": seconds,
            "peak_memory_bytes": ambake::peak_memory(),
        }))?;
    } else if !args.common.quiet {
        let path = part.path.display();
        say(&match part.already {
            true => format!("part {shard} was complete already: {path}\n"),
            false => format!(
                "part {shard}: {} tiles, {} texels, {} rays in {seconds:.2} s: {path}\n\
                 when all parts are there: ambake merge {}\n",
                part.tiles,
                part.texels,
                part.rays,
                output.display(),
            ),
        })?;
    }
    Ok(Outcome::Done)
}

/// The command line and the folder that it was given in, for the merge.
pub fn given() -> anyhow::Result<Value> {
    let folder = std::env::current_dir().context("cannot tell the current folder")?;
    let text = |text: std::ffi::OsString| {
        text.into_string().map_err(|text| {
            anyhow::anyhow!(
                "{} is not in UTF-8, which --shard needs; rename it",
                text.to_string_lossy()
            )
        })
    };
    let words: Vec<String> = words()
        .into_iter()
        .skip(1)
        .map(text)
        .collect::<anyhow::Result<_>>()?;
    Ok(json!({"words": words, "folder": text(folder.into_os_string())?}))
}
