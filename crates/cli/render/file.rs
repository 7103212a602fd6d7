//! Picture files.

use crate::host;
use anyhow::{Context, bail};
use maps::{Format, Image, Labels};
use report::Output;
use std::path::Path;

/// What a picture's name asks for.
pub fn ending(path: &Path) -> anyhow::Result<&'static str> {
    let ending = path.extension().map(|e| e.to_ascii_lowercase());
    match ending.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => Ok("exr"),
        Some("png") => Ok("png"),
        _ => bail!("{}: a picture's name ends in .exr or .png", path.display()),
    }
}

/// Writes a picture, or nothing under its name.
pub fn write(path: &Path, picture: &Image, about: &str) -> anyhow::Result<()> {
    let dir = match path.parent() {
        Some(dir) if dir != Path::new("") => dir,
        _ => Path::new("."),
    };
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not a file name", path.display()))?;
    let mut output = Output::create(dir)?;
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
