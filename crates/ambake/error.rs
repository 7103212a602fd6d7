//! What can go wrong between a scene and its written lightmaps.
//!
//! Messages of this and of the other crates call options by their flags, as the command line shows them
//! ([`Error::in_flags`]). What a library shows names the options themselves: that is done here alone ([`in_names`]).

use std::convert::Infallible;
use std::fmt;

/// Why a bake could not be made or written. Every message is one line that says what, where, and what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// The scene cannot be loaded or built.
    Scene(scene::Error),
    /// The sky's picture cannot be read.
    Sky(environment::Error),
    /// An option has a value that it cannot have, or two options exclude each other.
    Option {
        /// The option by its own name, or by its flag.
        name: &'static str,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A material gives off more light than can be baked.
    Emission {
        /// The scene.
        scene: String,
        /// Its material.
        material: String,
        /// Its largest channel.
        value: f32,
    },
    /// A result would have a name that the file system does not take.
    LongName {
        /// Where the result would go.
        path: String,
    },
    /// The charts cannot be laid out.
    Layout {
        /// The scene.
        scene: String,
        /// Why, and what to do.
        source: atlas::Error,
    },
    /// The scene cannot be made ready for rays.
    Rays(rays::Error),
    /// Worker threads cannot be started.
    Threads(rayon::ThreadPoolBuildError),
    /// A result cannot be written, or an earlier one cannot be read.
    Output(report::Error),
    /// The pages of a finished bake cannot be looked up.
    Lightmap(render::Error),
    /// A file of a bake could not be written. What was saved before stays.
    Unwritten {
        /// Which file, and why not.
        source: report::Error,
        /// MiB that all files of the bake take, about.
        needed: u64,
    },
    /// The parts of a sharded bake cannot be merged.
    Parts {
        /// Their directory.
        dir: String,
        /// What is missing or does not fit, and what to do.
        problem: String,
    },
    /// The bake would not fit into memory.
    Memory {
        /// Bytes that it would take.
        need: u64,
        /// Bytes that it may take.
        limit: u64,
        /// Who sets this limit.
        limited_by: LimitedBy,
        /// A page edge in texels that fits, where there is one.
        size: Option<u32>,
    },
    /// A file of an earlier bake holds something else than it should.
    Damaged {
        /// The file.
        path: String,
    },
    /// What an update kept is not what a bake gives.
    Differs {
        /// The earlier bake.
        dir: String,
        /// The page.
        page: u32,
        /// Column and row of the first texel of the tile.
        texel: [u32; 2],
    },
    /// The progress listener cancelled the bake.
    Cancelled,
}

/// Errors of others that become one of ours as they are.
macro_rules! from {
    ($($variant:ident($error:ty),)*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        }
    )*};
}

from! {
    Scene(scene::Error),
    Sky(environment::Error),
    Rays(rays::Error),
    Threads(rayon::ThreadPoolBuildError),
    Output(report::Error),
    Lightmap(render::Error),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&in_names(&self.in_flags()))
    }
}

impl std::error::Error for Error {
    /// What is behind the error that the message tells of.
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Scene(error) => error.source(),
            Self::Sky(error) => error.source(),
            Self::Rays(error) => error.source(),
            Self::Output(error) | Self::Unwritten { source: error, .. } => error.source(),
            Self::Lightmap(error) => error.source(),
            _ => None,
        }
    }
}

impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl Error {
    /// The message as the command line says it: with `--max-memory` for the option `max_memory`.
    pub fn in_flags(&self) -> String {
        match self {
            Self::Scene(error) => error.to_string(),
            Self::Sky(error) => error.to_string(),
            Self::Option { name, problem } => format!("{name}: {problem}"),
            Self::Emission {
                scene,
                material,
                value,
            } => format!(
                "{scene}: material `{material}` has an emission of {value:e}; it must be from 0 to 1e12"
            ),
            Self::LongName { path } => format!(
                "{path}: the name is too long for this file system; give the scene's file a shorter one"
            ),
            Self::Layout { scene, source } => format!("{scene}: {source}"),
            Self::Rays(error) => error.to_string(),
            Self::Threads(error) => format!("cannot start the worker threads: {error}"),
            Self::Output(error) => error.to_string(),
            Self::Lightmap(error) => error.to_string(),
            Self::Unwritten { source, needed } => format!(
                "{source}; what was saved is kept, the same command goes on from it (all files take about {needed} MiB)"
            ),
            Self::Parts { dir, problem } => format!("{dir}: {problem}"),
            Self::Memory {
                need,
                limit,
                limited_by,
                size,
            } => too_large(*need, *limit, *limited_by, *size),
            Self::Damaged { path } => format!("cannot read {path}: the file is damaged"),
            Self::Differs {
                dir,
                page,
                texel: [x, y],
            } => format!(
                "page {page}: the texels about {x}, {y} that were kept of {dir} differ from those of a new bake; \
                 nothing was written, bake without --update"
            ),
            Self::Cancelled => "the bake was cancelled".into(),
        }
    }

    /// A complaint about an option.
    pub(crate) fn option(name: &'static str, problem: impl Into<String>) -> Self {
        Self::Option {
            name,
            problem: problem.into(),
        }
    }
}

/// What bounds the memory of a bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LimitedBy {
    /// The caller, by [`Bake::max_memory`](crate::Bake::max_memory).
    Given,
    /// What the machine has free.
    Machine,
    /// A control group of this process, such as its container.
    Group,
    /// A limit of this process, as `ulimit` sets it.
    Process,
}

/// What to do about a bake that does not fit into memory.
fn too_large(need: u64, limit: u64, by: LimitedBy, size: Option<u32>) -> String {
    let in_units = |bytes: u64| match bytes as f64 / f64::from(1 << 20) {
        mib if mib < 1024.0 => format!("{mib:.0} MiB"),
        mib => format!("{:.2} GiB", mib / 1024.0),
    };
    let whose = match by {
        LimitedBy::Given => "--max-memory allows",
        LimitedBy::Machine => "this system has",
        LimitedBy::Group => "the control group of this process allows",
        LimitedBy::Process => "the limits of this process (ulimit) allow",
    };
    let advice = match (size, by) {
        (Some(size), LimitedBy::Given) => format!("`--size {size}` fits"),
        (Some(size), LimitedBy::Machine) => {
            format!("`--size {size}` fits, and `--max-memory` overrides this check")
        }
        (Some(size), LimitedBy::Group) => format!("`--size {size}` fits, or raise that limit"),
        (Some(size), LimitedBy::Process) => {
            format!("`--size {size}` fits, or raise that limit or take fewer `--threads`")
        }
        (None, LimitedBy::Given) => {
            "the scene alone does not fit; raise --max-memory, or take a machine with more".into()
        }
        (None, LimitedBy::Machine) => {
            "the scene alone does not fit; take a machine with more, or override this check with \
             --max-memory"
                .into()
        }
        (None, LimitedBy::Group | LimitedBy::Process) => {
            "the scene alone does not fit; raise that limit".into()
        }
    };
    format!(
        "the bake takes about {} of memory and {whose} {}; {advice}",
        in_units(need),
        in_units(limit),
    )
}

/// Flags that are not called as their options.
const RENAMED: [(&str, &str); 4] = [
    ("allow-outside", "Files::Anywhere"),
    ("for", "for_engines"),
    ("lights", "file_lights"),
    ("to", "to_vertices"),
];

/// A message with options for its flags: `` `size` 512 `` for `` `--size 512` `` and `` `threads` `` for `--threads`. A
/// whole command of the program stays what it is, and so do names with two hyphens.
fn in_names(message: &str) -> String {
    let is_name = |c: char| c.is_ascii_lowercase() || c == '-';
    let mut named = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(at) = rest.find("--") {
        let (before, after) = (&rest[..at], &rest[at + 2..]);
        let (flag, value) = after.split_at(after.find(|c| !is_name(c)).unwrap_or(after.len()));
        let is_quoted = before.ends_with('`');
        let so_far = &message[..message.len() - after.len()];
        let is_command = so_far.matches('`').count() % 2 == 1 && !is_quoted;
        let is_flag = is_quoted || before.is_empty() || before.ends_with(' ');
        if flag.is_empty() || is_command || !is_flag {
            named += &rest[..at + 2 + flag.len()];
            rest = value;
            continue;
        }
        named += before.strip_suffix('`').unwrap_or(before);
        named += &format!("`{}`", option(flag));
        rest = match (is_quoted, value.find('`')) {
            (true, Some(end)) => {
                named += &value[..end];
                &value[end + 1..]
            }
            _ => value,
        };
    }
    (named + rest).replace(" with -o", "")
}

/// The option that a flag sets.
fn option(flag: &str) -> String {
    let own = RENAMED.iter().find(|(renamed, _)| *renamed == flag);
    own.map_or_else(|| flag.replace('-', "_"), |(_, option)| (*option).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_names_flags_on_the_command_line_and_options_in_a_library() {
        let error = Error::Memory {
            need: 3 << 30,
            limit: 1 << 30,
            limited_by: LimitedBy::Machine,
            size: Some(512),
        };
        let flags = error.in_flags();
        assert!(
            flags.ends_with("`--size 512` fits, and `--max-memory` overrides this check"),
            "{flags}"
        );
        let names = error.to_string();
        assert!(
            names.ends_with("`size` 512 fits, and `max_memory` overrides this check"),
            "{names}"
        );
        for (message, expected) in [
            (
                "lower --size, ask for fewer --layers",
                "lower `size`, ask for fewer `layers`",
            ),
            (
                "name one of them by --for",
                "name one of them by `for_engines`",
            ),
            (
                "run `ambake bake A --shard 1/2`",
                "run `ambake bake A --shard 1/2`",
            ),
            (
                "/a--b/c.obj: choose another place with -o",
                "/a--b/c.obj: choose another place",
            ),
            (
                "use `--uv auto` or `--uv unwrap`, or `a --b --c`",
                "use `uv` auto or `uv` unwrap, or `a --b --c`",
            ),
        ] {
            assert_eq!(in_names(message), expected);
        }
    }
}
