//! What can go wrong with a blur.

/// A failure with one line that names the place and the cure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A picture or a request that the job cannot use.
    #[error(transparent)]
    Environment(#[from] environment::Error),
    /// A line of a text table is not what it should be.
    #[error("line {line}: {expected} belong there")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What each line holds.
        expected: &'static str,
    },
    /// A lobe that is no reflectance function.
    #[error("unusable lobe: {0}")]
    Lobe(String),
}
