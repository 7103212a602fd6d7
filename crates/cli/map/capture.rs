//! `ambake map capture`: the illumination map of a place in a scene.

use super::args::Capture;
use super::file::{Target, picture_size, write};
use crate::common::build;
use crate::host;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use ::render::{Direct, Error, Lamps, Light, PointForm, add_points, capture};
use ambake::flags::common::points;
use anyhow::bail;
use environment::{Format, MapLayout, Orientation};
use glam::DVec3;
use rays::Surfaces;
use scene::Scene;
use serde_json::json;
use std::time::Instant;

/// Runs the sub-verb.
pub fn run(args: &Capture) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let stop = Stop::listen()?;
    let threads = host::set_threads(args.common.threads)?;
    Format::of(&args.output)?;
    let size = match args.size {
        Some(size) => picture_size(args.to, size),
        None => args.to.size(4 * args.face as usize),
    };
    args.to.check(size.0, size.1)?;
    let files = match args.allow_outside {
        true => scene::Files::Anywhere,
        false => scene::Files::Inside,
    };
    let mut scene = scene::load_with(&args.scene, files)?;
    hide(&mut scene, &args.hide)?;
    let (world, backend) = build(scene, args.backend, threads)?;
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let points: Vec<Light> = points(&args.point, world.origin()).collect();
    let sky = args.sky.load()?;
    let black = sky.light().is_black() && lamps.is_empty() && points.is_empty();
    if black && !args.common.quiet {
        tell("warning: nothing shines here, the map is black; give --sky or --point");
    }
    let direct = Direct {
        rays: args.rays,
        sky: sky.light().clone(),
        lights: &points,
        seed: args.seed,
        ..Direct::new(&surfaces, backend.as_ref(), &lamps)
    };
    let at = DVec3::from(args.at) - world.origin();
    let show = Show {
        unit: "texels",
        quiet: args.common.quiet,
    };
    let grid = args.samples as usize;
    let map = watch(show, &stop, |progress| {
        capture(&direct, at, args.to, size, grid, progress)
    });
    let map = match map {
        Err(Error::Cancelled) => return Ok(stop.outcome()),
        map => map?,
    };
    let normalisation = match args.point_source {
        PointForm::Radiance => "radiance",
        PointForm::Raw => "radiance, but point lights raw",
    };
    let map = add_points(map, &direct, at, args.point_source)?;
    let layout = MapLayout {
        projection: args.to,
        orientation: Orientation::Ambake,
        size,
    };
    let inputs = world.scene().inputs.iter().chain(args.sky.file());
    let inputs: Vec<_> = inputs.cloned().collect();
    let target = Target {
        path: &args.output,
        inputs: &inputs,
    };
    let written = write(&target, &[(None, map.image())], layout, normalisation)?;
    if args.common.json {
        say_json(&json!({
            "schema_version": 1, "scene": args.scene, "at": args.at, "projection": args.to.name(),
            "size": [size.0, size.1], "samples": args.samples, "rays": args.rays,
            "integral": map.integral(), "backend": backend.describe(), "files": written,
            "seconds": started.elapsed().as_secs_f64(),
        }))?;
    } else if !args.common.quiet {
        let names: Vec<_> = written.iter().map(|p| p.display().to_string()).collect();
        let seconds = started.elapsed().as_secs_f64();
        say(&format!("wrote {} in {seconds:.1} s\n", names.join(", ")))?;
    }
    Ok(Outcome::Done)
}

/// Takes objects out of the scene.
fn hide(scene: &mut Scene, names: &[String]) -> anyhow::Result<()> {
    for name in names {
        let before = scene.instances.len();
        scene.instances.retain(|object| object.name != *name);
        if scene.instances.len() == before {
            let objects = scene.instances.iter().take(10);
            let known: Vec<_> = objects.map(|object| object.name.as_str()).collect();
            bail!(
                "{}: there is no object `{name}`; its first ones are {}",
                scene.path.display(),
                known.join(", ")
            );
        }
    }
    Ok(())
}
