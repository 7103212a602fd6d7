//! `ambake render --maps`: frames shaded from reflection maps.

use crate::args::{number, positive};
use crate::figures::Figure;
use crate::render::{Args, write};
use crate::{Outcome, say};
use ::bake::{Overrides, Ray, RayBackend, Surfaces, World};
use ::render::Camera;
use ::render::tables::{
    Balls, CameraPath, GBuffer, Index, Lookup, NormalCode, Shader, Surfel, Table, Turn, View,
    Weight, backdrop,
};
use anyhow::{Context, bail};
use clap::{ArgGroup, Args as ClapArgs, ValueEnum};
use glam::DVec3;
use maps::{IlluminationMap, Image, Lobe, Normalise, Orientation, Projection, Request};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Shading from tables: section 3 of the 1984 text.
#[derive(ClapArgs)]
#[command(group = ArgGroup::new("shading").multiple(true)
    .conflicts_with_all(["bake", "figure", "model", "rays", "sky", "background", "sun", "point", "max_distance", "exponent"]))]
#[command(group = ArgGroup::new("lit").multiple(true))]
pub struct Tables {
    /// Shade from the reflection maps D and S, as `ambake map diffuse` and `specular` write them
    #[arg(long, value_name = "D,S", value_parser = pair, groups = ["shading", "lit"])]
    pub maps: Option<[PathBuf; 2]>,
    /// Surface type of every object [default: phong]
    #[arg(long, value_enum, groups = ["shading", "lit"], requires_ifs([
        ("phong", "maps"), ("retro", "maps"), ("varnish", "maps"),
        ("varnish", "environment"), ("mirror", "environment"), ("refraction", "environment"), ("luminous", "environment"),
    ]))]
    pub shader: Option<ShaderName>,
    /// Illumination map behind the objects [default: black]; also what mirrors and varnish show
    #[arg(long, value_name = "FILE", requires = "lit")]
    pub environment: Option<PathBuf>,
    /// How tables are read; the last three average over what a pixel reflects
    #[arg(long, value_enum, default_value_t = LookupName::Bilinear, requires = "lit")]
    pub lookup: LookupName,
    /// Wd by the cosine of the view angle: `constant`, `schlick:F0`, or a file of lines with a cosine and a weight
    #[arg(long, value_name = "W", default_value = "constant", value_parser = weight, requires = "shading")]
    pub diffuse_weight: WeightName,
    /// Ws, likewise
    #[arg(long, value_name = "W", default_value = "constant", value_parser = weight, requires = "shading")]
    pub specular_weight: WeightName,
    /// Refractive index behind the surface, of `--shader refraction`
    #[arg(long, value_name = "N", default_value = "1.5", value_parser = positive, requires = "shading")]
    pub ior: f64,
    /// Round normals to what a frame buffer would hold: one of 256, or an octahedral code of this many bits
    #[arg(long, value_enum, requires = "shading")]
    pub normals: Option<NormalsName>,
    /// Frames of a sequence OUT.0000.exr, OUT.0001.exr, … [default with --path: one a key]
    #[arg(long, value_name = "N", requires = "shading", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: Option<u32>,
    /// Degrees that the objects turn from frame to frame about --up through the middle of the scene
    #[arg(long, value_name = "A", requires = "frames", allow_hyphen_values = true, value_parser = number)]
    pub turn_deg: Option<f64>,
    /// Camera path: lines of eye X,Y,Z and looked-at X,Y,Z, interpolated by a spline
    #[arg(long, value_name = "FILE", requires = "shading", conflicts_with_all = ["eye", "look"])]
    pub path: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShaderName {
    /// Wd kd D[N] + Ws ks S[R]
    Phong,
    /// Ws ks I[R]
    Mirror,
    /// As phong, under a clear coat that adds half of I[R]
    Varnish,
    /// Wd kd D[N] + Ws ks S[E]: light goes back where it comes from
    Retro,
    /// Ws ks I[T], refracted at one surface
    Refraction,
    /// kd times the mean of I
    Luminous,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LookupName {
    /// One texel
    Nearest,
    /// Between four texels
    Bilinear,
    /// Halves the pixel until its corners show adjacent texels
    Recursive,
    /// Integrates over the quad of the corners
    Quad,
    /// Rectangle of a pre-integrated table, constant cost
    Summed,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NormalsName {
    /// 256 normals of the visible hemisphere
    #[value(name = "256")]
    Visible256,
    /// Octahedral, 16 bits
    #[value(name = "oct8+8")]
    Oct8,
    /// Octahedral, 20 bits
    #[value(name = "oct10+10")]
    Oct10,
    /// Octahedral, 24 bits
    #[value(name = "oct12+12")]
    Oct12,
    /// Octahedral, 32 bits
    #[value(name = "oct16+16")]
    Oct16,
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

impl LookupName {
    fn lookup(self) -> Lookup {
        match self {
            LookupName::Nearest => Lookup::Nearest,
            LookupName::Bilinear => Lookup::Bilinear,
            LookupName::Recursive => Lookup::Recursive,
            LookupName::Quad => Lookup::Quad,
            LookupName::Summed => Lookup::Summed,
        }
    }
}

impl NormalsName {
    fn code(self) -> NormalCode {
        match self {
            NormalsName::Visible256 => NormalCode::Visible256,
            NormalsName::Oct8 => NormalCode::Octahedral(8),
            NormalsName::Oct10 => NormalCode::Octahedral(10),
            NormalsName::Oct12 => NormalCode::Octahedral(12),
            NormalsName::Oct16 => NormalCode::Octahedral(16),
        }
    }
}

impl WeightName {
    fn weight(&self) -> anyhow::Result<Weight> {
        let path = match self {
            WeightName::Known(weight) => return Ok(weight.clone()),
            WeightName::File(path) => path,
        };
        let pairs: Vec<[f32; 2]> = rows::<2>(path, "a cosine and a weight")?
            .into_iter()
            .map(|pair| pair.map(|v| v as f32))
            .collect();
        let sound = |[x, w]: &[f32; 2]| (0.0..=1.0).contains(x) && w.is_finite() && *w >= 0.0;
        let ascending = pairs.windows(2).all(|p| p[0][0] < p[1][0]);
        if pairs.is_empty() || !ascending || !pairs.iter().all(sound) {
            bail!(
                "{}: cosines must ascend within 0..1 and weights be 0 or above",
                path.display()
            );
        }
        Ok(Weight::Table(pairs))
    }
}

/// The tables that were read or made.
#[derive(Default)]
struct Loaded {
    diffuse: Option<Table>,
    specular: Option<Table>,
    environment: Option<Table>,
    normalisation: Option<String>,
}

/// Runs the verb on a loaded scene.
pub fn run(
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    started: Instant,
) -> anyhow::Result<Outcome> {
    let surfaces = Surfaces::new(world);
    let overrides = Overrides {
        albedo: args.albedo,
        specular: args.specular,
        exponent: args.exponent,
    };
    let hit = |eye: DVec3, direction: DVec3| {
        let ray = Ray {
            origin: eye.as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        let point = surfaces.at(&backend.closest(&ray)?, -direction);
        let material = overrides.applied(point.material);
        Some(Surfel {
            normal: point.normal,
            albedo: material.albedo,
            specular: material.specular,
        })
    };
    if let Some(Figure::Balls) = args.figure {
        return balls(args, world, hit);
    }
    let tables = &args.tables;
    let loaded = load(tables)?;
    let shader = shader(tables, &loaded)?;
    let path = tables.path.as_deref().map(camera_path).transpose()?;
    let keys = path.as_ref().map(|path| path.keys() as u32);
    let frames = tables.frames.or(keys).unwrap_or(1);
    let numbered = tables.frames.is_some() || path.is_some();
    let axis = DVec3::from(args.view.up).try_normalize();
    let mut behind: Option<(Camera, Image)> = None;
    let mut shading = 0.0;
    let mut written = Vec::new();
    for frame in 0..frames {
        let camera = match &path {
            None => args.view.camera(world)?,
            Some(path) => {
                let [eye, look] = path.at(frame, frames);
                let fov = args.view.fov_deg.to_radians();
                Camera::new(eye, look, args.view.up.into(), fov, args.view.size)
                    .with_context(|| format!("frame {frame}"))?
            }
        };
        let angle = (tables.turn_deg.unwrap_or(0.0) * f64::from(frame)).to_radians();
        let turn = Turn {
            centre: world.bounds().center(),
            axis: axis.context("--up 0,0,0 is no direction")?,
            angle,
        };
        let lookup = tables.lookup.lookup();
        let view = View {
            camera: &camera,
            turn,
            samples: args.view.samples,
            corners: lookup.needs_corners(),
        };
        let mut buffer = GBuffer::take(&view, hit);
        if let Some(name) = tables.normals {
            buffer.encode(name.code());
        }
        if behind.as_ref().is_none_or(|(taken, _)| *taken != camera) {
            behind = Some((camera, backdrop(&camera, loaded.environment.as_ref())));
        }
        let mut picture = match &behind {
            Some((_, picture)) => picture.clone(),
            None => unreachable!("the backdrop was just taken"),
        };
        let before = Instant::now();
        shader.frame(&buffer, lookup, &mut picture);
        shading += before.elapsed().as_secs_f64();
        let described = json!({
            "scene": world.scene().content_hash,
            "maps": tables.maps,
            "environment": tables.environment,
            "normalisation": loaded.normalisation,
            "lookup": lookup.name(),
            "samples": args.view.samples,
            "frame": frame,
            "turn_deg": angle.to_degrees(),
            "eye": camera.eye.to_array(),
            "forward": camera.forward.to_array(),
            "fov_deg": args.view.fov_deg,
        });
        for path in &args.output {
            let path = if numbered {
                numbered_name(path, frame)
            } else {
                path.clone()
            };
            write(&path, &picture, &described.to_string())?;
            written.push(path);
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    if args.common.json {
        let summary = json!({
            "schema_version": 1, "files": written, "frames": frames, "backend": backend.describe(),
            "normalisation": loaded.normalisation, "seconds": seconds, "shading_seconds": shading,
        });
        say(&format!("{}\n", serde_json::to_string_pretty(&summary)?))?;
    } else if !args.common.quiet {
        let last = written.last().map(|p| p.display().to_string());
        let milliseconds = 1e3 * shading / f64::from(frames);
        say(&format!(
            "{frames} frames to {} in {seconds:.1} s, {milliseconds:.2} ms of shading a frame\n",
            last.unwrap_or_default()
        ))?;
    }
    Ok(Outcome::Done)
}

/// The figure of six materials.
fn balls(
    args: &Args,
    world: &World,
    hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
) -> anyhow::Result<Outcome> {
    let [dir] = args.output.as_slice() else {
        bail!("--figure takes one -o DIR");
    };
    let path = args.tables.environment.as_deref();
    let path = path.context("--figure balls needs --environment")?;
    let (environment, _) = polar(path)?;
    let mut camera = args.view.camera(world)?;
    let [width, height] = camera.size;
    camera.size = [(width / 3).max(1), (height / 2).max(1)];
    let sheet = Balls::of(&environment)?.sheet(
        &camera,
        args.view.samples,
        args.tables.lookup.lookup(),
        hit,
    );
    let described = json!({
        "scene": world.scene().content_hash,
        "environment": path,
        "materials": Balls::NAMES,
        "lookup": args.tables.lookup.lookup().name(),
    });
    for name in ["balls.exr", "balls.png"] {
        write(&dir.join(name), &sheet, &described.to_string())?;
    }
    Ok(Outcome::Done)
}

/// Reads the maps of the arguments.
fn load(tables: &Tables) -> anyhow::Result<Loaded> {
    let mut loaded = Loaded::default();
    if let Some([d, s]) = &tables.maps {
        let ((diffuse, d_label), (specular, s_label)) = (polar(d)?, polar(s)?);
        if let (Some(of_d), Some(of_s)) = (&d_label, &s_label)
            && of_d != of_s
        {
            bail!(
                "{} is normalised by `{of_d}`, {} by `{of_s}`; make both with one --normalise",
                d.display(),
                s.display()
            );
        }
        loaded.diffuse = Some(Table::new(&diffuse)?);
        loaded.specular = Some(Table::new(&specular)?);
        loaded.normalisation = d_label.or(s_label);
    }
    if let Some(path) = &tables.environment {
        let (environment, _) = polar(path)?;
        loaded.environment = Some(Table::new(&environment)?);
        if tables.shader == Some(ShaderName::Luminous) {
            let request = Request {
                lobe: Lobe::Luminous,
                normalise: Normalise::Radiance,
                projection: Projection::Polar,
                size: (2, 1),
            };
            let maps = maps::convolve(&environment, &[request])?;
            loaded.diffuse = Some(Table::new(&maps[0])?);
        }
    }
    Ok(loaded)
}

/// A polar map in ambake's axes and its normalisation.
fn polar(path: &Path) -> anyhow::Result<(IlluminationMap, Option<String>)> {
    let file = maps::read(path)?;
    let label = |name: &str| file.labels.get(name).map(String::as_str);
    let projection = label("ambakeProjection").unwrap_or(Projection::Polar.name());
    let orientation = label("ambakeOrientation").unwrap_or(Orientation::Ambake.name());
    if projection != Projection::Polar.name() || orientation != Orientation::Ambake.name() {
        bail!(
            "{} is a {projection} map with the axes of {orientation}; run ambake map convert --to polar on it",
            path.display()
        );
    }
    let normalisation = label("ambakeNormalisation").map(String::from);
    let map = IlluminationMap::new(file.image, Projection::Polar)
        .with_context(|| path.display().to_string())?;
    Ok((map, normalisation))
}

fn shader<'a>(tables: &Tables, loaded: &'a Loaded) -> anyhow::Result<Shader<'a>> {
    let name = tables.shader.unwrap_or(ShaderName::Phong);
    let (d, s) = (loaded.diffuse.as_ref(), loaded.specular.as_ref());
    let i = loaded.environment.as_ref();
    let index = match name {
        ShaderName::Retro => Index::Retro,
        ShaderName::Refraction => Index::Refraction((1.0 / tables.ior) as f32),
        _ => Index::Mirror,
    };
    let (diffuse, specular, coat) = match name {
        ShaderName::Phong | ShaderName::Retro => (d, s, None),
        ShaderName::Varnish => (d, s, i),
        ShaderName::Mirror | ShaderName::Refraction => (None, i, None),
        ShaderName::Luminous => (d, None, None),
    };
    Ok(Shader {
        diffuse,
        specular,
        index,
        coat,
        diffuse_weight: tables.diffuse_weight.weight()?,
        specular_weight: tables.specular_weight.weight()?,
    })
}

fn camera_path(path: &Path) -> anyhow::Result<CameraPath> {
    let keys = rows::<6>(path, "eye X,Y,Z and looked-at X,Y,Z")?;
    let keys = keys
        .into_iter()
        .map(|[a, b, c, d, e, f]| [DVec3::new(a, b, c), DVec3::new(d, e, f)]);
    CameraPath::new(keys.collect()).with_context(|| {
        format!(
            "{}: it has no lines; one a key frame belongs there",
            path.display()
        )
    })
}

/// Lines of `N` finite numbers apart by commas or blanks; `#` begins a comment.
fn rows<const N: usize>(path: &Path, what: &str) -> anyhow::Result<Vec<[f64; N]>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut rows = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split([' ', '\t', ',', '\r']).filter(|w| !w.is_empty());
        let values: Result<Vec<f64>, String> = words.map(number).collect();
        match values.map(<[f64; N]>::try_from) {
            Ok(Ok(row)) => rows.push(row),
            Ok(Err(values)) if values.is_empty() => {}
            _ => bail!("{} line {}: {what} belong there", path.display(), at + 1),
        }
    }
    Ok(rows)
}

/// `OUT.0007.exr` of `OUT.exr`.
fn numbered_name(path: &Path, frame: u32) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{frame:04}.{ending}"))
}

fn pair(text: &str) -> Result<[PathBuf; 2], String> {
    match text.split_once(',') {
        Some((d, s)) if !d.is_empty() && !s.is_empty() && !s.contains(',') => {
            Ok([d.into(), s.into()])
        }
        _ => Err("expected two files as D,S".into()),
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
