//! Bakes of scenes that gltfpack and gltf-transform have compressed, against bakes of what they decode.

use crate::support::bake;
use std::path::Path;

#[test]
fn a_compressed_scene_bakes_as_its_decoded_twin() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/scene/tests/files/compressed");
    let flags = ["--size", "64", "--rays", "16"];
    for name in [
        "pack",
        "pack_float",
        "transform",
        "draco",
        "draco_sequential",
    ] {
        let (_folder, page) = bake(&folder.join(format!("{name}.glb")), &flags);
        let (_twin_folder, twin) = bake(&folder.join(format!("{name}.plain.glb")), &flags);
        assert_eq!(page.names(), twin.names(), "{name}");
        assert!(
            page.plane("diffuse").iter().any(|&v| v > 0.0 && v < 0.9),
            "{name}"
        );
        for layer in page.names() {
            assert_eq!(page.plane(layer), twin.plane(layer), "{name}: {layer}");
        }
    }
}
