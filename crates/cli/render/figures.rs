//! `ambake render --figure`: the figures of the papers.

use super::args::{Args, Figure};
use super::{file, options};
use crate::outcome::Outcome;
use crate::progress::watch;
use crate::stop::Stop;
use ::bench::figures::{fig1, fig1_csv, fig1_svg, fig3};
use ::frames::Balls;
use ::render::{Error, Lamps, Model};
use anyhow::{Context, bail};
use rays::{RayBackend, Surfaces, World};
use report::Output;
use serde_json::json;

/// The files of a figure: names and bytes.
type Files = Vec<(String, Vec<u8>)>;

/// Draws a figure into the one directory of the arguments.
pub fn draw(
    figure: Figure,
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
) -> anyhow::Result<Outcome> {
    let [dir] = args.output.as_slice() else {
        bail!("--figure takes one -o DIR");
    };
    let files = match figure {
        Figure::Fig1 => points(args, world, backend, stop),
        Figure::Fig3 => models(args, world, backend, stop),
        Figure::Balls => balls(args, world, backend, stop),
    };
    let files = match files {
        Ok(files) => files,
        Err(error) if matches!(error.downcast_ref(), Some(Error::Cancelled)) => {
            return Ok(stop.outcome());
        }
        Err(error) => return Err(error),
    };
    let mut output = Output::create(dir)?;
    output.protect(file::inputs(args, world, None));
    for (name, bytes) in files {
        output.stage_bytes(&name, &bytes)?;
    }
    output.publish()?;
    Ok(Outcome::Done)
}

/// The specular ambient term against view angle and exponent.
fn points(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
) -> anyhow::Result<Files> {
    let (surfaces, lamps) = (Surfaces::new(world), Lamps::of(world));
    let sky = options::sky(args)?;
    let mut direct = options::direct(args, Model::Phong, &sky, &surfaces, backend, &[], &lamps);
    let points = watch(options::show(args, "points"), stop, |progress| {
        fig1(&mut direct, progress)
    })?;
    let svg = fig1_svg(&points).map_err(|problem| anyhow::anyhow!("fig1.svg: {problem}"))?;
    Ok(vec![
        ("fig1.csv".into(), fig1_csv(&points).into_bytes()),
        ("fig1.svg".into(), svg.into_bytes()),
    ])
}

/// The scene by the three models, and their differences.
fn models(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
) -> anyhow::Result<Files> {
    let (surfaces, lamps) = (Surfaces::new(world), Lamps::of(world));
    let sky = options::sky(args)?;
    let mut direct = options::direct(args, Model::Phong, &sky, &surfaces, backend, &[], &lamps);
    let camera = options::framing(&args.view, world).camera(world)?;
    let figure = watch(options::show(args, "pixels"), stop, |progress| {
        fig3(&mut direct, &camera, args.view.samples, progress)
    })?;
    let about = json!({
        "scene": world.scene().content_hash,
        "rays": args.rays,
        "samples": args.view.samples,
        "eye": (camera.eye + world.origin()).to_array(),
        "forward": camera.forward.to_array(),
        "fov_deg": args.view.fov_deg(),
        "sky": sky,
        "seed": args.common.seed,
    });
    Ok(figure.files(&file::labels(&about.to_string()))?)
}

/// A body in six materials.
fn balls(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
) -> anyhow::Result<Files> {
    let surfaces = Surfaces::new(world);
    let subject = options::subject(args, &surfaces, backend, &[]);
    let path = args.tables.environment.as_deref();
    let path = path.context("--figure balls needs --environment")?;
    let balls = Balls::of(&maps::read_polar(path)?.map)?;
    let mut camera = options::framing(&args.view, world).camera(world)?;
    camera.size = Balls::picture_size(camera.size);
    let lookup = args.tables.lookup;
    let sheet = watch(options::show(args, "pixels"), stop, |progress| {
        balls.sheet(
            &camera,
            args.view.samples,
            lookup,
            progress,
            |eye, toward| subject.hit(eye, toward),
        )
    })?;
    let about = json!({
        "scene": world.scene().content_hash,
        "environment": path,
        "materials": Balls::NAMES,
        "lookup": lookup.name(),
    });
    let labels = file::labels(&about.to_string());
    let exr = environment::encode(&sheet, environment::Format::Exr, &labels)?;
    let png = report::picture_png(sheet.width, &sheet.pixels);
    Ok(vec![("balls.exr".into(), exr), ("balls.png".into(), png)])
}
