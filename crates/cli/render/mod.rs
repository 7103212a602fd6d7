//! `ambake render`: pictures through a camera.

pub mod args;
mod ball_args;
mod balls;
#[cfg(feature = "bench")]
mod figures;
mod file;
mod frames;
mod options;
mod picture;
mod relit;
pub mod run;
mod tables_args;
