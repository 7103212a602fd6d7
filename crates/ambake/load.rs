//! From a file to its scene.

use crate::error::Error;
use crate::scene::Scene;
pub use ::scene::Files;
use std::path::Path;

/// The scene in an OBJ, glTF or GLB file. Files that it names are read only in its folder or below: see [`load_with`].
///
/// # Errors
/// One line that names the file, the place and the cure.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, Error> {
    Ok(::scene::load(path.as_ref())?.into())
}

/// As [`load`], with a say in where the files may lie that the scene names.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: impl AsRef<Path>, allowed: Files) -> Result<Scene, Error> {
    Ok(::scene::load_with(path.as_ref(), allowed)?.into())
}
