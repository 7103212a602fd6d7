//! Pages: tiles baked into planes, denoised, composed and dilated.

mod baker;
mod compose;
mod composed;
mod directional;
mod finish;
mod integrated;
mod joined;
mod pilot;
mod planes;
mod sample;
mod share;
mod spend;
mod stats;
mod surveys;
mod tangent;
mod terms;
mod tile;

pub use baker::{Baker, Take};
pub(crate) use finish::finish_light;
pub use pilot::Pilot;
pub use planes::{BakedPage, LayerPlanes};
pub use sample::sampled;
pub use share::Deal;
pub use stats::{ErrorSums, PageStats};
pub use surveys::bytes_of_surveys;
pub(crate) use surveys::remade;
pub(crate) use terms::light_layers;
pub use terms::{channels_of_terms, layers_in_work, layers_of_light};
pub use tile::BakedTile;
pub(crate) use tile::{Column, Columns};
