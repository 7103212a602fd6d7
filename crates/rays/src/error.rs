//! What can go wrong between a loaded scene and its first ray.

/// Why a world or a ray backend could not be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A placed object leaves the range of single precision, in which rays are cast.
    #[error(
        "object {instance} of {file}: its placed vertices exceed the range of single precision; scale the scene down"
    )]
    OutOfRange {
        /// The scene file.
        file: String,
        /// Name of the instance.
        instance: String,
    },
    /// A normal map cannot be decoded.
    #[error(transparent)]
    NormalMap(#[from] scene::Error),
    /// Embree is absent, too old or refused the scene.
    #[error("embree backend: {0}; `--backend obvhs` needs no library")]
    Embree(#[from] embree::Error),
}
