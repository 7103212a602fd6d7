//! Texels meet rays: what a bake models, the surface under each texel, its integrals with their errors, and pages.
//!
//! The stages stand in folders in the order they run: `plan` decides what a scene needs, `survey` cuts texels into cells
//! of surface, `integrate` casts their rays, `denoise` smooths terms over a surface, `page` composes models and keeps
//! planes. [`Bake`] runs them.
#![forbid(unsafe_code)]

mod denoise;
mod integrate;
mod options;
mod page;
mod plan;
mod survey;

pub use integrate::{REPLICATES, Terms};
pub use options::{Denoise, Effort, Options, Pattern, PointSet, Sky, View};
pub use page::{Bake, BakedPage, BakedTexel, PageStats, Plane, Progress};
pub use plan::{Choice, Decision, Plan};
