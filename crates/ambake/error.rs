//! What can go wrong between a scene and its written lightmaps.

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
    /// A finished bake could not be written. Its state is saved.
    #[error(
        "{source}; what was baked is kept, the same command with --resume writes it (about {needed} MiB)"
    )]
    Unwritten {
        /// Which file, and why not.
        source: report::Error,
        /// MiB that all files of the bake take, about.
        needed: u64,
    },
    /// The progress listener cancelled the bake.
    #[error("the bake was cancelled")]
    Cancelled,
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
