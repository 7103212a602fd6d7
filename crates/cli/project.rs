//! `ambake.toml` beside what a verb reads, a scene, the folder of a bake or a picture: flags that need not be typed
//! again.
//!
//! ```toml
//! [bake]                    # every scene of the folder
//! size = 512
//! sky = "dusk.hdr"          # files are looked for beside this one
//!
//! [scene."hall.glb"]        # one scene; these win over [bake]
//! rays = 1024
//!
//! [object."wall*"]          # objects by name, with * and ?, of every scene
//! density = 20
//!
//! [scene."hall.glb".object."altar"]   # of one scene
//! density = 80
//!
//! [probes]                  # `ambake probes`; so are [render] and [fit], and [scene."hall.glb".probes]
//! spacing = 2
//!
//! [export]                  # of a finished bake; so are [view] and [compare]
//! for = ["godot"]
//!
//! [map.specular]            # so are all verbs of `ambake map`
//! exponent = 100
//! ```
//!
//! What is typed wins over the file. The file's options are put before the typed ones and both are read by the same
//! parser, so that each has the range and the meaning of its flag.

use crate::args::{Args, Verb};
use crate::common::text_file;
use anyhow::{Context, bail};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The name of the file.
pub const PROJECT_FILE: &str = "ambake.toml";

/// The verbs with a table of their own that take a scene. The others that take one share the table of `bake`.
const OWN: [&str; 3] = ["probes", "render", "fit"];

/// Those that take the folder of a finished bake.
const OF_FOLDERS: [&str; 3] = ["export", "view", "compare"];

/// The verb whose own verbs have tables below its name: `[map.specular]`.
const GROUP: &str = "map";

/// Options of the file that are left out where another one of them is typed, beside those of which the grammar says so.
const EITHER: [&[&str]; 4] = [
    &["spacing", "grid", "at"],
    &["rays", "target-relative"],
    &["rays", "max-rays"],
    &["layers", "only"],
];

/// Options whose value may be a file or a folder that lies beside the project file.
const PATHS: [&str; 5] = ["sky", "bake", "probes", "response", "table"];

/// Flags that are for one run alone.
const ONCE: [&str; 8] = [
    "output", "fresh", "resume", "shard", "update", "verify", "after", "json",
];

/// What was typed, with the options of the verb's own table in the project file beside what it reads; without such a
/// verb or file, what was typed.
///
/// # Errors
/// One line that names the file, the table and the option.
pub fn with_own_table(typed: Vec<OsString>) -> anyhow::Result<Vec<OsString>> {
    // Something that is required may stand in the file.
    let grammar = Args::grammar();
    let found = grammar
        .clone()
        .ignore_errors(true)
        .try_get_matches_from(&typed);
    let Some((verb, below)) = found.as_ref().ok().and_then(ArgMatches::subcommand) else {
        return Ok(typed);
    };
    let (verb, below) = match below.subcommand() {
        Some((own, below)) if verb == GROUP => (format!("{verb}.{own}"), below),
        _ => (verb.to_owned(), below),
    };
    let has_table = [OWN, OF_FOLDERS].concat().contains(&&*verb) || verb.contains('.');
    let Some(read_path) = first_path(&grammar, &verb, below).filter(|_| has_table) else {
        return Ok(typed);
    };
    let Some(path) = beside(&read_path) else {
        return Ok(typed);
    };
    let more = read(&path).and_then(|table| {
        let flags = flags(&path, &table, &read_path, (&verb, below));
        flags.with_context(|| path.display().to_string())
    })?;
    Ok(between(&typed, &verb, more))
}

/// The scene, folder or picture that a verb was given first.
fn first_path(grammar: &Command, verb: &str, typed: &ArgMatches) -> Option<PathBuf> {
    let first = command(grammar, verb)?.get_positionals().next()?;
    let mut words = typed.try_get_raw(first.get_id().as_str()).ok()??;
    words.next().map(PathBuf::from)
}

/// The grammar of a verb; `map.specular` is a verb of `map`.
fn command<'a>(grammar: &'a Command, verb: &str) -> Option<&'a Command> {
    let mut names = verb.split('.');
    names.try_fold(grammar, |command, name| command.find_subcommand(name))
}

/// The project file beside a scene, a folder or a picture, where there is one.
fn beside(read: &Path) -> Option<PathBuf> {
    // The folder `.` has its name one folder up.
    let path = match read.file_name() {
        Some(_) => read.with_file_name(PROJECT_FILE),
        None => std::path::absolute(read).ok()?.with_file_name(PROJECT_FILE),
    };
    (read != Path::new("-") && path.is_file()).then_some(path)
}

/// What was typed, with more flags after the verb.
fn between(typed: &[OsString], verb: &str, more: Vec<String>) -> Vec<OsString> {
    let at = verb.split('.').fold(0, |from, name| {
        let place = typed[from..].iter().position(|word| word == name);
        from + place.unwrap_or(0) + 1
    });
    let more = more.into_iter().map(OsString::from);
    let words = typed[..at].iter().cloned().chain(more);
    words.chain(typed[at..].iter().cloned()).collect()
}

/// What was `typed`, the program's name first, completed by the project file beside the scene; `None` where there is no
/// such file.
///
/// # Errors
/// One line that names the file, the table and the option.
pub fn completed(scene: &Path, typed: &[OsString]) -> anyhow::Result<Option<Verb>> {
    let Some(path) = beside(scene) else {
        return Ok(None);
    };
    let table = read(&path)?;
    let args = with_flags(typed, |typed| flags(&path, &table, scene, ("bake", typed)))
        .with_context(|| path.display().to_string())?;
    Ok(Some(args.verb))
}

/// The file's tables.
fn read(path: &Path) -> anyhow::Result<Table> {
    let text = text_file(path)?;
    let table = text.parse::<Table>().map_err(|error| {
        let before = error
            .span()
            .map_or("", |span| &text[..span.start.min(text.len())]);
        let line = before.matches('\n').count() + 1;
        anyhow::anyhow!("{} line {line}: {}", path.display(), error.message())
    })?;
    for name in table
        .get("scene")
        .and_then(Value::as_table)
        .into_iter()
        .flat_map(Table::keys)
    {
        if table["scene"][name].is_table() && !path.with_file_name(name).exists() {
            bail!(
                "{}: [scene.\"{name}\"] names no file beside it",
                path.display()
            );
        }
    }
    Ok(table)
}

/// The arguments with more flags between the verb and what was typed after it.
fn with_flags(
    typed: &[OsString],
    flags: impl FnOnce(&ArgMatches) -> anyhow::Result<Vec<String>>,
) -> anyhow::Result<Args> {
    let one_line = |error: clap::Error| {
        let text = error.to_string();
        let line = text.lines().next().unwrap_or_default();
        anyhow::anyhow!("{}", line.strip_prefix("error: ").unwrap_or(line))
    };
    let matches = Args::grammar()
        .try_get_matches_from(typed)
        .map_err(one_line)?;
    let Some((verb, below)) = matches.subcommand() else {
        bail!("no verb");
    };
    let words = between(typed, verb, flags(below)?);
    let matches = Args::grammar()
        .try_get_matches_from(words)
        .map_err(one_line)?;
    Args::from_arg_matches(&matches).map_err(one_line)
}

/// The options of the file, those for a scene last.
fn tables<'a>(table: &'a Table, scene: &str) -> anyhow::Result<Tables<'a>> {
    let mut found = Vec::new();
    let as_table = |title: &str, value: &'a Value| {
        let table = value.as_table();
        table.with_context(|| format!("[{title}] is no table"))
    };
    for (title, content) in table {
        if content.as_table().is_none() {
            bail!("`{title}` stands outside of a table; write it below [bake]");
        }
        match title.as_str() {
            own if own == "bake" || OWN.contains(&own) || OF_FOLDERS.contains(&own) => {
                found.push((
                    own.to_owned(),
                    own.to_owned(),
                    true,
                    as_table(own, content)?,
                ));
            }
            GROUP => {
                for (own, content) in as_table(GROUP, content)? {
                    let title = format!("{GROUP}.{own}");
                    let content = content.as_table().with_context(|| {
                        format!("`{own}` stands in [{GROUP}], which has a table for each verb: [{GROUP}.specular]")
                    })?;
                    found.push((title.clone(), title, true, content));
                }
            }
            "scene" | "object" => {}
            other => bail!(
                "unknown table [{other}]; there are [bake], [{}], [{GROUP}.VERB], [scene.\"FILE\"] and \
                 [object.\"NAME\"]",
                [OWN, OF_FOLDERS].concat().join("], [")
            ),
        }
    }
    for (name, own) in table
        .get("scene")
        .and_then(Value::as_table)
        .into_iter()
        .flatten()
    {
        let title = format!("scene.\"{name}\"");
        let Some(own) = own.as_table() else {
            bail!("`{name}` stands in [scene], which has a table for each file: [scene.\"FILE\"]");
        };
        for verb in OWN {
            if let Some(value) = own.get(verb) {
                let title = format!("{title}.{verb}");
                let own = as_table(&title, value)?;
                found.push((title, verb.to_owned(), name == scene, own));
            }
        }
        found.push((title, "bake".to_owned(), name == scene, own));
    }
    Ok(found)
}

/// Tables of options: the title of each, the verb whose flags it holds, whether they are for the scene, and itself.
type Tables<'a> = Vec<(String, String, bool, &'a Table)>;

/// The file's options for a scene as flags of a verb, but for those that were typed.
fn flags(
    path: &Path,
    table: &Table,
    scene: &Path,
    (verb, typed): (&str, &ArgMatches),
) -> anyhow::Result<Vec<String>> {
    let name = scene.file_name().unwrap_or_default().to_string_lossy();
    let mut grammar = Args::grammar();
    grammar.build();
    let verbs = |verb: &str| {
        command(&grammar, verb).with_context(|| format!("[{verb}]: there is no such verb"))
    };
    let mut options: Vec<(String, String, &Value)> = Vec::new();
    let mut flags = Vec::new();
    if let ("bake", Some(objects)) = (verb, table.get("object").and_then(Value::as_table)) {
        for (object, wishes) in objects {
            flags.extend(object_flags(object, wishes)?);
        }
    }
    for (title, of, is_own, content) in tables(table, &name)? {
        for (key, value) in content {
            match value.as_table() {
                Some(objects) if key == "object" && title.starts_with("scene") => {
                    for (object, wishes) in objects {
                        let own = object_flags(object, wishes)?;
                        flags.extend(own.into_iter().filter(|_| is_own && verb == "bake"));
                    }
                    continue;
                }
                Some(_) if OWN.contains(&&**key) && title.starts_with("scene") => continue,
                _ => {}
            }
            if ONCE.contains(&&**key) {
                bail!("`{key}` in [{title}] belongs to one run: type it");
            }
            // A typo is told by whichever verb reads the file, for whichever scene.
            let known = find(verbs(&of)?, key);
            known.with_context(|| {
                let of = of.replace('.', " ");
                format!(
                    "unknown option `{key}` in [{title}]; \
                     options are the flags of `ambake {of} --help` without dashes"
                )
            })?;
            if of == verb && is_own {
                options.retain(|(_, earlier, _)| earlier != key);
                options.push((title.clone(), key.clone(), value));
            }
        }
    }
    let command = verbs(verb)?;
    let is_typed = |arg: &Arg| {
        let id = arg.get_id().as_str();
        typed.try_contains_id(id).is_ok()
            && typed.value_source(id) == Some(ValueSource::CommandLine)
    };
    let typed_args: Vec<&Arg> = command
        .get_arguments()
        .filter(|arg| is_typed(arg))
        .collect();
    for (title, key, value) in options {
        let Some(arg) = find(command, &key) else {
            continue;
        };
        // What a verb does not take, such as files for engines in a plan, serves the others.
        if typed.try_contains_id(arg.get_id().as_str()).is_err() {
            continue;
        }
        let repeats = matches!(arg.get_action(), ArgAction::Append);
        let others = typed_args
            .iter()
            .filter(|other| other.get_id() != arg.get_id());
        let excluded = others.copied().any(|other| {
            let excludes = |one: &Arg, other: &Arg| {
                let all = command.get_arg_conflicts_with(one);
                all.iter().any(|arg| arg.get_id() == other.get_id())
            };
            let are_either = |either: &&[&str]| {
                [arg, other]
                    .iter()
                    .all(|one| one.get_long().is_some_and(|name| either.contains(&name)))
            };
            excludes(arg, other) || excludes(other, arg) || EITHER.iter().any(are_either)
        });
        if excluded || (is_typed(arg) && !repeats) {
            continue;
        }
        let words = words(value).with_context(|| match value {
            Value::Array(list) if list.is_empty() => {
                format!("`{key}` in [{title}] is an empty list")
            }
            Value::Array(_) => {
                format!("`{key}` in [{title}] is a list of lists; write each as text, \"1,2,3\"")
            }
            _ => format!("`{key}` in [{title}] is neither text, number, true, false nor a list"),
        })?;
        match value {
            Value::Boolean(on) if matches!(arg.get_action(), ArgAction::SetTrue) => {
                if *on {
                    flags.push(format!("--{key}"));
                }
            }
            Value::Array(_) if repeats && arg.get_value_delimiter().is_none() => {
                flags.extend(words.iter().map(|word| format!("--{key}={word}")));
            }
            _ => {
                let beside = path.with_file_name(&words[0]);
                let is_path = PATHS.contains(&&*key) && words.len() == 1;
                let word = match is_path && beside.exists() {
                    true => beside.display().to_string(),
                    false => words.join(","),
                };
                flags.push(format!("--{key}={word}"));
            }
        }
    }
    Ok(flags)
}

/// The option of a verb that a file may hold under a name.
fn find<'a>(command: &'a Command, name: &str) -> Option<&'a Arg> {
    let mut arguments = command.get_arguments();
    arguments.find(|arg| arg.get_long() == Some(name) && !ONCE.contains(&name))
}

/// The flags for the objects of a name.
fn object_flags(name: &str, wishes: &Value) -> anyhow::Result<Vec<String>> {
    let place = format!("[object.\"{name}\"]");
    let wishes = wishes.as_table().with_context(|| {
        format!("`{name}` stands in [object], which has a table for each name: [object.\"NAME\"]")
    })?;
    let mut flags = Vec::new();
    for (key, value) in wishes {
        match (key.as_str(), value) {
            ("density", value @ (Value::Integer(_) | Value::Float(_))) => {
                flags.push(format!("--density-of={name}={value}"));
            }
            ("include" | "exclude", Value::Boolean(true)) => flags.push(format!("--{key}={name}")),
            ("buried", Value::String(word)) => flags.push(format!("--buried-of={name}={word}")),
            ("cast", Value::Boolean(false)) => flags.push(format!("--no-cast={name}")),
            ("include" | "exclude", Value::Boolean(false)) | ("cast", Value::Boolean(true)) => {}
            _ => bail!(
                "`{key} = {value}` in {place}; there are density = NUMBER, include = true, exclude = true, cast = \
                 false and buried = \"keep\" or \"drop\""
            ),
        }
    }
    Ok(flags)
}

/// A value as the words of a flag.
fn words(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::String(text) => Some(vec![text.clone()]),
        Value::Integer(_) | Value::Float(_) | Value::Boolean(_) => Some(vec![value.to_string()]),
        Value::Array(list) if !list.is_empty() => {
            let one = |value: &Value| match value {
                Value::Array(_) => None,
                other => words(other).map(|words| words.concat()),
            };
            list.iter().map(one).collect()
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
