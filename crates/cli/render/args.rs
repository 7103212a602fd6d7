//! What was typed after `ambake render`. `options.rs` says what it means.

use super::ball_args::Balls;
use super::tables_args::Tables;
use ::render::Model;
use ambake::Backend;
use ambake::flags::common::{Common, Shining};
use ambake::flags::parse::{color, exponent, field_of_view, number, positive, size, triple, whole};
use ambake::flags::sky::{SkyArg, sky};
use ambake::flags::values::word;
use clap::{Args as ClapArgs, ValueEnum};
use std::path::PathBuf;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    /// Picture to write: .exr (linear, float) or .png (sRGB); give it twice for both. With --figure a directory
    #[arg(help_heading = "Files")]
    #[arg(short = 'o', long = "output", value_name = "IMAGE", required = true)]
    pub output: Vec<PathBuf>,
    /// Draw a figure instead: `fig1` on an open scene such as scenes/plane.obj with `--rays` for each point, `fig3` on
    /// any scene, `balls` on a body such as scenes/ball.obj; needs a program built with `--features bench`
    #[arg(help_heading = "Files")]
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
    #[command(flatten)]
    pub matte: Matte,
    #[command(flatten)]
    pub balls: Balls,
    /// Film's curve, a file that `map merge --save-response` wrote: a .png holds what the film would record, in place
    /// of sRGB, and the photograph of --backdrop is read by it, so that a scene is laid over it in the photograph's own
    /// tones
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["figure", "alpha"])]
    pub response: Option<PathBuf>,
    /// Let normal maps of materials bend the shading normals
    #[arg(help_heading = "Surfaces")]
    #[arg(long)]
    pub normal_maps: bool,
    /// Ambient model [default: that of the bake; without one ggx for glTF and phong for OBJ]
    #[arg(help_heading = "Surfaces")]
    #[arg(long, value_parser = word::<Model>())]
    pub model: Option<Model>,
    /// Rays over the hemisphere of every camera sample, and as many over a specular lobe; 0 leaves ambient light out
    #[arg(help_heading = "Rays")]
    #[arg(long, value_name = "N", default_value_t = 64, conflicts_with = "bake")]
    #[arg(value_parser = whole::<u32>(0..=65_536))]
    pub rays: u32,
    /// Take the ambient model from the finished bake of SCENE in DIR instead; its Phong term is that of the view the
    /// bake was made for (`bake --view`), not of this camera
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "DIR")]
    pub bake: Option<PathBuf>,
    /// Sky radiance, linear: R,G,B for a uniform sky, or an illumination map (.hdr, .exr; polar unless its header says
    /// otherwise), toward whose light as many rays again are cast; also what is seen behind the scene [default: 1,1,1;
    /// with --bake the mean of the bake's sky]
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "R,G,B|FILE", value_parser = sky)]
    pub sky: Option<SkyArg>,
    /// Another radiance behind the scene, linear, as R,G,B [default: the sky's; a pale blue with --bake and without
    /// --eye]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B", value_parser = color)]
    pub background: Option<[f32; 3]>,
    /// Stops by which a PNG is brightened; auto brightens or darkens what could not be seen otherwise [default: 0; auto
    /// with --bake and without --eye]
    #[arg(help_heading = "Files")]
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true, value_parser = exposure)]
    pub exposure: Option<Exposure>,
    #[command(flatten)]
    pub shining: Shining,
    /// Occluders farther than this many scene units do not count [default: no limit]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "D", value_parser = positive)]
    pub max_distance: Option<f64>,
    /// Lobe exponent of every material, 0 to 1e6
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "N", conflicts_with = "bake", value_parser = exponent)]
    pub exponent: Option<f64>,
    /// Diffuse reflectance of every material, linear, as R,G,B
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B", conflicts_with = "bake", value_parser = color)]
    pub albedo: Option<[f32; 3]>,
    /// Specular reflectance of every material, linear, as R,G,B
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B", conflicts_with = "bake", value_parser = color)]
    pub specular: Option<[f32; 3]>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(help_heading = "Machine", hide_short_help = true)]
    #[arg(long, value_parser = word::<Backend>())]
    pub backend: Option<Backend>,
    #[command(flatten)]
    pub common: Common,
}

/// What the scene is laid over.
#[derive(ClapArgs)]
pub struct Matte {
    /// Leave out what is behind the scene and write its share of each pixel as alpha, for matting; colours of an .exr
    /// are multiplied by it
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, conflicts_with_all = ["figure", "background", "backdrop"])]
    pub alpha: bool,
    /// Picture of the same size that the scene stands before: .exr or .hdr (linear), .png or .jpg (sRGB)
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["figure", "background"])]
    pub backdrop: Option<PathBuf>,
}

/// Where the picture is taken from.
#[derive(ClapArgs)]
pub struct View {
    /// Eye point in scene units [default: in front, above and to the right of the whole scene; with --bake what fits
    /// best, inside where the scene is a closed room, as in the bake's STEM.lit.png]
    #[arg(help_heading = "Camera")]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub eye: Option<[f64; 3]>,
    /// Point that is looked at, in scene units [default: the middle of the scene]
    #[arg(help_heading = "Camera")]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub look: Option<[f64; 3]>,
    /// Direction that is upward in the picture
    #[arg(help_heading = "Camera", hide_short_help = true)]
    #[arg(long, value_name = "X,Y,Z", default_value = "0,1,0", allow_hyphen_values = true, value_parser = triple)]
    pub up: [f64; 3],
    /// Vertical field of view in degrees, above 0 and below 180 [default: 40; 65 where a fitted view stands inside of a
    /// room]
    #[arg(help_heading = "Camera")]
    #[arg(long, value_name = "F", value_parser = field_of_view)]
    pub fov_deg: Option<f64>,
    /// Width and height in pixels
    #[arg(help_heading = "Camera")]
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = size)]
    pub size: [u32; 2],
    /// Camera samples of a pixel: a regular grid of N x N
    #[arg(help_heading = "Camera")]
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u32>(1..=64))]
    pub samples: u32,
}

impl View {
    /// The vertical field of view in degrees.
    pub fn fov_deg(&self) -> f64 {
        self.fov_deg.unwrap_or(40.0)
    }
}

/// How bright an 8-bit picture is.
#[derive(Clone, Copy, PartialEq)]
pub enum Exposure {
    /// Bright enough to be seen.
    Auto,
    /// Brightened by so many stops.
    Stops(f64),
}

fn exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "auto" => Ok(Exposure::Auto),
        _ => match number(text) {
            Ok(stops) if stops.abs() <= 30.0 => Ok(Exposure::Stops(stops)),
            _ => Err("expected auto or a number of stops from -30 to 30".into()),
        },
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Specular ambient term against view angle and exponent: fig1.svg and fig1.csv
    Fig1,
    /// The scene in ambient light only by five models, with their differences: fig3_*.exr, fig3_*.png and fig3.csv
    Fig3,
    /// The scene in six materials before --environment: balls.png and balls.exr
    Balls,
}
