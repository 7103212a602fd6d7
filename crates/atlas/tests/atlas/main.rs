//! The atlas from outside: layouts, footprints, gutters.

mod cuts;
mod footprints;
mod gutters;
mod layouts;
mod models;
mod reused;
mod scenes;
