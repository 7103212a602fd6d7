//! A safe wrapper over Debian's Embree (4, else 3.13): triangle meshes, instances, occlusion and closest hits.
//!
//! ```
//! use ambake_embree::{Device, DeviceConfig, Error, Ray, SceneBuilder};
//!
//! let device = match Device::new(&DeviceConfig::default()) {
//!     Ok(device) => device,
//!     Err(Error::NotBuilt) => return Ok(()), // Embree was not installed when this was built
//!     Err(e) => return Err(e),
//! };
//! let mut builder = SceneBuilder::new(&device);
//! builder.triangles(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]], &[[0, 1, 2]])?;
//! let scene = builder.commit()?;
//! let ray = Ray { origin: [0.25, 0.25, 0.0], direction: [0.0, 0.0, 1.0], t_min: 0.0, t_max: f32::INFINITY };
//! assert!(scene.occluded(&ray));
//! # Ok::<(), Error>(())
//! ```
//!
//! Conventions, equal in both majors, for single rays, packets and closest hits, with robust traversal on and off:
//! * a ray is open at `t_min` and closed at `t_max`: it meets what lies at `t_min < t <= t_max`;
//! * `t` counts lengths of `direction`, which need not be a unit vector;
//! * both sides of a triangle block; the normal follows the right-hand rule of its winding;
//! * geometry ids count from 0 in the order of the builder's calls, meshes and instances alike.
//!
//! The crate's API is the same where Embree is absent: then [`Device::new`] returns [`Error::NotBuilt`], and the types
//! that would hold a handle have no values.
//!
//! Everything `unsafe` of the project stands here, in `embree4-sys` and in `oidn`. Rules of the library that this crate
//! keeps are listed in `vendor-notes/embree.md`.
//!
//! # Where what is
//!
//! `builder.rs` makes scenes and `scene.rs` asks them. What is new of Embree gets a function in
//! `crates/embree4-sys/shim/shim.c` first. Without Embree `absent.rs` stands in.

mod check;
mod config;
mod error;
mod ray;

#[cfg(not(embree))]
mod absent;
#[cfg(embree)]
mod bare;
#[cfg(embree)]
mod builder;
#[cfg(embree)]
mod device;
#[cfg(embree)]
mod hit_test;
#[cfg(embree)]
mod scene;

#[cfg(not(embree))]
pub use absent::{Device, Recording, Scene, SceneBuilder, header_version};
#[cfg(embree)]
pub use bare::Recording;
#[cfg(embree)]
pub use builder::SceneBuilder;
pub use check::serves;
pub use config::{DeviceConfig, DeviceInfo, Isa, Keep, Memory, Tasking, Version};
#[cfg(embree)]
pub use device::{Device, header_version};
pub use error::Error;
pub use ray::{Coherence, Hit, Lanes, PacketWidth, Ray, RayPacket};
#[cfg(embree)]
pub use scene::Scene;
