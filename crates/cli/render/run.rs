//! `ambake render`: the scene is loaded, then a picture, frames or a figure are made.

use super::args::Args;
use super::{file, frames, picture, relit};
use crate::common::build;
use crate::host;
use crate::outcome::{Outcome, tell};
use crate::stop::Stop;
use ::render::{Lightmap, Model};
use scene::Format;
use std::path::Path;
use std::time::Instant;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let stop = Stop::listen()?;
    let threads = host::set_threads(args.common.threads)?;
    #[cfg(not(feature = "bench"))]
    if args.figure.is_some() {
        return crate::bench::absent();
    }
    if args.figure.is_none() {
        for path in &args.output {
            file::ending(path)?;
        }
    }
    if args.tables.relight {
        return relit::relight(args);
    }
    let (scene, lightmap, model) = match &args.bake {
        None => {
            let scene = scene::load_with(&args.scene, args.common.files())?;
            let model = args.model.unwrap_or(match scene.format {
                Format::Gltf | Format::Glb => Model::Ggx,
                Format::Obj | Format::Memory => Model::Phong,
            });
            (scene, None, model)
        }
        Some(dir) => {
            let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy();
            let model = args.model.unwrap_or_else(|| baked_model(dir, &stem));
            let (scene, map) = Lightmap::load(dir, &stem, model.name())?;
            (scene, Some(map), model)
        }
    };
    let (mut world, backend) = build(scene, args.backend, threads)?;
    if args.normal_maps {
        world.read_normal_maps()?;
        for (name, problem) in world.broken_normal_maps() {
            if !args.common.quiet {
                let alone = "the mesh's normals stand alone";
                tell(&format!("texture `{name}`: {problem}; {alone}"));
            }
        }
    }
    let backend = backend.as_ref();
    #[cfg(feature = "bench")]
    if let Some(figure) = args.figure {
        return super::figures::draw(figure, args, &world, backend, &stop);
    }
    if let Some(code) = args.tables.encode {
        return relit::encode(code, args, &world, backend, &stop);
    }
    if args.tables.asked() {
        return frames::draw(args, &world, backend, &stop, started);
    }
    picture::draw(
        args,
        model,
        &world,
        backend,
        lightmap.as_ref(),
        &stop,
        started,
    )
}

/// The model that a bake was made by; Phong where that cannot be read.
fn baked_model(dir: &Path, stem: &str) -> Model {
    let bake = report::read_record(dir, stem);
    match bake.as_ref().and_then(|bake| bake.options.get("model")) {
        Some(model) if model == "ggx" => Model::Ggx,
        _ => Model::Phong,
    }
}
