//! Picture files.

use super::args::Args;
use crate::host;
use anyhow::{Context, bail};
use maps::{Format, Image, Labels};
use rays::World;
use report::Output;
use std::path::{Path, PathBuf};

/// What a picture's name asks for.
pub fn ending(path: &Path) -> anyhow::Result<&'static str> {
    let ending = path.extension().map(|e| e.to_ascii_lowercase());
    match ending.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => Ok("exr"),
        Some("png") => Ok("png"),
        _ => bail!("{}: a picture's name ends in .exr or .png", path.display()),
    }
}

/// Every file that a picture of the arguments is made from.
pub fn inputs(args: &Args, world: &World) -> Vec<PathBuf> {
    let tables = &args.tables;
    let maps = tables.maps.iter().flatten();
    let others = maps.chain(&tables.environment).chain(&tables.path);
    world.scene().inputs.iter().chain(others).cloned().collect()
}

/// Writes a picture, or nothing under its name; never in the place of one of its `inputs`.
pub fn write(path: &Path, picture: &Image, about: &str, inputs: &[PathBuf]) -> anyhow::Result<()> {
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not a file name", path.display()))?;
    let mut output = Output::for_file(path)?;
    output.protect(inputs.iter().cloned());
    if ending(path)? == "exr" {
        output.stage_bytes(name, &maps::encode(picture, Format::Exr, &labels(about))?)?;
    } else {
        output.stage_bytes(name, &report::picture_png(picture.width, &picture.pixels))?;
    }
    output.publish()?;
    Ok(())
}

/// The header of a picture: who made it, and from which options.
pub fn labels(about: &str) -> Labels {
    Labels::from([
        ("ambakeVersion".into(), host::VERSION.into()),
        ("ambakeOptions".into(), about.into()),
    ])
}
