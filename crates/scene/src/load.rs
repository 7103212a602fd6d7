//! From a file to its scene.

use crate::image::Budget;
use crate::input::{Bounds, Input};
use crate::source::format_of;
use crate::{Error, Files, Format, Scene, validate};
use std::path::Path;

/// The scene in a file, complete and validated: see [`Scene`] for what holds afterwards.
///
/// A GLB file is known by its first bytes, `.obj` and `.gltf` by their ending. Files named inside (buffers, images,
/// material libraries) are looked for beside the file that names them, and are read only in its folder or below: see
/// [`Files`].
///
/// # Errors
/// One line that names the file, the place and the cure; see [`Error`]. Nothing a file can hold makes this panic, and
/// what it allocates is bounded by a multiple of the bytes it reads.
///
/// ```no_run
/// let scene = ambake_scene::load(std::path::Path::new("room.glb"))?;
/// println!("{} triangles", scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>());
/// # Ok::<(), ambake_scene::Error>(())
/// ```
pub fn load(path: &Path) -> Result<Scene, Error> {
    load_with(path, Files::Inside)
}

/// As [`load`], with a say in where the files may lie that the scene names.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: &Path, allowed: Files) -> Result<Scene, Error> {
    load_within(path, allowed, Budget::default())
}

/// As [`load_with`], within a bound for decoded pictures.
pub(crate) fn load_within(path: &Path, allowed: Files, pictures: Budget) -> Result<Scene, Error> {
    let format = format_of(path)?;
    let mut input = Input::new(path);
    input.bounds = Bounds { allowed, pictures };
    let parts = match format {
        #[cfg(feature = "obj")]
        Format::Obj => crate::obj::load(&mut input)?,
        #[cfg(feature = "gltf")]
        Format::Gltf | Format::Glb => crate::gltf::load(&mut input, format)?,
        // A file is never `Format::Memory`.
        _ => return Err(Error::NotBuilt { path: path.into() }),
    };
    validate::scene(input, format, parts)
}
