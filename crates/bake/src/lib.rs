//! Texels meet rays: what a bake models, the surface under each texel, its integrals with their errors, and pages.
//!
//! The stages stand in folders in the order they run: `plan` decides what a scene needs, `survey` cuts texels into cells
//! of surface, `integrate` casts their rays, `denoise` smooths terms over a surface, `page` composes models and keeps
//! planes. [`Baker`] runs them.
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
//! let backend = rays::build(rays::BackendKind::Obvhs(rays::Layout::default()), &world, 0)?;
//!
//! let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, &options);
//! let mut page = baker.start(0);
//! baker.run(&mut page, &());
//! assert!(page.finished && page.stats.rays > 0);
//! # Ok(())
//! # }
//! ```
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
    AmbientCoefficient, Bounces, Buried, Denoise, Effort, Footprint, Model, Options, Pattern,
    PointSet, Seams, Shading, Sky, View,
};
pub use page::{
    BakedPage, BakedTile, Baker, Deal, ErrorSums, LayerPlanes, PageStats, Pilot, Take,
    layers_in_work, layers_of_light,
};
pub use plan::{AnyViewErrors, Decision, Method, OpenTriangles, Plan};
pub use reach::{Fingerprint, Reach};
pub use seams::{SeamStats, seam_points};
