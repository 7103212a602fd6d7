//! Illumination maps and reflection maps: G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984).
//!
//! An [`Image`] read from a file becomes, with a [`Projection`], the radiance that arrives from every direction: an
//! [`IlluminationMap`], to be looked up, converted, convolved into the maps D and S, or drawn from as a sky
//! ([`SkyMap`]). The crate opens image files and encodes them into memory; it creates no files and prints nothing.
//!
//! ```
//! use ambake_maps::{Format, IlluminationMap, Image, Labels, diffuse, encode, read, specular};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("room.hdr");
//! # std::fs::write(&path, encode(&Image::filled(64, 32, [0.5; 3]), Format::Hdr, &Labels::new())?)?;
//!
//! // From the file's own layout to a map of radiance.
//! let file = read(&path)?;
//! let layout = file.layout(&path, None, None)?;
//! let room = IlluminationMap::new(file.image, layout.projection)?;
//!
//! // What a matt and a glossy surface reflect, by the normal and by the mirror direction.
//! let d = diffuse(&room, (72, 36))?;
//! let s = specular(&room, 50.0, (256, 128))?;
//! let seen = 0.6 * d.bilinear([0.0, 1.0, 0.0])[0] + 0.4 * s.bilinear([0.6, 0.0, 0.8])[0];
//! assert!((seen - 0.5).abs() < 1e-6);
//!
//! let bytes = encode(d.image(), Format::Exr, &Labels::new())?;
//! assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01]); // OpenEXR's magic number
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where what is
//!
//! * Projections: `projection`; a new one has its file there. Axes of other tools: `orientation.rs`.
//! * Blurs: `convolve`, where `lobe.rs` has the kinds of surfaces. Measured surfaces: `lobe_table.rs` and
//!   `reflectance.rs`; how frames read between their maps is in `crates/render/src/tables/shader.rs`.
//! * Photographs to maps: `ball`, `merge`, and `mosaic.rs` with `gains.rs`.
//! * Directions drawn from a sky: `sky_map.rs`.
#![forbid(unsafe_code)]
// Without its tools some helpers have no caller.
#![cfg_attr(not(feature = "tools"), allow(dead_code, unused_imports))]

pub mod ball;
#[cfg(feature = "tools")]
mod columns;
mod convert;
#[cfg(feature = "tools")]
mod convolve;
mod error;
#[cfg(feature = "tools")]
mod exr_file;
mod faces;
#[cfg(feature = "tools")]
mod file;
mod gains;
#[cfg(feature = "tools")]
mod hdr;
mod image;
mod image_file;
mod layout;
#[cfg(feature = "tools")]
mod lobe_table;
mod map;
#[cfg(feature = "tools")]
pub mod merge;
mod mosaic;
mod orientation;
#[cfg(feature = "tools")]
mod painted;
#[cfg(feature = "tools")]
mod polar;
mod projection;
#[cfg(feature = "tools")]
mod reflectance;
mod sky;
#[cfg(feature = "tools")]
mod sky_file;
mod sky_map;
mod stats;

pub use convert::{convert, convert_image};
pub use error::Error;
pub use faces::FACES;
pub use gains::Gains;
pub use image::Image;
pub use image_file::{ImageFile, Labels};
pub use layout::Layout;
pub use map::{IlluminationMap, ReflectionMap};
pub use mosaic::{Mosaic, mosaic};
pub use orientation::Orientation;
pub use projection::{Direction, Projection};
pub use sky::Sky;
pub use sky_map::SkyMap;
pub use stats::MapStats;
#[cfg(feature = "tools")]
pub use {
    convolve::{Lobe, Normalise, Request, convolve, diffuse, specular},
    file::{Format, encode, encode_with, read, read_unchecked},
    polar::{PolarFile, read_polar},
    reflectance::Reflectance,
    sky_file::{SkyFile, read_sky},
};
