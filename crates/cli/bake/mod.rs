//! `ambake bake` and `ambake plan`.

pub mod checkpoint;
pub mod options;
pub mod plan;
pub mod run;
pub mod sky;
pub mod summary;
