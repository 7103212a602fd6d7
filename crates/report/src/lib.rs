//! Writes every output file of a bake: OpenEXR pages, PNG previews, glTF, `bake.json` and difference pictures.
//!
//! The crate takes plain data (a [`Page`], a `Scene`, an `Atlas`, a [`BakeReport`]) and never the baker. Files are made
//! in memory or under a temporary name; [`Output`] gives them their final names only when the whole set is complete.
//!
//! # Where what is
//!
//! * EXR pages: `exr_write.rs`. Previews: `preview.rs`. The GLB: `gltf`. `bake.json`: `bake_json.rs`, and whose report
//!   it is: `record.rs`.
//! * What an engine gets: `engines`, with its table in `table.rs`, the pictures in the files beside it, GLB files with
//!   light in them in `scene_glb.rs`, occlusion beside roughness in `orm_glb.rs`, copies as instances in `instanced`
//!   and light by direction in `sh.rs`. Shaders for any view: `any_view`.
//! * `report.html`: `viewer`, where `mod.rs`, `embed.rs`, `cutouts.rs`, `balls.rs` write it; the page itself is HTML,
//!   CSS and JavaScript beside them.
//! * `compare`: `compare.rs`, with pictures by `difference.rs`. Files of probes: `probes`. Layouts: `layout.rs` has
//!   words and warnings, `layout_file.rs` the file.
//! * Saved tiles and parts: `checkpoint.rs` is the format; `crates/ambake/resume.rs` says what is in it and when.
//! * Temporary names, and which files of an earlier bake go: `output.rs`. The lock on a folder: `lock.rs`. What may be
//!   opened in it: `regular.rs`.
#![forbid(unsafe_code)]

mod any_view;
mod bake_json;
mod checkpoint;
mod compare;
mod cpu;
mod difference;
mod engines;
mod error;
mod exr_read;
mod exr_write;
mod gltf;
mod glyphs;
mod layout;
mod layout_file;
mod lock;
mod origin;
mod output;
mod page;
mod page_files;
mod picture;
mod preview;
mod probes;
mod record;
mod regular;
mod space;
mod viewer;

pub use any_view::{AnyViewReport, any_view_files, stage_any_view};
pub use bake_json::*;
pub use checkpoint::{Journal, JournalWriter, remove_journal, write_journal};
pub use compare::{Comparison, Difference, PageComparison, Worst, compare_layers, compare_pages};
pub use cpu::cpu_seconds;
pub use difference::{difference_picture, difference_png, nice_limit};
pub use engines::{
    Engine, LightSource, LightmapReport, PageLight, ScenePictures, check_compressed, engine_files,
    light_source, scene_files, stage_engines,
};
pub use error::Error;
pub use exr_read::{MAX_EDGE, PageFile, read_page_exr};
pub use exr_write::{PageHeader, write_page_exr};
pub use gltf::{Shades, read_gltf, source_gltf, write_gltf};
pub use layout::{LayoutReport, ObjectLayout, Spread};
pub use layout_file::{layout_blocks, layout_hash, layout_of_blocks, read_layout, write_layout};
pub use origin::check_origin;
pub use output::{Folder, Output, copy_files};
pub use page::{Channel, Page, PageLayer};
pub use page_files::{NamedPage, page_files, read_page};
pub use picture::{matte_png, picture_png};
pub use preview::{Encoding, occlusion_png, preview_png};
pub use probes::{
    InterpolationReport, PROBES_SCHEMA, ProbeFile, ProbeGrid, ProbeRecord, ProbeReport, ProbeSet,
    ReflectionLevel, ReflectionMaps, ReflectionReport, probe_file, probe_files, read_probes,
    stage_probes,
};
pub use record::{REPORT_FILE, read_record, record_name, scene_file, stage_report};
pub use regular::check_regular;
pub use space::check_space;
pub use viewer::{EmbeddedPage, EmbeddedProbes, Kernel, REPORT_NAME, Viewer};
