//! `ambake map capture`: the illumination map of a place in a scene.

use crate::args::{self, Backend};
use crate::bake::options;
use crate::map::args::{Common, projection};
use crate::map::file::{picture_size, write};
use crate::render::run::lights;
use crate::{host, say};
use ::render::{Direct, Lamps, Light, Model, PointForm, add_points, capture};
use anyhow::bail;
use clap::{Args as ClapArgs, ValueEnum};
use glam::DVec3;
use maps::{Format, Layout, Orientation, Projection};
use rays::{Overrides, Surfaces, World, WorldOptions};
use scene::Scene;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    /// The place, in scene units: the middle of the object that will be shaded
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple)]
    pub at: [f64; 3],
    /// Map to write: .hdr or .exr; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Width and height of OUT in texels; of one face for a cube [default: by --face]
    #[arg(long, value_name = "WxH", conflicts_with = "face", value_parser = args::size)]
    pub size: Option<[u32; 2]>,
    /// Edge of each of the six pictures of a cube in texels; other projections get as many on the equator
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub face: u32,
    /// Camera rays of a texel: a regular grid of K x K
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: u32,
    /// Rays of every camera ray over the hemisphere where it ends, and as many toward shining surfaces
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=65_536))]
    pub rays: u32,
    /// Uniform sky radiance, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", default_value = "1,1,1", value_parser = args::color)]
    pub sky: [f32; 3],
    /// Point light at X,Y,Z with intensity E (W/sr: E over distance² arrives); may be repeated
    #[arg(long, value_name = "X,Y,Z,E", allow_hyphen_values = true, value_parser = args::light)]
    pub point: Vec<[f64; 4]>,
    /// What a point light adds to the map
    #[arg(long, value_enum, default_value_t = PointSource::Radiance)]
    pub point_source: PointSource,
    /// Leave out the object of this name, the one that will be shaded; may be repeated
    #[arg(long, value_name = "OBJECT")]
    pub hide: Vec<String>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    /// Seed of the sample points
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum PointSource {
    /// E over distance² over the texel's solid angle: what it lights does not depend on the size of the map
    Radiance,
    /// E over distance², as the 1984 text says
    Raw,
}

/// Runs the sub-verb.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let started = Instant::now();
    let threads = host::set_threads(args.common.threads)?;
    Format::of(&args.output)?;
    let size = match args.size {
        Some(size) => picture_size(args.to, size),
        None => args.to.size(4 * args.face as usize),
    };
    args.to.check(size.0, size.1)?;
    let mut scene = scene::load(&args.scene)?;
    hide(&mut scene, &args.hide)?;
    let rules = WorldOptions {
        instancing: true,
        filter_all: false,
    };
    let world = World::new(Arc::new(scene), rules)?;
    let backend = rays::build(options::backend_kind(args.backend), &world, threads)?;
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let points: Vec<Light> = lights(&[], &args.point);
    let sky = glam::Vec3::from(args.sky).as_dvec3();
    if sky == DVec3::ZERO && lamps.is_empty() && points.is_empty() {
        eprintln!("ambake: warning: nothing shines here, the map is black; give --sky or --point");
    }
    let direct = Direct {
        surfaces: &surfaces,
        backend: backend.as_ref(),
        model: Model::Lambert,
        rays: args.rays,
        sky,
        background: sky,
        lights: &points,
        max_distance: f32::INFINITY,
        overrides: Overrides::default(),
        seed: args.seed,
        lamps: &lamps,
    };
    let at = DVec3::from(args.at);
    let map = capture(&direct, at, args.to, size, args.samples as usize)?;
    let (form, normalisation) = match args.point_source {
        PointSource::Radiance => (PointForm::Radiance, "radiance"),
        PointSource::Raw => (PointForm::Raw, "radiance, but point lights raw"),
    };
    let map = add_points(map, &direct, at, form)?;
    let layout = Layout {
        projection: args.to,
        orientation: Orientation::Ambake,
        size,
    };
    let written = write(&args.output, &[(None, map.image())], layout, normalisation)?;
    if args.common.json {
        let json = json!({
            "schema_version": 1, "scene": args.scene, "at": args.at, "projection": args.to.name(),
            "size": [size.0, size.1], "samples": args.samples, "rays": args.rays,
            "integral": map.integral(), "backend": backend.describe(), "files": written,
            "seconds": started.elapsed().as_secs_f64(),
        });
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
    }
    if args.common.quiet {
        return Ok(());
    }
    let names: Vec<_> = written.iter().map(|p| p.display().to_string()).collect();
    let seconds = started.elapsed().as_secs_f64();
    say(&format!("wrote {} in {seconds:.1} s\n", names.join(", ")))
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
