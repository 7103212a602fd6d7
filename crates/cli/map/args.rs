//! `ambake map`: illumination maps and reflection maps.

use crate::args;
use crate::map::file::{self, Source, write};
use crate::{Outcome, host, say};
use anyhow::{Context, bail};
use clap::{Args as ClapArgs, Subcommand, ValueEnum};
use maps::{IlluminationMap, Layout, Lobe, Normalise, Orientation, Projection, Request};
use serde_json::json;
use std::path::{Path, PathBuf};

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
    Ball(crate::map::ball::Args),
    /// Exposure brackets to one picture of radiance
    Merge(crate::map::merge::Args),
    /// The light that arrives at a place in a scene
    ///
    /// Surfaces that shine (Ke, emissiveFactor) are seen as they are. Others are secondary sources: the light that
    /// reaches them straight from the sky, from shining surfaces and from point lights, reflected once by Lambert's law.
    Capture(crate::map::capture::Args),
}

/// The picture that is read.
#[derive(ClapArgs)]
pub struct Input {
    /// Picture: .hdr, .exr, or .png and .jpg taken as sRGB; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Projection of IN: polar, cube, cross, strip, ortho, ball, angular, octahedral [default: its header's, else polar]
    #[arg(long, value_name = "PROJECTION", value_parser = projection)]
    pub from: Option<Projection>,
    /// Whose axes IN has: ambake, gltf, three.js, blender, filament, openexr [default: its header's, else ambake]
    #[arg(long, value_name = "TOOL", value_parser = orientation)]
    pub from_orientation: Option<Orientation>,
}

#[derive(ClapArgs)]
pub struct Common {
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Print nothing but errors
    #[arg(long)]
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
    #[arg(long, value_name = "WxH", value_parser = args::size)]
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
    #[arg(long, value_name = "WxH", default_value = "72x36", value_parser = args::size)]
    pub size: [u32; 2],
    /// Projection of OUT
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Factor of the integral: 1/π (1/4π for luminous), or the 1984 text's 1/4π
    #[arg(long, value_enum, default_value_t = Scale::Radiance)]
    pub normalise: Scale,
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
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = args::number)]
    pub exponent: Vec<f64>,
    /// Roughness of the ggx kernel, 0.06 to 1, or several separated by commas; its α is roughness²
    #[arg(long, value_name = "R,..", value_delimiter = ',', value_parser = args::number)]
    pub roughness: Vec<f64>,
    /// Reflectance function
    #[arg(long, value_enum, default_value_t = SpecularKernel::Phong)]
    pub kernel: SpecularKernel,
    /// Table of the kernel `table`: lines of a cosine, ascending in -1..1, and a value of at least 0; after a first line
    /// `degrees,value` angles from the mirror direction, ascending in 0..180. Linear in the cosine between lines
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Width and height of OUT in texels; of one face for a cube
    #[arg(long, value_name = "WxH", default_value = "512x256", value_parser = args::size)]
    pub size: [u32; 2],
    /// Projection of OUT
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = projection)]
    pub to: Projection,
    /// Factor of the integral: one over the kernel's integral ((n+1)/2π for phong), or the 1984 text's 1/4π
    #[arg(long, value_enum, default_value_t = Scale::Radiance)]
    pub normalise: Scale,
    #[command(flatten)]
    pub common: Common,
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
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Scale {
    /// A constant map of 1 gives 1
    Radiance,
    /// 1/4π
    Seed,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match args {
        Args::Convert(args) => convert(args),
        Args::Stats(args) => stats(args),
        Args::Diffuse(args) => diffuse(args),
        Args::Specular(args) => specular(args),
        Args::Ball(args) => crate::map::ball::run(args),
        Args::Merge(args) => crate::map::merge::run(args),
        Args::Capture(args) => crate::map::capture::run(args),
    }?;
    Ok(Outcome::Done)
}

fn convert(args: &Convert) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let source = Source::read(&args.input)?;
    let size = match args.size {
        Some(size) => file::picture_size(args.to, size),
        None => args.to.size(source.texels()),
    };
    let to = Layout {
        projection: args.to,
        orientation: args.orientation,
        size,
    };
    let image = maps::convert_image(&source.image, source.layout, to)
        .with_context(|| args.input.input.display().to_string())?;
    let normalisation = source.normalisation.as_deref().unwrap_or("radiance");
    let written = write(&args.output, &[(None, &image)], to, normalisation)?;
    summary(&args.common, &args.input.input, &source, &written)
}

fn stats(args: &Stats) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let source = Source::read_unchecked(&args.input)?;
    let (size, projection) = (source.layout.size, source.layout.projection);
    let (mut integral, mut area) = ([0.0; 3], 0.0);
    let (mut maximum, mut place) = (f32::NEG_INFINITY, [0, 0]);
    let (mut minimum, mut non_finite, mut negative) = (f32::INFINITY, 0u64, 0u64);
    for (at, pixel) in source.image.pixels.iter().enumerate() {
        let (x, y) = (at % size.0, at / size.0);
        let omega = projection.solid_angle(size, x, y);
        if omega == 0.0 {
            continue;
        }
        if !pixel.iter().all(|v| v.is_finite()) {
            non_finite += 1;
            continue;
        }
        negative += u64::from(pixel.iter().any(|v| *v < 0.0));
        area += omega;
        integral = std::array::from_fn(|c| integral[c] + omega * f64::from(pixel[c]));
        let largest = pixel.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        minimum = pixel.iter().copied().fold(minimum, f32::min);
        if largest > maximum {
            (maximum, place) = (largest, [x, y]);
        }
    }
    if area == 0.0 {
        bail!(
            "{}: no pixel is finite; repair the picture",
            args.input.input.display()
        );
    }
    let mean = integral.map(|v| v / area);
    let direction = projection.direction(size, place[0] as f64 + 0.5, place[1] as f64 + 0.5);
    if args.common.json {
        let json = json!({
            "schema_version": 1, "map": args.input.input, "size": [size.0, size.1],
            "projection": projection.name(), "orientation": source.layout.orientation.name(),
            "mean": mean, "maximum": maximum, "maximum_at": place, "maximum_direction": direction, "minimum": minimum,
            "integral": integral, "solid_angle": area, "non_finite": non_finite, "negative": negative,
        });
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
    }
    let triple = |v: [f64; 3]| v.map(|v| format!("{v:.6}")).join(" ");
    say(&format!(
        "{} x {} texels, {}, axes of {}\nmean       {}\nintegral   {} (radiance times sr)\nmaximum    {maximum} at ({}, {})\n\
         minimum    {minimum}\nnon-finite {non_finite} texels\nnegative   {negative} texels\n",
        size.0,
        size.1,
        projection.name(),
        source.layout.orientation.name(),
        triple(mean),
        triple(integral),
        place[0],
        place[1],
    ))
}

fn diffuse(args: &Diffuse) -> anyhow::Result<()> {
    let lobe = match args.kernel {
        DiffuseKernel::Lambert => Lobe::Lambert,
        DiffuseKernel::Luminous => Lobe::Luminous,
    };
    let target = (args.to, args.size);
    reflect(
        &args.input,
        &args.output,
        &[(None, lobe)],
        target,
        args.normalise,
        &args.common,
    )
}

fn specular(args: &Specular) -> anyhow::Result<()> {
    let (values, flag) = match args.kernel {
        SpecularKernel::Phong | SpecularKernel::Varnish => (&args.exponent, "--exponent"),
        SpecularKernel::Ggx => (&args.roughness, "--roughness"),
        _ => (&Vec::new(), ""),
    };
    if values.is_empty() && !flag.is_empty() {
        bail!("this kernel needs {flag}");
    }
    let lobe = |value: f64| match args.kernel {
        SpecularKernel::Varnish => Lobe::Varnish(value),
        SpecularKernel::Ggx => Lobe::Ggx(value),
        _ => Lobe::Phong(value),
    };
    let lobes = match (args.kernel, &args.table) {
        (SpecularKernel::Mirror, _) => vec![(None, Lobe::Mirror)],
        (SpecularKernel::Table, Some(path)) => vec![(None, table(path)?)],
        (SpecularKernel::Table, None) => bail!("this kernel needs --table"),
        _ if values.len() == 1 => vec![(None, lobe(values[0]))],
        _ => values
            .iter()
            .map(|v| (Some(v.to_string()), lobe(*v)))
            .collect(),
    };
    let target = (args.to, args.size);
    reflect(
        &args.input,
        &args.output,
        &lobes,
        target,
        args.normalise,
        &args.common,
    )
}

/// A lobe from lines of a cosine or an angle and a value; `#` begins a comment, a heading tells which.
fn table(path: &Path) -> anyhow::Result<Lobe> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut pairs = Vec::new();
    let mut degrees = false;
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let separator = |c: char| c == ',' || c == ';' || c.is_whitespace();
        let words: Vec<_> = line.split(separator).filter(|w| !w.is_empty()).collect();
        let values: Result<Vec<f64>, _> = words.iter().map(|w| w.parse::<f64>()).collect();
        match (values.as_deref(), words.as_slice()) {
            (Ok([]), _) => {}
            (Ok([x, value]), _) => pairs.push((*x, *value)),
            (Err(_), ["degrees", _]) if pairs.is_empty() => degrees = true,
            (Err(_), ["cosine", _]) if pairs.is_empty() => {}
            _ => bail!(
                "{} line {}: a cosine or an angle and a value belong there",
                path.display(),
                number + 1
            ),
        }
    }
    if degrees {
        if let Some((angle, _)) = pairs.iter().find(|(x, _)| !(0.0..=180.0).contains(x)) {
            bail!(
                "{}: {angle} degrees; an angle lies in 0..180",
                path.display()
            );
        }
        pairs
            .iter_mut()
            .for_each(|pair| pair.0 = pair.0.to_radians().cos());
        pairs.reverse();
    }
    let lobe = Lobe::Table(pairs);
    lobe.check().with_context(|| path.display().to_string())?;
    Ok(lobe)
}

/// Convolves and writes.
fn reflect(
    input: &Input,
    output: &Path,
    lobes: &[(Option<String>, Lobe)],
    (projection, size): (Projection, [u32; 2]),
    scale: Scale,
    common: &Common,
) -> anyhow::Result<()> {
    host::set_threads(common.threads)?;
    let (normalise, normalisation) = match scale {
        Scale::Radiance => (Normalise::Radiance, "radiance"),
        Scale::Seed => (Normalise::Seed, "seed"),
    };
    for (_, lobe) in lobes {
        lobe.check()?;
    }
    let size = file::picture_size(projection, size);
    projection.check(size.0, size.1)?;
    let source = Source::read(input)?;
    let named = || input.input.display().to_string();
    // Reflection maps are written in ambake's own axes.
    let own = Layout {
        orientation: Orientation::Ambake,
        ..source.layout
    };
    let image = maps::convert_image(&source.image, source.layout, own).with_context(named)?;
    let map = IlluminationMap::new(image, own.projection).with_context(named)?;
    let request = |lobe: &Lobe| Request {
        lobe: lobe.clone(),
        normalise,
        projection,
        size,
    };
    let requests: Vec<Request> = lobes.iter().map(|(_, lobe)| request(lobe)).collect();
    let results = maps::convolve(&map, &requests).with_context(named)?;
    let images: Vec<_> = lobes
        .iter()
        .zip(&results)
        .map(|((suffix, _), map)| (suffix.clone(), map.image()))
        .collect();
    let to = Layout {
        projection,
        orientation: Orientation::Ambake,
        size,
    };
    let written = write(output, &images, to, normalisation)?;
    summary(common, &input.input, &source, &written)
}

fn summary(
    common: &Common,
    input: &Path,
    source: &Source,
    written: &[PathBuf],
) -> anyhow::Result<()> {
    if common.json {
        let json = json!({
            "schema_version": 1, "map": input, "projection": source.layout.projection.name(),
            "orientation": source.layout.orientation.name(), "files": written,
        });
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
    }
    if common.quiet {
        return Ok(());
    }
    say(&written
        .iter()
        .map(|path| format!("wrote {}\n", path.display()))
        .collect::<String>())
}

pub fn projection(text: &str) -> Result<Projection, String> {
    Projection::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Projection::all().map(Projection::name).collect();
        format!("unknown projection; there are {}", names.join(", "))
    })
}

fn orientation(text: &str) -> Result<Orientation, String> {
    Orientation::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Orientation::all().map(Orientation::name).collect();
        format!("unknown orientation; there are {}", names.join(", "))
    })
}
