//! `ambake map`: illumination maps and reflection maps.

pub mod args;
mod ball;
mod capture;
mod convert;
pub mod file;
mod merge;
mod mosaic;
mod reflect;
pub mod run;
mod stats;
