//! `ambake.toml` beside a scene: flags of the verbs that bake, plan, watch or lay out, which need not be typed again.
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
//! ```
//!
//! What is typed wins over the file. The file's options are put before the typed ones and both are read by the same
//! parser, so that each has the range and the meaning of its flag.

use crate::args::{Args, Verb};
use crate::bake::args::Bake;
use crate::common::text_file;
use anyhow::{Context, bail};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args as ClapArgs, FromArgMatches};
use std::ffi::OsString;
use std::path::Path;
use toml::{Table, Value};

/// The name of the file.
pub const PROJECT_FILE: &str = "ambake.toml";

/// Options of the file that are left out where one of the others is typed.
const EXCLUDE: [(&[&str], &[&str]); 2] = [
    (&["rays"], &["target-error", "target-relative", "max-rays"]),
    (&["layers"], &["only"]),
];

/// Flags that are for one run alone.
const ONCE: [&str; 8] = [
    "output", "fresh", "resume", "shard", "update", "verify", "after", "json",
];

/// What was `typed`, the program's name first, completed by the project file beside the scene; `None` where there is no
/// such file.
///
/// # Errors
/// One line that names the file, the table and the option.
pub fn completed(scene: &Path, typed: &[OsString]) -> anyhow::Result<Option<Verb>> {
    let path = scene.with_file_name(PROJECT_FILE);
    if scene == Path::new("-") || !path.is_file() {
        return Ok(None);
    }
    let table = read(&path)?;
    let args = with_flags(typed, |typed| flags(&path, &table, scene, typed))
        .with_context(|| path.display().to_string())?;
    Ok(Some(args.verb))
}

/// The file's tables.
fn read(path: &Path) -> anyhow::Result<Table> {
    let text = text_file(path)?;
    text.parse::<Table>().map_err(|error| {
        let before = error
            .span()
            .map_or("", |span| &text[..span.start.min(text.len())]);
        let line = before.matches('\n').count() + 1;
        anyhow::anyhow!("{} line {line}: {}", path.display(), error.message())
    })
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
    let at = typed.iter().position(|word| word == verb).unwrap_or(0) + 1;
    let more = flags(below)?.into_iter().map(OsString::from);
    let words = typed[..at].iter().cloned().chain(more);
    let words = words.chain(typed[at..].iter().cloned());
    let matches = Args::grammar()
        .try_get_matches_from(words)
        .map_err(one_line)?;
    Args::from_arg_matches(&matches).map_err(one_line)
}

/// The file's options for a scene as flags, but for those that were typed.
fn flags(
    path: &Path,
    table: &Table,
    scene: &Path,
    typed: &ArgMatches,
) -> anyhow::Result<Vec<String>> {
    let known = Bake::augment_args(clap::Command::new("bake"));
    let once = |arg: &&Arg| arg.get_long().is_some_and(|name| !ONCE.contains(&name));
    let known: Vec<&Arg> = known.get_arguments().filter(once).collect();
    let name = scene.file_name().unwrap_or_default().to_string_lossy();
    let mut options: Vec<(String, String, Value)> = Vec::new();
    let mut flags = Vec::new();
    for (title, content) in table {
        let content = content.as_table().with_context(|| {
            format!("`{title}` stands outside of a table; write it below [bake]")
        })?;
        match title.as_str() {
            "bake" => {}
            "scene" => {}
            "object" => {
                for (object, wishes) in content {
                    flags.extend(object_flags(object, wishes)?);
                }
            }
            other => bail!(
                "unknown table [{other}]; there are [bake], [scene.\"FILE\"] and [object.\"NAME\"]"
            ),
        }
    }
    let own = table.get("scene").and_then(|scenes| scenes.get(&*name));
    for (title, content) in [
        ("bake".to_owned(), table.get("bake")),
        (format!("scene.\"{name}\""), own),
    ] {
        let Some(content) = content else { continue };
        let content = content
            .as_table()
            .with_context(|| format!("[{title}] is no table"))?;
        for (key, value) in content {
            let objects = value
                .as_table()
                .filter(|_| key == "object" && title != "bake");
            if let Some(objects) = objects {
                for (object, wishes) in objects {
                    flags.extend(object_flags(object, wishes)?);
                }
                continue;
            }
            options.retain(|(_, earlier, _)| earlier != key);
            options.push((title.clone(), key.clone(), value.clone()));
        }
    }
    let is_typed = |flag: &str| {
        let arg = known.iter().find(|arg| arg.get_long() == Some(flag));
        arg.is_some_and(|arg| {
            let source = typed.try_contains_id(arg.get_id().as_str()).is_ok();
            source && typed.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine)
        })
    };
    for (title, key, value) in options {
        let arg = known.iter().find(|arg| arg.get_long() == Some(&key));
        let arg = arg.with_context(|| {
            format!("unknown option `{key}` in [{title}]; options are the flags of `ambake bake --help` without dashes")
        })?;
        // What a verb does not take, such as files for engines in a plan, serves the others.
        if typed.try_contains_id(arg.get_id().as_str()).is_err() {
            continue;
        }
        let repeats = matches!(arg.get_action(), ArgAction::Append);
        let excluded = EXCLUDE.iter().any(|(a, b)| {
            let against = |one: &[&str], other: &[&str]| {
                one.contains(&key.as_str()) && other.iter().any(|flag| is_typed(flag))
            };
            against(a, b) || against(b, a)
        });
        if excluded || (is_typed(&key) && !repeats) {
            continue;
        }
        let words = words(&value).with_context(|| {
            format!("`{key}` in [{title}] is neither text, number, true, false nor a list")
        })?;
        match value {
            Value::Boolean(on) if matches!(arg.get_action(), ArgAction::SetTrue) => {
                if on {
                    flags.push(format!("--{key}"));
                }
            }
            Value::Array(_) if repeats && arg.get_value_delimiter().is_none() => {
                flags.extend(words.iter().map(|word| format!("--{key}={word}")));
            }
            _ => {
                let beside = path.with_file_name(&words[0]);
                let word = match key == "sky" && words.len() == 1 && beside.is_file() {
                    true => beside.display().to_string(),
                    false => words.join(","),
                };
                flags.push(format!("--{key}={word}"));
            }
        }
    }
    Ok(flags)
}

/// The flags for the objects of a name.
fn object_flags(name: &str, wishes: &Value) -> anyhow::Result<Vec<String>> {
    let place = format!("[object.\"{name}\"]");
    let wishes = wishes
        .as_table()
        .with_context(|| format!("{place} is no table"))?;
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

    fn job(file: &str, typed: &str) -> anyhow::Result<crate::bake::args::Job> {
        let table: Table = file.parse().expect("TOML");
        let typed = format!("ambake bake folder/hall.glb -o out {typed}");
        let typed: Vec<OsString> = typed.split_whitespace().map(OsString::from).collect();
        let path = Path::new("folder/ambake.toml");
        let args = with_flags(&typed, |typed| {
            flags(path, &table, Path::new("folder/hall.glb"), typed)
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
        assert!(
            plain.buried_of[0].0 == "wall*"
                && plain.buried_of[0].1 == crate::bake::args::Buried::Keep
        );
        let typed = job(file, "--size 32 --target-error 0.1 --density-of door=4").unwrap();
        assert_eq!((typed.size, typed.target_error), (32, Some(0.1)));
        assert_eq!(typed.density_of.len(), 2, "later ones win, so both stand");
        assert_eq!(typed.density_of[1].0, "door");
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
            ("[bake]\noutput = 'x'", "unknown option `output`"),
            ("[scenes]\n", "unknown table [scenes]"),
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
