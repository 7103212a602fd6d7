//! `ambake render --probe-ball` and `--mirror-ball`: what something white or shiny would look like at a place.

use super::args::Args;
use crate::common::Backend;
use crate::parse::number;
use crate::probes::args::corners;
use ::render::{Ball, Shows};
use ambake::{Bounces, Places, ProbeOptions, ProbeVolume, Probes};
use clap::Args as ClapArgs;
use glam::DVec3;
use maps::{IlluminationMap, Layout, Orientation, convert_image};
use rays::World;
use std::path::{Path, PathBuf};

/// Balls in the picture.
#[derive(ClapArgs)]
pub struct Balls {
    /// White ball in the light of the place X,Y,Z of this radius, by the nine harmonics of a probe that is gathered
    /// there; several are separated by semicolons. With --bake its light is that of the bake. It casts no shadow
    /// [default radius: a fortieth of the scene]
    #[arg(long, value_name = "X,Y,Z[,RADIUS];..", value_delimiter = ';', allow_hyphen_values = true, value_parser = ball,
          conflicts_with_all = ["figure", "shading", "encode"])]
    pub probe_ball: Vec<Place>,
    /// Light the balls by the volume in this STEM.probes.json, as engines do: linearly between the probes around
    #[arg(long, value_name = "FILE", requires = "probe_ball")]
    pub probes: Option<PathBuf>,
    /// Mirror ball at X,Y,Z of this radius, along whose rays the scene is seen; as --probe-ball
    #[arg(long, value_name = "X,Y,Z[,RADIUS];..", value_delimiter = ';', allow_hyphen_values = true, value_parser = ball,
          conflicts_with_all = ["figure", "shading", "encode"])]
    pub mirror_ball: Vec<Place>,
    /// Let mirror balls show this map of their surroundings, as engines do: a picture that `ambake probes
    /// --reflections` wrote, .exr or .hdr
    #[arg(long, value_name = "FILE", requires = "mirror_ball")]
    pub reflection: Option<PathBuf>,
    /// The map is as far away as the walls of this box, by two corners: the `room` of the reflection [default:
    /// endlessly far]
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", requires = "reflection", allow_hyphen_values = true, value_parser = corners)]
    pub room: Option<[[f64; 3]; 2]>,
}

/// A ball as it was typed.
#[derive(Clone, Copy)]
pub struct Place {
    center: [f64; 3],
    radius: Option<f64>,
}

fn ball(text: &str) -> Result<Place, String> {
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let (center, radius) = match *numbers.as_slice() {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, radius] if radius > 0.0 => ([x, y, z], Some(radius)),
        [_, _, _, radius] => return Err(format!("the radius {radius} must be above 0")),
        _ => return Err("expected X,Y,Z or X,Y,Z,RADIUS".into()),
    };
    Ok(Place { center, radius })
}

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
    let white = args.balls.probe_ball.iter().zip(lights(args)?);
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
fn lights(args: &Args) -> anyhow::Result<Vec<Vec<DVec3>>> {
    let asked = &args.balls.probe_ball;
    Ok(match &args.balls.probes {
        _ if asked.is_empty() => Vec::new(),
        Some(file) => {
            let volume = ProbeVolume::read(file)?;
            asked.iter().map(|ball| volume.light(ball.center)).collect()
        }
        None => gathered(args)?.report().lights().collect(),
    })
}

/// A map of surroundings in the axes of the scene.
fn reflection(path: &Path) -> anyhow::Result<IlluminationMap> {
    let file = maps::read(path)?;
    let from = file.layout(path, None, None)?;
    let to = Layout {
        orientation: Orientation::Ambake,
        ..from
    };
    let image = convert_image(&file.image, from, to)?;
    Ok(IlluminationMap::new(image, to.projection)?)
}

/// Probes at the balls, in the light of the picture: what surfaces reflect is in it where a bake shows it.
fn gathered(args: &Args) -> anyhow::Result<Probes> {
    let scene = ambake::load_with(&args.scene, args.common.files())?;
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
    options.backend = Backend::chosen(args.backend);
    let places = Places::At(centers.collect());
    Ok(Probes::gather(&scene, &places, &options, &())?)
}
