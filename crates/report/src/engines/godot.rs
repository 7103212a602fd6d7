//! The scene as Godot 3 and 4 show it: `STEM.godot.glb`, and beside it what Godot reads when it imports that.
//!
//! Godot reads occlusion and emission of glTF at the first coordinates. Its own materials can multiply their colour by
//! a second texture at UV2 ("detail"), and a script that an importer runs can set that. So the materials carry the
//! number of their page in their names, a `.import` file names the script of either version, and another keeps Godot
//! from compressing the lightmap.

use super::scene_kind::{Picture, SceneGlb, TextFile};
use super::{Engine, PageLight};
use crate::preview::encode;
use png::ColorType;
use serde_json::{Map, Value};

pub const GODOT: SceneGlb = SceneGlb {
    suffix: "godot",
    engines: &[Engine::Godot],
    extensions: &[],
    picture,
    shows,
    beside: &[
        TextFile {
            ending: "godot.glb.import",
            text: import,
        },
        TextFile {
            ending: "godot3.gd",
            text: |_| include_str!("godot3.gd").into(),
        },
        TextFile {
            ending: "godot4.gd",
            text: |_| include_str!("godot4.gd").into(),
        },
    ],
    words: [
        "radiance that leaves a matt surface, by materials that multiply their colour by STEM.P.lightmap.exr at UV2",
        "Copy STEM.godot* and STEM.*.lightmap.exr* to the top of a Godot project before it sees them, without the \
         script of the other version. \
         The scene is lit as it is, without lamps and sky.",
    ],
};

/// How Godot imports a lightmap: as it is, to be filtered and not repeated. Keys of version 3, then of 4.
pub const IMPORT: &str = "\
[remap]

importer=\"texture\"

[params]

compress/mode=3
flags/repeat=0
flags/filter=true
flags/mipmaps=false
flags/srgb=0
detect_3d=false
mipmaps/generate=false
detect_3d/compress_to=0
";

/// How Godot imports the scene: coordinates at full precision, and a script for its materials. Version 3 wants its
/// whole path.
fn import(stem: &str) -> String {
    let stem = stem.replace('\\', "\\\\").replace('"', "\\\"");
    format!(
        "\
[remap]

importer=\"scene\"
type=\"PackedScene\"

[params]

nodes/custom_script=\"res://{stem}.godot3.gd\"
materials/location=1
materials/storage=0
meshes/compress=false
import_script/path=\"{stem}.godot4.gd\"
meshes/generate_lods=false
meshes/force_disable_compression=true
gltf/naming_version=2
gltf/texture_map_mode=0
"
    )
}

/// In place of the occlusion, which no material shows.
fn picture(_: &PageLight<'_>) -> Option<Picture> {
    let png = encode([1; 2], ColorType::Grayscale, &[255], None);
    Some(Picture { png, strength: 1.0 })
}

/// Names the material after its page.
fn shows(map: &mut Map<String, Value>, page: usize, _: u64, _: f32) {
    let name = map.get("name").and_then(Value::as_str).unwrap_or_default();
    let name = format!("{name}.ambake.{page}");
    map.insert("name".into(), name.into());
}
