//! `ambake bake`: scenes in, lightmaps out.

use super::args::Bake as Args;
use super::prepare::{Target, prepare_in};
use super::shard;
use super::summary::summary;
use crate::args::{Verb, words};
use crate::outcome::{Outcome, one_line, printable, say, say_json_text, tell};
use crate::progress::{Show, square, watch};
use crate::stop::Stop;
use crate::{allocate, project, view};
use ambake::Written;
use ambake::flags::common::Common;
use anyhow::bail;
use report::Output;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the verb: one scene into `-o DIR`, several into a folder each, `DIR/STEM`; without `-o` each into one
/// beside it. Where one of several fails the others are baked all the same.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    let [scene] = args.scene.as_slice() else {
        return several(args, &stop);
    };
    if args.shard.is_some() && scene == Path::new("-") {
        bail!("--shard takes a scene file, which each shard and the merge can read again");
    }
    if args.shard.is_some() && args.earlier.update.is_some() {
        bail!(
            "--update keeps what --shard would bake; leave out one of them: a merged bake can be updated"
        );
    }
    one(args, scene, &args.folder(scene), &stop)
}

fn several(args: &Args, stop: &Stop) -> anyhow::Result<Outcome> {
    if args.shard.is_some() {
        bail!("--shard takes one scene at a time");
    }
    if args.earlier.update.is_some() {
        bail!("--update takes one scene at a time");
    }
    let mut folders: HashMap<PathBuf, &Path> = HashMap::new();
    for scene in &args.scene {
        let folder = args.folder(scene);
        if let Some(other) = folders.insert(folder.clone(), scene) {
            bail!(
                "{} and {} would both be baked into {}; bake them one by one with different -o",
                other.display(),
                scene.display(),
                folder.display()
            );
        }
    }
    let (mut done, mut failed) = match args.after[..] {
        [done, failed] => (done, failed),
        _ => (0, 0),
    };
    for scene in args.scene.iter().skip(done) {
        done += 1;
        if let Ok(rest) = program_after(done, failed + 1) {
            allocate::in_work(printable(&scene.to_string_lossy()).into(), rest);
        }
        match one(args, scene, &args.folder(scene), stop) {
            Ok(Outcome::Done) => {}
            Ok(other) => return Ok(other),
            Err(error) => {
                failed += 1;
                tell(&one_line(&error));
            }
        }
    }
    match failed {
        0 => Ok(Outcome::Done),
        _ => bail!("{failed} of {} scenes were not baked", args.scene.len()),
    }
}

/// This program with its arguments, for the scenes after the first `done`, of which `failed` were not baked.
fn program_after(done: usize, failed: usize) -> io::Result<Command> {
    let mut typed = words().into_iter().skip(1);
    let mut program = Command::new(std::env::current_exe()?);
    program.args(typed.next());
    program.args(["--after".into(), done.to_string(), failed.to_string()]);
    program.args(typed);
    Ok(program)
}

/// Bakes a scene into a folder.
fn one(args: &Args, scene: &Path, output: &Path, stop: &Stop) -> anyhow::Result<Outcome> {
    // A directory that cannot be written, or is another bake's, is found before the scene is loaded. Shards share
    // theirs.
    let _folder = match args.shard {
        Some(_) => Output::create(output)?.folder(),
        None => Output::exclusive(output)?.folder(),
    };
    let completed = project::completed(scene, &words())?;
    let args = match &completed {
        Some(Verb::Bake(bake)) => bake,
        _ => args,
    };
    let target = Target {
        dir: output,
        parts: args.shard.is_some(),
        engines: &args.engines,
        update: args.earlier.update.as_deref(),
        verify: args.earlier.verify,
    };
    let job = prepare_in(&target, scene, &args.job, &args.common)?;
    if let Some(part) = args.shard {
        return shard::run(args, output, &job, part, stop);
    }
    let pages = job.atlas().page_count;
    if pages > 1 && !args.common.quiet {
        let size = square(job.atlas().page_size);
        tell(&format!("the layout takes {pages} pages of {size}"));
    }
    let show = Show {
        unit: "texels",
        quiet: args.common.quiet,
    };
    let resume = args.runs.resume();
    let written = watch(show, stop, |progress| {
        job.run_into(output, resume, progress)
    });
    let mut written = match written {
        Err(ambake::Error::Cancelled) => {
            if !args.common.quiet {
                tell("stopped; the same command continues");
            }
            return Ok(stop.outcome());
        }
        other => other?,
    };
    if args.report {
        report(&mut written, output)?;
    }
    tell_written(&written, &args.common, output)
}

/// Writes the report of a bake beside its files.
pub fn report(written: &mut Written, dir: &Path) -> anyhow::Result<()> {
    let path = view::write(dir)?;
    written.report.files.push(::report::REPORT_NAME.into());
    written.files.push(path);
    Ok(())
}

/// Says what was written.
pub fn tell_written(written: &Written, common: &Common, dir: &Path) -> anyhow::Result<Outcome> {
    if common.json {
        say_json_text(&written.report.to_json())?;
    } else if !common.quiet {
        say(&summary(&written.report, common.verbose, dir))?;
    }
    Ok(Outcome::Done)
}
