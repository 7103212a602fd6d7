//! glTF 2.0 and GLB: one [`crate::Mesh`] a primitive that the scene uses, one [`crate::Instance`] a placement of it.
//!
//! The `gltf` crate parses and validates the JSON. Its accessor readers and typed wrappers are not used: they index
//! and unwrap where the file is wrong. Everything here goes through `get` on the parsed JSON and through the checked
//! byte ranges of `accessor.rs`; `vendor-notes/gltf.md` lists what was found.
//!
//! What is left out is counted as a warning: `points-and-lines`, `leftover-indices`, `uv-sets-after-a-gap`, `skins`,
//! `morph-targets`, `alpha-as-mask` (BLEND), `ignored-extensions` (of materials), `unread-textures`,
//! `missing-textures`, `clamped-factors`.

mod accessor;
mod container;
mod materials;
mod nodes;
mod primitives;

use crate::material::untinted;
use crate::source::{Input, Uri, beside, short, uri};
use crate::validate::Parts;
use crate::{Error, Format};
use accessor::Data;
use gltf::json::validation::{Error as Finding, Validate};
use gltf::json::{Path as JsonPath, Root};
use std::borrow::Cow;

/// Required extensions that hold no obstacle: they are implemented, or have no influence on ambient reflection.
const SUPPORTED: [&str; 10] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads the glTF or GLB file of `input` with its buffers and images.
pub(crate) fn load(input: &mut Input, format: Format) -> Result<Parts, Error> {
    let bytes = input.read(&input.path.clone())?;
    let (json, bin) = match format {
        Format::Glb => {
            container::chunks(&bytes).map_err(|(place, problem)| input.invalid(place, problem))?
        }
        _ => (bytes.as_slice(), None),
    };
    let root = document(input, json)?;
    let data = Data {
        root: &root,
        buffers: buffers(input, &root, bin)?,
    };

    let mut parts = Parts::default();
    let placements = nodes::placements(input, &data)?;
    let mut primitives = primitives::load(input, &data, &placements, &mut parts)?;
    nodes::instances(&root, placements, &mut primitives, &mut parts);
    materials::load(input, &data, &mut parts)?;
    let untinted_index = parts.materials.len() as u32;
    let mut without = parts
        .meshes
        .iter_mut()
        .filter(|mesh| mesh.material == primitives::NO_MATERIAL)
        .peekable();
    if without.peek().is_some() || untinted_index == 0 {
        parts.materials.push(untinted("none"));
    }
    without.for_each(|mesh| mesh.material = untinted_index);
    Ok(parts)
}

/// The parsed and validated JSON.
fn document(input: &Input, json: &[u8]) -> Result<Root, Error> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root = Root::from_slice(json).map_err(|e| {
        let version = gltf::json::deserialize::from_slice::<gltf::json::Value>(json).ok();
        let version = version
            .as_ref()
            .and_then(|v| v.get("asset")?.get("version")?.as_str().map(short));
        match version {
            Some(version) if !version.starts_with('2') => old(input, &version),
            _ => input.invalid(
                "JSON",
                format!(
                    "{}; export the file again",
                    e.to_string().replace('\n', " ")
                ),
            ),
        }
    })?;
    if !root.asset.version.starts_with("2.") {
        return Err(old(input, &short(&root.asset.version)));
    }
    if let Some(name) = root
        .extensions_required
        .iter()
        .find(|name| !SUPPORTED.contains(&name.as_str()))
    {
        return Err(unsupported(input, name));
    }
    // The crate's own validation indexes with POSITION before it has looked at the range.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(bad) = primitive
                .attributes
                .values()
                .find(|index| index.value() >= root.accessors.len())
            {
                let problem = format!(
                    "accessor {bad} of {}; the file is corrupt",
                    root.accessors.len()
                );
                return Err(input.invalid(format!("mesh {m} primitive {p}"), problem));
            }
        }
    }
    let mut findings = Vec::new();
    root.validate(&root, JsonPath::new, &mut |path, finding| {
        let path = path().to_string();
        // Bounds of POSITION are not used; accessors without a view and required extensions are judged elsewhere.
        let other = path.ends_with("min") || path.ends_with("max") || path.ends_with("bufferView");
        let elsewhere = matches!(finding, Finding::Missing | Finding::Invalid) && other;
        if !elsewhere && !matches!(finding, Finding::Unsupported) {
            findings.push(format!("{path}: {}", finding.to_string().to_lowercase()));
        }
    });
    match findings.as_slice() {
        [] => Ok(root),
        [first] => Err(input.invalid("JSON", format!("{first}; export the file again"))),
        [first, rest @ ..] => Err(input.invalid(
            "JSON",
            format!("{first} (and {} more); export the file again", rest.len()),
        )),
    }
}

fn old(input: &Input, version: &str) -> Error {
    let problem = format!(
        "glTF version {version} is not read; convert it to 2.0 with `npx gltf-pipeline -i IN -o OUT`"
    );
    input.invalid("JSON", problem)
}

fn unsupported(input: &Input, extension: &str) -> Error {
    let advice = match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "decode the meshes first: `npx @gltf-transform/cli copy IN OUT`"
        }
        "KHR_texture_basisu" => {
            "decode the textures first: `npx @gltf-transform/cli ktxdecompress IN OUT`"
        }
        "EXT_texture_webp" | "EXT_texture_avif" => {
            "convert the textures first: `npx @gltf-transform/cli png IN OUT --formats \"*\"`"
        }
        _ => "export the file without it",
    };
    Error::Extension {
        path: input.path.clone(),
        extension: short(extension),
        advice,
    }
}

/// The bytes of every buffer, each at least as long as the JSON says.
fn buffers<'a>(
    input: &mut Input,
    root: &Root,
    bin: Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>, Error> {
    let mut out = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let place = format!("buffer {i}");
        let bytes = match (&buffer.uri, bin) {
            (Some(text), _) => {
                match uri(text).map_err(|problem| input.invalid(place.as_str(), problem))? {
                    Uri::Data(bytes) => Cow::Owned(bytes),
                    Uri::File(name) => Cow::Owned(input.read(&beside(&input.path, &name))?),
                }
            }
            (None, Some(bin)) if i == 0 => Cow::Borrowed(bin),
            _ => {
                let packed = |name: &&String| name.ends_with("_meshopt_compression");
                return Err(match root.extensions_used.iter().find(packed) {
                    Some(name) => unsupported(input, name),
                    None => input.invalid(
                        place,
                        "it has neither a uri nor a binary chunk; export the file again",
                    ),
                });
            }
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let problem = format!(
                "{} bytes are announced, {} are there; the file is truncated, copy or export it again",
                buffer.byte_length.0,
                bytes.len()
            );
            return Err(input.invalid(place, problem));
        }
        out.push(bytes);
    }
    Ok(out)
}
