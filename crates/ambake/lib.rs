//! ambake bakes *ambient reflection* into lightmaps on a plain CPU, and states its error.
//!
//! For every texel of a texture atlas it casts rays over the hemisphere and integrates the Lambertian and the Phong
//! ambient terms directly, with occlusion. It sets them beside the traditional model, a constant times an occlusion
//! factor.
//!
//! # From a file
//!
//! ```
//! # fn main() -> Result<(), ambake::Error> {
//! # let folder = tempfile::tempdir().unwrap();
//! let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
//! let baked = ambake::Bake::new(&scene).size(64).rays(16).run(&())?;
//! baked.write(folder.path())?; // EXR pages, PNG previews, a GLB and bake.json
//! # Ok(())
//! # }
//! ```
//!
//! # In memory
//!
//! ```
//! use ambake::{Bake, Layer, Mesh, Scene};
//!
//! # fn main() -> Result<(), ambake::Error> {
//! let mut floor = Mesh::default();
//! floor.positions = vec![[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
//! floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
//! let scene = Scene::from_meshes(vec![floor], vec![])?;
//!
//! let baked = Bake::new(&scene).size(32).rays(16).run(&())?;
//! let page = baked.page(0);
//! let (coverage, diffuse) = (page.layer(Layer::Coverage), page.layer(Layer::Diffuse));
//! for (covered, value) in coverage.iter().zip(diffuse) {
//!     // Nothing stands above a lone floor: every texel of it sees the whole sky.
//!     assert!(*covered == 0.0 || *value == 1.0);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # What is here
//!
//! * [`load`], [`Scene`], [`Mesh`], [`Material`], [`Placement`]: what is baked.
//! * [`Bake`]: the options, named as the flags of the command line, and the start of a bake.
//! * [`Baked`], [`Page`], [`Layer`], [`Object`]: the result in memory, where objects lie on it, and how it is written.
//! * [`Probes`], [`ProbeVolume`]: light for what moves, at places in the air and between them.
//! * [`Progress`]: how a bake tells how far it is, and is told to stop; `()` is a silent one.
//! * [`Job`]: a bake that is planned, laid out and ready, for programs that want to look before they start.
//! * [`rays`]: the trait of ray backends, to bring one of your own ([`Bake::with_backend`]).
//! * [`atlas`], [`baker`], [`loaded`], [`render`], [`report`], [`glam`], [`rayon`], [`serde_json`]: what the types
//!   above are made of, so that every type in a signature has a name here and its version is the library's.
//!
//! ```
//! use ambake::{Job, Scene, atlas, baker, loaded, rays, report};
//! fn laid_out(job: &Job) -> (&atlas::Atlas, &report::LayoutReport, &rays::World) {
//!     (job.atlas(), job.layout_report(), job.world())
//! }
//! fn planned(job: &Job) -> (&baker::Plan, Vec<report::DecisionReport>, Vec<report::WarningReport>) {
//!     (job.plan(), job.decisions(), job.warnings())
//! }
//! fn data(scene: &Scene) -> &loaded::Scene {
//!     scene
//! }
//! ```
//!
//! # Features
//!
//! The default is the program, with everything. With `default-features = false` the library bakes scenes made in memory
//! with obvhs. `embree` adds Embree, `obj`, `gltf`, `draco` and `meshopt` add [`load`], `sky` adds [`Sky::load`],
//! `write` all that becomes a file, and `report` the page `report.html`. `docs/library.md` has the table.
//!
//! Directions point away from surfaces, colours are linear, angles are radians, and lengths are in scene units. The
//! stored terms are 1 for an open texel under a sky of radiance 1.
//!
//! # Where what is
//!
//! For those who change the library:
//!
//! * From a file to its scene: `load.rs`. What is asked for: `bake` and `options`, its flags `flags`, their words
//!   `words.rs`. A bake between plan and result: `job.rs`, `run.rs` and `run_into.rs`, what it warns of `warnings.rs`.
//!   What is written, and which names of an earlier bake go: `write`.
//! * What a bake will take: `estimate.rs`, its memory `memory.rs`. Whether a scene is an interior: `interior.rs`,
//!   and what stands around it: `dome.rs`; what lies whole in another object: `swallowed.rs`.
//! * Where objects lie on pages: `object.rs`. Values at vertices: `vertices.rs`.
//! * What can be seen: `seen.rs` for points of a triangle, `eyes.rs` for one point from places, `shell.rs` for the
//!   outsides of rooms, `shut.rs` for the insides of cupboards, `facing.rs` for faces that look the wrong way,
//!   `points.rs` for points of an object.
//! * Saved states: `resume`. Shards: `shard.rs`, `parts.rs` and `merge.rs`. Updates: `update.rs`, their files
//!   `state.rs`. The atlas alone: `layout.rs`,
//!   its files `layout_files.rs`.
//! * The picture of the lit scene: `lit.rs`. Probes: `probes`.
#![forbid(unsafe_code)]
// Without the files of a bake some helpers have no caller.
#![cfg_attr(not(feature = "write"), allow(dead_code))]

#[cfg(test)]
mod again_tests;
#[cfg(feature = "write")]
mod any_view;
mod bake;
mod baked;
#[cfg(test)]
mod built_tests;
mod choices;
#[cfg(feature = "write")]
mod differ;
mod dome;
#[cfg(feature = "write")]
mod earlier;
#[cfg(not(feature = "write"))]
#[path = "no_earlier.rs"]
mod earlier;
mod error;
mod estimate;
#[cfg(feature = "write")]
mod export;
mod eyes;
mod facing;
#[cfg(feature = "flags")]
#[doc(hidden)]
pub mod flags;
mod hidden;
mod host;
#[cfg(feature = "write")]
mod interior;
mod job;
mod layout;
#[cfg(feature = "write")]
mod layout_files;
#[cfg(feature = "write")]
mod lit;
#[cfg(any(feature = "obj", feature = "gltf"))]
mod load;
mod memory;
#[cfg(feature = "write")]
mod merge;
mod object;
mod options;
mod outline;
#[cfg(feature = "write")]
mod parts;
mod points;
#[cfg(feature = "write")]
mod probes;
#[cfg(feature = "write")]
mod resume;
mod run;
#[cfg(feature = "write")]
mod run_into;
mod scene;
mod seen;
#[cfg(feature = "write")]
mod shard;
mod shell;
mod shut;
mod sky;
#[cfg(feature = "write")]
mod state;
mod swallowed;
#[cfg(feature = "write")]
mod update;
mod vertices;
mod warnings;
mod words;
#[cfg(feature = "write")]
mod write;

pub use crate::bake::Bake;
pub use ::bake as baker;
pub use ::bake::{
    AmbientCoefficient, BakedPage, BounceStats, Bounces, Buried, Choice, Decision, Denoise,
    Footprint, Method, Model, PageStats, Pilot, PointSet, SeamStats, Seams, Shading, View,
};
pub use ::environment::Up;
pub use ::scene as loaded;
pub use baked::{Baked, Page};
pub use dome::surrounding;
pub use error::{Error, LimitedBy};
pub use estimate::Estimate;
pub use host::{REVISION, VERSION, peak_memory};
pub use job::Job;
pub use layers::{Layer, Preview, Progress, Term, Unit};
pub use layout::Layout;
#[cfg(any(feature = "obj", feature = "gltf"))]
pub use load::{Files, load, load_with};
pub use object::Object;
pub use options::{Backend, Effort, Options, Pages, Uv};
pub use rays::{self, Light};
pub use report::{BakeReport, Engine, PageReport};
pub use scene::{AlphaMode, Material, Mesh, MetallicRoughness, Placement, Scene, Texture, Warning};
pub use sky::Sky;
pub use vertices::Vertices;
pub use {atlas, environment, glam, rayon, render, report, serde_json};
#[cfg(feature = "write")]
pub use {
    export::{Exported, export},
    merge::Parts,
    parts::Shard,
    probes::{Places, ProbeOptions, ProbePart, ProbeParts, ProbeVolume, Probes},
    report::{LightLevel, ProbeRecord, ProbeReport, ReflectionLevel, ReflectionReport},
    resume::Resume,
    shard::Part,
    write::Written,
};
