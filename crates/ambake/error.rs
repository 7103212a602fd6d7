//! What can go wrong between a scene and its written lightmaps.

use std::convert::Infallible;

/// Why a bake could not be made or written. Every message is one line that says what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene cannot be loaded or built.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// The sky's picture cannot be read.
    #[error(transparent)]
    Sky(#[from] maps::Error),
    /// An option has a value that it cannot have, or two options exclude each other.
    #[error("{name}: {problem}")]
    Option {
        /// The option, as its flag is called.
        name: &'static str,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A material gives off more light than can be baked.
    #[error(
        "{scene}: material `{material}` has an emission of {value:e}; it must be from 0 to 1e12"
    )]
    Emission {
        /// The scene.
        scene: String,
        /// Its material.
        material: String,
        /// Its largest channel.
        value: f32,
    },
    /// A result would have a name that the file system does not take.
    #[error(
        "{path}: the name is too long for this file system; give the scene's file a shorter one"
    )]
    LongName {
        /// Where the result would go.
        path: String,
    },
    /// The charts cannot be laid out.
    #[error("{scene}: {source}")]
    Layout {
        /// The scene.
        scene: String,
        /// Why, and what to do.
        source: atlas::Error,
    },
    /// The scene cannot be made ready for rays.
    #[error(transparent)]
    Rays(#[from] rays::Error),
    /// Worker threads cannot be started.
    #[error("cannot start the worker threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A result cannot be written, or an earlier one cannot be read.
    #[error(transparent)]
    Output(#[from] report::Error),
    /// The pages of a finished bake cannot be looked up.
    #[error(transparent)]
    Lightmap(#[from] render::Error),
    /// A file of a bake could not be written. What was saved before stays.
    #[error(
        "{source}; what was saved is kept, the same command goes on from it (all files take about {needed} MiB)"
    )]
    Unwritten {
        /// Which file, and why not.
        source: report::Error,
        /// MiB that all files of the bake take, about.
        needed: u64,
    },
    /// The parts of a sharded bake cannot be merged.
    #[error("{dir}: {problem}")]
    Parts {
        /// Their directory.
        dir: String,
        /// What is missing or does not fit, and what to do.
        problem: String,
    },
    /// The bake would not fit into memory.
    #[error("{}", too_large(*need, *limit, *limited_by, *size))]
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
    #[error("cannot read {path}: the file is damaged")]
    Damaged {
        /// The file.
        path: String,
    },
    /// What an update kept is not what a bake gives.
    #[error(
        "page {page}: the texels about {}, {} that were kept of {dir} differ from those of a new bake; nothing was written, bake without --update",
        texel[0], texel[1]
    )]
    Differs {
        /// The earlier bake.
        dir: String,
        /// The page.
        page: u32,
        /// Column and row of the first texel of the tile.
        texel: [u32; 2],
    },
    /// The progress listener cancelled the bake.
    #[error("the bake was cancelled")]
    Cancelled,
}

impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl Error {
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
