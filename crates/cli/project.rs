//! `ambake.toml` beside a scene: flags of the verbs that take a scene, which need not be typed again.
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

/// The verbs with a table of their own. The others that take a scene share that of `bake`.
const OWN: [&str; 3] = ["probes", "render", "fit"];

/// Options of the file that are left out where another one of them is typed, beside those of which the grammar says so.
const EITHER: [&[&str]; 4] = [
    &["spacing", "grid", "at"],
    &["rays", "target-relative"],
    &["rays", "max-rays"],
    &["layers", "only"],
];

/// Options whose value may be a file or a folder that lies beside the project file.
const PATHS: [&str; 3] = ["sky", "bake", "probes"];

/// Flags that are for one run alone.
const ONCE: [&str; 8] = [
    "output", "fresh", "resume", "shard", "update", "verify", "after", "json",
];

/// What was typed, with the options of the verb's own table in the project file beside the scene; without such a verb or
/// file, what was typed.
///
/// # Errors
/// One line that names the file, the table and the option.
pub fn with_own_table(typed: Vec<OsString>) -> anyhow::Result<Vec<OsString>> {
    // Something that is required may stand in the file.
    let found = Args::grammar()
        .ignore_errors(true)
        .try_get_matches_from(&typed);
    let Some((verb, below)) = found.as_ref().ok().and_then(ArgMatches::subcommand) else {
        return Ok(typed);
    };
    let scene = below.try_get_one::<PathBuf>("scene").ok().flatten();
    let scene = scene.filter(|_| OWN.contains(&verb));
    let Some((scene, path)) = scene.and_then(|scene| Some((scene, beside(scene)?))) else {
        return Ok(typed);
    };
    let more = read(&path).and_then(|table| {
        let flags = flags(&path, &table, scene, (verb, below));
        flags.with_context(|| path.display().to_string())
    })?;
    Ok(between(&typed, verb, more))
}

/// The project file of a scene, where there is one.
fn beside(scene: &Path) -> Option<PathBuf> {
    let path = scene.with_file_name(PROJECT_FILE);
    (scene != Path::new("-") && path.is_file()).then_some(path)
}

/// What was typed, with more flags after the verb.
fn between(typed: &[OsString], verb: &str, more: Vec<String>) -> Vec<OsString> {
    let at = typed.iter().position(|word| word == verb).unwrap_or(0) + 1;
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
            own if own == "bake" || OWN.contains(&own) => {
                found.push((own.to_owned(), own, true, as_table(own, content)?));
            }
            "scene" | "object" => {}
            other => bail!(
                "unknown table [{other}]; there are [bake], [{}], [scene.\"FILE\"] and [object.\"NAME\"]",
                OWN.join("], [")
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
                found.push((title.clone(), verb, name == scene, as_table(&title, value)?));
            }
        }
        found.push((title, "bake", name == scene, own));
    }
    Ok(found)
}

/// Tables of options: the title of each, the verb whose flags it holds, whether they are for the scene, and itself.
type Tables<'a> = Vec<(String, &'a str, bool, &'a Table)>;

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
    let verbs = |verb: &str| grammar.find_subcommand(verb).context("no such verb");
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
            let known = find(verbs(of)?, key);
            known.with_context(|| {
                format!("unknown option `{key}` in [{title}]; options are the flags of `ambake {of} --help` without dashes")
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
                "`{key} = {value}` in {place}; there are density = NUMBER, include = true, exclude = true, cast = false and buried = \"keep\" or \"drop\""
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
mod tests {
    use super::*;

    fn job(file: &str, typed: &str) -> anyhow::Result<ambake::flags::bake::Job> {
        let table: Table = file.parse().expect("TOML");
        let typed = format!("ambake bake folder/hall.glb -o out {typed}");
        let typed: Vec<OsString> = typed.split_whitespace().map(OsString::from).collect();
        let path = Path::new("folder/ambake.toml");
        let args = with_flags(&typed, |typed| {
            flags(path, &table, Path::new("folder/hall.glb"), ("bake", typed))
        })?;
        match args.verb {
            Verb::Bake(bake) => Ok(bake.job),
            _ => unreachable!("bake was typed"),
        }
    }

    #[test]
    fn typed_flags_win_over_the_scene_and_the_scene_over_the_folder() {
        let file = "[bake]\nsize = 64\nrays = 8\nlayers = ['bent', 'normal']\nnormal-maps = true\nsky = [1, 0.5, 0.25]\n\
            [scene.'hall.glb']\nsize = 128\n[scene.'other.glb']\nsize = 256\n[object.'wall*']\ndensity = 20\nexclude = false\ncast = false\nburied = 'keep'";
        let plain = job(file, "").unwrap();
        assert_eq!((plain.size, plain.rays, plain.layers.len()), (128, 8, 2));
        assert!(plain.normal_maps);
        assert_eq!(plain.density_of, [("wall*".to_owned(), 20.0)]);
        assert_eq!(plain.no_cast, ["wall*"]);
        assert_eq!(plain.buried_of.len(), 1);
        assert!(plain.buried_of[0].0 == "wall*" && plain.buried_of[0].1 == ambake::Buried::Keep);
        let typed = job(file, "--size 32 --target-error 0.1 --density-of door=4").unwrap();
        assert_eq!((typed.size, typed.target_error), (32, Some(0.1)));
        assert_eq!(typed.density_of.len(), 2, "later ones win, so both stand");
        assert_eq!(typed.density_of[1].0, "door");
    }

    #[test]
    fn verbs_with_a_table_of_their_own_take_theirs_alone_and_it_may_hold_what_is_required() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = "[bake]\nsize = 64\n[probes]\nspacing = 2\nrays = 128\noutput = 'x'\n[scene.'hall.glb'.probes]\nrays = 256\nbake = 'baked'\n\
            [render]\nsize = '32x16'";
        let write =
            |text: &str| std::fs::write(folder.path().join(PROJECT_FILE), text).expect("written");
        std::fs::create_dir(folder.path().join("baked")).expect("a folder");
        let words = |verb: &str, more: &str| -> Vec<OsString> {
            let scene = folder.path().join("hall.glb");
            let words = ["ambake".into(), verb.into(), scene.into_os_string()].into_iter();
            words
                .chain(more.split_whitespace().map(OsString::from))
                .collect()
        };
        write(file);
        let error = with_own_table(words("probes", "-o out")).expect_err("the scene is absent");
        assert!(format!("{error:#}").contains("[scene.\"hall.glb\"] names no file"));
        std::fs::write(folder.path().join("hall.glb"), "").expect("written");
        write(file);
        let error = with_own_table(words("probes", "-o out")).expect_err("output is typed");
        assert!(format!("{error:#}").contains("`output` in [probes] belongs to one run"));
        write(&file.replace("output = 'x'", ""));
        let probes = |more: &str| match Args::of(with_own_table(words("probes", more))?)?.verb {
            Verb::Probes(probes) => anyhow::Ok(probes.job),
            _ => unreachable!("probes was typed"),
        };
        let plain = probes("-o out").expect("all that is required");
        assert_eq!((plain.spacing, plain.rays), (Some(2.0), 256));
        assert_eq!(plain.bake, Some(folder.path().join("baked")));
        // Places and numbers of rays are of one kind or another.
        let typed = probes("-o out --at 0,1,0 --target-error 0.1").expect("all that is required");
        assert_eq!((typed.spacing, typed.at.len(), typed.rays), (None, 1, 1024));
        assert!(
            with_own_table(words("render", ""))
                .expect("words")
                .contains(&"--size=32x16".into())
        );
        let untouched = words("view", "");
        assert_eq!(with_own_table(untouched.clone()).expect("words"), untouched);
    }

    #[test]
    fn objects_of_one_scene_are_named_below_it() {
        let file = "[object.wall]\ndensity = 20\n[scene.'hall.glb'.object.altar]\ndensity = 80\n[scene.'other.glb'.object.door]\ndensity = 4";
        let found = job(file, "").unwrap().density_of;
        assert_eq!(
            found,
            [("wall".to_owned(), 20.0), ("altar".to_owned(), 80.0)]
        );
    }

    #[test]
    fn what_is_wrong_is_one_line_that_names_the_place() {
        for (file, word) in [
            ("size = 64", "outside of a table"),
            ("[bake]\nsise = 64", "unknown option `sise` in [bake]"),
            ("[bake]\nsize = 0", "--size"),
            ("[bake]\nsize = 'big'", "--size"),
            ("[bake]\nsize = {}", "`size` in [bake]"),
            (
                "[bake]\noutput = 'x'",
                "`output` in [bake] belongs to one run",
            ),
            ("[scenes]\n", "unknown table [scenes]"),
            ("[scene]\nrays = 3", "`rays` stands in [scene]"),
            ("[object]\ndensity = 3", "`density` stands in [object]"),
            ("[bake]\nsun = [[1, 2, 3, 4]]", "a list of lists"),
            ("[scene.'other.glb']\nsise = 3", "in [scene.\"other.glb\"]"),
            ("[scene.'other.glb'.object.x]\ndensty = 3", "`densty = 3`"),
            ("[probes]\nsize = 4", "unknown option `size` in [probes]"),
            (
                "[scene.'hall.glb'.render]\nrais = 4",
                "in [scene.\"hall.glb\".render]",
            ),
            ("[object.wall]\nrays = 4", "[object.\"wall\"]"),
            (
                "[scene.'hall.glb'.object.wall]\nrays = 4",
                "[object.\"wall\"]",
            ),
            ("[scene.'hall.glb']\nobject = 3", "unknown option `object`"),
            ("[bake]\nlayers = []", "`layers` in [bake]"),
        ] {
            let Err(error) = job(file, "") else {
                panic!("{file} was taken");
            };
            let text = format!("{error:#}");
            assert!(
                text.contains(word) && !text.contains('\n'),
                "{file}: {text}"
            );
        }
    }
}
