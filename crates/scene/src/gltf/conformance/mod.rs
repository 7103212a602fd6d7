//! What of glTF 2.0 and of its extensions a bake reads: one table. Warnings are made from it, and the table of
//! `docs/gltf.md`, which a test holds to it.
//!
//! Sources: the glTF 2.0 specification, section 5; the extensions of its repository, `extensions/2.0`, on 26 November
//! 2026, and those of other makers that are in wide use.

#[cfg(test)]
mod tests;

use super::names::own_name;
use crate::WarningKind;
use crate::input::{Input, short};
use Support::{Approximated, Harmless, Honoured, NotRead};
use WarningKind::IgnoredExtensions as Ignored;
use serde_json::Value;
use std::collections::HashSet;

/// What becomes of a property or an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// It decides the bake as its text says.
    Honoured,
    /// It cannot change a bake.
    Harmless,
    /// It decides the bake, but not to the letter; the note says how.
    Approximated,
    /// It could change light, and is left out with a counted warning.
    NotRead,
}

/// A line of the table.
pub struct Row {
    /// The extension, or properties of the core with what they belong to.
    pub name: &'static str,
    /// What becomes of it.
    pub support: Support,
    /// How it is read, or what is done without it.
    pub note: &'static str,
    /// What is counted of it: [`WarningKind::IgnoredExtensions`] wherever it stands, another kind where it is read.
    pub warning: Option<WarningKind>,
    /// Geometry cannot be had without it, so a file that requires it is refused.
    pub needed: bool,
    /// The property that says how much of it there is: without it, or with 0, nothing of it shows and nothing is
    /// counted.
    pub amount: Option<&'static str>,
}

const fn row(name: &'static str, support: Support, note: &'static str) -> Row {
    Row {
        name,
        support,
        note,
        warning: None,
        needed: false,
        amount: None,
    }
}

const fn told(name: &'static str, support: Support, note: &'static str, kind: WarningKind) -> Row {
    Row {
        warning: Some(kind),
        ..row(name, support, note)
    }
}

const fn amount(name: &'static str, amount: &'static str, note: &'static str) -> Row {
    Row {
        amount: Some(amount),
        ..told(name, NotRead, note, Ignored)
    }
}

const fn needed(name: &'static str, note: &'static str) -> Row {
    Row {
        needed: true,
        ..told(name, NotRead, note, Ignored)
    }
}

/// Compressed geometry, which a build without its decoder cannot have.
const fn decoded(name: &'static str, is_built: bool) -> Row {
    match is_built {
        true => row(name, Honoured, ""),
        false => needed(name, "this program was built without its decoder"),
    }
}

/// The properties of the core.
#[rustfmt::skip]
pub const CORE: &[Row] = &[
    row("accessor: bufferView, byteOffset, componentType, normalized, count, type, sparse", Honoured,
        "without a bufferView zeros; integers may be written as 1.0, here as elsewhere"),
    row("accessor: min, max", Harmless, "bounds are those of the numbers themselves"),
    row("animation", Harmless, "nodes are baked where they stand"),
    row("asset: version", Honoured, "2.x"),
    row("asset: copyright, generator, minVersion", Harmless, "no version of 2.x after 2.0 exists"),
    row("buffer: uri, byteLength", Honoured,
        "a file in the folder of the scene or below, or a data URI; \
        one that cannot be had and that no mesh needs stops nothing"),
    row("bufferView: buffer, byteOffset, byteLength, byteStride", Honoured, ""),
    row("bufferView: target", Harmless, ""),
    row("camera, node: camera", Harmless, ""),
    row("extensionsRequired, extensionsUsed", Honoured,
        "a file is refused where it requires one that is not known, or geometry that cannot be read"),
    row("extras, name", Harmless, "names stand in reports; `extras.ambake` says what `docs/flags.md` lists"),
    row("image: uri, bufferView", Honoured, "PNG and JPEG by their bytes; WebP, BMP and TGA too"),
    row("image: mimeType", Harmless, "the bytes say what they are"),
    row("material: alphaMode, alphaCutoff", Honoured, "BLEND lets the share 1 - alpha of the light pass"),
    row("material: doubleSided", Approximated,
        "every triangle blocks and reflects light on both sides; \
        the back of a single-sided one sends out none of its own"),
    row("material: emissiveFactor, emissiveTexture", Honoured, "a lamp, with `--bounces` and in pictures"),
    told("material: normalTexture", Approximated, "with `--normal-maps` it bends normals; relief casts no shadow",
        WarningKind::IgnoredNormalMaps),
    row("material: occlusionTexture", Harmless, "the bake's own takes its place"),
    row("material: baseColorFactor, baseColorTexture", Honoured, ""),
    row("material: metallicFactor, roughnessFactor, metallicRoughnessTexture", Approximated,
        "as Phong's model; with `--model ggx` as the specification has it"),
    row("primitive: attributes POSITION, NORMAL, TANGENT, TEXCOORD_n, COLOR_0", Honoured,
        "without POSITION there is no surface; `COLOR_0` multiplies base colour and alpha; \
        its integers are shares, said or not"),
    row("primitive: attributes COLOR_1 and above, _OWN", Harmless, "only programs of their own know them"),
    row("primitive: indices, material", Honoured, "without a material a surface is white and matt"),
    row("primitive: mode 4, 5, 6", Honoured, "triangles, strips and fans"),
    told("primitive: mode 0, 1, 2, 3", NotRead, "points and lines have no area", WarningKind::PointsAndLines),
    told("primitive: targets; mesh, node: weights", NotRead, "the base shape is baked", WarningKind::MorphTargets),
    row("node: children, mesh, matrix, translation, rotation, scale", Honoured, ""),
    told("skin, node: skin, attributes JOINTS_n, WEIGHTS_n", NotRead, "the mesh is baked where its node stands",
        WarningKind::Skins),
    row("sampler: magFilter, wrapS, wrapT", Honoured, ""),
    row("sampler: minFilter", Harmless, "a texel has the mean of points of the finest level"),
    row("scene, scenes", Honoured, "the default scene, else the first, else all nodes; others are named"),
    row("texture: source, sampler; textureInfo: index, texCoord", Honoured, ""),
];

/// The extensions.
#[rustfmt::skip]
pub const EXTENSIONS: &[Row] = &[
    row("KHR_animation_pointer", Harmless, "as animations"),
    row("KHR_audio_emitter", Harmless, ""),
    decoded("KHR_draco_mesh_compression", cfg!(feature = "draco")),
    told("KHR_gaussian_splatting", NotRead, "splats are left out", Ignored),
    row("KHR_implicit_shapes", Harmless, "they stand for bodies of physics"),
    row("KHR_interactivity", Harmless, ""),
    row("KHR_lights_punctual", Honoured, "with `--lights file`; lux and candela are units of irradiance and intensity"),
    amount("KHR_materials_anisotropy", "anisotropyStrength", "highlights are round"),
    amount("KHR_materials_clearcoat", "clearcoatFactor", "the surface is baked without its coat"),
    amount("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", "no light passes the surface"),
    row("KHR_materials_dispersion", Harmless, "light that passes is not bent"),
    row("KHR_materials_emissive_strength", Honoured, ""),
    row("KHR_materials_ior", Honoured, "as reflectance; light that passes is not bent"),
    amount("KHR_materials_iridescence", "iridescenceFactor",
        "highlights have the colour of the surface without its film"),
    row("KHR_materials_pbrSpecularGlossiness", Honoured, "in place of metallic and roughness"),
    amount("KHR_materials_sheen", "sheenColorFactor", "the surface is baked without its sheen"),
    told("KHR_materials_specular", Approximated, "factors are read, textures are not", WarningKind::UnreadTextures),
    told("KHR_materials_transmission", Approximated,
        "light passes straight on; lamps and surfaces shine through it in its tint, channel by channel; \
        of the sky a bake takes the mean of the tint", WarningKind::GreyTransmission),
    told("KHR_materials_unlit", Approximated,
        "viewers show the surface without light; it is baked as a lit one of its base colour", Ignored),
    row("KHR_materials_variants", Harmless, "the materials that primitives name are baked"),
    amount("KHR_materials_volume", "thicknessFactor",
        "light that passes keeps its direction, and its colour but for the surface's"),
    row("KHR_mesh_quantization", Honoured, ""),
    decoded("KHR_meshopt_compression", cfg!(feature = "meshopt")),
    row("KHR_node_hoverability", Harmless, ""),
    row("KHR_node_selectability", Harmless, ""),
    row("KHR_node_visibility", Honoured, "hidden nodes and all below them are absent"),
    row("KHR_physics_rigid_bodies", Harmless, ""),
    told("KHR_techniques_webgl", NotRead, "shaders are not run; the material is baked as its other properties say",
        Ignored),
    told("KHR_texture_basisu", NotRead, "the core's picture is read; without one the factor stands alone",
        WarningKind::UnreadTextures),
    row("KHR_texture_transform", Honoured, ""),
    row("KHR_xmp", Harmless, ""),
    row("KHR_xmp_json_ld", Harmless, ""),
    row("EXT_instance_features", Harmless, ""),
    told("EXT_lights_ies", NotRead, "lights of the file are not baked", Ignored),
    told("EXT_lights_image_based", NotRead, "the sky of the file is not baked; name one by `--sky`", Ignored),
    row("EXT_mesh_features", Harmless, "it reads the same coordinates in the written GLB"),
    row("EXT_mesh_gpu_instancing", Honoured, ""),
    row("EXT_mesh_manifold", Harmless, ""),
    row("EXT_mesh_primitive_edge_visibility", Harmless, ""),
    needed("EXT_mesh_primitive_restart", "strips are read as one"),
    decoded("EXT_meshopt_compression", cfg!(feature = "meshopt")),
    row("EXT_structural_metadata", Harmless, ""),
    told("EXT_texture_astc", NotRead, "the core's picture is read; without one the factor stands alone",
        WarningKind::UnreadTextures),
    told("EXT_texture_avif", NotRead, "the core's picture is read; without one the factor stands alone",
        WarningKind::UnreadTextures),
    row("EXT_texture_webp", Honoured, ""),
    row("MSFT_lod", Harmless, "the nodes of the scene are baked, the finest level"),
    row("MSFT_packing_normalRoughnessMetallic", Harmless, "the core's textures are read"),
    row("MSFT_packing_occlusionRoughnessMetallic", Harmless, "the core's textures are read"),
    told("MSFT_texture_dds", NotRead, "the core's picture is read; without one the factor stands alone",
        WarningKind::UnreadTextures),
    told("ADOBE_materials_clearcoat_specular", NotRead, "the surface is baked without its coat", Ignored),
    told("ADOBE_materials_clearcoat_tint", NotRead, "the surface is baked without its coat", Ignored),
    told("ADOBE_materials_thin_transparency", NotRead,
        "no light passes the surface but by KHR_materials_transmission", Ignored),
    row("AGI_articulations", Harmless, ""),
    row("AGI_stk_metadata", Harmless, ""),
    told("CESIUM_RTC", NotRead,
        "its centre is added to nothing: lights and eyes that are given by coordinates \
        count from the file's own origin", Ignored),
    row("CESIUM_primitive_outline", Harmless, ""),
    row("FB_geometry_metadata", Harmless, ""),
    row("FB_ngon_encoding", Harmless, "its triangles are baked"),
    row("GODOT_single_root", Harmless, ""),
    row("GRIFFEL_bim_data", Harmless, ""),
    row("MOZ_hubs_components", Harmless, ""),
    row("MOZ_lightmap", Harmless, "a lightmap of an earlier bake adds no light to this one"),
    needed("MPEG_accessor_timed", "the numbers of the file's own buffers are read"),
    row("MPEG_animation_timing", Harmless, ""),
    row("MPEG_audio_spatial", Harmless, ""),
    needed("MPEG_buffer_circular", "the file's own buffers are read"),
    row("MPEG_media", Harmless, "what plays is named by the extensions that use it"),
    told("MPEG_mesh_linking", NotRead, "the mesh is baked as it stands in the file", Ignored),
    told("MPEG_scene_dynamic", NotRead, "the scene is baked as it stands in the file", Ignored),
    told("MPEG_texture_video", NotRead, "the texture's picture is read, not its video", Ignored),
    row("MPEG_viewport_recommended", Harmless, ""),
    told("NV_materials_mdl", NotRead, "the material is baked as its other properties say", Ignored),
    row("OMI_physics_body", Harmless, ""),
    row("OMI_physics_shape", Harmless, ""),
    row("VRM", Harmless, ""),
    told("VRMC_materials_mtoon", NotRead, "the material is baked as its other properties say", Ignored),
    row("VRMC_node_constraint", Harmless, ""),
    row("VRMC_springBone", Harmless, ""),
    row("VRMC_vrm", Harmless, ""),
    needed("WEB3D_quantized_attributes", "positions are read as they stand"),
];

/// The line of an extension.
fn extension(name: &str) -> Option<&'static Row> {
    EXTENSIONS.iter().find(|row| row.name == name)
}

/// Whether a file that requires an extension can be baked.
pub(super) fn is_supported(name: &str) -> bool {
    extension(name).is_some_and(|row| !row.needed)
}

/// Counts the extensions that could change light and are not read, and those that are not known, with the names of what
/// has them.
pub(super) fn warn(input: &mut Input, json: &Value) {
    let mut document = Vec::new();
    collect(json.get("extensions"), &mut document);
    note(input, "the file", document);
    let used = used_materials(json);
    let lists = json.as_object().into_iter().flatten();
    for (key, list) in lists {
        let what = key.strip_suffix('s').unwrap_or(key);
        let what = if key == "meshes" { "mesh" } else { what };
        for (i, item) in list.as_array().into_iter().flatten().enumerate() {
            if key == "materials" && !used.contains(&(i as u64)) {
                continue;
            }
            let mut names = Vec::new();
            find(item, &mut names);
            let place = match own_name(item) {
                Some(name) => format!("{what} `{}`", short(name)),
                None => format!("{what} {i}"),
            };
            note(input, &place, names);
        }
    }
}

/// The materials that primitives name.
fn used_materials(json: &Value) -> HashSet<u64> {
    let list = |of: Option<&Value>| of.and_then(Value::as_array).cloned().unwrap_or_default();
    let meshes = list(json.get("meshes")).into_iter();
    let primitives = meshes.flat_map(|mesh| list(mesh.get("primitives")));
    primitives
        .filter_map(|primitive| primitive.get("material")?.as_u64())
        .collect()
}

/// The names of all extensions in an element, those of its parts and of other extensions included.
fn find<'a>(value: &'a Value, names: &mut Vec<&'a str>) {
    match value {
        Value::Object(fields) => {
            collect(fields.get("extensions"), names);
            let parts = fields
                .iter()
                .filter(|(key, _)| *key != "extras" && *key != "extensions");
            parts.for_each(|(_, part)| find(part, names));
        }
        Value::Array(parts) => parts.iter().for_each(|part| find(part, names)),
        _ => {}
    }
}

/// The names under `extensions`, and what stands in them.
fn collect<'a>(extensions: Option<&'a Value>, names: &mut Vec<&'a str>) {
    for (name, content) in extensions.and_then(Value::as_object).into_iter().flatten() {
        let amount = extension(name).and_then(|row| row.amount);
        if amount.is_none_or(|amount| shows(content, amount)) {
            names.push(name);
        }
        find(content, names);
    }
}

/// True where a number, or one of a list, is not 0.
fn shows(content: &Value, amount: &str) -> bool {
    let is_some = |value: &Value| value.as_f64() != Some(0.0);
    match content.get(amount) {
        None => false,
        Some(Value::Array(list)) => list.iter().any(is_some),
        Some(value) => is_some(value),
    }
}

fn note(input: &mut Input, place: &str, mut names: Vec<&str>) {
    names.sort_unstable();
    names.dedup();
    for name in names {
        let message = match extension(name) {
            Some(row) if row.warning == Some(Ignored) => format!("{name}: {}", row.note),
            Some(_) => continue,
            None => format!(
                "{} is not known here; where it changes how surfaces look, the bake does not show it",
                short(name)
            ),
        };
        input.warn(Ignored, place, 1, message);
    }
}
