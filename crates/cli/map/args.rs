//! What was typed after `ambake map`.

use ambake::Backend;
use ambake::flags::parse::{field_of_view, light, number, size, triple, whole};
use ambake::flags::sky::{SkyArg, sky};
use ambake::flags::values::{named, word};
use clap::{Args as ClapArgs, Subcommand, ValueEnum};
use environment::{Orientation, Projection};
use maps::Normalise;
use maps::ball::Circle;
use maps::merge::Model;
use render::PointForm;
use std::path::PathBuf;

#[derive(Subcommand)]
pub enum Args {
    /// Any projection to any, with every texel's energy kept
    Convert(Convert),
    /// Mean, maximum, integral over the sphere, non-finite count
    Stats(Stats),
    /// The diffuse reflection map D
    Diffuse(Diffuse),
    /// The specular reflection map S
    Specular(Specular),
    /// Photographs of a mirrored ball to a map
    Ball(Ball),
    /// Six photographs along the axes to a map without seams
    Mosaic(Mosaic),
    /// Exposure brackets to one picture of radiance
    Merge(Merge),
    /// The light that arrives at a place in a scene
    ///
    /// Surfaces that shine (Ke, emissiveFactor) are seen as they are. Others are secondary sources: the light that
    /// reaches them straight from the sky, from shining surfaces and from point lights, reflected once by Lambert's
    /// law.
    Capture(Capture),
}

/// The picture that is read.
#[derive(ClapArgs)]
pub struct Input {
    /// Picture: .hdr, .exr, or .png and .jpg taken as sRGB; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Projection of IN: polar, cube, cross, strip, ortho, ball, angular, octahedral [default: its header's, else
    /// polar]
    #[arg(long, value_name = "PROJECTION", value_parser = projection)]
    pub from: Option<Projection>,
    /// Whose axes IN has: ambake, gltf, three.js, blender, filament, openexr [default: its header's, else ambake]
    #[arg(long, value_name = "TOOL", value_parser = orientation)]
    pub from_orientation: Option<Orientation>,
}

#[derive(ClapArgs)]
pub struct Common {
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1024))]
    pub threads: Option<u32>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(ClapArgs)]
pub struct Convert {
    #[command(flatten)]
    pub input: Input,
    /// Picture to write: .hdr or .exr; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", value_parser = projection)]
    pub to: Projection,
    /// Whose axes OUT has: ambake, gltf, three.js, blender, filament, openexr
    #[arg(long, value_name = "TOOL", default_value = "ambake", value_parser = orientation)]
    pub orientation: Orientation,
    /// Width and height of OUT in texels; of one face for a cube [default: as many texels on the equator as IN]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Stats {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Diffuse {
    #[command(flatten)]
    pub input: Input,
    /// Picture to write: .hdr or .exr, in ambake's orientation
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Reflectance function
    #[arg(long, value_enum, default_value_t = DiffuseKernel::Lambert)]
    pub kernel: DiffuseKernel,
    /// Width and height of OUT in texels; of one face for a cube
    #[arg(long, value_name = "WxH", default_value = "72x36", value_parser = size)]
    pub size: [u32; 2],
    /// Projection of OUT
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Factor of the integral: 1/π (1/4π for luminous), or the 1984 text's 1/4π
    #[arg(long, default_value = "radiance", value_parser = word::<Normalise>())]
    pub normalise: Normalise,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Specular {
    #[command(flatten)]
    pub input: Input,
    /// Picture to write: .hdr or .exr, in ambake's orientation; with several exponents NAME.exr stands for NAME_N.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Lobe exponent, 0 to 1e5, or several separated by commas
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = number)]
    pub exponent: Vec<f64>,
    /// Roughness of the ggx kernel, 0.06 to 1, or several separated by commas; its α is roughness²
    #[arg(long, value_name = "R,..", value_delimiter = ',', value_parser = number)]
    pub roughness: Vec<f64>,
    /// Reflectance function
    #[arg(long, value_enum, default_value_t = SpecularKernel::Phong)]
    pub kernel: SpecularKernel,
    /// Table of the kernel `table`: lines of a cosine, ascending in -1..1, and a value of at least 0; after a first
    /// line `degrees,value` angles from the mirror direction, ascending in 0..180. Linear in the cosine between lines.
    /// Of the kernel `reflectance`: a first line `incidence,degrees,red,green,blue` or `incidence,degrees,value`, then
    /// lines of the view's incidence, the angle from the mirror direction, and BRDF times cosine per steradian
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Width and height of OUT in texels; of one face for a cube
    #[arg(long, value_name = "WxH", default_value = "512x256", value_parser = size)]
    pub size: [u32; 2],
    /// Projection of OUT
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Factor of the integral: one over the kernel's integral ((n+1)/2π for phong; 1 for reflectance), or the 1984
    /// text's 1/4π
    #[arg(long, default_value = "radiance", value_parser = word::<Normalise>())]
    pub normalise: Normalise,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Ball {
    /// Photographs of a mirrored ball: .hdr, .exr, or .png and .jpg taken as sRGB; two from directions 90 degrees apart
    /// hide each other's rim and camera best
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Map to write: .exr, with the channel `confidence`, or .hdr; for a cube NAME.exr stands for NAME_px.exr …
    /// NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Outline of the ball: its middle from the left and from the top, and its radius, in pixels; once for each IN
    /// [default: found by its edge]
    #[arg(long, value_name = "X,Y,R", allow_hyphen_values = true, value_parser = circle)]
    pub circle: Vec<Circle>,
    /// Distance of the camera from the middle of the ball, in radii of the ball; once, or once for each IN [default:
    /// far away, an orthographic picture]
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = number)]
    pub distance: Vec<f64>,
    /// Direction from the ball to the camera in ambake's axes, +y up; once for each IN [default for one IN: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub toward: Vec<[f64; 3]>,
    /// Reflectance of the ball, one number or R,G,B; it is divided out
    #[arg(long, value_name = "R,G,B", default_value = "1", value_parser = reflectance)]
    pub reflectance: [f64; 3],
    /// Film's curve, a file that `map merge --save-response` wrote: photographs are then .png or .jpg, and it takes the
    /// place of sRGB
    #[arg(long, value_name = "FILE")]
    pub response: Option<PathBuf>,
    /// What each photograph is multiplied by, channel by channel: found where two photographs see the same, or nothing
    #[arg(long, value_enum, default_value_t = GainsName::Off)]
    pub gains: GainsName,
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Width and height of OUT in texels; of one face for a cube [default: as fine as the middle of the largest ball]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Mosaic {
    /// NAME.exr for the square photographs NAME_px.exr, NAME_nx.exr … NAME_nz.exr, toward +x, -x and so on with the
    /// axes of a cube's faces; .hdr, .exr, or .png and .jpg taken as sRGB. A series of exposures of each goes through
    /// `map merge` first
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Map to write: .hdr or .exr; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// What a photograph spans from side to side, in degrees, from 90 below 180; what is more than 90 fades from
    /// photograph to photograph
    #[arg(long, value_name = "F", default_value = "90", value_parser = field_of_view)]
    pub fov_deg: f64,
    /// Film's curve, a file that `map merge --save-response` wrote: photographs are then .png or .jpg, and it takes the
    /// place of sRGB
    #[arg(long, value_name = "FILE")]
    pub response: Option<PathBuf>,
    /// What each photograph is multiplied by, channel by channel: found where two photographs show the same, or nothing
    #[arg(long, value_enum, default_value_t = GainsName::Auto)]
    pub gains: GainsName,
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Width and height of OUT in texels; of one face for a cube [default: as fine as the photographs]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Merge {
    /// Photographs of one view with different exposure times: .png of 8 or 16 bits, or .jpg
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Picture to write: .exr, with the channel `confidence`, or .hdr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Exposure time of each IN in seconds, separated by commas [default: EXIF's ExposureTime, times
    /// what FNumber and ISO add to it where the camera names them, in seconds of the first photograph's]
    #[arg(long, value_name = "T,..", value_delimiter = ',', allow_hyphen_values = true, value_parser = number)]
    pub times: Vec<f64>,
    /// Curve from recorded values to exposure: fitted to the brackets (debevec: least squares of log exposures;
    /// robertson: of exposures), or known (linear, srgb, or a file that --save-response wrote)
    #[arg(long, value_name = "debevec|robertson|linear|srgb|FILE", default_value = "debevec", value_parser = response)]
    pub response: Response,
    /// Write the curve to a file, for --response
    #[arg(long, value_name = "FILE")]
    pub save_response: Option<PathBuf>,
    /// Find and undo whole-pixel shifts between the photographs
    #[arg(long)]
    pub align: bool,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Capture {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    /// Read files that the scene names outside of its folder too, for a scene that you trust
    #[arg(long)]
    pub allow_outside: bool,
    /// The place, in scene units: the middle of the object that will be shaded
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub at: [f64; 3],
    /// Map to write: .hdr or .exr; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Width and height of OUT in texels; of one face for a cube [default: by --face]
    #[arg(long, value_name = "WxH", conflicts_with = "face", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Edge of each of the six pictures of a cube in texels; other projections get as many on the equator
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = whole::<u32>(1..=4096))]
    pub face: u32,
    /// Camera rays of a texel: a regular grid of K x K
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = whole::<u32>(1..=64))]
    pub samples: u32,
    /// Rays of every camera ray over the hemisphere where it ends, and as many toward shining surfaces
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = whole::<u32>(0..=65_536))]
    pub rays: u32,
    /// Sky radiance, linear: R,G,B for a uniform sky, or an illumination map (.hdr, .exr; polar unless its header says
    /// otherwise)
    #[arg(long, value_name = "R,G,B|FILE", default_value = "1,1,1", value_parser = sky)]
    pub sky: SkyArg,
    /// Point light at X,Y,Z with intensity E or R,G,B (W/sr: E over distance² arrives); may be repeated
    #[arg(long, value_name = "X,Y,Z,E|X,Y,Z,R,G,B", allow_hyphen_values = true, value_parser = light)]
    pub point: Vec<[f64; 6]>,
    /// What a point light adds to the map
    #[arg(long, default_value = "radiance", value_parser = word::<PointForm>())]
    pub point_source: PointForm,
    /// Leave out the object of this name, the one that will be shaded; may be repeated
    #[arg(long, value_name = "OBJECT")]
    pub hide: Vec<String>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(long, value_parser = word::<Backend>())]
    pub backend: Option<Backend>,
    /// Seed of the sample points
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: u64,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum GainsName {
    /// Found and undone
    Auto,
    /// Photographs stay as they are
    Off,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum DiffuseKernel {
    /// max(0, x)
    Lambert,
    /// 1 everywhere
    Luminous,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum SpecularKernel {
    /// max(0, x)ⁿ; --exponent
    Phong,
    /// The map itself
    Mirror,
    /// Phong under a clear coat that mirrors half; --exponent
    Varnish,
    /// GGX seen along the normal, as prefiltered maps of engines; --roughness
    Ggx,
    /// Linear between the lines of a file; --table
    Table,
    /// The lobes that a file has for each incidence and colour; --table. OUT stands for OUT_A.exr of each incidence A
    /// in degrees
    Reflectance,
}

#[derive(Clone)]
pub enum Response {
    /// Fitted, or one of the known curves.
    Model(Model),
    /// Curves in a file.
    File(PathBuf),
}

fn projection(text: &str) -> Result<Projection, String> {
    let found = Projection::from_name(text);
    named("projection", found, Projection::all().map(Projection::name))
}

fn response(text: &str) -> Result<Response, String> {
    Ok(match text {
        "debevec" => Response::Model(Model::Debevec),
        "robertson" => Response::Model(Model::Robertson),
        "linear" => Response::Model(Model::Linear),
        "srgb" => Response::Model(Model::Srgb),
        file if file.contains(['.', '/']) => Response::File(file.into()),
        _ => {
            return Err(
                "it is none of debevec, robertson, linear and srgb, nor a file with an ending"
                    .into(),
            );
        }
    })
}

fn orientation(text: &str) -> Result<Orientation, String> {
    let found = Orientation::from_name(text);
    named(
        "orientation",
        found,
        Orientation::all().map(Orientation::name),
    )
}

fn circle(text: &str) -> Result<Circle, String> {
    let [x, y, radius] = triple(text)?;
    Ok(Circle { x, y, radius })
}

fn reflectance(text: &str) -> Result<[f64; 3], String> {
    match text.contains(',') {
        true => triple(text),
        false => Ok([number(text)?; 3]),
    }
}
