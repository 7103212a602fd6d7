//! Picture files.

use super::args::Args;
use super::tables_args::WeightName;
use crate::host;
use crate::sky::SkyArg;
use ::render::Lightmap;
use ::render::tables::specular_files;
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

/// Every file that a picture of the arguments is made from; the pages of `--bake` are those of `lightmap`.
pub fn inputs(args: &Args, world: &World, lightmap: Option<&Lightmap>) -> Vec<PathBuf> {
    let tables = &args.tables;
    let weights = [&tables.diffuse_weight, &tables.specular_weight];
    let weights = weights.into_iter().filter_map(|weight| match weight {
        WeightName::File(path) => Some(path),
        WeightName::Known(_) => None,
    });
    let maps = tables.maps.iter().flatten();
    let glosses = tables.maps.iter().flat_map(|[_, s]| {
        let files = specular_files(s, &tables.exponents, &tables.incidences);
        files.into_iter().flatten()
    });
    let glosses: Vec<PathBuf> = glosses.collect();
    let others = maps
        .chain(&glosses)
        .chain(weights)
        .chain(lightmap.map_or(&[][..], Lightmap::files))
        .chain(&tables.environment)
        .chain(&tables.path)
        .chain(&args.matte.backdrop)
        .chain(args.sky.as_ref().and_then(SkyArg::file));
    world.scene().inputs.iter().chain(others).cloned().collect()
}

/// Writes a picture, or nothing under its name; never in the place of one of its `inputs`.
pub fn write(
    path: &Path,
    picture: &Image,
    alpha: Option<&[f32]>,
    about: &str,
    inputs: &[PathBuf],
) -> anyhow::Result<()> {
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not a file name", path.display()))?;
    let mut output = Output::for_file(path)?;
    output.protect(inputs.iter().cloned());
    if ending(path)? == "exr" {
        let alpha = alpha.map(|values| ("A", values));
        let bytes = maps::encode_with(picture, alpha, Format::Exr, &labels(about))?;
        output.stage_bytes(name, &bytes)?;
    } else {
        let png = match alpha {
            Some(alpha) => report::matte_png(picture.width, &picture.pixels, alpha),
            None => report::picture_png(picture.width, &picture.pixels),
        };
        output.stage_bytes(name, &png)?;
    }
    output.publish()?;
    Ok(())
}

/// What a picture stands before.
pub enum Behind {
    /// What the scene has behind it.
    Own,
    /// Nothing: alpha is written.
    Nothing,
    /// A picture of the same size.
    Plate(Image),
}

impl Behind {
    /// What the arguments ask for.
    pub fn of(args: &Args) -> anyhow::Result<Behind> {
        let Some(path) = &args.matte.backdrop else {
            return Ok(if args.matte.alpha {
                Behind::Nothing
            } else {
                Behind::Own
            });
        };
        let plate = maps::read(path)?.image;
        let [width, height] = args.view.size.map(|n| n as usize);
        if (plate.width, plate.height) != (width, height) {
            bail!(
                "{0}: it has {1} x {2} pixels, the picture {width} x {height}; ask for --size {1}x{2}",
                path.display(),
                plate.width,
                plate.height
            );
        }
        Ok(Behind::Plate(plate))
    }

    /// A picture before black with its alpha, as it is written: over the plate, or with the alpha.
    pub fn compose<'a>(&self, picture: &mut Image, alpha: &'a [f32]) -> Option<&'a [f32]> {
        match self {
            Behind::Own => None,
            Behind::Nothing => Some(alpha),
            Behind::Plate(plate) => {
                ::render::over(picture, alpha, plate);
                None
            }
        }
    }
}

/// The header of a picture: who made it, and from which options.
pub fn labels(about: &str) -> Labels {
    Labels::from([
        ("ambakeVersion".into(), host::VERSION.into()),
        ("ambakeOptions".into(), about.into()),
    ])
}
