//! Pictures of encoded normals: `--encode` writes them, `--relight` shades them.

use super::args::Args;
use super::file::{Behind, Film};
use super::tables_args::ShaderName;
use super::{file, options};
use crate::host;
use crate::outcome::{Outcome, say};
use crate::progress::watch;
use crate::stop::Stop;
use ::frames::{Encoded, Error, NormalCode, TableSet, backdrop, frame};
use anyhow::bail;
use environment::Format;
use rays::{RayBackend, Surfaces, World};
use report::Output;
use serde_json::json;
use std::path::Path;

/// Writes what the camera sees as codes.
pub fn encode(
    code: NormalCode,
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
    stop: &Stop,
) -> anyhow::Result<Outcome> {
    let [path] = args.output.as_slice() else {
        bail!("--encode takes one -o FILE.exr");
    };
    if file::ending(path)? != "exr" {
        bail!(
            "{}: --encode writes an .exr file, which holds codes as they are",
            path.display()
        );
    }
    let camera = options::framing(&args.view, world).camera(world)?;
    let surfaces = Surfaces::new(world);
    let subject = options::subject(args, &surfaces, backend, &[]);
    let encoded = watch(options::show(args, "pixels"), stop, |progress| {
        let hit = |eye, toward| subject.hit(eye, toward);
        Encoded::take(&camera, code, progress, hit)
    });
    let encoded = match encoded {
        Err(Error::Render(::render::Error::Cancelled)) => return Ok(stop.outcome()),
        encoded => encoded?,
    };
    let (image, mut labels) = encoded.file();
    labels.insert("ambakeVersion".into(), host::VERSION.into());
    let mut output = Output::for_file(path)?;
    output.protect(file::inputs(args, world, None));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    output.stage_bytes(&name, &environment::encode(&image, Format::Exr, &labels)?)?;
    output.publish()?;
    done(args, path)
}

/// Shades such a picture from tables.
pub fn relight(args: &Args) -> anyhow::Result<Outcome> {
    let tables = &args.tables;
    let encoded = Encoded::read(&args.scene)?;
    let surface = options::surface_type(tables, tables.shader.unwrap_or(ShaderName::Phong));
    let maps = tables.maps.as_ref();
    let maps = maps.map(|[d, s]| [d.as_path(), s.as_path()]);
    let set = TableSet::read(
        &[surface],
        maps,
        [&tables.exponents, &tables.incidences],
        tables.environment.as_deref(),
    )?;
    let lookup = tables.lookup;
    if lookup.needs_corners() || tables.shader == Some(ShaderName::Traced) {
        bail!(
            "--relight: codes hold one normal a pixel; use --lookup nearest or bilinear, and no traced surfaces"
        );
    }
    let mut shader = set.shader(surface, options::weights(tables)?);
    shader.translucency = tables.translucency;
    let film = Film::of(args)?;
    let size = encoded.camera().size;
    let behind = Behind::of(args, size, &film)?;
    let environment = match behind {
        Behind::Own => set.environment.as_ref(),
        _ => None,
    };
    let mut picture = backdrop(encoded.camera(), environment);
    let buffer = encoded.buffer(&options::overrides(args));
    frame(&[shader], &buffer, lookup, &mut picture);
    let mut alpha = vec![0.0; picture.pixels.len()];
    buffer.places().for_each(|place| alpha[place] = 1.0);
    let matte = behind.compose(&mut picture, &alpha);
    let about = json!({
        "relit": args.scene.file_name().map(|name| name.to_string_lossy()),
        "maps": tables.maps,
        "normalisation": set.normalisation,
        "lookup": lookup.name(),
    });
    let mut inputs = file::tables_inputs(args);
    inputs.push(args.scene.clone());
    for path in &args.output {
        file::write(path, &picture, matte, &about.to_string(), &inputs, &film)?;
    }
    done(args, &args.output[0])
}

fn done(args: &Args, path: &Path) -> anyhow::Result<Outcome> {
    if !args.common.quiet {
        say(&format!("{}\n", path.display()))?;
    }
    Ok(Outcome::Done)
}
