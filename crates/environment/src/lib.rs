//! Environments: the light that arrives from all around, as pictures of it and as a sky to draw directions from.
//!
//! An [`Image`] becomes, with a [`Projection`], the radiance that arrives from every direction: an [`IlluminationMap`],
//! to be looked up, converted, or drawn from as a sky ([`SkyMap`]). With the feature `files` the crate opens image
//! files and encodes them into memory; it creates no files and prints nothing.
//!
//! ```
//! use ambake_environment::{IlluminationMap, Image, Projection, SkyMap, convert};
//!
//! let mut image = Image::filled(32, 24, [0.5; 3]);
//! image.pixels[32 * 12 + 12] = [80.0; 3];
//! let cross = IlluminationMap::new(image, Projection::Cross)?;
//! let polar = convert(&cross, Projection::Polar, Projection::Polar.size(64))?;
//! let sky = SkyMap::new(&polar)?;
//! assert!((sky.mean()[0] * 4.0 * std::f64::consts::PI / cross.integral()[0] - 1.0).abs() < 1e-6);
//! # Ok::<(), ambake_environment::Error>(())
//! ```
//!
//! # Where what is
//!
//! * Projections: `projection`; a new one has its file there. Axes of other tools: `orientation.rs`. From one layout to
//!   another: `convert.rs`.
//! * Files: `file`, where `picture.rs` knows the formats and `layout.rs` what headers say.
//! * Directions drawn from a sky: `sky_map.rs`.
//!
//! Blurs, photographs and tables of reflectance are in `crates/maps`.
#![forbid(unsafe_code)]

mod convert;
mod error;
#[cfg(feature = "files")]
mod file;
mod image;
mod map;
mod orientation;
mod projection;
mod sky;
mod sky_map;
mod stats;
mod up;

pub use convert::{MapLayout, convert, convert_image};
pub use error::Error;
#[cfg(feature = "files")]
pub use file::{
    ExrSource, FACES, Format, ImageFile, Labels, Planes, SkyFile, contents, encode, encode_with,
    exr_chunks, exr_planes, read, read_sky, read_unchecked, recorded,
};
pub use image::Image;
pub use map::IlluminationMap;
pub use orientation::Orientation;
pub use projection::{Direction, Projection, cube};
pub use sky::Sky;
pub use sky_map::SkyMap;
pub use stats::MapStats;
pub use up::Up;
