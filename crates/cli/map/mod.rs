//! `ambake map`.

pub mod args;
pub mod ball;
pub mod capture;
pub mod file;
pub mod merge;
