//! `ambake bake` and `ambake plan`.

pub mod args;
mod layer_help;
mod options;
pub mod plan;
pub mod prepare;
pub mod run;
mod sky;
mod stdin;
mod summary;
