//! Reads OBJ/MTL, glTF and GLB into one plain, validated [`Scene`].
//!
//! `load` is the entrance, [`Scene::from_meshes`] and [`Scene::from_placements`] those for a program that has its
//! meshes in memory. What is
//! repaired or ignored is the list of [`WarningKind`], what stops a load stands at the head of `validate.rs`. Colours
//! and alpha of a material's textures are read with [`Scene::color`] and its neighbours.
//!
//! # Where what is
//!
//! * From a file to its scene: `load.rs`. OBJ: `obj`. glTF: `gltf`, where `conformance` is the table of what is read,
//!   `said.rs` knows what `extras.ambake` says, `compressed` decodes meshes and `lights.rs` has the lights. Scenes made
//!   in memory: `authored`, their materials `authored/material.rs`.
//! * What is repaired and what is refused: `validate.rs`.
//! * What a load has so far, and what it may read: `input.rs`. Where the files of a scene may lie, and which are read:
//!   `source.rs`, for pictures of a glTF `gltf/document.rs`. `SECURITY.md` says why.
//! * From where coordinates count, and what is said of lost digits: `far.rs`. `crates/rays/src/origin.rs` moves worlds.
//! * Numbers joined into sets, as charts and solids are found: `sets.rs`.
//! * Materials as Phong parameters: `material.rs`. How normal maps are decoded: `normal_map.rs`. At a point of a
//!   surface both are `rays`' matter.
#![forbid(unsafe_code)]
// Without one of the readers some helpers have no caller.
#![cfg_attr(
    not(all(feature = "obj", feature = "draco", feature = "meshopt")),
    allow(dead_code)
)]

mod alpha_blocks;
pub mod authored;
mod bounds;
mod document;
#[cfg(feature = "files")]
mod edited;
mod error;
pub mod far;
#[cfg(feature = "files")]
mod foreign;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "files")]
mod image;
mod input;
#[cfg(feature = "files")]
mod load;
mod lookup;
mod material;
mod normal_map;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "files")]
mod packed;
#[cfg(test)]
mod picture_tests;
mod sets;
#[cfg(feature = "files")]
mod source;
mod types;
mod validate;
mod warning;

pub use alpha_blocks::AlphaBlocks;
pub use bounds::around;
pub use document::{EncodedImage, GltfDocument};
pub use error::Error;
#[cfg(feature = "gltf")]
pub use gltf::{Elements, conformance};
#[cfg(feature = "files")]
pub use input::Files;
pub use input::kept_name;
#[cfg(feature = "files")]
pub use load::{load, load_with};
pub use material::{MAX_EXPONENT, phong_from_metallic_roughness, phong_from_specular_glossiness};
pub use normal_map::{NormalMap, Packed, PackedImage};
#[cfg(feature = "files")]
pub use packed::picture;
pub use sets::Sets;
pub use types::*;
pub use warning::{Warning, WarningKind};
