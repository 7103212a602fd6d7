//! `ambake bake` and `ambake plan`.

pub mod args;
pub mod layout;
pub mod merge;
pub mod plan;
pub mod prepare;
pub mod run;
pub mod shard;
mod stdin;
mod summary;
pub mod watch;
