//! glTF 2.0 and GLB: one [`crate::Mesh`] a primitive that the scene uses, one [`crate::Instance`] a placement of it,
//! and the [`crate::GltfDocument`] itself for the writer.
//!
//! Nothing judges the document as a whole: each part is read where the scene that is baked needs it, through `get` on
//! the plain JSON and through the checked byte ranges of `accessor.rs`. Positions, indices and the places of nodes must
//! be sound. All else that is broken is as if it were not there, and told of (`reader.rs`).
//!
//! What is read, and what is left out and counted as a warning, is the table of `conformance`.

mod accessor;
#[cfg(any(feature = "draco", feature = "meshopt"))]
mod compressed;
pub mod conformance;
mod container;
mod document;
mod elements;
mod images;
mod lights;
mod materials;
mod names;
mod nodes;
mod phong;
mod primitives;
mod reader;
mod root;
mod said;

pub use elements::Elements;

use crate::input::Input;
use crate::source::without_mark;
use crate::validate::Parts;
use crate::{Error, Format, GltfDocument, Material};
use container::Chunks;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Reads the glTF or GLB file of `input` with its buffers and images.
pub(crate) fn load(input: &mut Input, format: Format) -> Result<Parts, Error> {
    let mut bytes = input.read_main()?;
    let Chunks { json, bin } = match format {
        Format::Glb => {
            container::chunks(&bytes).map_err(|(place, problem)| input.invalid(place, problem))?
        }
        _ => Chunks {
            json: 0..bytes.len(),
            bin: None,
        },
    };
    let text = without_mark(&bytes[json]);
    let mut json = serde_json::from_slice(text).map_err(|e| {
        input.invalid(
            "JSON",
            format!("{e}; correct that place, or export the file again"),
        )
    })?;
    root::write_integers_as_such(&mut json);
    root::check(input, &json)?;
    root::make_lists(input, &mut json);
    conformance::warn(input, &json);
    // The file's own memory becomes the first buffer's.
    let bin = bin.map(|bin| {
        bytes.truncate(bin.end);
        bytes.drain(..bin.start);
        bytes
    });
    let mut document = GltfDocument::open(input, json, bin)?;
    #[cfg(any(feature = "draco", feature = "meshopt"))]
    compressed::decode(&mut document);

    let mut parts = Parts::default();
    let mut image_files = BTreeMap::new();
    let (placements, lights) = nodes::placements(input, &document)?;
    parts.lights = lights;
    let mut primitives = primitives::load(input, &document, &placements, &mut parts)?;
    nodes::instances(&document, placements, &mut primitives, &mut parts);
    materials::load(input, &document, &mut parts, &mut image_files)?;
    let untinted_index = parts.materials.len() as u32;
    let mut without = parts
        .meshes
        .iter_mut()
        .filter(|mesh| mesh.material == primitives::NO_MATERIAL)
        .peekable();
    if without.peek().is_some() || untinted_index == 0 {
        parts.materials.push(Material::untinted("none"));
    }
    without.for_each(|mesh| mesh.material = untinted_index);
    document.take_images(input, image_files)?;
    root::drop_dangling(&mut document.json);
    parts.source = Some(Arc::new(document));
    Ok(parts)
}
