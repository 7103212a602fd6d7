//! The table of layers: one place that says what a bake can write, in which unit, and how it is stored and shown.
#![forbid(unsafe_code)]

mod layer;

pub use layer::Layer;
