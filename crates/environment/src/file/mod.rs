//! Files of pictures of light: read strictly, laid out as they say, encoded into memory.

mod exr;
mod faces;
mod hdr;
mod image_file;
mod layout;
mod painted;
mod picture;
mod sky;

pub use exr::{ExrSource, Planes, exr_chunks, exr_planes};
pub use faces::FACES;
pub use image_file::{ImageFile, Labels};
pub use picture::{Format, contents, encode, encode_with, read, read_unchecked, recorded};
pub use sky::{SkyFile, read_sky};
