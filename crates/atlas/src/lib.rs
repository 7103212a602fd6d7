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
//!
//! # Where what is
//!
//! * How many texels an object gets: `share.rs` is the rule, `search.rs` finds the densities that fit, and
//!   `drafts.rs` where it begins.
//! * How charts are made: `charts.rs`; flat faces, which are not cut, in `flat`; what is handed to the unwrapper in
//!   `parts.rs`, what it makes of that in `unwrap.rs`; sheets that are drawn twice: `doubled.rs`; how large curved
//!   pieces are cut and laid flat in `flatten`.
//! * Coordinates of the file: `keep.rs`, and `authored.rs` where their charts are packed apart.
//! * Packing: `pack.rs` for a page, `pages.rs` for several, `copies.rs` for the charts of a mesh that stands in several
//!   places. How wide gutters are: `gutter.rs`. How they are filled: `dilate.rs`.
//! * Which charts count as hidden: `hidden.rs` asks, `crates/ambake/seen.rs` answers for points of a triangle,
//!   `crates/ambake/shell.rs` for the outsides of rooms.
//! * Which part of a texel counts: `footprint.rs`. How triangles are cut to texels: `cutter.rs`; which texels need no
//!   cut: `cover.rs`.
//! * What a listener hears while charts are made: `told.rs`.
//! * Layouts that follow an earlier one: `reuse.rs`, with room for what is new by `free.rs`.
//! * What is said of a layout: `facts.rs` measures, `room.rs` finds a page that is large enough; words and warnings are
//!   in `crates/report/src/layout.rs`.
#![forbid(unsafe_code)]

mod arrange;
mod audit;
mod authored;
mod centre;
mod charts;
mod clip;
mod copies;
mod cover;
mod covered;
mod cutter;
mod dilate;
mod doubled;
mod drafts;
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
mod sheet;
mod tile_part;
mod told;
mod touching;
mod twins;
mod types;
mod unwrap;
mod uv;

pub use cover::MOST_HELD;
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
