//! What was typed: the command line as clap sees it. `options.rs` says what it means.

use ::bake::Choice;
use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use layers::Layer;
use std::path::PathBuf;

/// Ambient-reflection lightmap baker that states its error.
#[derive(Parser)]
#[command(name = "ambake", version = crate::host::VERSION, max_term_width = 100)]
pub struct Args {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand)]
pub enum Verb {
    /// Bakes a scene: lightmap atlas, previews, glTF and bake.json
    Bake(Bake),
    /// Says what a bake of this scene would model and why, and what it would cost
    Plan(Plan),
    /// Traditional against Lambert against Phong from a finished bake, or any two EXR pages
    Compare(Compare),
    /// A picture of a scene through a camera, shaded by an ambient model and lights
    Render(Box<crate::render::run::Args>),
    /// Illumination maps and reflection maps: convert, convolve, measure
    #[command(subcommand)]
    Map(Box<crate::map::args::Args>),
    /// Speed against error: CSV, SVG and a readable summary
    Bench(Bench),
    /// Tells which ray libraries were really loaded and what they can do; exit 1 if one is unusable
    Doctor(Doctor),
}

#[derive(ClapArgs)]
pub struct Bake {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    #[command(flatten)]
    pub job: Job,
    /// Directory for the results; it is made if needed
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
    /// Continue an interrupted bake of the same scene and options in DIR
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Plan {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub common: Common,
}

/// What decides the values of a bake.
#[derive(ClapArgs)]
pub struct Job {
    /// Page edge in texels
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub size: u32,
    /// Texels per scene unit; pages are added as needed [default: the highest that fits one page]
    #[arg(long, value_name = "D", value_parser = positive)]
    pub density: Option<f64>,
    /// Rays per texel over the hemisphere; the specular lobe takes as many again where a material needs it
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub rays: u32,
    /// Stop a texel when its standard error is at most E, instead of a fixed number of rays
    #[arg(long, value_name = "E", value_parser = target_error, conflicts_with = "rays")]
    pub target_error: Option<f64>,
    /// With --target-error: the most rays that a texel may take, over the hemisphere and again over the lobe
    #[arg(long, value_name = "N", default_value_t = 16_384, requires = "target_error", value_parser = clap::value_parser!(u32).range(16..=16_777_216))]
    pub max_rays: u32,
    /// Whether blocks of 4 x 4 texels share their directions: a little faster, but errors show as blocks
    #[arg(long, value_enum, default_value_t = Pattern::Independent)]
    pub pattern: Pattern,
    /// Local regression over the texels of a surface, which falls back to the plain value where it does not help: fewer rays
    /// for the same error, at a small bias that the error layer includes
    #[arg(long, value_enum, alias = "filter", default_value_t = Denoise::Off)]
    pub denoise: Denoise,
    /// Sky radiance, linear: R,G,B for a uniform sky, or an illumination map (.hdr, .exr; polar unless its header says otherwise),
    /// from whose light as many rays again are drawn
    #[arg(long, value_name = "R,G,B|FILE", default_value = "1,1,1", value_parser = crate::bake::sky::sky)]
    pub sky: crate::bake::sky::SkyArg,
    /// View of the specular term: `normal` (V = N everywhere) or an eye point X,Y,Z in scene units
    #[arg(long, value_name = "normal|X,Y,Z", default_value = "normal", allow_hyphen_values = true, value_parser = view)]
    pub view: ::bake::View,
    /// Occluders farther than this many scene units do not count [default: no limit]
    #[arg(long, value_name = "D", value_parser = positive)]
    pub max_distance: Option<f64>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    /// Lightmap coordinates: keep the file's, unwrap, or keep them where they are usable
    #[arg(long, value_enum, default_value_t = Uv::Auto)]
    pub uv: Uv,
    /// Further layers, separated by commas: position, normal, geometric, bent, exponent, object, validity, difference.lambert,
    /// difference.phong, error.visibility, error.specular, albedo, reflectance
    #[arg(long, value_name = "A,B,C", value_delimiter = ',', value_parser = layer)]
    pub layers: Vec<Layer>,
    /// Exactly these layers (coverage is always written); terms that none of them needs are not computed
    #[arg(long, value_name = "A,B,C", value_delimiter = ',', value_parser = layer, conflicts_with = "layers")]
    pub only: Vec<Layer>,
    /// Lobe exponent of every material, 0 to 1e6
    #[arg(long, value_name = "N", value_parser = exponent)]
    pub exponent: Option<f64>,
    /// Diffuse reflectance of every material, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", value_parser = color)]
    pub albedo: Option<[f32; 3]>,
    /// Specular reflectance of every material, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", value_parser = color)]
    pub specular: Option<[f32; 3]>,
    /// Planner choices to switch off: sky, diffuse, visibility, specular, open, instances, filter
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = choice)]
    pub plan_off: Vec<Choice>,
}

#[derive(ClapArgs)]
pub struct Compare {
    /// A finished bake's directory, or two EXR pages
    #[arg(num_args = 1..=2, required = true, value_name = "DIR | A.exr B.exr")]
    pub paths: Vec<PathBuf>,
    /// Directory for the difference pictures [default: the bake's directory; with two pages, none are written]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

#[derive(ClapArgs)]
pub struct Bench {
    /// Scene file: .obj, .gltf or .glb
    #[arg(required_unless_present_any = ["samplers", "hard", "maps", "tables"])]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub job: Job,
    /// Directory for bench.csv, bench.svg and bench.md; it is made if needed
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present_any = ["samplers", "ceiling", "hard"])]
    pub output: Option<PathBuf>,
    /// Only the ratio of a bake to the bare loop of rtcOccluded16 over its packets
    #[arg(long, conflicts_with = "samplers")]
    pub ceiling: bool,
    /// Only the error of the point sets on four exact scenes
    #[arg(long)]
    pub samplers: bool,
    /// Only the cases that break bakers, on every backend: a Markdown table; exit 1 if one fails
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling"])]
    pub hard: bool,
    /// Only the convolution of maps against the plain double sum: maps.csv and maps.md in DIR
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling", "hard"])]
    pub maps: bool,
    /// Only shading from reflection maps: error and flicker of each look-up, frames a second; tables.csv, tables_speed.csv and
    /// tables.md in DIR
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling", "hard", "maps"])]
    pub tables: bool,
    /// Repeats of every measurement
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeats: u32,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Doctor {
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(ClapArgs)]
pub struct Common {
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Seed of the sample points
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
    /// Also print the plan and the time of each phase
    #[arg(short = 'v', long)]
    pub verbose: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Debian's Embree
    Embree,
    /// Pure Rust: obvhs, 8-wide compressed BVH
    Obvhs,
    /// Pure Rust: obvhs, binary BVH
    ObvhsBvh2,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Pattern {
    /// Every texel has its own directions
    Independent,
    /// Blocks of 4 x 4 texels share theirs
    Tiled,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Denoise {
    Off,
    Regression,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Uv {
    Auto,
    Keep,
    Unwrap,
}

pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a finite number")),
    }
}

pub fn positive(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && (value as f32).is_finite() && value as f32 > 0.0 => Ok(value),
        _ => Err("must be above 0".into()),
    }
}

fn target_error(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("must be above 0 and below 1".into()),
    }
}

pub fn exponent(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if (0.0..=1e6).contains(&value) => Ok(value),
        _ => Err("must be between 0 and 1e6".into()),
    }
}

pub fn triple(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    match parts.as_slice() {
        [a, b, c] => Ok([number(a)?, number(b)?, number(c)?]),
        _ => Err("expected three numbers separated by commas".into()),
    }
}

pub fn color(text: &str) -> Result<[f32; 3], String> {
    let values = triple(text)?.map(|v| v as f32);
    if values.iter().all(|v| v.is_finite() && *v >= 0.0) {
        Ok(values)
    } else {
        Err("each must be 0 or above".into())
    }
}

pub fn light(text: &str) -> Result<[f64; 4], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, z, e] = parts.as_slice() else {
        return Err("expected four numbers separated by commas".into());
    };
    let values = [number(x)?, number(y)?, number(z)?, number(e)?];
    match values {
        [.., e] if e < 0.0 => Err("the last must be 0 or above".into()),
        _ => Ok(values),
    }
}

/// [`light`] whose place is a direction.
pub fn sun(text: &str) -> Result<[f64; 4], String> {
    let values = light(text)?;
    match values {
        [0.0, 0.0, 0.0, _] => Err("0,0,0 is no direction".into()),
        _ => Ok(values),
    }
}

pub fn field_of_view(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && value < 180.0 => Ok(value),
        _ => Err("must be above 0 and below 180".into()),
    }
}

pub fn size(text: &str) -> Result<[u32; 2], String> {
    let edge = |text: &str| match text.trim().parse::<u32>() {
        Ok(edge) if (1..=16_384).contains(&edge) => Ok(edge),
        _ => Err(format!("`{text}` is not a number between 1 and 16384")),
    };
    match text.split_once('x') {
        Some((width, height)) => Ok([edge(width)?, edge(height)?]),
        None => Err("expected WIDTHxHEIGHT, such as 960x540".into()),
    }
}

fn view(text: &str) -> Result<::bake::View, String> {
    if text == "normal" {
        return Ok(::bake::View::Normal);
    }
    triple(text)
        .map(|eye| ::bake::View::Eye(eye.into()))
        .map_err(|e| format!("expected `normal` or X,Y,Z: {e}"))
}

fn layer(text: &str) -> Result<Layer, String> {
    Layer::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Layer::all().map(Layer::name).collect();
        format!("unknown layer; there are {}", names.join(", "))
    })
}

fn choice(text: &str) -> Result<Choice, String> {
    Choice::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Choice::ALL.iter().map(|choice| choice.name()).collect();
        format!("unknown choice; there are {}", names.join(", "))
    })
}
