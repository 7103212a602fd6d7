//! Illumination maps and reflection maps: G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984).
//!
//! An [`Image`] read from a file becomes, with a [`Projection`], the radiance that arrives from every direction. The
//! crate opens image files and encodes them into memory; it creates no files and prints nothing.
#![forbid(unsafe_code)]

pub mod ball;
mod convert;
mod convolve;
mod error;
mod exr_file;
mod file;
mod hdr;
mod image;
mod map;
pub mod merge;
mod orientation;
mod painted;
mod projection;
mod sky_map;

pub use convert::{Layout, convert, convert_image};
pub use convolve::{Lobe, Normalise, Request, convolve, diffuse, specular};
pub use error::Error;
pub use file::{Format, ImageFile, Labels, encode, encode_with, read, read_unchecked};
pub use image::Image;
pub use map::{IlluminationMap, ReflectionMap};
pub use orientation::Orientation;
pub use projection::{Direction, Projection};
pub use sky_map::SkyMap;
