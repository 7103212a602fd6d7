//! Intel Open Image Denoise, loaded at run time: nothing is linked, and a program without the library runs as well.
//!
//! Versions 1 and 2 of its C interface agree in all functions that are called here, but for the name of one. The
//! processor's device is used, whose bits do not depend on the number of threads; another version of the library, or
//! another set of vector instructions, may give others. Its documentation is
//! <https://www.openimagedenoise.org/documentation.html>.
//!
//! # Where what is
//!
//! The library's functions are called in `library.rs`; `absent.rs` stands in where the feature `library` is left out.
//! `crates/bake/src/denoise/oidn.rs` hands it pages.

#[cfg(not(feature = "library"))]
mod absent;
#[cfg(feature = "library")]
mod library;

#[cfg(not(feature = "library"))]
pub use absent::{Oidn, load};
#[cfg(feature = "library")]
pub use library::{Oidn, load};

/// The variable that names a folder with the library in it, or in its `lib`.
pub const FOLDER: &str = "OIDN_DIR";

/// Why nothing was denoised.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The library is nowhere.
    #[error(
        "Intel Open Image Denoise is not installed: `pip download --no-deps pyoidn==2.5.1.0`, unzip the file and set \
         OIDN_DIR to its folder pyoidn/oidn, or leave the denoiser to `--denoise regression`"
    )]
    Absent,
    /// The feature `library` is left out.
    #[error(
        "this program is built without Intel Open Image Denoise; build it with the feature `oidn`"
    )]
    LeftOut,
    /// A library of that name lacks a function.
    #[error("{file} is no Intel Open Image Denoise of version 1 or 2: it lacks {function}")]
    Foreign {
        /// Name or path of the library.
        file: String,
        /// The first function that is missing.
        function: &'static str,
    },
    /// A library of another version, whose functions may have other types.
    #[error("{file} is version {}.{} of Intel Open Image Denoise; this ambake calls 1 and 2", version / 10_000,
        version / 100 % 100)]
    Version {
        /// Name or path of the library.
        file: String,
        /// 10,000 times the major version, 100 times the minor one, and the patch.
        version: i32,
    },
    /// The library refused.
    #[error("Intel Open Image Denoise: {0}")]
    Refused(String),
}
