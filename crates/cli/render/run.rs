//! `ambake render`: a picture through a camera.

use crate::args::{self, Backend, Common};
use crate::bake::options;
use crate::render::figures::{self, Figure};
use crate::render::frames;
use crate::render::table_args::Tables;
use crate::{Outcome, host, say};
use ::render::{Camera, Direct, Lamps, Light, Lightmap, Model, Sample, picture};
use anyhow::{Context, bail};
use clap::{Args as ClapArgs, ValueEnum};
use glam::DVec3;
use maps::{Format, Image, Labels};
use rays::{Overrides, RayBackend, Surfaces, World, WorldOptions};
use report::Output;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    /// Picture to write: .exr (linear, float) or .png (sRGB); give it twice for both. With --figure a directory
    #[arg(short = 'o', long = "output", value_name = "IMAGE", required = true)]
    pub output: Vec<PathBuf>,
    /// Draw a figure instead: `fig1` on an open scene such as scenes/plane.obj with `--rays` for each point, `fig3` on any
    /// scene, `balls` on a body such as scenes/ball.obj
    #[arg(
        long,
        value_enum,
        conflicts_with = "bake",
        group = "lit",
        requires_if("balls", "environment")
    )]
    pub figure: Option<Figure>,
    #[command(flatten)]
    pub tables: Tables,
    #[command(flatten)]
    pub view: View,
    /// Ambient model
    #[arg(long, value_enum, default_value_t = ModelName::Phong)]
    pub model: ModelName,
    /// Rays over the hemisphere of every camera sample, and as many over a specular lobe; 0 leaves ambient light out
    #[arg(long, value_name = "N", default_value_t = 64, conflicts_with = "bake", value_parser = clap::value_parser!(u32).range(0..=65_536))]
    pub rays: u32,
    /// Take the ambient model from the finished bake of SCENE in DIR instead; its Phong term is that of the view the bake
    /// was made for (`bake --view`), not of this camera
    #[arg(long, value_name = "DIR")]
    pub bake: Option<PathBuf>,
    /// Uniform sky radiance, linear, as R,G,B; also what is seen behind the scene
    #[arg(long, value_name = "R,G,B", default_value = "1,1,1", value_parser = args::color)]
    pub sky: [f32; 3],
    /// Another radiance behind the scene, linear, as R,G,B [default: the sky's]
    #[arg(long, value_name = "R,G,B", value_parser = args::color)]
    pub background: Option<[f32; 3]>,
    /// Distant light in the direction X,Y,Z with irradiance E (W/m², facing); may be repeated
    #[arg(long, value_name = "X,Y,Z,E", allow_hyphen_values = true, value_parser = args::sun)]
    pub sun: Vec<[f64; 4]>,
    /// Point light at X,Y,Z with intensity E (W/sr: E over distance² arrives); may be repeated
    #[arg(long, value_name = "X,Y,Z,E", allow_hyphen_values = true, value_parser = args::light)]
    pub point: Vec<[f64; 4]>,
    /// Occluders farther than this many scene units do not count [default: no limit]
    #[arg(long, value_name = "D", value_parser = args::positive)]
    pub max_distance: Option<f64>,
    /// Lobe exponent of every material, 0 to 1e6
    #[arg(long, value_name = "N", value_parser = args::exponent)]
    pub exponent: Option<f64>,
    /// Diffuse reflectance of every material, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", value_parser = args::color)]
    pub albedo: Option<[f32; 3]>,
    /// Specular reflectance of every material, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", value_parser = args::color)]
    pub specular: Option<[f32; 3]>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    #[command(flatten)]
    pub common: Common,
}

/// Where the picture is taken from.
#[derive(ClapArgs)]
pub struct View {
    /// Eye point in scene units [default: in front, above and to the right of the whole scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple)]
    pub eye: Option<[f64; 3]>,
    /// Point that is looked at, in scene units [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple)]
    pub look: Option<[f64; 3]>,
    /// Direction that is upward in the picture
    #[arg(long, value_name = "X,Y,Z", default_value = "0,1,0", allow_hyphen_values = true, value_parser = args::triple)]
    pub up: [f64; 3],
    /// Vertical field of view in degrees, above 0 and below 180
    #[arg(long, value_name = "F", default_value = "40", value_parser = args::field_of_view)]
    pub fov_deg: f64,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = args::size)]
    pub size: [u32; 2],
    /// Camera samples of a pixel: a regular grid of N x N
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: u32,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelName {
    /// Constant times the open share of the hemisphere
    Traditional,
    /// The Lambertian ambient term
    Lambert,
    /// Lambertian and specular terms
    Phong,
}

impl ModelName {
    fn model(self) -> Model {
        match self {
            ModelName::Traditional => Model::Traditional,
            ModelName::Lambert => Model::Lambert,
            ModelName::Phong => Model::Phong,
        }
    }
}

impl View {
    /// The camera, framing what the arguments leave open.
    pub fn camera(&self, world: &World) -> anyhow::Result<Camera> {
        let fov = self.fov_deg.to_radians();
        let (up, size) = (DVec3::from(self.up), self.size);
        let middle = world.bounds().center();
        let corners = (0..world.scene().instances.len() as u32).flat_map(|instance| {
            let triangles = world.part(instance).1.triangles().len() as u32;
            (0..triangles).flat_map(move |triangle| world.corners(instance, triangle))
        });
        let eye = match self.eye {
            Some(eye) => eye.into(),
            None => Camera::framing(corners, middle, up, fov, size),
        };
        let look = self.look.map_or(middle, DVec3::from);
        Ok(Camera::new(eye, look, up, fov, size)?)
    }
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let threads = host::set_threads(args.common.threads)?;
    if args.figure.is_none() {
        for path in &args.output {
            ending(path)?;
        }
    }
    let (scene, lightmap) = match &args.bake {
        None => (scene::load(&args.scene)?, None),
        Some(dir) => {
            let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy();
            let (scene, map) = Lightmap::load(dir, &stem, args.model.model().name())?;
            (scene, Some(map))
        }
    };
    let world = World::new(
        Arc::new(scene),
        WorldOptions {
            instancing: true,
            filter_all: false,
        },
    )?;
    let backend = rays::build(options::backend_kind(args.backend), &world, threads)?;
    if let Some(figure) = args.figure {
        return figures::draw(figure, args, &world, backend.as_ref());
    }
    if args.tables.asked() {
        return frames::run(args, &world, backend.as_ref(), started);
    }
    let camera = args.view.camera(&world)?;
    let picture = take(args, &world, backend.as_ref(), lightmap.as_ref(), &camera);
    let described = json!({
        "scene": world.scene().content_hash,
        "model": args.model.model().name(),
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
    for path in &args.output {
        write(path, &picture, &described.to_string())?;
    }
    if args.common.json {
        let summary = json!({
            "schema_version": 1,
            "width": picture.width,
            "height": picture.height,
            "options": described,
            "backend": backend.describe(),
            "seconds": started.elapsed().as_secs_f64(),
        });
        say(&format!("{}\n", serde_json::to_string_pretty(&summary)?))?;
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

/// The picture of the arguments.
fn take(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    lightmap: Option<&Lightmap>,
    camera: &Camera,
) -> Image {
    let surfaces = Surfaces::new(world);
    let lights = lights(&args.sun, &args.point);
    let lamps = Lamps::of(world);
    let direct = shader(args, &surfaces, backend, &lights, &lamps);
    picture(
        camera,
        args.view.samples,
        |sample: &Sample| match lightmap {
            None => direct.radiance(sample),
            Some(map) => direct.radiance_baked(sample, map),
        },
    )
}

/// What shades the rays.
pub fn shader<'a>(
    args: &Args,
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
    lights: &'a [Light],
    lamps: &'a Lamps,
) -> Direct<'a> {
    let rgb = |rgb: [f32; 3]| glam::Vec3::from(rgb).as_dvec3();
    Direct {
        surfaces,
        backend,
        model: args.model.model(),
        rays: args.rays,
        sky: rgb(args.sky),
        background: rgb(args.background.unwrap_or(args.sky)),
        lights,
        max_distance: args.max_distance.map_or(f32::INFINITY, |d| d as f32),
        seed: args.common.seed,
        overrides: Overrides {
            albedo: args.albedo,
            specular: args.specular,
            exponent: args.exponent,
        },
        lamps,
    }
}

/// The lights of `--sun` and `--point`.
pub fn lights(suns: &[[f64; 4]], points: &[[f64; 4]]) -> Vec<Light> {
    let sun = suns.iter().map(|&[x, y, z, irradiance]| Light::Distant {
        toward: DVec3::new(x, y, z).normalize(),
        irradiance,
    });
    let point = points.iter().map(|&[x, y, z, intensity]| Light::Point {
        position: DVec3::new(x, y, z),
        intensity,
    });
    sun.chain(point).collect()
}

/// What a picture's name asks for.
fn ending(path: &Path) -> anyhow::Result<&'static str> {
    let ending = path.extension().map(|e| e.to_ascii_lowercase());
    match ending.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => Ok("exr"),
        Some("png") => Ok("png"),
        _ => bail!("{}: a picture's name ends in .exr or .png", path.display()),
    }
}

/// Writes a picture, or nothing under its name.
pub fn write(path: &Path, picture: &Image, about: &str) -> anyhow::Result<()> {
    let dir = match path.parent() {
        Some(dir) if dir != Path::new("") => dir,
        _ => Path::new("."),
    };
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not a file name", path.display()))?;
    let mut output = Output::create(dir)?;
    if ending(path)? == "exr" {
        let labels = Labels::from([
            ("ambakeVersion".into(), host::VERSION.into()),
            ("ambakeOptions".into(), about.into()),
        ]);
        output.stage_bytes(name, &maps::encode(picture, Format::Exr, &labels)?)?;
    } else {
        output.stage_bytes(name, &report::picture_png(picture.width, &picture.pixels))?;
    }
    output.publish()?;
    Ok(())
}
