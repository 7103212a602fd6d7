//! Writes every output file of a bake: OpenEXR pages, PNG previews, glTF, `bake.json` and difference pictures.
//!
//! The crate takes plain data (a [`Page`], a `Scene`, an `Atlas`, a [`BakeReport`]) and never the baker. Files are made
//! in memory or under a temporary name; [`Output`] gives them their final names only when the whole set is complete.
//!
//! # Where what is
//!
//! * EXR pages: `exr_write.rs`. Previews: `preview.rs`. The GLB: `gltf`. `bake.json`: `bake_json`, and whose report
//!   it is: `record.rs` and `stage_record.rs`.
//! * What an engine gets: `engines`, with its table in `engine_table.rs`, the pictures in the files beside it, GLB
//!   files with light in them in `scene_glb.rs`, occlusion beside roughness in `orm_glb.rs`, copies as instances in
//!   `instanced` and light by direction in `sh.rs`. Shaders for any view: `any_view`.
//! * `report.html`: `viewer`, where `mod.rs`, `embed.rs`, `cutouts.rs`, `balls.rs` write it; the page itself is HTML,
//!   CSS and JavaScript beside them.
//! * `compare`: `compare.rs`, with pictures by `difference.rs`. Files of probes: `probes`. Layouts: `layout.rs` has
//!   words and warnings, `layout_file.rs` the file.
//! * Saved tiles and parts: `checkpoint` is the format; `crates/ambake/resume` says what is in it and when.
//! * Temporary names, and which files of an earlier bake go: `output`. The lock on a folder: `lock.rs`. What may be
//!   opened in it: `regular.rs`.
#![forbid(unsafe_code)]
// Without all of its writers some helpers have no caller.
#![cfg_attr(not(feature = "viewer"), allow(dead_code, unused_imports))]

#[cfg(feature = "write")]
mod any_view;
mod bake_json;
mod checkpoint;
#[cfg(feature = "write")]
mod compare;
mod cpu;
#[cfg(feature = "write")]
mod difference;
mod engine_table;
#[cfg(feature = "write")]
mod engines;
mod error;
#[cfg(feature = "write")]
mod exr_read;
#[cfg(feature = "write")]
mod exr_write;
#[cfg(feature = "write")]
mod gltf;
#[cfg(feature = "write")]
mod glyphs;
mod layout;
mod layout_file;
mod lock;
#[cfg(feature = "write")]
mod origin;
#[cfg(feature = "write")]
mod output;
mod page;
#[cfg(feature = "write")]
mod page_files;
#[cfg(feature = "write")]
mod picture;
#[cfg(feature = "write")]
mod preview;
#[cfg(feature = "write")]
mod probes;
mod record;
mod regular;
mod space;
#[cfg(feature = "write")]
mod stage_record;
#[cfg(feature = "viewer")]
mod viewer;

pub use bake_json::*;
pub use checkpoint::{Journal, JournalWriter, remove_journal, write_journal};
pub use cpu::cpu_seconds;
pub use engine_table::{Engine, LightmapReport, check_compressed, engine_files};
pub use error::Error;
pub use layout::{LayoutReport, ObjectLayout, Spread};
pub use layout_file::{layout_blocks, layout_hash, layout_of_blocks, read_layout, write_layout};
pub use page::{Channel, Page, PageLayer};
pub use record::{REPORT_FILE, REPORT_NAME, read_record, record_name, scene_file};
pub use regular::check_regular;
pub use space::check_space;
#[cfg(feature = "viewer")]
pub use viewer::{EmbeddedPage, EmbeddedProbes, Kernel, Viewer};
#[cfg(feature = "write")]
pub use {
    any_view::{any_view_files, stage_any_view},
    compare::{Comparison, Difference, PageComparison, Worst, compare_layers, compare_pages},
    difference::{difference_picture, difference_png, nice_limit},
    engines::{
        LightLevel, LightSource, PageLight, ScenePictures, light_levels, light_source, scene_files,
        stage_engines,
    },
    exr_read::{MAX_EDGE, PageFile, read_page_exr},
    exr_write::{PageHeader, write_page_exr},
    gltf::{Shades, read_gltf, source_gltf, write_gltf},
    origin::check_origin,
    output::{Folder, Output, copy_files, remove_staged_on_panic},
    page_files::{NamedPage, page_files, read_page},
    picture::{matte_png, picture_png},
    preview::{Encoding, occlusion_png, preview_png},
    probes::{
        InterpolationReport, PROBES_SCHEMA, ProbeFile, ProbeGrid, ProbeRecord, ProbeReport,
        ProbeSet, ReflectionLevel, ReflectionMaps, ReflectionReport, probe_file, probe_files,
        read_probes, stage_probes,
    },
    stage_record::stage_report,
};
