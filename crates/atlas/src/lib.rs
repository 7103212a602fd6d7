//! Lightmap atlas: charts, packing, texel footprints, gutters.
//!
//! [`layout`] gives every triangle of every object its place on a page and audits the result. [`PageRaster`] cuts the
//! triangles of a page into area-true texel footprints, a tile at a time. [`Dilation`] fills the gutters.
//!
//! ```
//! use ambake_atlas::{Options, layout};
//! use scene::{Scene, authored};
//!
//! let mut triangle = authored::Mesh::default();
//! triangle.positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! triangle.triangles = vec![[0, 1, 2]];
//! let scene = Scene::from_meshes(vec![triangle], vec![authored::Material::default()])?;
//! let options = Options { page_size: 64, ..Options::default() };
//! let atlas = layout(&scene, &options, &|| false)?;
//! assert_eq!((atlas.page_count, atlas.chart_count), (1, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod arrange;
mod audit;
mod authored;
mod centre;
mod charts;
mod clip;
mod cover;
mod cutter;
mod dilate;
mod error;
mod facts;
mod flat;
mod flatten;
mod footprint;
mod free;
mod glob;
pub mod gutter;
mod hidden;
mod keep;
mod layout;
mod mask;
mod measure;
mod objects;
mod pack;
mod pages;
mod parts;
mod raster;
mod reuse;
mod room;
mod search;
mod share;
mod tile_part;
mod touching;
mod twins;
mod types;
mod uv;

pub use cover::Held;
pub use cutter::Weights;
pub use dilate::{Dilation, RINGS};
pub use error::{Error, Why};
pub use facts::{Facts, ObjectFacts, facts};
pub use footprint::{Footprint, Piece, Tile};
pub use layout::{Seen, layout, layout_seen};
pub use measure::{charts, largest_charts};
pub use objects::{ObjectName, instances_named, object_names};
pub use raster::{PageRaster, Rasters};
pub use reuse::{Claim, claims, reuse};
pub use room::roomy_size;
pub use tile_part::TilePart;
pub use touching::{LEAST_TOUCHING, touching};
pub use types::*;
pub use uv::triangle_uv;
