//! How a verb ends, and what it says on the way.

use anyhow::Context;
use clap::error::ErrorKind;
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::LazyLock;

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
    let mut messages = error.chain().map(in_flags);
    let mut line = messages.next().unwrap_or_default();
    for cause in messages {
        if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line.replace('\n', " ")
}

/// What an error says. The library's own names options; here they are flags.
fn in_flags(error: &(dyn std::error::Error + 'static)) -> String {
    match error.downcast_ref::<ambake::Error>() {
        Some(error) => error.in_flags(),
        None => error.to_string(),
    }
}

/// The exit status where the command line is wrong, which is told in one line on standard error; or where it asks for
/// help alone.
pub fn misused(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        if !wants_ascii() {
            error.exit();
        }
        let text = error.render().to_string();
        match error.use_stderr() {
            true => note(text.trim_end()),
            false => drop(say(&text)),
        }
        return ExitCode::from(error.exit_code() as u8);
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

/// What a terminal or a viewer of logs may obey or hide rather than show: control characters but the end of line, the
/// separators of lines and paragraphs, and marks that turn the direction of writing.
fn odd(c: char) -> bool {
    let unseen = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    unseen || c.is_control() && c != '\n'
}

/// Whether whoever started the program shows nothing but ASCII: the locale is that of C.
pub fn wants_ascii() -> bool {
    static ASCII: LazyLock<bool> = LazyLock::new(|| {
        let set = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
        let locale = set("LC_ALL")
            .or_else(|| set("LC_CTYPE"))
            .or_else(|| set("LANG"));
        locale.is_some_and(|locale| ["C", "POSIX"].contains(&&*locale))
    });
    *ASCII
}

/// The text as it may stand on this terminal.
pub fn printable(text: &str) -> Cow<'_, str> {
    shown(text, wants_ascii())
}

/// The text with odd characters as `\u{..}`, for names and numbers of a scene file come from strangers; `in_ascii` all
/// others that are none too, but for those that ambake uses itself.
fn shown(text: &str, in_ascii: bool) -> Cow<'_, str> {
    let is_foreign = |c: char| odd(c) || in_ascii && !c.is_ascii();
    if !text.contains(is_foreign) {
        return text.into();
    }
    let escape = |c: char| match c {
        c if !is_foreign(c) => c.to_string(),
        '²' => "^2".into(),
        '³' => "^3".into(),
        '°' => " degrees".into(),
        '×' => "x".into(),
        'µ' | 'μ' => "u".into(),
        'π' => "pi".into(),
        'α' => "alpha".into(),
        '–' | '−' => "-".into(),
        '…' => "...".into(),
        c => format!("\\u{{{:x}}}", u32::from(c)),
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

/// Prints JSON to standard output, without odd characters.
pub fn say_json_text(json: &str) -> anyhow::Result<()> {
    write(&(printable_json(json) + "\n"))
}

/// The same JSON as it may stand on a terminal. Odd characters in it stand in strings, where JSON has its own escapes.
fn printable_json(json: &str) -> String {
    let escape = |c: char| match odd(c) {
        true => format!("\\u{:04x}", u32::from(c)),
        false => c.to_string(),
    };
    json.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_command_line_is_told_of_in_one_line() {
        for (said, line) in [
            (
                "error: unexpected argument '--siz' found\n\n  tip: a similar argument exists: '--size'\n\n\
                 Usage: ambake bake <SCENE>\n\nFor more information, try '--help'.\n",
                "unexpected argument '--siz' found, a similar argument exists: '--size'",
            ),
            (
                "error: the following required arguments were not provided:\n  --output <DIR>\n  <SCENE>...\n\n\
                 Usage: ambake\n",
                "the following required arguments were not provided: --output <DIR>, <SCENE>...",
            ),
            (
                "error: invalid value 'foo' for '--denoise <DENOISE>'\n  [possible values: off, oidn]\n\n\
                 For more information, try '--help'.\n",
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

    #[test]
    fn a_terminal_of_the_locale_c_gets_ascii() {
        assert_eq!(shown("64² in µs at 90°", true), "64^2 in us at 90 degrees");
        assert_eq!(shown("Zimmer ä", true), "Zimmer \\u{e4}");
        assert_eq!(shown("Zimmer ä 64²", false), "Zimmer ä 64²");
    }

    #[test]
    fn what_breaks_or_turns_a_line_is_printed_as_its_number() {
        let marks = [0x0d, 0x1b, 0x85, 0x61c, 0x200e, 0x200f];
        for code in marks
            .into_iter()
            .chain(0x2028..=0x202e)
            .chain(0x2066..=0x2069)
        {
            let name = format!("a{}b\n", char::from_u32(code).expect("a character"));
            assert_eq!(printable(&name), format!("a\\u{{{code:x}}}b\n"));
            let json = Value::from(name.as_str()).to_string();
            let shown = printable_json(&json);
            assert!(!shown.contains(odd), "{shown:?}");
            let read: Value = serde_json::from_str(&shown).expect("it stays JSON");
            assert_eq!(read, name.as_str(), "{shown}");
        }
        for plain in ["é 日本 \u{2027}\u{202f}\u{2065}", "{\n  \"a\": 1\n}"] {
            assert_eq!(printable(plain), plain);
            assert_eq!(printable_json(plain), plain);
        }
    }
}
