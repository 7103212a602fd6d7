//! Lightmap atlas: charts, packing, texel footprints, gutters.
//!
//! [`layout`] gives every triangle of every object its place on a page and audits the result. [`PageRaster`] cuts the
//! triangles of a page into area-true texel footprints, a tile at a time. [`Dilation`] fills the gutters.
//!
//! ```
//! use ambake_atlas::{Options, UvMode, layout};
//! use scene::{Scene, authored};
//!
//! let mut triangle = authored::Mesh::default();
//! triangle.positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! triangle.triangles = vec![[0, 1, 2]];
//! let scene = Scene::from_meshes(vec![triangle], vec![authored::Material::default()])?;
//! let options = Options { uv: UvMode::Auto, page_size: 64, density: None };
//! let atlas = layout(&scene, &options, &|| false)?;
//! assert_eq!((atlas.page_count, atlas.chart_count), (1, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod audit;
mod centre;
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
pub use measure::charts;
pub use raster::PageRaster;
pub use types::*;
pub use uv::triangle_uv;
