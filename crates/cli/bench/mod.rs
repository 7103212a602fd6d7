//! `ambake bench`: speed against error.

pub mod args;
pub mod run;
mod texels;
