//! Pictures through a camera.
//!
//! A picture is [`picture`] over a [`Camera`] and something that tells the radiance along a ray: `Direct` integrates
//! the ambient models where the ray meets the scene, `Lightmap` looks them up in a bake.
//!
//! ```
//! use ambake_render::{Camera, picture};
//! use glam::DVec3;
//!
//! // Straight ahead, a right angle from top to bottom. The radiance is how far a ray leans to the right.
//! let camera = Camera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, std::f64::consts::FRAC_PI_2, [4, 4])?;
//! let image = picture(&camera, 1, &(), |sample| DVec3::splat(sample.direction.x.max(0.0)))?;
//! assert_eq!(image.pixels[0], [0.0; 3]);
//! assert!(image.pixels[3][0] > image.pixels[2][0]);
//! # Ok::<(), ambake_render::Error>(())
//! ```
//!
//! # Where what is
//!
//! * The camera: `camera.rs`. Where a scene is seen from when nobody says: `viewpoint`; how bright it is shown:
//!   `exposure.rs`.
//! * What a sample shows, front to back: `shown.rs`; how that is shaded: `direct.rs`, by the models of `model.rs`.
//! * Alpha, and scenes over a backdrop: `matte.rs`. How a place in a scene is captured: `capture.rs`.
//! * White balls and mirrors at places: `ball.rs`. Frames from tables are in `crates/frames`.
#![forbid(unsafe_code)]

#[cfg(feature = "pictures")]
mod ball;
mod camera;
#[cfg(feature = "pictures")]
mod capture;
#[cfg(test)]
mod capture_tests;
#[cfg(feature = "pictures")]
mod direct;
#[cfg(test)]
mod direct_tests;
mod error;
mod exposure;
#[cfg(test)]
mod fixture;
mod framing;
#[cfg(feature = "pictures")]
mod lightmap;
#[cfg(feature = "pictures")]
mod lit;
mod matte;
#[cfg(feature = "pictures")]
mod microfacets;
#[cfg(feature = "pictures")]
mod model;
mod picture;
mod progress;
#[cfg(feature = "pictures")]
mod shown;
#[cfg(feature = "pictures")]
mod text;
mod viewpoint;
#[cfg(feature = "pictures")]
mod weight;

pub use camera::Camera;
pub use error::Error;
pub use exposure::{Exposure, backdrop};
pub use framing::Framing;
pub use matte::{alpha, over};
pub use picture::{Sample, picture};
pub use progress::{Part, each};
pub use rays::{Lamps, Light};
pub use viewpoint::places_within;
#[cfg(feature = "pictures")]
pub use {
    ball::{Ball, Shows},
    capture::{PointForm, add_points, capture},
    direct::Direct,
    lightmap::{Lightmap, TexelPlace, baked_scene},
    lit::Lit,
    model::Model,
    text::rows,
    weight::Weight,
};
