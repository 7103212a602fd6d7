//! Rays meet mathematics: backends, planner, integrator.
#![forbid(unsafe_code)]

mod alpha;
mod backend;
mod embree_backend;
mod error;
#[cfg(test)]
mod fixture;
mod mix;
mod obvhs_backend;
#[cfg(test)]
mod obvhs_tests;
mod parity;
mod referee;
mod tree;
mod triangle;
mod world;

pub use alpha::AlphaTest;
pub use backend::{BackendKind, Coherence, Layout, Ray, RayBackend, RayPacket, SurfaceHit, build};
pub use embree_backend::EmbreeBackend;
pub use error::Error;
pub use obvhs_backend::ObvhsBackend;
pub use parity::{Answer, Disagreement, ParityReport, TestRays, parity};
pub use referee::{Margin, Ruling, judge, judge_triangle, t_rounding};
pub use world::{Bounds, Geometry, Part, Positions, World, WorldOptions};
