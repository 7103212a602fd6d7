//! The atlas from outside: layouts, footprints, gutters.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests say what they skip"
)]

mod cuts;
mod densities;
mod footprints;
mod gutters;
mod layouts;
mod models;
mod page_counts;
mod reused;
mod scenes;
mod spoilt;
