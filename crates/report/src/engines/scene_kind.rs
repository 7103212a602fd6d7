//! What the kinds of GLB files that carry light differ in.

use super::{Engine, PageLight};
use serde_json::{Map, Value};

/// A kind of GLB files that show the scene with its light.
pub(super) struct SceneGlb {
    /// What stands between the stem and `.glb`, and at the end of the names of its pictures.
    pub suffix: &'static str,
    /// The engines that get it.
    pub engines: &'static [Engine],
    /// The extensions that its materials use.
    pub extensions: &'static [&'static str],
    /// The picture of a page; `None` where the page lacks a layer.
    pub picture: fn(&PageLight<'_>) -> Option<Picture>,
    /// Makes a material show a page's texture on the lightmap's coordinates, in place of the occlusion; given the page,
    /// the texture and the strength of its picture.
    pub shows: fn(&mut Map<String, Value>, usize, u64, f32),
    /// What an engine wants to find beside it.
    pub beside: &'static [TextFile],
    /// Unit and use, as `bake.json` says them.
    pub words: [&'static str; 2],
}

/// A text file that stands beside such a GLB.
pub(super) struct TextFile {
    /// What stands behind `STEM.` in its name.
    pub ending: &'static str,
    /// Its content, for a stem.
    pub text: fn(&str) -> String,
}

/// Light of one page in 8 bits.
pub(super) struct Picture {
    pub png: Vec<u8>,
    /// What white stands for.
    pub strength: f32,
}
