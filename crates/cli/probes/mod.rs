//! `ambake probes`: light for what moves.

pub mod args;
pub mod merge;
pub mod run;
