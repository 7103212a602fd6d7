//! The `ambake` command: arguments to typed options to calls, and exit codes.
//!
//! Exit status: 0 done, 1 the job failed (one line on standard error), 2 the command line is wrong, 130 and 143 stopped
//! by Ctrl-C or SIGTERM with a state that `--resume` continues.
#![forbid(unsafe_code)]

mod args;
mod bake;
mod bench;
mod compare;
mod doctor;
mod host;
mod map;
mod progress;
mod render;
mod stop;

use anyhow::Context;
use clap::Parser;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// How a verb that did not fail ended.
enum Outcome {
    Done,
    /// Stopped by this signal; the state is saved.
    Stopped(i32),
    /// `doctor` found something unusable.
    Unusable,
}

fn main() -> ExitCode {
    let args = args::Args::parse();
    let result = match &args.verb {
        args::Verb::Bake(bake) => bake::run::run(bake),
        args::Verb::Plan(plan) => bake::plan::run(plan),
        args::Verb::Compare(compare) => compare::run(compare),
        args::Verb::Render(render) => render::run::run(render),
        args::Verb::Map(map) => map::args::run(map),
        args::Verb::Bench(bench) => bench::run::run(bench),
        args::Verb::Doctor(doctor) => doctor::run(doctor),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Unusable) => ExitCode::FAILURE,
        Ok(Outcome::Stopped(signal)) => ExitCode::from(128 + signal as u8),
        Err(error) => {
            eprintln!("ambake: {}", one_line(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error with its causes on one line; a cause that the line already names is not repeated.
fn one_line(error: &anyhow::Error) -> String {
    let mut line = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line.replace('\n', " ")
}

/// Prints to standard output. A reader that has gone away is no failure.
fn say(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}
