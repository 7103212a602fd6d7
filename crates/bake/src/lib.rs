//! Texels meet rays: what a bake models, the surface under each texel, its integrals with their errors, and pages.
//!
//! The stages stand in folders in the order they run: `plan` decides what a scene needs, `survey` cuts texels into
//! cells of surface, `integrate` casts their rays, `denoise` smooths terms over a surface, `page` composes models and
//! keeps planes. [`Baker`] runs them.
//!
//! ```
//! use ambake_bake::{Baker, Options, Plan};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/wall_long.obj");
//! # if !std::path::Path::new(file).exists() { return Ok(()); }
//! let scene = std::sync::Arc::new(scene::load(file.as_ref())?);
//! let options = Options { effort: ambake_bake::Effort::Rays(16), ..Options::default() };
//! let (plan, world) = Plan::of(&scene, &options)?;
//! let layout = atlas::Options { page_size: 64, ..Default::default() };
//! let atlas = atlas::layout(&scene, &layout, &|| false)?;
//! let backend = rays::build(rays::BackendKind::Obvhs(rays::TreeKind::default()), &world, 0)?;
//!
//! let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, &options);
//! let mut page = baker.start(0);
//! baker.run(&mut page, &());
//! assert!(page.finished && page.stats.rays > 0);
//! # Ok(())
//! # }
//! ```
//!
//! # Where what is
//!
//! * What is left out of a bake, with the reason that is printed: `plan`.
//! * What lies under a texel: `survey`; what a sample stands on: `survey/cells.rs`; which part of it is sampled:
//!   `survey/seen.rs`.
//! * How rays become terms: `integrate/mod.rs`, sixteen at a time in `integrate/gang`. There `aim.rs` says where they
//!   start and go, `gloss.rs` has microfacets, `moments.rs` layers for any view and `directional.rs` light by
//!   direction, which `page/directional.rs` carries through the last steps.
//! * Where rays go: `integrate/lobe.rs` says how many a highlight takes, `integrate/guides.rs` where those of dark
//!   surfaces go, `page/spend.rs` where those of a target go. Which texels are kept: `page/surveys.rs`.
//! * The standard error: `integrate/estimate.rs`; what neighbours share: `integrate/pool.rs`.
//! * Light that bounces: `bounce`, with what a surface sends in `radiosity.rs`, what a texel receives in `gather.rs`
//!   and where its rays are aimed in `spots.rs`.
//! * Buried texels are filled in `mend`; those that look-ups beside a contact read, in its `contact.rs`.
//! * The denoiser: `denoise`, with the fits in `fit`, local sums in `plane.rs`, what a chart is fitted together with
//!   in `beyond.rs`, what a texel takes of the fits in `choose.rs` and the error that it states in `stated.rs`. What is
//!   taken out before: `strays.rs`, `lines.rs`.
//! * Which charts are one surface, and how their seams are solved: `seams`; between pages `across.rs`, where a wall
//!   ends them `walls.rs`.
//! * Layers from facts: `page/compose.rs`. What becomes of a tile: `page/integrated.rs`. Tiles of a shard:
//!   `page/share.rs`. What an update may keep: `reach`.
#![forbid(unsafe_code)]

mod bounce;
mod choice;
mod clock;
mod denoise;
mod integrate;
mod labels;
mod mend;
mod options;
mod page;
mod plan;
mod reach;
mod seams;
mod survey;

pub use ambient::any_view::KernelTable;
pub use bounce::{BounceStats, KeepGathers};
pub use choice::Choice;
pub use integrate::{AnyView, Directional, Halves, Terms};
pub use options::{
    AmbientCoefficient, Bounces, Buried, Denoise, Effort, Footprint, Model, Options, PointSet,
    Seams, Shading, Sky, View,
};
pub use page::{
    BakedPage, BakedTile, Baker, Deal, ErrorSums, LayerPlanes, PageStats, Pilot, Take,
    bytes_of_surveys, channels_of_terms, layers_in_work, layers_of_light, sampled,
};
pub use plan::{AnyViewErrors, Decision, Method, OpenTriangles, Plan};
pub use reach::{Fingerprint, Reach};
pub use seams::{SeamStats, seam_points};
