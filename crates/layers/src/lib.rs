//! The ground that all crates stand on: the table of layers, and how a long job tells its progress.
//!
//! The table is the one place that says what a bake can write, in which unit, and how it is stored and shown.
//!
//! # Where what is
//!
//! `layer.rs` is the table, `progress.rs` the trait of progress. A new layer gets its line in the table and its value
//! in `crates/bake/src/page/compose.rs`.
#![forbid(unsafe_code)]

mod layer;
mod progress;

pub use layer::{Layer, Preview, Term, Unit};
pub use progress::Progress;
