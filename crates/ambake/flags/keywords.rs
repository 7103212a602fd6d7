//! Flags as the keyword arguments of a function, such as Python's.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, CommandFactory, Parser};
use std::any::TypeId;
use std::error::Error;
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// Flags of the terminal, and those that give a caller in memory nothing.
const TYPED: [&str; 7] = [
    "allow-outside",
    "json",
    "parts",
    "quiet",
    "reflection-size",
    "reflections",
    "verbose",
];

/// What the value of a keyword is.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// True or false.
    Switch,
    /// A whole number of at least 0.
    Whole,
    /// A number.
    Number,
    /// A file or a folder.
    Path,
    /// One of these.
    Word(Vec<String>),
    /// What the flag's text can be, in the form that help shows.
    Text(String),
}

/// A keyword argument.
#[derive(Debug, Clone)]
pub struct Keyword {
    /// The flag's name with underscores; `for`, a word of Python, has one at its end.
    pub name: String,
    /// What it takes.
    pub kind: Kind,
    /// True where it takes several values.
    pub repeats: bool,
    /// True where commas separate them.
    pub is_list: bool,
    /// True for what no list shows.
    pub is_hidden: bool,
    flag: String,
}

impl Keyword {
    fn of(arg: &Arg) -> Option<Self> {
        let flag = arg.get_long().filter(|flag| !TYPED.contains(flag))?;
        let own = arg.get_value_parser().type_id();
        let whole = [TypeId::of::<u8>(), TypeId::of::<u32>(), TypeId::of::<u64>()];
        let words = arg.get_possible_values();
        let form = arg.get_value_names().unwrap_or_default().concat();
        let kind = match arg.get_action().takes_values() {
            false => Kind::Switch,
            _ if !words.is_empty() => {
                Kind::Word(words.iter().map(|word| word.get_name().into()).collect())
            }
            // What is more than a number, such as 8G, has a longer form.
            _ if form.len() == 1 && whole.iter().any(|kind| own == *kind) => Kind::Whole,
            _ if form.len() == 1 && own == TypeId::of::<f64>() => Kind::Number,
            _ if own == TypeId::of::<PathBuf>() => Kind::Path,
            _ => Kind::Text(form),
        };
        Some(Self {
            name: name_of(flag),
            kind,
            repeats: matches!(arg.get_action(), clap::ArgAction::Append),
            is_list: arg.get_value_delimiter() == Some(','),
            is_hidden: arg.is_hide_set(),
            flag: format!("--{flag}"),
        })
    }

    /// The word of the command line that gives it this value; of a switch, the one that turns it on.
    pub fn with(&self, value: impl AsRef<OsStr>) -> OsString {
        let mut word = OsString::from(&self.flag);
        if self.kind != Kind::Switch {
            word.push("=");
            word.push(value);
        }
        word
    }
}

fn name_of(flag: &str) -> String {
    match flag {
        "for" => "for_".into(),
        _ => flag.replace('-', "_"),
    }
}

/// All keywords of a table of flags, in its order.
pub fn keywords<T: CommandFactory>() -> Vec<Keyword> {
    let mut grammar = T::command();
    grammar.build();
    grammar.get_arguments().filter_map(Keyword::of).collect()
}

/// What words of the command line say that [`Keyword::with`] made.
///
/// # Errors
/// One line that names the keyword.
pub fn parsed<T: Parser>(words: &[OsString]) -> Result<T, String> {
    let text_of = |error: &clap::Error, kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(texts)) => texts.join(", "),
        _ => String::new(),
    };
    T::try_parse_from(words).map_err(|error| {
        let text = |kind| text_of(&error, kind);
        let names = names_in(&text(ContextKind::InvalidArg));
        let lacks = |one: &&OsString| {
            let alone = T::try_parse_from([one]).err();
            alone.is_some_and(|alone| {
                let missing = names_in(&text_of(&alone, ContextKind::InvalidArg));
                alone.kind() == ErrorKind::MissingRequiredArgument
                    && names.iter().all(|name| missing.contains(name))
            })
        };
        match error.kind() {
            ErrorKind::ArgumentConflict => {
                let mut both = [names, names_in(&text(ContextKind::PriorArg))].concat();
                both.sort();
                let both = both.join(" and ");
                return format!("{both} exclude each other; give one of them");
            }
            ErrorKind::MissingRequiredArgument => {
                return match words.iter().find(lacks).filter(|_| names.len() == 1) {
                    Some(word) => {
                        let name = names_in(&word.to_string_lossy()).concat();
                        format!("{name} needs {} beside it", names.concat())
                    }
                    None => format!("give one of {}", names.join(", ")),
                };
            }
            _ => {}
        }
        let value = text(ContextKind::InvalidValue);
        let problem = match (error.source(), text(ContextKind::ValidValue)) {
            (Some(source), _) => problem(&value, &source.to_string()),
            (_, known) => format!("{value:?} is none of {known}"),
        };
        format!("{}: {problem}", names.concat())
    })
}

/// What is wrong with a value, as a sentence that needs no command line beside it.
pub fn problem(value: &str, source: &str) -> String {
    let unknown = source.strip_prefix("unknown ");
    match unknown.and_then(|of| of.split_once(';')) {
        Some((what, known)) => format!("there is no {what} {value:?};{known}"),
        None => source.into(),
    }
}

/// The keywords of the flags in a text.
fn names_in(text: &str) -> Vec<String> {
    let is_end = |c: char| !c.is_ascii_alphabetic() && c != '-';
    let flags = text.split("--").skip(1);
    let flags = flags.map(|rest| rest.split(is_end).next().unwrap_or_default());
    flags
        .filter(|flag| !TYPED.contains(flag))
        .map(name_of)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Bake, Probes};
    use super::*;

    #[test]
    fn a_mistake_is_one_line_that_names_the_keyword() {
        let problem = |words: &str| {
            let words: Vec<OsString> = words.split_whitespace().map(OsString::from).collect();
            parsed::<Bake>(&words).err().unwrap_or_default()
        };
        for (words, line) in [
            ("--size=0", "size: must be a whole number from 1 to 16384"),
            ("--under=-1", "under: must be at least 0"),
            ("--seams=all", r#"seams: "all" is none of off, object"#),
            ("--for=quake", r#"for_: there is no engine "quake"; there"#),
            ("--target-error=0.1 --rays=4", "rays and target_error ex"),
            ("--size=8 --max-rays=64", "max_rays needs target_error b"),
        ] {
            let problem = problem(words);
            assert!(problem.starts_with(line), "{words}: {problem}");
        }
        let places = |words: &[&str]| {
            let words: Vec<OsString> = words.iter().map(OsString::from).collect();
            parsed::<Probes>(&words).err().unwrap_or_default()
        };
        assert_eq!(places(&[]), "give one of spacing, grid, at");
        let lacking = places(&["--seed=3", "--at=0,0,0", "--max-rays=4096"]);
        assert_eq!(lacking, "max_rays needs target_error beside it");
    }
}
