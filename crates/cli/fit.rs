//! `ambake fit`: reflectances and exponent of a known shape from pictures of it in ambient light.

use crate::common::build;
use crate::host;
use crate::outcome::{Outcome, say, say_json};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use ambake::Backend;
use ambake::flags::common::Common;
use ambake::flags::parse::{color, field_of_view, positive, triple, whole};
use ambake::flags::values::word;
use ambient::Estimate;
use ambient::convention::lobe_scale;
use anyhow::{Context, bail};
use clap::Args as ClapArgs;
use environment::Sky;
use frames::{Fit, Shot, fit};
use glam::DVec3;
use rays::Surfaces;
use render::{Direct, Error, Framing, Lamps, Model};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::PathBuf;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file with the shape: .obj, .gltf or .glb; its materials do not count
    pub scene: PathBuf,
    /// Pictures of it: .exr or .hdr (linear), .png or .jpg (taken as sRGB)
    #[arg(value_name = "IMAGE", required = true)]
    pub images: Vec<PathBuf>,
    /// Eye point in scene units; one for all pictures, or repeated, one for each [default: in front, above and to the
    /// right of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub eye: Vec<[f64; 3]>,
    /// Point that is looked at; one for all pictures, or one for each [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = triple)]
    pub look: Vec<[f64; 3]>,
    /// Direction that is upward in the pictures
    #[arg(long, value_name = "X,Y,Z", default_value = "0,1,0", allow_hyphen_values = true, value_parser = triple)]
    pub up: [f64; 3],
    /// Vertical field of view in degrees, above 0 and below 180
    #[arg(long, value_name = "F", default_value_t = 40.0, value_parser = field_of_view)]
    pub fov_deg: f64,
    /// Uniform sky radiance, linear, as R,G,B
    #[arg(long, value_name = "R,G,B", default_value = "1,1,1", value_parser = color)]
    pub sky: [f32; 3],
    /// What the pictures multiply radiance by
    #[arg(long, value_name = "E", default_value_t = 1.0, value_parser = positive)]
    pub exposure: f64,
    /// Camera samples of a pixel: a regular grid of N x N
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u32>(1..=16))]
    pub samples: u32,
    /// Rays over the hemisphere of every camera sample, and as many over each lobe that is tried
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = whole::<u32>(1..=65_536))]
    pub rays: u32,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(long, value_parser = word::<Backend>())]
    pub backend: Option<Backend>,
    #[command(flatten)]
    pub common: Common,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    let threads = host::set_threads(args.common.threads)?;
    for (flag, given) in [("--eye", args.eye.len()), ("--look", args.look.len())] {
        if given > 1 && given != args.images.len() {
            bail!(
                "{flag} is given {given} times for {} pictures; give it once, or once for each",
                args.images.len()
            );
        }
    }
    if args.sky.contains(&0.0) {
        bail!("--sky: a channel of 0 lights nothing; each must be above 0");
    }
    let pictures = args
        .images
        .iter()
        .map(|path| environment::read(path).map(|file| file.image))
        .collect::<Result<Vec<_>, _>>()?;
    let scene = scene::load_with(&args.scene, args.common.files())?;
    let (world, backend) = build(scene, args.backend, threads)?;
    let nth = |given: &[[f64; 3]], at: usize| {
        let place = given.get(at).or(given.first()).copied();
        place.map(|place| DVec3::from(place) - world.origin())
    };
    let mut shots = Vec::new();
    for (at, picture) in pictures.iter().enumerate() {
        let framing = Framing {
            eye: nth(&args.eye, at),
            look: nth(&args.look, at),
            up: args.up.into(),
            fov: args.fov_deg.to_radians(),
            size: [picture.width as u32, picture.height as u32],
        };
        let camera = framing.camera(&world)?;
        shots.push(Shot { camera, picture });
    }
    let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
    if !lamps.is_empty() {
        bail!(
            "{}: it has surfaces that shine; pictures in ambient light alone are fitted",
            args.scene.display()
        );
    }
    let mut direct = Direct {
        model: Model::Phong,
        rays: args.rays,
        sky: Sky::Uniform(args.sky),
        seed: args.common.seed,
        ..Direct::new(&surfaces, backend.as_ref(), &lamps)
    };
    let how = (args.samples, args.exposure);
    let mut with = |rays: u32| {
        direct.rays = rays;
        watch(show(args), &stop, |progress| {
            fit(&mut direct, &shots, how, progress)
        })
    };
    let found = with(args.rays).and_then(|fine| Ok((with(args.rays.div_ceil(4))?, fine)));
    let found = match found {
        Err(Error::Cancelled) => return Ok(stop.outcome()),
        found => {
            let (coarse, fine) = found.with_context(|| args.scene.display().to_string())?;
            widened(fine, &coarse)
        }
    };
    if args.common.json {
        say_json(&described(&found, args))?;
    } else if !args.common.quiet {
        say(&words(&found))?;
    }
    Ok(Outcome::Done)
}

fn show(args: &Args) -> Show {
    Show {
        unit: "pixels",
        quiet: args.common.quiet,
    }
}

/// The fit with what noise of its own rays may have moved it by: that pulls slopes toward 0, at a quarter of the rays
/// about four times as far. All of the difference counts, because chance may have made it small.
fn widened(mut fine: Fit, coarse: &Fit) -> Fit {
    let widen = |fine: &mut Estimate, coarse: &Estimate| {
        let moved = (fine.value - coarse.value).abs();
        fine.std_err = fine.std_err.hypot(moved);
    };
    let own = fine.albedo.iter_mut().chain(&mut fine.specular);
    for (fine, coarse) in own.zip(coarse.albedo.iter().chain(&coarse.specular)) {
        widen(fine, coarse);
    }
    if let (Some(fine), Some(coarse)) = (&mut fine.exponent, &coarse.exponent) {
        widen(fine, coarse);
    }
    fine
}

/// 95 of 100 intervals hold the true value where what the pixels leave is noise.
fn interval(estimate: &Estimate) -> f64 {
    1.96 * estimate.std_err
}

fn described(fit: &Fit, args: &Args) -> Value {
    let value = |estimates: &[Estimate; 3]| json!(estimates.map(|e| e.value));
    let error = |estimates: &[Estimate; 3]| json!(estimates.map(|e| interval(&e)));
    let exponent = fit.exponent.map(|e| e.value);
    let k_s = fit
        .specular
        .map(|s| s.value * lobe_scale(exponent.unwrap_or(0.0)));
    json!({
        "schema_version": 1,
        "images": args.images.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        "albedo": value(&fit.albedo),
        "albedo_interval": error(&fit.albedo),
        "specular": value(&fit.specular),
        "specular_interval": error(&fit.specular),
        "exponent": exponent,
        "exponent_interval": fit.exponent.map(|e| interval(&e)),
        "kd": fit.albedo.map(|a| a.value / PI),
        "ks": k_s,
        "residual": fit.residual,
        "pixels": fit.pixels,
    })
}

fn words(fit: &Fit) -> String {
    let three = |name: &str, estimates: &[Estimate; 3]| {
        let each = estimates.map(|e| format!("{:.4} +- {:.4}", e.value, interval(&e)));
        format!("{name:<9} {}\n", each.join(", "))
    };
    let exponent = match fit.exponent {
        None => "exponent  none: nothing reflects specularly\n".into(),
        Some(e) => format!("exponent  {:.2} +- {:.2}\n", e.value, interval(&e)),
    };
    format!(
        "{}{}{exponent}{} pixels, {:.2e} root mean square is left; +- holds 95 of 100 true values\n",
        three("albedo", &fit.albedo),
        three("specular", &fit.specular),
        fit.pixels,
        fit.residual,
    )
}
