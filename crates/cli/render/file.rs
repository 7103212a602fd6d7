//! Picture files.

use super::args::Args;
use super::tables_args::WeightName;
use crate::host;
use ::frames::specular_files;
use ::render::Lightmap;
use ambake::flags::sky::SkyArg;
use anyhow::{Context, bail};
use environment::{Format, Image, Labels};
use maps::merge::Response;
use rays::World;
use report::Output;
use std::ffi::OsStr;
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
    let pages = lightmap.map_or(&[][..], Lightmap::files);
    let own = world.scene().inputs.iter().chain(pages).cloned();
    own.chain(tables_inputs(args)).collect()
}

/// Those of them that the command line names beside the scene.
pub fn tables_inputs(args: &Args) -> Vec<PathBuf> {
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
        .chain(&tables.environment)
        .chain(&tables.path)
        .chain(&args.matte.backdrop)
        .chain(&args.response)
        .chain(&args.balls.probes)
        .chain(&args.balls.reflection)
        .chain(args.sky.as_ref().and_then(SkyArg::file));
    others.cloned().collect()
}

/// Writes a picture, or nothing under its name; never in the place of one of its `inputs`.
pub fn write(
    path: &Path,
    picture: &Image,
    alpha: Option<&[f32]>,
    about: &str,
    inputs: &[PathBuf],
    film: &Film,
) -> anyhow::Result<()> {
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not a file name", path.display()))?;
    let mut output = Output::for_file(path)?;
    output.protect(inputs.iter().cloned());
    if ending(path)? == "exr" {
        let alpha = alpha.map(|values| ("A", values));
        let bytes = environment::encode_with(picture, alpha, Format::Exr, &labels(about))?;
        output.stage_bytes(name, &bytes)?;
    } else {
        let picture = film.recorded(picture.clone());
        let png = match alpha {
            Some(alpha) => report::matte_png(picture.width, &picture.pixels, alpha),
            None => report::picture_png(picture.width, &picture.pixels),
        };
        output.stage_bytes(name, &png)?;
    }
    output.publish()?;
    Ok(())
}

/// What records pictures of 8 bits: the curves of a film, else sRGB.
pub struct Film(Option<[Response; 3]>);

impl Film {
    /// The film of `--response`.
    pub fn of(args: &Args) -> anyhow::Result<Film> {
        let curves = args.response.as_deref().map(maps::merge::read_curves);
        Ok(Film(curves.transpose()?))
    }

    /// A photograph's radiance; pictures that are linear already stay as they are.
    fn developed(&self, path: &Path) -> Result<Image, environment::Error> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        match &self.0 {
            Some(curves) if !["exr", "hdr"].map(OsStr::new).contains(&&*ending) => {
                maps::merge::develop(path, curves)
            }
            _ => environment::read(path).map(|file| file.image),
        }
    }

    /// The picture that looks in sRGB as the film would record this one.
    fn recorded(&self, mut picture: Image) -> Image {
        let Some(curves) = &self.0 else {
            return picture;
        };
        let display = Response::srgb();
        for pixel in &mut picture.pixels {
            for (value, curve) in pixel.iter_mut().zip(curves) {
                *value = display.exposure(curve.recorded(f64::from(*value))) as f32;
            }
        }
        picture
    }
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
    pub fn of(args: &Args, size: [u32; 2], film: &Film) -> anyhow::Result<Behind> {
        let Some(path) = &args.matte.backdrop else {
            return Ok(if args.matte.alpha {
                Behind::Nothing
            } else {
                Behind::Own
            });
        };
        let plate = film.developed(path)?;
        let [width, height] = size.map(|n| n as usize);
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
