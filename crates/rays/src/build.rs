//! How a backend is chosen and built.

use crate::backend::{RayBackend, TreeKind};
use crate::embree_backend::EmbreeBackend;
use crate::error::Error;
use crate::obvhs_backend::ObvhsBackend;
use crate::world::World;

/// Which library answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackendKind {
    /// Debian's Embree.
    Embree,
    /// obvhs, in Rust throughout.
    Obvhs(TreeKind),
}

/// A backend over the world. `threads` bounds the threads of the build, 0 for all; obvhs builds in the current rayon
/// pool.
///
/// # Errors
/// Embree is absent or refuses the scene. obvhs has no errors.
pub fn build(
    kind: BackendKind,
    world: &World,
    threads: usize,
) -> Result<Box<dyn RayBackend>, Error> {
    Ok(match kind {
        BackendKind::Embree => Box::new(EmbreeBackend::build(world, threads)?),
        BackendKind::Obvhs(layout) => Box::new(ObvhsBackend::build(world, layout)),
    })
}

/// True where this build holds Embree; whether its library can be loaded shows when a backend is built.
pub fn has_embree() -> bool {
    embree::header_version().is_some()
}
