//! The JSON of a glTF file, parsed and validated: what is refused before anything is read from it.

use crate::Error;
use crate::source::{Input, short};
use gltf::json::validation::{Error as Finding, Validate};
use gltf::json::{Path as JsonPath, Root};

/// Required extensions that hold no obstacle: they are implemented, have no influence on ambient reflection, or name textures in a
/// format without which a scene can be baked, with a warning.
const SUPPORTED: [&str; 17] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "MSFT_texture_dds",
];

/// The parsed and validated JSON.
pub(super) fn parsed(input: &Input, json: &[u8]) -> Result<Root, Error> {
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

/// The error for an extension that this loader cannot do without and does not implement.
fn unsupported(input: &Input, extension: &str) -> Error {
    Error::Extension {
        path: input.path.clone(),
        extension: short(extension),
    }
}
