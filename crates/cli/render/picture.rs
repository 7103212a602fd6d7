//! A picture by the ambient models and lights.

use super::args::{Args, Exposure};
use super::file::{Behind, Film};
use super::{balls, file, options};
use crate::outcome::{Outcome, say, say_json};
use crate::progress::watch;
use crate::stop::Stop;
use ::render::{Camera, Error, Framing, Lamps, Lightmap, Model, Sample, alpha, backdrop, picture};
use ambake::{Sky, surrounding};
use anyhow::Context;
use glam::DVec3;
use rays::{RayBackend, Surfaces, World};
use report::BakeReport;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Makes the picture and writes it. Its ambient part is looked up in `lightmap` where there is one.
pub fn draw(
    args: &Args,
    model: Model,
    world: &World,
    backend: &dyn RayBackend,
    lightmap: Option<&Lightmap>,
    stop: &Stop,
    started: Instant,
) -> anyhow::Result<Outcome> {
    let framing = options::framing(&args.view, world);
    // From a bake and without a view of one's own, the picture is that of STEM.lit.png.
    let fitted = lightmap.is_some() && args.view.eye.is_none();
    let camera = match fitted {
        true => match baked_camera(args, &framing, world) {
            Some(camera) => camera,
            None => {
                let around = surrounding(world, backend, framing.up);
                framing.fitted(world, backend, &around, args.view.fov_deg.is_some())?
            }
        },
        false => framing.camera(world)?,
    };
    let surfaces = Surfaces::new(world);
    let lights = args.shining.lights(world.origin());
    let lamps = Lamps::of(world);
    let sky = match (&args.bake, &args.sky) {
        (Some(dir), None) => baked_sky(dir, &args.scene)?,
        _ => options::sky(args)?,
    };
    let mut direct = options::direct(args, model, &sky, &surfaces, backend, &lights, &lamps);
    direct.incidence = options::incidence(args, direct.model)?;
    if fitted && args.background.is_none() {
        direct.background = Some(backdrop(sky.mean().into()));
    }
    // What stands behind the surfaces has no part in how bright they are shown.
    let is_auto = match args.exposure {
        Some(Exposure::Auto) => true,
        Some(Exposure::Stops(_)) => false,
        None => fitted,
    };
    let film = Film::of(args)?;
    let behind = match Behind::of(args, args.view.size, &film)? {
        Behind::Own if is_auto => {
            let behind = |sample: &Sample| direct.behind(sample);
            Behind::Plate(picture(&camera, args.view.samples, &(), behind)?)
        }
        behind => behind,
    };
    if !matches!(behind, Behind::Own) {
        direct.background = Some(DVec3::ZERO);
    }
    let balls = balls::balls(args, world)?;
    let scene = |sample: &Sample| match lightmap {
        None => direct.radiance(sample),
        Some(map) => direct.radiance_baked(sample, map),
    };
    let on_balls = |sample: &Sample| direct.on_balls(sample, &balls, scene);
    let radiance = |sample: &Sample| on_balls(sample).unwrap_or_else(|| scene(sample));
    let picture = watch(options::show(args, "pixels"), stop, |progress| {
        picture(&camera, args.view.samples, progress, radiance)
    });
    let picture = match picture {
        Err(Error::Cancelled) => return Ok(stop.outcome()),
        picture => picture?,
    };
    let alpha = match behind {
        Behind::Own => Vec::new(),
        _ => {
            let coverage = |sample: &Sample| match on_balls(sample) {
                Some(_) => 1.0,
                None => direct.coverage(sample),
            };
            alpha(&camera, args.view.samples, &(), coverage)?
        }
    };
    let described = json!({
        "scene": world.scene().content_hash,
        "model": direct.model.name(),
        "rays": args.bake.is_none().then_some(args.rays),
        "samples": args.view.samples,
        "eye": (camera.eye + world.origin()).to_array(),
        "forward": camera.forward.to_array(),
        "fov_deg": (1e9 * 2.0 * camera.slope.atan().to_degrees()).round() / 1e9,
        "sky": sky,
        "sun": args.shining.sun,
        "point": args.shining.point,
        "sphere": args.shining.sphere,
        "rect": args.shining.rect,
        "seed": args.common.seed,
    });
    let inputs = file::inputs(args, world, lightmap);
    let exposure = match args.exposure {
        Some(Exposure::Stops(stops)) => ::render::Exposure::of_stops(stops),
        _ if is_auto => ::render::Exposure::of(&picture, &alpha),
        _ => ::render::Exposure::of_stops(0.0),
    };
    for path in &args.output {
        let mut shown = match file::ending(path)? {
            "png" => exposure.shown(picture.clone()),
            _ => picture.clone(),
        };
        let matte = behind.compose(&mut shown, &alpha);
        file::write(path, &shown, matte, &described.to_string(), &inputs, &film)?;
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

/// What a bake of the scene says of itself.
fn baked_report(dir: &Path, scene: &Path) -> Result<BakeReport, report::Error> {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    let own = report::read_record(dir, &stem);
    own.map_or_else(
        || report::read_bake_report(&dir.join(report::REPORT_FILE)),
        Ok,
    )
}

/// The camera of the picture that a bake made, which shows no less in a picture of other proportions; `None` where it
/// made none.
fn baked_camera(args: &Args, framing: &Framing, world: &World) -> Option<Camera> {
    let view = baked_report(args.bake.as_deref()?, &args.scene)
        .ok()?
        .picture?;
    let [width, height] = framing.size.map(f64::from);
    let slope = (view.fov_deg.to_radians() / 2.0).tan() * (view.aspect * height / width).max(1.0);
    let framing = Framing {
        fov: match args.view.fov_deg {
            Some(_) => framing.fov,
            None => 2.0 * slope.atan(),
        },
        ..*framing
    };
    let eye = DVec3::from(view.eye) - world.origin();
    framing
        .camera_at([eye, eye + DVec3::from(view.forward)])
        .ok()
}

/// The mean radiance of the sky that a bake of the scene was lit by.
fn baked_sky(dir: &Path, scene: &Path) -> anyhow::Result<Sky> {
    let path = dir.join(report::REPORT_FILE);
    let options = baked_report(dir, scene)?.options;
    let sky = options.get("sky").unwrap_or(&Value::Null);
    let mean = sky.get("mean").unwrap_or(sky);
    let mean: Option<[f32; 3]> = serde_json::from_value(mean.clone()).ok();
    let mean = mean.with_context(|| format!("{}: it names no sky; bake again", path.display()))?;
    Ok(Sky::uniform(mean))
}
