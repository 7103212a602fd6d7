//! The `ambake` command: arguments to typed options to calls, and exit codes.
//!
//! Exit status: 0 done, 1 the job failed (one line on standard error), 2 the command line is wrong, 130 and 143 stopped
//! by Ctrl-C or SIGTERM with a state that `--resume` continues.
#![forbid(unsafe_code)]

mod args;
mod bake;
mod checkpoint;
mod compare;
mod doctor;
mod host;
mod options;
mod plan;
mod progress;
mod stop;

use clap::Parser;
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
        args::Verb::Bake(bake) => bake::run(bake),
        args::Verb::Plan(plan) => plan::run(plan),
        args::Verb::Compare(compare) => compare::run(compare),
        args::Verb::Doctor(doctor) => doctor::run(doctor),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Unusable) => ExitCode::FAILURE,
        Ok(Outcome::Stopped(signal)) => ExitCode::from(128 + signal as u8),
        Err(error) => {
            let line = format!("{error:#}").replace('\n', " ");
            eprintln!("ambake: {line}");
            ExitCode::FAILURE
        }
    }
}
