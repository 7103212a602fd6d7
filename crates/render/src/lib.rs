//! Pictures through a camera.
//!
//! A picture is [`picture`] over a [`Camera`] and something that tells the radiance along a ray: [`Direct`] integrates the
//! ambient models where the ray meets the scene, [`Lightmap`] looks them up in a bake.
#![forbid(unsafe_code)]

mod camera;
mod capture;
#[cfg(test)]
mod capture_tests;
mod direct;
mod direct_lamps;
#[cfg(test)]
mod direct_tests;
mod error;
#[cfg(test)]
mod fixture;
mod framing;
mod light;
mod lightmap;
mod picture;
mod progress;
pub mod tables;
mod text;

pub use camera::Camera;
pub use capture::{PointForm, add_points, capture};
pub use direct::{Direct, Model};
pub use direct_lamps::Lamps;
pub use error::Error;
pub use framing::Framing;
pub use light::Light;
pub use lightmap::Lightmap;
pub use picture::{Sample, picture};
pub use progress::Part;
