//! Compressed geometry, decoded once when a file is opened: what reads the document afterwards, and what a writer keeps
//! of it, is plain.

#[cfg(feature = "draco")]
mod draco;
mod edit;
#[cfg(feature = "meshopt")]
mod meshopt;

use crate::GltfDocument;

/// Decodes what `EXT_meshopt_compression`, `KHR_meshopt_compression` and `KHR_draco_mesh_compression` compress, and
/// takes the extensions away where nothing uses them any more. What has an uncompressed fallback in the file stays as
/// it is: the fallback is read. What is damaged is absent: only what reads it fails.
pub(super) fn decode(document: &mut GltfDocument) {
    #[cfg(feature = "meshopt")]
    meshopt::decode(document);
    #[cfg(feature = "draco")]
    draco::decode(document);
}
