//! How a verb ends, and what it says on the way.

use anyhow::Context;
use serde_json::Value;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// How a verb that did not fail ended.
pub enum Outcome {
    Done,
    /// Stopped by this signal; nothing is half-written.
    Stopped(i32),
    /// `doctor` found something unusable.
    Unusable,
}

/// The exit status of a verb; a failure is told in one line on standard error.
pub fn exit_code(result: anyhow::Result<Outcome>) -> ExitCode {
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
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line.replace('\n', " ")
}

/// Prints to standard output. A reader that has gone away is no failure.
pub fn say(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// Prints a machine-readable summary to standard output.
pub fn say_json(summary: &Value) -> anyhow::Result<()> {
    say(&format!("{}\n", serde_json::to_string_pretty(summary)?))
}
