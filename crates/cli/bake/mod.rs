//! `ambake bake` and `ambake plan`.

pub mod args;
mod checkpoint;
pub mod options;
pub mod plan;
pub mod run;
mod sky;
mod summary;
