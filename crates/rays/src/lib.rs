//! The scene as rays see it: triangles placed in the world, the libraries that answer rays, and the surface where a ray
//! met it.
//!
//! [`World`] holds the triangles, [`build`] makes a [`RayBackend`] over it, [`Surfaces`] turns a hit into a
//! [`SurfacePoint`] with its material. A renderer or a baker needs nothing else to cast rays.
//!
//! ```
//! use ambake_rays::{BackendKind, Ray, TreeKind, World, WorldOptions, build};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/plane.obj");
//! # if !std::path::Path::new(file).exists() { return Ok(()); }
//! let scene = std::sync::Arc::new(scene::load(file.as_ref())?);
//! let world = World::new(scene, WorldOptions::default())?;
//! let backend = build(BackendKind::Obvhs(TreeKind::default()), &world, 0)?;
//!
//! let above = world.bounds().center() + glam::DVec3::Y;
//! let down = Ray {
//!     origin: above.as_vec3().to_array(),
//!     direction: [0.0, -1.0, 0.0],
//!     t_min: 0.0,
//!     t_max: f32::INFINITY,
//! };
//! assert_eq!(backend.closest(&down).map(|hit| hit.t), Some(1.0));
//! # Ok(())
//! # }
//! ```
//!
//! # Where what is
//!
//! * Backends: `backend.rs` is the trait, `build.rs` the choice. Which of coinciding triangles a ray meets:
//!   `coincident.rs`.
//! * The world and its precision: `world`, with the lit sides of triangles in `lit.rs`. Where its coordinates count
//!   from: `origin.rs`. Where rays start: `surface.rs`.
//! * What cut-out and see-through surfaces let through: `alpha_test.rs`, channel by channel
//!   `panes.rs`. Material at a point: `material.rs`.
//! * How normal maps bend normals: `normal_maps.rs`, with tangents from `tangents.rs` and their frames in `frames.rs`.
//! * What counts as inside of something: `solid`, with closed bodies and cavities in `mod.rs`, how deep a point lies in
//!   them in `depth.rs`, grounds in `ground`, rooms in `rooms.rs`, bodies without a bottom in `shut.rs`, those that
//!   look inward in `inward.rs` and `wound.rs`, ends of surfaces that nobody sees in `rims.rs` and what thin layers
//!   cover in `covers`. Whether a point of a triangle lies in it: `buried.rs`.
//! * Suns, point lights, spots, balls and panels: `light`. Surfaces that shine: `lamps.rs`.
#![forbid(unsafe_code)]

mod alpha_test;
mod backend;
mod boxes;
mod build;
mod buried;
mod coincident;
mod embree_backend;
mod error;
#[cfg(test)]
mod fixture;
mod frames;
mod geometry;
mod instancing;
mod lamps;
mod light;
mod material;
mod mix;
mod normal_maps;
mod obvhs_backend;
#[cfg(test)]
mod obvhs_tests;
mod origin;
mod panes;
mod part;
mod point;
mod solid;
mod surface;
mod tangents;
mod tree;
mod triangle;
mod world;

pub use alpha_test::AlphaTest;
pub use backend::{
    Coherence, Lanes, PacketWidth, Ray, RayBackend, RayPacket, Stops, SurfaceHit, TreeKind,
};
pub use boxes::Boxes;
pub use build::{BackendKind, build, has_embree};
pub use buried::Burial;
pub use embree_backend::EmbreeBackend;
pub use error::Error;
pub use frames::Frames;
pub use geometry::{Bounds, Geometry, Positions};
pub use lamps::Lamps;
pub use light::{Arrival, Cone, Light};
pub use material::{Overrides, PhongMaterial, emission_at, is_mapped, material_at};
pub use mix::Mix;
pub use obvhs_backend::ObvhsBackend;
pub use part::Part;
pub use point::{SurfacePoint, Surfaces};
pub use scene::around;
pub use solid::{Cover, Covering, Covers, NUDGE, Near, Rim, Solids};
pub use surface::{Patch, PlaneErrors};
pub use world::lit::above;
pub use world::{World, WorldOptions};
