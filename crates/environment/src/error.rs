//! What can go wrong with a map.

use std::path::PathBuf;

/// A failure with one line that names the file, the place and the cure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A file cannot be read, or is not what it should be.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        reason: String,
    },
    /// A pixel is no radiance: NaN, infinite or negative.
    #[error("{}: {channel} of pixel ({x}, {y}) is {value}; radiance is finite and at least 0, repair the \
        picture", path.display())]
    Pixel {
        /// The file.
        path: PathBuf,
        /// Column from the left, from 0.
        x: usize,
        /// Row from the top, from 0.
        y: usize,
        /// `red`, `green` or `blue`.
        channel: &'static str,
        /// The value.
        value: f32,
    },
    /// A header says a word for its projection or its axes that is none.
    #[error("{}: {label} in its header is {word:?}, none of {known}; give the right one by {flag} of `ambake \
        map`", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// `ambakeProjection` or `ambakeOrientation`.
        label: &'static str,
        /// What stands there.
        word: String,
        /// What may stand there.
        known: String,
        /// The flag that overrides it.
        flag: &'static str,
    },
    /// A file's picture cannot be laid out as it is said to be, or nobody says how it is.
    #[error("{}: {reason}", path.display())]
    Layout {
        /// The file.
        path: PathBuf,
        /// What does not fit and what to do.
        reason: String,
    },
    /// A picture or a request of a shape that the job cannot use.
    #[error("{0}")]
    Shape(String),
    /// A value that the chosen file format cannot hold.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
}
