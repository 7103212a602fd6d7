//! Pure mathematics of ambient reflection: models, closed forms, sampling.
//!
//! No rays, files, threads or printing. Everything is `f64`; callers convert to `f32` in one place of their own.
//! Directions are unit vectors that point away from the surface; angles are radians.
//!
//! ```
//! use ambake_ambient::{Frame, closed_form::phong_open, convention::lobe_scale, models::phong};
//! use glam::DVec3;
//!
//! // An open point seen at 60 degrees, with an exponent of 20: nearly all of the lobe is above the surface.
//! let (normal, view) = (DVec3::Z, DVec3::new(0.75_f64.sqrt(), 0.0, 0.5));
//! let specular = phong_open(20.0, normal.dot(view), normal.cross(view).length());
//! assert!(0.99 < specular && specular < 1.0);
//!
//! // Under a sky of radiance 2 it reflects at most albedo and specular colour allow.
//! let sky = DVec3::splat(2.0);
//! let seen = phong(sky, sky * specular, DVec3::splat(0.6), DVec3::splat(0.4));
//! assert!(1.99 < seen.x && seen.x < 2.0);
//!
//! // The term is the integral of the lobe by its scale, (n + 1) / 2π.
//! assert!((lobe_scale(20.0) * std::f64::consts::TAU - 21.0).abs() < 1e-14);
//! assert_eq!(Frame::from_normal(normal).to_world(DVec3::Z), normal);
//! ```
//!
//! # Where what is
//!
//! * Normalisation: `convention.rs`, and nowhere else. The models traditional, Lambert and Phong: `models.rs`. The
//!   Moon's dust: `lunar.rs`.
//! * Points without anything above them: `closed_form`. Microfacets: `ggx`.
//! * How directions are drawn: `sampling`, with the hemisphere, the lobe, the point sets, and in `guide.rs` the warp
//!   for dark surfaces. Those that a sky draws are in `crates/environment/src/sky_map.rs`.
//! * Layers for any view: `any_view`, and in its `order.rs` how many numbers they take. Harmonics of probes:
//!   `harmonics.rs`.

#![forbid(unsafe_code)]

pub mod any_view;
pub mod closed_form;
pub mod convention;
mod estimate;
pub mod frame;
pub mod ggx;
pub mod harmonics;
pub mod lanes;
pub mod lunar;
pub mod models;
pub mod quadrature;
pub mod sampling;
pub mod solve;

pub use estimate::Estimate;
pub use frame::Frame;
