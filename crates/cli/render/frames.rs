//! `ambake render --maps`: frames shaded from reflection maps.

use crate::render::run::{Args, write};
use crate::render::table_args::{ShaderName, Tables, rows};
use crate::{Outcome, say};
use ::render::Camera;
use ::render::tables::{
    Balls, CameraPath, GBuffer, Index, Shader, Surfel, Table, Turn, View, backdrop,
};
use anyhow::{Context, bail};
use glam::DVec3;
use maps::{IlluminationMap, Image, Lobe, Normalise, Orientation, Projection, Request};
use rays::{Overrides, Ray, RayBackend, Surfaces, World};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

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
    let hit = |eye, direction| surfel(args, &surfaces, backend, eye, direction);
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

/// What a camera ray meets.
fn surfel(
    args: &Args,
    surfaces: &Surfaces,
    backend: &dyn RayBackend,
    eye: DVec3,
    direction: DVec3,
) -> Option<Surfel> {
    let ray = Ray {
        origin: eye.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let overrides = Overrides {
        albedo: args.albedo,
        specular: args.specular,
        exponent: None,
    };
    let hit = backend.closest(&ray)?;
    let point = surfaces.at(&hit, -direction);
    let material = overrides.applied(point.material);
    Some(Surfel {
        normal: point.normal,
        albedo: material.albedo,
        specular: material.specular,
        object: hit.instance,
    })
}

/// Draws the figure of six materials into a directory.
pub fn balls(
    args: &Args,
    dir: &Path,
    world: &World,
    backend: &dyn RayBackend,
) -> anyhow::Result<Outcome> {
    let surfaces = Surfaces::new(world);
    let hit = |eye, direction| surfel(args, &surfaces, backend, eye, direction);
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

/// `OUT.0007.exr` of `OUT.exr`.
fn numbered_name(path: &Path, frame: u32) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{frame:04}.{ending}"))
}
