//! `ambake render --probe-ball` and `--mirror-ball`: what something white or shiny would look like at a place.

use super::args::Args;
use super::ball_args::Place;
use ::render::{Ball, Shows};
use ambake::Backend;
use ambake::{Bounces, Places, ProbeOptions, ProbeVolume, Probes};
use environment::{IlluminationMap, MapLayout, Orientation, convert_image};
use glam::DVec3;
use rays::World;
use std::path::Path;

/// Rays of the probe of a ball: its error is then far below what a screen shows.
const RAYS: u32 = 16_384;

/// A ball without a radius, as a share of the diagonal of the scene.
const SHARE: f64 = 1.0 / 40.0;

/// The balls that are asked for, in coordinates of the world.
///
/// # Errors
/// Their light cannot be gathered, or read.
pub fn balls(args: &Args, world: &World) -> anyhow::Result<Vec<Ball>> {
    let near = |place: [f64; 3]| DVec3::from(place) - world.origin();
    let ball = |place: &Place, shows| Ball {
        center: near(place.center),
        radius: place.radius.unwrap_or(SHARE * world.bounds().diagonal()),
        shows,
    };
    let white = args.balls.probe_ball.iter().zip(lights(args, world)?);
    let white = white.map(|(place, light)| ball(place, Shows::Light(light)));
    let shows = match &args.balls.reflection {
        None => Shows::Mirror,
        Some(path) => Shows::Map {
            map: reflection(path)?,
            room: args.balls.room.map(|room| room.map(near)),
        },
    };
    let mirrors = args.balls.mirror_ball.iter();
    Ok(white
        .chain(mirrors.map(|place| ball(place, shows.clone())))
        .collect())
}

/// The light of each white ball.
fn lights(args: &Args, world: &World) -> anyhow::Result<Vec<Vec<DVec3>>> {
    let asked = &args.balls.probe_ball;
    Ok(match &args.balls.probes {
        _ if asked.is_empty() => Vec::new(),
        Some(file) => {
            let volume = ProbeVolume::read(file)?;
            asked.iter().map(|ball| volume.light(ball.center)).collect()
        }
        None => gathered(args, world)?.report().lights().collect(),
    })
}

/// A map of surroundings in the axes of the scene.
fn reflection(path: &Path) -> anyhow::Result<IlluminationMap> {
    let file = environment::read(path)?;
    let from = file.layout(path, None, None)?;
    let to = MapLayout {
        orientation: Orientation::Ambake,
        ..from
    };
    let image = convert_image(&file.image, from, to)?;
    Ok(IlluminationMap::new(image, to.projection)?)
}

/// Probes at the balls, in the light of the picture: what surfaces reflect is in it where a bake shows it.
fn gathered(args: &Args, world: &World) -> anyhow::Result<Probes> {
    let centers = args.balls.probe_ball.iter().map(|ball| ball.center);
    let mut options = ProbeOptions::default();
    options.bake = args.bake.clone();
    options.sky = args.sky.as_ref().map(|sky| sky.load()).transpose()?;
    let own = args.shining.lights(DVec3::ZERO);
    options.lights = (!own.is_empty()).then_some(own);
    options.bounces = match args.bake {
        Some(_) => Bounces::Auto,
        None => Bounces::Off,
    };
    options.max_distance = args.max_distance.map(|distance| distance as f32);
    options.rays = RAYS;
    options.seed = args.common.seed;
    options.backend = args.backend.unwrap_or_else(Backend::best);
    let places = Places::At(centers.collect());
    // The scene of a bake's picture is the bake's own; its light is looked up in the scene that was baked.
    let scene = match args.bake {
        Some(_) => ambake::load_with(&args.scene, args.common.files())?,
        None => world.scene().clone().into(),
    };
    Ok(Probes::gather(&scene, &places, &options, &())?)
}
