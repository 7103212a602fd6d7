//! Rays meet mathematics: backends, planner, integrator.
#![forbid(unsafe_code)]

mod alpha;
mod backend;
mod both;
mod cell;
mod compose;
mod embree_backend;
mod error;
mod error_estimate;
mod filter;
#[cfg(test)]
mod fixture;
mod gang;
mod integrate;
mod layer;
mod mix;
mod obvhs_backend;
#[cfg(test)]
mod obvhs_tests;
mod open;
mod options;
mod page;
mod parity;
mod plan;
mod point;
mod referee;
mod regress;
mod surface;
mod texel;
mod tree;
mod triangle;
mod world;

pub use alpha::AlphaTest;
pub use backend::{BackendKind, Coherence, Layout, Ray, RayBackend, RayPacket, SurfaceHit, build};
pub use both::Both;
pub use compose::BakedTexel;
pub use embree_backend::EmbreeBackend;
pub use error::Error;
pub use integrate::{REPLICATES, Terms};
pub use layer::Layer;
pub use obvhs_backend::ObvhsBackend;
pub use open::OpenTriangles;
pub use options::{Effort, Filter, Options, Overrides, Pattern, PointSet, Sky, SkyMap, View};
pub use page::{Bake, BakedPage, PageStats, Plane, Progress};
pub use parity::{Answer, Disagreement, ParityReport, TestRays, parity};
pub use plan::{Choice, Decision, Plan};
pub use point::{SurfacePoint, Surfaces};
pub use referee::{Margin, Ruling, judge, judge_triangle, t_rounding};
pub use texel::TexelMaterial;
pub use world::{Bounds, Geometry, Part, Positions, World, WorldOptions};
