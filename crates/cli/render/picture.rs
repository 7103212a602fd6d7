//! A picture by the ambient models and lights.

use super::args::Args;
use super::{file, options};
use crate::common::lights;
use crate::outcome::{Outcome, say, say_json};
use crate::progress::watch;
use crate::stop::Stop;
use ::render::{Error, Lamps, Lightmap, Sample, picture};
use rays::{RayBackend, Surfaces, World};
use serde_json::json;
use std::time::Instant;

/// Makes the picture and writes it. Its ambient part is looked up in `lightmap` where there is one.
pub fn draw(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    lightmap: Option<&Lightmap>,
    stop: &Stop,
    started: Instant,
) -> anyhow::Result<Outcome> {
    let camera = options::framing(&args.view).camera(world)?;
    let surfaces = Surfaces::new(world);
    let lights = lights(&args.sun, &args.point);
    let lamps = Lamps::of(world);
    let direct = options::direct(args, &surfaces, backend, &lights, &lamps);
    let radiance = |sample: &Sample| match lightmap {
        None => direct.radiance(sample),
        Some(map) => direct.radiance_baked(sample, map),
    };
    let picture = watch(options::show(args, "pixels"), stop, |progress| {
        picture(&camera, args.view.samples, progress, radiance)
    });
    let picture = match picture {
        Err(Error::Cancelled) => return Ok(stop.outcome()),
        picture => picture?,
    };
    let described = json!({
        "scene": world.scene().content_hash,
        "model": direct.model.name(),
        "rays": args.bake.is_none().then_some(args.rays),
        "samples": args.view.samples,
        "eye": camera.eye.to_array(),
        "forward": camera.forward.to_array(),
        "fov_deg": args.view.fov_deg,
        "sky": args.sky,
        "sun": args.sun,
        "point": args.point,
        "seed": args.common.seed,
    });
    let inputs = file::inputs(args, world);
    for path in &args.output {
        file::write(path, &picture, &described.to_string(), &inputs)?;
    }
    if args.common.json {
        say_json(&json!({
            "schema_version": 1,
            "width": picture.width,
            "height": picture.height,
            "options": described,
            "backend": backend.describe(),
            "seconds": started.elapsed().as_secs_f64(),
        }))?;
    } else if !args.common.quiet {
        let names: Vec<_> = args
            .output
            .iter()
            .map(|p| p.display().to_string())
            .collect();
        say(&format!(
            "{} in {:.1} s\n",
            names.join(", "),
            started.elapsed().as_secs_f64()
        ))?;
    }
    Ok(Outcome::Done)
}
