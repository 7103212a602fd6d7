//! How a verb ends, and what it says on the way.

use anyhow::Context;
use clap::error::ErrorKind;
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};
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
            tell(&one_line(&error));
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

/// The exit status where the command line is wrong, which is told in one line on standard error; or where it asks for help alone.
pub fn misused(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        error.exit();
    }
    tell(&misuse(&error.render().to_string()));
    ExitCode::from(2)
}

/// What clap says in paragraphs, in one line: what is wrong, what may have been meant, and where to read more.
fn misuse(said: &str) -> String {
    let said = said.strip_prefix("error: ").unwrap_or(said);
    let lines = said.lines().map(str::trim);
    let own = lines.take_while(|line| {
        !line.starts_with("Usage:") && !line.starts_with("For more information")
    });
    let mut line = String::new();
    for part in own.filter(|part| !part.is_empty()) {
        let part = part.strip_prefix("tip: ").unwrap_or(part);
        let joint = match line.chars().last() {
            None => "",
            Some(':') => " ",
            Some(_) if part.starts_with('[') => " ",
            Some(_) => ", ",
        };
        line.extend([joint, part]);
    }
    line + "; `--help` lists all there is"
}

/// Prints a line on standard error under the program's name. Where nobody can read it, nothing else is to be done.
pub fn tell(line: &str) {
    note(&format!("ambake: {line}"));
}

/// As [`tell`], without the program's name.
pub fn note(line: &str) {
    let _ = writeln!(io::stderr(), "{}", printable(line));
}

/// The text as it may stand on a terminal: control characters but the end of line, and marks that turn the direction of
/// writing, become `\u{..}`. Names and numbers of a scene file come from strangers.
pub fn printable(text: &str) -> Cow<'_, str> {
    let odd = |c: char| {
        (c.is_control() && c != '\n')
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(odd) {
        return text.into();
    }
    let escape = |c: char| match odd(c) {
        true => format!("\\u{{{:x}}}", u32::from(c)),
        false => c.to_string(),
    };
    text.chars().map(escape).collect()
}

/// Prints to standard output. A reader that has gone away is no failure.
pub fn say(text: &str) -> anyhow::Result<()> {
    write(&printable(text))
}

fn write(text: &str) -> anyhow::Result<()> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// Prints a machine-readable summary to standard output.
pub fn say_json(summary: &Value) -> anyhow::Result<()> {
    say_json_text(&serde_json::to_string_pretty(summary)?)
}

/// Prints JSON to standard output. What is left of control characters in it stands in strings, where JSON has its own escapes.
pub fn say_json_text(json: &str) -> anyhow::Result<()> {
    let escape = |c: char| match c.is_control() && c != '\n' {
        true => format!("\\u{:04x}", u32::from(c)),
        false => c.to_string(),
    };
    write(&(json.chars().map(escape).collect::<String>() + "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_command_line_is_told_of_in_one_line() {
        for (said, line) in [
            (
                "error: unexpected argument '--siz' found\n\n  tip: a similar argument exists: '--size'\n\nUsage: ambake bake <SCENE>\n\nFor more information, try '--help'.\n",
                "unexpected argument '--siz' found, a similar argument exists: '--size'",
            ),
            (
                "error: the following required arguments were not provided:\n  --output <DIR>\n  <SCENE>...\n\nUsage: ambake\n",
                "the following required arguments were not provided: --output <DIR>, <SCENE>...",
            ),
            (
                "error: invalid value 'foo' for '--denoise <DENOISE>'\n  [possible values: off, oidn]\n\nFor more information, try '--help'.\n",
                "invalid value 'foo' for '--denoise <DENOISE>' [possible values: off, oidn]",
            ),
        ] {
            assert_eq!(misuse(said), format!("{line}; `--help` lists all there is"));
        }
    }

    #[test]
    fn a_line_never_holds_what_moves_a_cursor() {
        let line = printable("a\u{1b}[2Jb\rc\u{9b}d\u{202e}e\nf");
        assert_eq!(line, "a\\u{1b}[2Jb\\u{d}c\\u{9b}d\\u{202e}e\nf");
        assert!(matches!(printable("Zimmer ä 50 %"), Cow::Borrowed(_)));
    }
}
