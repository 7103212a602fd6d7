//! `ambake probes`: light for what moves.

pub mod args;
pub mod part;
pub mod run;
