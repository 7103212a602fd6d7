//! Frames shaded from reflection maps.

use super::args::Args;
use super::file::{Behind, Film};
use super::{file, options};
use crate::common::parsed;
use crate::outcome::{Outcome, say, say_json};
use crate::progress::watch;
use crate::stop::Stop;
use ::frames::{CameraPath, Error, Frame, Motion, Sequence, SurfaceType, TableSet};
use anyhow::Context;
use rays::{RayBackend, Surfaces, World};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Makes the frames and writes each as soon as it is done.
pub fn draw(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
    started: Instant,
) -> anyhow::Result<Outcome> {
    let tables = &args.tables;
    let (types, shadings) = options::surface_types(tables, world.scene())?;
    let maps = tables.maps.as_ref();
    let maps = maps.map(|[d, s]| [d.as_path(), s.as_path()]);
    let set = TableSet::read(
        &types,
        maps,
        [&tables.exponents, &tables.incidences],
        tables.environment.as_deref(),
    )?;
    let film = Film::of(args)?;
    let behind = Behind::of(args, args.view.size, &film)?;
    let mut sequence = sequence(args, world, &set, &types)?;
    if !matches!(behind, Behind::Own) {
        sequence.environment = None;
    }
    let sequence = sequence;
    let surfaces = Surfaces::new(world);
    let subject = options::subject(args, &surfaces, backend, &shadings);
    let numbered = tables.frames.is_some() || tables.path.is_some();
    let inputs = file::inputs(args, world, None);
    let mut shading = 0.0;
    let mut written = Vec::new();
    let ended = watch(options::show(args, "pixels"), stop, |progress| {
        for frame in sequence.frames(progress, |eye, toward| subject.hit(eye, toward)) {
            let mut frame = frame?;
            let alpha = std::mem::take(&mut frame.alpha);
            let matte = behind.compose(&mut frame.picture, &alpha);
            shading += frame.shading_seconds;
            let about = about(args, world, &sequence, &set, &frame).to_string();
            for path in &args.output {
                let path = match numbered {
                    true => numbered_name(path, frame.number),
                    false => path.clone(),
                };
                file::write(&path, &frame.picture, matte, &about, &inputs, &film)?;
                written.push(path);
            }
        }
        anyhow::Ok(())
    });
    if let Err(error) = ended {
        return match error.downcast_ref() {
            Some(Error::Render(::render::Error::Cancelled)) => Ok(stop.outcome()),
            _ => Err(error),
        };
    }
    let (frames, seconds) = (sequence.frames, started.elapsed().as_secs_f64());
    if args.common.json {
        say_json(&json!({
            "schema_version": 1, "files": written, "frames": frames, "backend": backend.describe(),
            "normalisation": set.normalisation, "seconds": seconds, "shading_seconds": shading,
        }))?;
    } else if !args.common.quiet {
        let last = written.last().map(|p| p.display().to_string());
        let milliseconds = 1e3 * shading / f64::from(frames);
        say(&format!(
            "{frames} frames to {} in {seconds:.1} s, {milliseconds:.2} ms of shading a frame\n",
            last.unwrap_or_default()
        ))?;
    }
    Ok(Outcome::Done)
}

/// The sequence of the arguments.
fn sequence<'a>(
    args: &Args,
    world: &World,
    set: &'a TableSet,
    types: &[SurfaceType],
) -> anyhow::Result<Sequence<'a>> {
    let tables = &args.tables;
    let weights = options::weights(tables)?;
    let mut shaders: Vec<_> = types
        .iter()
        .map(|surface| set.shader(*surface, weights.clone()))
        .collect();
    for shader in &mut shaders {
        shader.translucency = tables.translucency;
    }
    let framing = options::framing(&args.view, world);
    let axis = framing.up.try_normalize();
    let path = tables.path.as_deref();
    let path = path
        .map(|path| parsed(path, CameraPath::parse))
        .transpose()?;
    let keys = path.as_ref().map(|path| path.keys() as u32);
    Ok(Sequence {
        frames: tables.frames.or(keys).unwrap_or(1),
        motion: match path {
            None => Motion::Still(framing.camera(world)?),
            Some(path) => Motion::Path(path.counted_from(world.origin()), framing),
        },
        turn_deg: tables.turn_deg.unwrap_or(0.0),
        about: [
            world.bounds().center(),
            axis.context("--up 0,0,0 is no direction")?,
        ],
        samples: args.view.samples,
        normals: tables.normals,
        shaders,
        lookup: tables.lookup,
        environment: set.environment.as_ref(),
    })
}

/// Everything that decides a frame, for its header.
fn about(
    args: &Args,
    world: &World,
    sequence: &Sequence<'_>,
    set: &TableSet,
    frame: &Frame,
) -> Value {
    json!({
        "scene": world.scene().content_hash,
        "maps": args.tables.maps,
        "exponents": args.tables.exponents,
        "incidences": args.tables.incidences,
        "environment": args.tables.environment,
        "normalisation": set.normalisation,
        "lookup": sequence.lookup.name(),
        "samples": sequence.samples,
        "frame": frame.number,
        "turn_deg": frame.angle.to_degrees(),
        "eye": (frame.camera.eye + world.origin()).to_array(),
        "forward": frame.camera.forward.to_array(),
        "fov_deg": args.view.fov_deg(),
    })
}

/// `OUT.0007.exr` of `OUT.exr`.
fn numbered_name(path: &Path, frame: u32) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{frame:04}.{ending}"))
}
