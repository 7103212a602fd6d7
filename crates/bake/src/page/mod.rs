//! Pages: tiles baked into planes, denoised, composed and dilated.

mod baker;
mod compose;
mod finish;
mod planes;
mod stats;

pub use baker::{Baker, Pilot};
pub(crate) use finish::{finish_light, light_terms};
pub use planes::{BakedPage, LayerPlanes};
pub use stats::{ErrorSums, PageStats};
