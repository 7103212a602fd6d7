//! Compressed geometry, decoded once when a file is opened: what reads the document afterwards, and what a writer keeps
//! of it, is plain.

mod draco;
mod edit;
mod meshopt;

use super::document::GltfDocument;
use crate::Error;
use crate::source::Input;

/// Decodes what `EXT_meshopt_compression`, `KHR_meshopt_compression` and `KHR_draco_mesh_compression` compress, and
/// takes the extensions away where nothing uses them any more. What has an uncompressed fallback in the file stays as
/// it is: the fallback is read.
///
/// # Errors
/// The view or primitive whose data are damaged.
pub(super) fn decode(input: &Input, document: &mut GltfDocument) -> Result<(), Error> {
    meshopt::decode(document).map_err(|(place, problem)| input.invalid(place, problem))?;
    draco::decode(document).map_err(|(place, problem)| input.invalid(place, problem))
}
