//! Pure mathematics of ambient reflection: models, closed forms, sampling.
//!
//! No rays, files, threads or printing. Everything is `f64`; callers convert to `f32` in one place of their own.
//! Directions are unit vectors that point away from the surface; angles are radians.

#![forbid(unsafe_code)]

pub mod closed_form;
pub mod convention;
mod estimate;
pub mod frame;
pub mod lanes;
pub mod models;
pub mod quadrature;
pub mod sampling;

pub use estimate::Estimate;
pub use frame::Frame;
