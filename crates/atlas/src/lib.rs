//! Lightmap atlas: charts, packing, texel footprints, gutters.
//!
//! [`layout`] gives every triangle of every object its place on a page and audits the result. [`PageRaster`] cuts the
//! triangles of a page into area-true texel footprints, a tile at a time. [`Dilation`] fills the gutters.
#![forbid(unsafe_code)]

mod audit;
mod clip;
mod dilate;
mod error;
mod footprint;
mod keep;
mod layout;
mod measure;
mod raster;
mod rectangles;
mod types;
mod unwrap;
mod uv;

pub use dilate::{Dilation, RINGS};
pub use error::{Error, Why};
pub use footprint::{Footprint, Piece, TILE, Tile};
pub use layout::layout;
pub use raster::PageRaster;
pub use types::*;
pub use uv::triangle_uv;
