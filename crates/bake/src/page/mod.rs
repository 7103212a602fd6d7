//! Pages: tiles baked into planes, denoised, composed and dilated.

mod baker;
mod compose;
mod finish;
mod planes;
mod share;
mod stats;
mod tile;

pub use baker::{Baker, Pilot};
pub use finish::layers_in_work;
pub(crate) use finish::{finish_light, light_terms};
pub use planes::{BakedPage, LayerPlanes};
pub use share::Deal;
pub use stats::{ErrorSums, PageStats};
pub use tile::BakedTile;
