//! Illumination maps and reflection maps: G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984).
//!
//! Photographs become an [`IlluminationMap`], the radiance that arrives from every direction, and that is convolved
//! into the maps D and S, which shading looks up. Frames are shaded from them in `crates/frames`; pictures of
//! light, their files and projections are in `crates/environment`. The crate creates no files and prints nothing.
//!
//! ```
//! use environment::{Format, IlluminationMap, Image, Labels, encode, read};
//! use ambake_maps::{diffuse, specular};
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
//! * Blurs: `convolve`, where `lobe.rs` has the kinds of surfaces. Measured surfaces: `lobe_table.rs` and
//!   `reflectance.rs`; how frames read between their maps is in `crates/frames/src/shader.rs`.
//! * Photographs to maps: `ball`, `merge`, and `mosaic.rs` with `gains.rs`.
#![forbid(unsafe_code)]

use environment::IlluminationMap;

pub mod ball;
mod columns;
mod convolve;
mod error;
mod gains;
mod lobe_table;
pub mod merge;
mod mosaic;
mod polar;
mod reflectance;

pub use convolve::{Lobe, Normalise, Request, convolve, diffuse, specular};
pub use error::Error;
pub use gains::Gains;
pub use mosaic::{Mosaic, mosaic};
pub use polar::{PolarFile, read_polar};
pub use reflectance::Reflectance;

/// A convolved picture, indexed by the normal (D) or by the mirror direction (S). It looks up like the map it came
/// from.
pub type ReflectionMap = IlluminationMap;
