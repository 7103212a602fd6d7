//! `ambake bench`: speed against error.

pub mod args;
mod peers;
pub mod run;
mod stated;
mod texels;
