//! `ambake bench`.

pub mod run;
