//! What can go wrong before or while a picture is made.

use std::path::PathBuf;

/// A failure with one line that says what to change.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The camera has no direction or no upright.
    #[error("the camera {problem}; give other --eye, --look or --up")]
    Camera {
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A baked scene or page is absent or damaged.
    #[error(transparent)]
    Report(#[from] report::Error),
    /// A baked scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// A map cannot be used.
    #[error(transparent)]
    Map(#[from] environment::Error),
    /// A line of a text table is not what it should be.
    #[error("line {line}: {expected} belong there")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What each line holds.
        expected: &'static str,
    },
    /// A text table cannot be used as a whole.
    #[error("{0}")]
    Text(&'static str),
    /// The listener asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// A bake does not hold what the picture needs.
    #[error("{}: {problem}", path.display())]
    Bake {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        problem: String,
    },
}
