//! Files that engines load as they are: lightmaps and ambient occlusion, a page at a time.
//!
//! Every engine gets the same light: what arrives at a matt surface without its albedo, E / pi, which is 1 under an
//! open sky of radiance 1. What an engine multiplies by differs; [`Engine`]'s table says it, and `bake.json` repeats
//! it.

mod ao;
mod blocks;
mod container;
mod dds;
mod godot;
mod half_exr;
mod instanced;
mod ktx2;
mod light;
mod lightmap_glb;
mod lit_glb;
mod mips;
mod orm_glb;
mod scene_glb;
mod scene_kind;
mod sh;

pub(crate) use container::{parts, whole};
pub(crate) use ktx2::{Shape, encode_as};
pub use light::{LightSource, PageLight, light_source};
pub use mips::levels as light_levels;
pub use scene_glb::{ScenePictures, scene_files};

pub(crate) use crate::engine_table::BEVY_WHITE;
use crate::engine_table::Kind;
use crate::{Engine, Error, LightmapReport, Output};
use environment::{Format, Image, Labels};
use ktx2::Texels;
use std::path::Path;

/// Stages the files that `engines` get of one page, and returns what `bake.json` says of them. The bytes are a function
/// of the page alone: an export makes the same files as the bake. `compress`: in blocks, where an engine reads those,
/// if [`crate::check_compressed`] allows it.
///
/// # Errors
/// A file cannot be staged.
pub fn stage_engines(
    output: &mut Output,
    stem: &str,
    page: &PageLight<'_>,
    engines: &[Engine],
    compress: bool,
) -> Result<Vec<LightmapReport>, Error> {
    let kinds = Kind::of(engines, page.sh.is_some(), compress);
    if kinds.is_empty() {
        return Ok(Vec::new());
    }
    let levels = mips::levels(page);
    let light: Vec<Vec<u8>> = match compress {
        true => levels.iter().map(blocks::light).collect(),
        false => Vec::new(),
    };
    for kind in &kinds {
        let bytes = match kind {
            Kind::Exr => half_exr::encode([page.size; 2], &levels[0].pixels),
            Kind::Hdr => hdr(&levels[0], &kind.file(stem, page.page))?,
            Kind::Ktx2 => ktx2::encode(&levels, 1),
            Kind::Bc6h => ktx2::encode_blocks(page.size, Texels::Bc6h, &light),
            Kind::Bc6hDds => dds::encode(page.size, &light),
            Kind::Sh => sh::slices(page).unwrap_or_default(),
            Kind::ShKtx2 => sh::array(page).unwrap_or_default(),
            Kind::Ao => ao::deep(page),
            Kind::Bc7 => {
                let grey: Vec<_> = mips::occlusion(page).iter().map(blocks::grey).collect();
                ktx2::encode_blocks(page.size, Texels::Bc7, &grey)
            }
            Kind::Ao8 => ao::dithered(page),
            Kind::GodotImport => godot::IMPORT.into(),
        };
        output.stage_bytes(&kind.file(stem, page.page), &bytes)?;
    }
    let entries = engines.iter().flat_map(|engine| {
        let kinds = Kind::of(&[*engine], page.sh.is_some(), compress).into_iter();
        let light = kinds.filter(|kind| kind.is_light());
        light.map(|kind| engine.entry(kind, kind.file(stem, page.page)))
    });
    Ok(entries.collect())
}

/// The light of a page, or a smaller level of it, as engines take it. No texel is void: around charts stand their
/// nearest texels, and smooth means between those.
#[derive(Debug, Clone, PartialEq)]
pub struct LightLevel {
    /// Edge in texels.
    pub size: u32,
    /// E / pi without albedo, linear RGB, row 0 on top, `size * size` of them; 0..=65504, the largest half float.
    pub pixels: Vec<[f32; 3]>,
}

impl LightLevel {
    /// The bits of its pixels as half floats R, G, B, A, the alpha being 1: what a texture of four half floats holds.
    pub fn half_floats(&self) -> Vec<[u16; 4]> {
        halves(&self.pixels).collect()
    }
}

/// Half floats of pixels, with an alpha of 1.
fn halves(pixels: &[[f32; 3]]) -> impl Iterator<Item = [u16; 4]> {
    let texel = |&[r, g, b]: &[f32; 3]| [r, g, b, 1.0].map(|v| half::f16::from_f32(v).to_bits());
    pixels.iter().map(texel)
}

/// A Radiance picture: 32-bit RGBE, run-length coded.
fn hdr(level: &LightLevel, name: &str) -> Result<Vec<u8>, Error> {
    let image = Image {
        width: level.size as usize,
        height: level.size as usize,
        pixels: level.pixels.clone(),
    };
    environment::encode(&image, Format::Hdr, &Labels::new())
        .map_err(|error| Error::write(Path::new(name), std::io::Error::other(error.to_string())))
}
