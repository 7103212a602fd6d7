//! `ambake bake --shard I/N`: one part of a bake.

use super::args::Bake as Args;
use crate::args::{Args as Line, Verb, words};
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use ambake::flags::common::Common;
use ambake::{Job, Shard};
use anyhow::Context;
use clap::FromArgMatches;
use serde_json::{Value, json};
use std::ffi::OsString;
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
    let Some(part) = unless_stopped(part, &args.common)? else {
        return Ok(stop.outcome());
    };
    let facts = json!({
        "tiles": part.tiles,
        "texels": part.texels,
        "rays": part.rays,
        "share": part.share,
        "peak_memory_bytes": ambake::peak_memory(),
    });
    let words = format!(
        "{} tiles, {} texels, {} rays",
        part.tiles, part.texels, part.rays
    );
    let of = (shard, part.path.as_path(), part.already);
    finish(&args.common, of, (facts, &words), started)
}

/// The part; `None` where it was stopped, which is told.
pub fn unless_stopped<T>(
    part: Result<T, ambake::Error>,
    common: &Common,
) -> anyhow::Result<Option<T>> {
    match part {
        Err(ambake::Error::Cancelled) => {
            if !common.quiet {
                tell("stopped; the same command continues");
            }
            Ok(None)
        }
        other => Ok(Some(other?)),
    }
}

/// Tells of a part that is there now, in its file, and whether it was before: `facts` for programs, `words` for people.
pub fn finish(
    common: &Common,
    (shard, path, already): (Shard, &Path, bool),
    (facts, words): (Value, &str),
    started: Instant,
) -> anyhow::Result<Outcome> {
    let seconds = started.elapsed().as_secs_f64();
    if common.json {
        let mut told = json!({
            "schema_version": 1,
            "shard": shard.index,
            "of": shard.of,
            "file": path.file_name().map(|name| name.to_string_lossy()),
            "already": already,
            "seconds": seconds,
        });
        if let (Some(told), Value::Object(facts)) = (told.as_object_mut(), facts) {
            told.extend(facts);
        }
        say_json(&told)?;
    } else if !common.quiet {
        let file = path.display();
        let folder = path.parent().unwrap_or(Path::new(".")).display();
        say(&match already {
            true => format!("part {shard} was complete already: {file}\n"),
            false => format!(
                "part {shard}: {words} in {seconds:.2} s: {file}\n\
                 when all parts are there: ambake merge {folder}\n"
            ),
        })?;
    }
    Ok(Outcome::Done)
}

/// The command line and the folder that it was given in, for the merge.
pub fn given() -> anyhow::Result<Value> {
    let folder = std::env::current_dir().context("cannot tell the current folder")?;
    let text = |text: OsString| {
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

/// The command line that parts were made by, in whose folder this process is from now on, for it may name files from
/// there. Where that folder is absent here, so are the files, and the scene's error says so.
pub fn typed(given: &Value) -> anyhow::Result<Vec<OsString>> {
    let words: Vec<String> = serde_json::from_value(given["words"].clone())
        .context("the parts do not say how they were made; make them with this program")?;
    if let Some(folder) = given["folder"].as_str() {
        let _ = std::env::set_current_dir(folder);
    }
    let words = std::iter::once("ambake".to_owned()).chain(words);
    Ok(words.map(OsString::from).collect())
}

/// The verb of that command line.
pub fn verb(typed: &[OsString]) -> anyhow::Result<Verb> {
    let line = Line::grammar().try_get_matches_from(typed);
    let line = line.and_then(|line| Line::from_arg_matches(&line));
    let line = line.context("this program does not know the command line of the parts")?;
    Ok(line.verb)
}
