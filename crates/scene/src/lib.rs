//! Reads OBJ/MTL, glTF and GLB into one plain, validated [`Scene`].
//!
//! [`load`] is the entrance, [`Scene::from_meshes`] and [`Scene::from_placements`] those for a program that has its
//! meshes in memory. What is
//! repaired or ignored is the list of [`WarningKind`], what stops a load stands at the head of `validate.rs`. Colours
//! and alpha of a material's textures are read with [`Scene::color`] and its neighbours.
//!
//! # Where what is
//!
//! * OBJ: `obj`. glTF: `gltf`, where `conformance.rs` is the table of what is read, `said.rs` knows what
//!   `extras.ambake` says, `compressed` decodes meshes and
//!   `lights.rs` has the lights. Scenes made in memory: `authored`, their materials
//!   `authored/material.rs`.
//! * What is repaired and what is refused: `validate.rs`.
//! * Where the files of a scene may lie, and which are read: `source.rs`, for pictures of a glTF `gltf/document.rs`.
//!   `SECURITY.md` says why.
//! * From where coordinates count, and what is said of lost digits: `far.rs`. `crates/rays/src/origin.rs` moves worlds.
//! * Numbers joined into sets, as charts and solids are found: `sets.rs`.
//! * Materials as Phong parameters: `material.rs`. How normal maps are decoded: `normal_map.rs`. At a point of a
//!   surface both are `rays`' matter.
#![forbid(unsafe_code)]

mod alpha_blocks;
pub mod authored;
mod edited;
mod error;
pub mod far;
mod gltf;
mod image;
mod lookup;
mod material;
mod normal_map;
mod obj;
#[cfg(test)]
mod picture_tests;
mod sets;
mod source;
mod types;
mod validate;
mod warning;

pub use alpha_blocks::AlphaBlocks;
pub use error::Error;
pub use gltf::{Elements, EncodedImage, GltfDocument, conformance};
pub use material::{MAX_EXPONENT, phong_from_metallic_roughness, phong_from_specular_glossiness};
pub use normal_map::{NormalMap, PackedImage};
pub use sets::Sets;
pub use source::Files;
pub use types::*;
pub use warning::{Warning, WarningKind};

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
    load_within(path, allowed, image::Budget::default())
}

/// As [`load_with`], within a bound for decoded pictures.
fn load_within(path: &Path, allowed: Files, pictures: image::Budget) -> Result<Scene, Error> {
    let format = source::format_of(path)?;
    let mut input = source::Input::new(path, allowed);
    input.pictures = pictures;
    let parts = match format {
        Format::Obj => obj::load(&mut input)?,
        // A file is never `Format::Memory`.
        _ => gltf::load(&mut input, format)?,
    };
    validate::scene(input, format, parts)
}
