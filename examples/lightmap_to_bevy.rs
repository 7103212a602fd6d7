//! Writes what Bevy's `Lightmap` component reads: a GLB whose meshes carry the lightmap coordinates as `TEXCOORD_1`
//! (Bevy's `ATTRIBUTE_UV_1`), and for each page an OpenEXR picture with plain R, G, B channels in half floats.
//!
//! Run it with `cargo run --release --example lightmap_to_bevy -- scenes/courtyard.obj out-bevy`.
//!
//! In Bevy, attach to every entity with a mesh of the GLB:
//!
//! ```text
//! Lightmap { image: asset_server.load("courtyard.0.lightmap.exr"), uv_rect: Rect::new(0., 0., 1., 1.), ..default() }
//! ```
//!
//! and set `StandardMaterial::lightmap_exposure`. The values are light that arrives, without albedo: E / pi, which is 1
//! under an open sky of radiance 1. Bevy multiplies them by the base colour.

#![allow(clippy::print_stdout, reason = "an example shows what it did")]

use ambake::{Bake, Layer};
use exr::prelude::{f16, write_rgb_file};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let scene_file = arguments
        .next()
        .unwrap_or_else(|| root.join("scenes/courtyard.obj"));
    let folder = arguments.next().unwrap_or_else(|| "out-bevy".into());
    std::fs::create_dir_all(&folder)?;

    let scene = ambake::load(&scene_file)?;
    let baked = Bake::new(&scene)
        .size(512)
        .rays(64)
        .only([Layer::Diffuse, Layer::Irradiance])
        .run(&())?;

    baked.write_gltf(folder.join(format!("{}.glb", scene.stem())))?;
    for page in baked.pages() {
        let [red, green, blue] = [0, 1, 2].map(|c| page.channel(Layer::Irradiance, c));
        let edge = page.size() as usize;
        let name = format!("{}.{}.lightmap.exr", scene.stem(), page.number());
        write_rgb_file(folder.join(&name), edge, edge, |x, y| {
            let at = y * edge + x;
            let [r, g, b] = [red[at], green[at], blue[at]].map(f16::from_f32);
            (r, g, b)
        })?;
        println!("{}", folder.join(name).display());
    }
    Ok(())
}
