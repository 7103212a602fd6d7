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
        let is = |kinds: &[TypeId]| {
            let own = arg.get_value_parser().type_id();
            kinds.iter().any(|kind| own == *kind)
        };
        let whole = [TypeId::of::<u8>(), TypeId::of::<u32>(), TypeId::of::<u64>()];
        let words = arg.get_possible_values();
        let kind = match arg.get_action().takes_values() {
            false => Kind::Switch,
            _ if !words.is_empty() => {
                Kind::Word(words.iter().map(|word| word.get_name().into()).collect())
            }
            _ if is(&whole) => Kind::Whole,
            _ if is(&[TypeId::of::<f64>()]) => Kind::Number,
            _ if is(&[TypeId::of::<PathBuf>()]) => Kind::Path,
            _ => Kind::Text(arg.get_value_names().unwrap_or_default().concat()),
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
    T::try_parse_from(words).map_err(|error| {
        let needs_more = |one: &OsString| {
            let alone = T::try_parse_from([one]).err();
            alone.filter(|error| error.kind() == ErrorKind::MissingRequiredArgument)
        };
        let named = |kind| flags_in(&error, kind);
        match error.kind() {
            ErrorKind::ArgumentConflict => {
                let mut both =
                    [named(ContextKind::InvalidArg), named(ContextKind::PriorArg)].concat();
                both.sort();
                format!(
                    "{} exclude each other; give one of them",
                    both.join(" and ")
                )
            }
            ErrorKind::MissingRequiredArgument => {
                let missing = named(ContextKind::InvalidArg);
                match (
                    missing.len(),
                    words.iter().find(|one| needs_more(one).is_some()),
                ) {
                    (1, Some(word)) => {
                        let name = flags_of(&word.to_string_lossy()).concat();
                        format!("{name} needs {} beside it", missing.concat())
                    }
                    _ => format!("give one of {}", missing.join(", ")),
                }
            }
            _ => told(&error),
        }
    })
}

/// Why a keyword cannot have its value.
fn told(error: &clap::Error) -> String {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(words)) => words.join(", "),
        _ => String::new(),
    };
    let value = text(ContextKind::InvalidValue);
    let problem = match (error.source(), text(ContextKind::ValidValue)) {
        (Some(source), _) => problem(&value, &source.to_string()),
        (None, known) if !known.is_empty() => format!("{value:?} is none of {known}"),
        _ => error.to_string().lines().next().unwrap_or_default().into(),
    };
    let name = flags_in(error, ContextKind::InvalidArg).concat();
    format!("{name}: {problem}")
}

/// What is wrong with a value, as a sentence that needs no command line beside it.
pub fn problem(value: &str, source: &str) -> String {
    let range = source
        .split_once(" is not in ")
        .and_then(|(_, range)| range.split_once("..="));
    let unknown = source
        .strip_prefix("unknown ")
        .and_then(|of| of.split_once(';'));
    match (range, unknown) {
        (Some((least, most)), _) => format!("must be between {least} and {most}"),
        (_, Some((what, known))) => format!("there is no {what} {value:?};{known}"),
        _ => source.into(),
    }
}

/// The keywords of the flags that a part of an error names.
fn flags_in(error: &clap::Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => flags_of(text),
        Some(ContextValue::Strings(texts)) => flags_of(&texts.join(" ")),
        _ => Vec::new(),
    }
}

fn flags_of(text: &str) -> Vec<String> {
    let name = |text: &str| {
        let end = text.find(|c: char| !c.is_ascii_alphabetic() && c != '-');
        text[..end.unwrap_or(text.len())].to_owned()
    };
    let flags = text.split("--").skip(1).map(name);
    flags
        .filter(|flag| !TYPED.contains(&&**flag))
        .map(|flag| name_of(&flag))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Bake, Probes};
    use super::*;

    fn problem_of<T: Parser>(words: &[&str]) -> String {
        let words: Vec<OsString> = words.iter().map(OsString::from).collect();
        match parsed::<T>(&words) {
            Ok(_) => panic!("{words:?} was taken"),
            Err(problem) => problem,
        }
    }

    #[test]
    fn a_mistake_is_one_line_that_names_the_keyword() {
        for (words, line) in [
            (vec!["--size=0"], "size: must be between 1 and 16384"),
            (vec!["--under=-1"], "under: must be at least 0"),
            (
                vec!["--seams=all"],
                "seams: \"all\" is none of off, object, scene",
            ),
            (
                vec!["--layers=ao"],
                "layers: there is no layer \"ao\"; there are coverage",
            ),
            (
                vec!["--for=quake"],
                "for_: there is no engine \"quake\"; there are",
            ),
            (
                vec!["--target-error=0.1", "--rays=4"],
                "rays and target_error exclude each other; give one of them",
            ),
            (
                vec!["--max-rays=64"],
                "max_rays needs target_error beside it",
            ),
            (vec!["--verify"], "verify needs update beside it"),
        ] {
            let problem = problem_of::<Bake>(&words);
            assert!(problem.starts_with(line), "{words:?}: {problem}");
        }
        assert_eq!(problem_of::<Probes>(&[]), "give one of spacing, grid, at");
        let both = problem_of::<Probes>(&["--spacing=1", "--at=0,0,0"]);
        assert_eq!(both, "at and spacing exclude each other; give one of them");
    }

    #[test]
    fn keywords_are_flags_with_a_kind() {
        let keywords = keywords::<Bake>();
        let kind = |name: &str| {
            let found = keywords.iter().find(|keyword| keyword.name == name);
            found.map(|keyword| keyword.kind.clone())
        };
        assert_eq!(kind("normal_maps"), Some(Kind::Switch));
        assert_eq!(kind("seed"), Some(Kind::Whole));
        assert_eq!(kind("under"), Some(Kind::Number));
        assert_eq!(kind("update"), Some(Kind::Path));
        assert_eq!(
            kind("to"),
            Some(Kind::Word(vec!["pages".into(), "vertices".into()]))
        );
        assert_eq!(kind("density"), Some(Kind::Text("D|even".into())));
        assert!(kind("for_").is_some() && kind("quiet").is_none());
    }
}
