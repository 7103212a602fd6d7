//! What was typed after `ambake render --maps`. `options.rs` says what it means.

use ::frames::{Lookup, NormalCode};
use ::render::Weight;
use ambake::flags::parse::{exponent, number, positive, whole};
use ambake::flags::values::word;
use clap::{ArgGroup, Args as ClapArgs, ValueEnum};
use std::path::PathBuf;

/// Shading from tables: section 3 of the 1984 text.
#[derive(ClapArgs)]
#[command(group = ArgGroup::new("shading").multiple(true)
    .conflicts_with_all(["bake", "figure", "model", "rays", "sky", "background", "sun", "point", "sphere", "rect",
        "max_distance", "exponent"]))]
#[command(group = ArgGroup::new("lit").multiple(true))]
pub struct Tables {
    /// Shade from the reflection maps D and S, as `ambake map diffuse` and `specular` write them
    #[arg(help_heading = "Tables")]
    #[arg(long, value_name = "D,S", value_parser = pair, groups = ["shading", "lit"])]
    pub maps: Option<[PathBuf; 2]>,
    /// S stands for the files of these exponents, as `ambake map specular --exponent N,..` names them; each pixel is
    /// shaded with that of its material, between two of them
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_name = "N,..", value_delimiter = ',', requires = "maps", value_parser = exponent)]
    pub exponents: Vec<f64>,
    /// S stands for the files of these incidences in degrees, as `ambake map specular --kernel reflectance` names them;
    /// each pixel is shaded with that of its view, between two of them. With --exponents for S_N_A.exr
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_name = "A,..", value_delimiter = ',', requires = "maps", value_parser = incidence)]
    pub incidences: Vec<f64>,
    /// Surface type of every object but those of --shader-of [default: phong]
    #[arg(help_heading = "Surfaces")]
    #[arg(long, value_enum, groups = ["shading", "lit"], requires_ifs([
        ("phong", "maps"), ("retro", "maps"), ("varnish", "maps"),
        ("varnish", "environment"), ("mirror", "environment"), ("refraction", "environment"),
        ("luminous", "environment"), ("traced", "environment"),
    ]))]
    pub shader: Option<ShaderName>,
    /// Another surface type for the objects of this name, as in `urn*=mirror`; * stands for any characters, ? for one.
    /// May be repeated; later ones win
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "NAME=TYPE", requires = "shading", value_parser = shader_of)]
    pub shader_of: Vec<(String, ShaderName)>,
    /// Illumination map behind the objects [default: black]; also what mirrors and varnish show
    #[arg(help_heading = "Tables")]
    #[arg(long, value_name = "FILE", requires = "lit")]
    pub environment: Option<PathBuf>,
    /// How tables are read; the last three average over what a pixel reflects
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, default_value = "bilinear", value_parser = word::<Lookup>(), requires = "lit")]
    pub lookup: Lookup,
    /// Wd by the cosine of the view angle: `constant`, `schlick:F0`, or a file of lines with a cosine and a weight, or
    /// red, green and blue; after a first line `degrees` angles from the normal
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_name = "W", default_value = "constant", value_parser = weight, requires = "shading")]
    pub diffuse_weight: WeightName,
    /// Ws, likewise. Without --maps it weighs the Phong highlight of --sun and its kin by the cosine of their incidence
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_name = "W", default_value = "constant", value_parser = weight)]
    pub specular_weight: WeightName,
    /// Share of the diffuse light that comes through from behind, 0 to 1: it is looked up in D at -N
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "T", default_value = "0", value_parser = share, requires = "shading")]
    pub translucency: f32,
    /// Refractive index behind the surface, of `--shader refraction`
    #[arg(help_heading = "Surfaces", hide_short_help = true)]
    #[arg(long, value_name = "N", default_value = "1.5", value_parser = positive, requires = "shading")]
    pub ior: f64,
    /// Round normals to what a frame buffer would hold: one of 256, or an octahedral code of this many bits
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_parser = word::<NormalCode>(), requires = "shading")]
    pub normals: Option<NormalCode>,
    /// Write the normals that the camera sees as codes in place of a picture, with camera and materials in the header
    /// of the .exr, for --relight
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, value_name = "CODE", value_parser = word::<NormalCode>())]
    #[arg(conflicts_with_all = ["shading", "bake", "figure"])]
    pub encode: Option<NormalCode>,
    /// SCENE is a picture that --encode wrote: shade it from --maps
    #[arg(help_heading = "Tables", hide_short_help = true)]
    #[arg(long, requires = "maps")]
    #[arg(conflicts_with_all = ["shader_of", "frames", "path", "normals", "eye", "look", "up", "fov_deg", "size",
        "samples", "normal_maps"])]
    pub relight: bool,
    /// Frames of a sequence OUT.0000.exr, OUT.0001.exr, … [default with --path: one a key]
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "N", requires = "shading", value_parser = whole::<u32>(1..=1_000_000))]
    pub frames: Option<u32>,
    /// Degrees that the objects turn from frame to frame about --up through the middle of the scene
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "A", requires = "frames", allow_hyphen_values = true, value_parser = number)]
    pub turn_deg: Option<f64>,
    /// Camera path: lines of eye X,Y,Z and looked-at X,Y,Z, interpolated by a spline
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "FILE", requires = "shading", conflicts_with_all = ["eye", "look"])]
    pub path: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShaderName {
    /// Wd kd D(N) + Ws ks S(R)
    Phong,
    /// Ws ks I(R)
    Mirror,
    /// As phong, under a clear coat that adds half of I(R)
    Varnish,
    /// Wd kd D(N) + Ws ks S(E): light goes back where it comes from
    Retro,
    /// Ws ks I(T), refracted at one surface
    Refraction,
    /// kd times the mean of I
    Luminous,
    /// As mirror, but a ray finds what of the scene stands in R
    Traced,
}

/// A weight before its file is read.
#[derive(Clone)]
pub enum WeightName {
    Known(Weight),
    File(PathBuf),
}

impl Tables {
    /// True where frames are shaded from tables.
    pub fn asked(&self) -> bool {
        self.maps.is_some() || self.shader.is_some()
    }
}

fn pair(text: &str) -> Result<[PathBuf; 2], String> {
    match text.split_once(',') {
        Some((d, s)) if !d.is_empty() && !s.is_empty() && !s.contains(',') => {
            Ok([d.into(), s.into()])
        }
        _ => Err("expected two files as D,S".into()),
    }
}

fn incidence(text: &str) -> Result<f64, String> {
    match number(text)? {
        angle if (0.0..=90.0).contains(&angle) => Ok(angle),
        _ => Err("an incidence lies in 0..90 degrees".into()),
    }
}

fn shader_of(text: &str) -> Result<(String, ShaderName), String> {
    // A name may hold the sign too.
    let (name, surface) = text
        .rsplit_once('=')
        .ok_or("expected NAME=TYPE, such as `urn*=mirror`")?;
    let surface = ShaderName::from_str(surface, false).map_err(|_| {
        let known = ShaderName::value_variants().iter();
        let known = known.filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = known.map(|value| value.get_name().into()).collect();
        format!("`{surface}` is none of {}", known.join(", "))
    })?;
    Ok((name.into(), surface))
}

fn share(text: &str) -> Result<f32, String> {
    match number(text)? {
        share if (0.0..=1.0).contains(&share) => Ok(share as f32),
        _ => Err("a share lies in 0..1".into()),
    }
}

fn weight(text: &str) -> Result<WeightName, String> {
    if text == "constant" {
        return Ok(WeightName::Known(Weight::Constant));
    }
    match text.strip_prefix("schlick:") {
        None => Ok(WeightName::File(text.into())),
        Some(f0) => match number(f0)? {
            f0 if (0.0..=1.0).contains(&f0) => Ok(WeightName::Known(Weight::Schlick(f0 as f32))),
            _ => Err("F0 lies in 0..1".into()),
        },
    }
}
