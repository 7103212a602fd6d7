//! `ambake bake` and `ambake plan`.

pub mod args;
mod layer_help;
pub mod layout;
pub mod merge;
pub mod options;
pub mod plan;
pub mod prepare;
pub mod run;
pub mod shard;
mod stdin;
mod summary;
pub mod values;
pub mod watch;
