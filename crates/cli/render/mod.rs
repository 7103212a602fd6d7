//! `ambake render`.

pub mod figures;
pub mod frames;
pub mod run;
pub mod table_args;
