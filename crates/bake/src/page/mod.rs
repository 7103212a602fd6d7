//! Pages: tiles baked into planes, denoised, composed and dilated.

mod baker;
mod compose;
mod finish;
mod planes;
mod stats;

pub use baker::{Baker, Pilot};
pub use planes::{BakedPage, LayerPlanes};
pub use stats::{ErrorSums, PageStats};
