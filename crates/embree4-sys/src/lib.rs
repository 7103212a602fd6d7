//! Raw bindings to the Embree that is installed: 4 where its headers and library are found, else 3.13.
//!
//! `build.rs` generates them from the installed headers through `shim/shim.h` and compiles `shim/shim.c` against the
//! same headers. Where Embree (or libclang, which generates the bindings) is missing, or `AMBAKE_NO_EMBREE=1` is set,
//! this crate is empty; with the feature `required` what is missing fails the build. Dependents learn what happened
//! from build metadata:
//!
//! | variable | value |
//! |---|---|
//! | `DEP_EMBREE_AVAILABLE` | `1`, or `0` where the crate is empty |
//! | `DEP_EMBREE_HEADER_VERSION` | for example `4.3.3` |
//! | `DEP_EMBREE_LIB_DIR` | the folder that holds the library at link time |
//! | `DEP_EMBREE_ABSENT_BECAUSE` | one sentence, where the crate is empty |
//!
//! `EMBREE_INCLUDE_DIR` (the folder that holds `embree4/` or `embree3/`) and `EMBREE_LIB_DIR` come before the system.
//! Enums are plain integers: a value that these headers do not know is not undefined behaviour.

#![no_std]

#[cfg(embree)]
#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unused_qualifications,
    clippy::all,
    clippy::undocumented_unsafe_blocks,
    rustdoc::all
)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

#[cfg(embree)]
pub use bindings::*;
