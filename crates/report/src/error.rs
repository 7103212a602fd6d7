//! What can go wrong while output is written or a finished bake is read back.

use std::io;
use std::path::{Path, PathBuf};

/// A failure with one line that names the file, the place and the cure.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The output directory cannot be made or is not a directory.
    #[error("cannot use {} as output directory: {reason}; choose another with -o", path.display())]
    Directory {
        /// The directory asked for.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// Another job has the directory.
    #[error("another bake into {} is running; wait for it, or choose another place with -o", path.display())]
    Busy {
        /// The directory asked for.
        path: PathBuf,
    },
    /// The results will not fit.
    #[error(
        "{} has {} MiB free, and this bake needs about {} MiB there for its results and its saved state; free some \
         space, lower --size, ask for fewer --layers, or choose another place with -o",
        path.display(), free >> 20, needed.div_ceil(1 << 20)
    )]
    Full {
        /// The directory asked for.
        path: PathBuf,
        /// Bytes that are free there.
        free: u64,
        /// Bytes that are needed.
        needed: u64,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {source}; {}", path.display(), advice(source))]
    Write {
        /// The final name of the file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// An output would replace a file that it is made from.
    #[error("{} is an input of this job and would be replaced; choose another place with -o", path.display())]
    ReplacesInput {
        /// The file.
        path: PathBuf,
    },
    /// A result would replace a scene that is none of an earlier bake.
    #[error(
        "{} was not written by a bake into this directory and would be replaced; move it, or choose another place with \
         -o",
        path.display()
    )]
    ReplacesScene {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be read, or is not what it should be.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        reason: String,
    },
    /// A value to be written is NaN or infinite. This is a bug of the baker, caught before it reaches a file.
    #[error(
        "layer {layer} holds {value} at texel ({x}, {y}); nothing was written, please report this scene"
    )]
    NonFinite {
        /// Channel name.
        layer: String,
        /// Texel column.
        x: u32,
        /// Texel row.
        y: u32,
        /// The value.
        value: f32,
    },
    /// A file is asked for that cannot be made of what is there.
    #[error("{option}: {problem}")]
    Mismatched {
        /// The file, or the flag that asks for it.
        option: String,
        /// Why not, and what to do.
        problem: String,
    },
    /// A page lacks a layer that the job needs.
    #[error("the page has no layer {layer}; bake again with --layers {layer}")]
    MissingLayer {
        /// Layer name.
        layer: String,
    },
    /// Two pages that are to be compared do not fit.
    #[error("pages differ: {reason}; compare pages of the same layout")]
    Mismatch {
        /// How they differ.
        reason: String,
    },
    /// Two pages that are to be compared do not show the same surfaces.
    #[error("{reason}")]
    Unrelated {
        /// What their headers say, and what to compare instead.
        reason: String,
    },
}

impl Error {
    /// A write error for the final name `path`.
    pub(crate) fn write(path: &Path, source: io::Error) -> Error {
        Error::Write {
            path: path.to_owned(),
            source,
        }
    }

    /// A read error for `path`.
    pub(crate) fn read(path: &Path, reason: impl Into<String>) -> Error {
        Error::Read {
            path: path.to_owned(),
            reason: reason.into(),
        }
    }
}

/// What to do about a failed write.
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free some space and run again"
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "make the directory writable or choose another with -o"
        }
        io::ErrorKind::IsADirectory => "move the directory of that name away",
        _ => "check the disk and run again",
    }
}
