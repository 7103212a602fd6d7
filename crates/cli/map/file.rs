//! Map files: which pictures a name stands for, headers, staging.

use super::args::{Common, Input};
use crate::outcome::{say, say_json};
use anyhow::{Context, bail};
use environment::{FACES, Format, Image, ImageFile, Labels, MapLayout, Orientation, Projection};
use report::Output;
use serde_json::json;
use std::path::{Path, PathBuf};

/// A map that was read.
pub struct Source {
    pub image: Image,
    pub layout: MapLayout,
    /// What the header says about its values.
    pub normalisation: Option<String>,
    /// Every picture that was read for it.
    pub inputs: Vec<PathBuf>,
}

impl Source {
    /// Reads a map strictly.
    pub fn read(input: &Input) -> anyhow::Result<Source> {
        Self::with(input, environment::read)
    }

    /// Reads a map whose pixels may hold any value.
    pub fn read_unchecked(input: &Input) -> anyhow::Result<Source> {
        Self::with(input, environment::read_unchecked)
    }

    fn with(
        input: &Input,
        read: impl Fn(&Path) -> Result<ImageFile, environment::Error>,
    ) -> anyhow::Result<Source> {
        let path = &input.input;
        let (file, inputs) = match input.from {
            Some(Projection::Cube) if !path.exists() => faces(path, read)?,
            _ => (read(path)?, vec![path.clone()]),
        };
        let layout = file.layout(path, input.from, input.from_orientation)?;
        let normalisation = file.labels.get("ambakeNormalisation").cloned();
        Ok(Source {
            image: file.image,
            layout,
            normalisation,
            inputs,
        })
    }

    /// Texels on the equator.
    pub fn texels(&self) -> usize {
        self.layout.projection.texels(self.layout.size)
    }
}

/// `DIR/STEM_SUFFIX.ENDING` of `DIR/STEM.ENDING`.
fn suffixed(path: &Path, suffix: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{suffix}.{ending}"))
}

/// The files of the six faces of the cube `path`.
pub fn face_paths(path: &Path) -> anyhow::Result<[PathBuf; 6]> {
    let paths = FACES.map(|face| suffixed(path, face));
    match paths.iter().find(|path| !path.exists()) {
        None => Ok(paths),
        Some(missing) => bail!(
            "cube face {} is missing; a cube has the faces {}",
            missing.display(),
            FACES.join(", ")
        ),
    }
}

/// Reads photographs: as maps are read or, with a file of curves, by these.
pub fn photographs(
    response: Option<&Path>,
) -> anyhow::Result<impl Fn(&Path) -> Result<Image, environment::Error>> {
    let curves = response.map(maps::merge::read_curves).transpose()?;
    Ok(move |path: &Path| match &curves {
        None => environment::read(path).map(|file| file.image),
        Some(curves) => maps::merge::develop(path, curves),
    })
}

/// The six faces of a cube below each other.
fn faces(
    path: &Path,
    read: impl Fn(&Path) -> Result<ImageFile, environment::Error>,
) -> anyhow::Result<(ImageFile, Vec<PathBuf>)> {
    let paths = face_paths(path)?;
    let mut cube: Option<ImageFile> = None;
    for path in &paths {
        let file = read(path)?;
        let (width, height) = (file.image.width, file.image.height);
        if width != height {
            bail!(
                "{} is {width} x {height} pixels; a cube face is square",
                path.display()
            );
        }
        match &mut cube {
            None => cube = Some(file),
            Some(cube) if cube.image.width == width => {
                cube.image.pixels.extend(file.image.pixels);
                cube.image.height += height;
            }
            Some(cube) => bail!(
                "{} is {width} pixels wide, {} is {}; the faces of a cube have one size",
                path.display(),
                paths[0].display(),
                cube.image.width
            ),
        }
    }
    let cube = cube.with_context(|| format!("{} has no faces", path.display()))?;
    Ok((cube, paths.to_vec()))
}

/// The picture's size for a size that was typed: of one face for a cube.
pub fn picture_size(projection: Projection, [width, height]: [u32; 2]) -> (usize, usize) {
    let (width, height) = (width as usize, height as usize);
    match projection {
        Projection::Cube if width == height => (width, 6 * height),
        _ => (width, height),
    }
}

/// Where a map is written, and what it must not replace.
pub struct Target<'a> {
    pub path: &'a Path,
    /// The files that it is made from.
    pub inputs: &'a [PathBuf],
}

/// Writes pictures of one layout, each with its suffix where it has one; all of them or none.
pub fn write(
    target: &Target,
    images: &[(Option<String>, &Image)],
    layout: MapLayout,
    normalisation: &str,
) -> anyhow::Result<Vec<PathBuf>> {
    let planes: Vec<_> = images
        .iter()
        .map(|(s, image)| (s.as_deref(), *image, None))
        .collect();
    write_planes(target, &planes, layout, normalisation)
}

/// Writes one picture with a confidence for every texel.
pub fn write_with_confidence(
    target: &Target,
    image: &Image,
    confidence: &[f32],
    layout: MapLayout,
    normalisation: &str,
) -> anyhow::Result<Vec<PathBuf>> {
    write_planes(
        target,
        &[(None, image, Some(confidence))],
        layout,
        normalisation,
    )
}

/// A suffix, a picture and the confidence of its texels.
type Planes<'a> = (Option<&'a str>, &'a Image, Option<&'a [f32]>);

fn write_planes(
    target: &Target,
    images: &[Planes],
    layout: MapLayout,
    normalisation: &str,
) -> anyhow::Result<Vec<PathBuf>> {
    let path = target.path;
    let format = Format::of(path)?;
    let labels = labels(layout, normalisation);
    let mut output = Output::for_file(path)?;
    output.protect(target.inputs.iter().cloned());
    let mut stage =
        |path: &Path, image: &Image, confidence: Option<&[f32]>| -> anyhow::Result<()> {
            let bytes = environment::encode_with(
                image,
                confidence.map(|values| ("confidence", values)),
                format,
                &labels,
            )
            .with_context(|| path.display().to_string())?;
            let name = path.file_name().context("the output has no file name")?;
            Ok(output.stage_bytes(&name.to_string_lossy(), &bytes)?)
        };
    for (suffix, image, confidence) in images {
        let path = suffix.map_or(path.to_owned(), |suffix| suffixed(path, suffix));
        if layout.projection != Projection::Cube {
            stage(&path, image, *confidence)?;
            continue;
        }
        let n = image.width;
        for (k, (face, pixels)) in FACES
            .iter()
            .zip(image.pixels.chunks_exact(n * n))
            .enumerate()
        {
            let face_image = Image {
                width: n,
                height: n,
                pixels: pixels.to_vec(),
            };
            let part = confidence.map(|c| &c[k * n * n..(k + 1) * n * n]);
            stage(&suffixed(&path, face), &face_image, part)?;
        }
    }
    Ok(output.publish()?)
}

/// What the header says.
fn labels(layout: MapLayout, normalisation: &str) -> Labels {
    let axes = match layout.projection {
        Projection::Polar => {
            "row 0 looks up +y; u = atan2(x, z) with +z in the middle column, growing toward +x to the right"
        }
        Projection::Cube | Projection::Cross | Projection::Strip => {
            "faces +x -x +y -y +z -z as in OpenGL cube maps"
        }
        Projection::Ortho => "x to the right, y up; z >= 0 left, z < 0 right",
        Projection::Ball => {
            "mirrored sphere, +z in the middle, -z at the rim, x to the right, y up"
        }
        Projection::Angular => "angle from +z by radius, -z at the rim, x to the right, y up",
        Projection::Octahedral => "octahedron, +z in the middle, x to the right, y up",
    };
    let axes = match layout.orientation {
        Orientation::Ambake => axes.into(),
        other => format!("as {} looks it up", other.name()),
    };
    [
        ("ambakeVersion", crate::host::VERSION.into()),
        ("ambakeProjection", layout.projection.name().into()),
        ("ambakeOrientation", layout.orientation.name().into()),
        ("ambakeAxes", axes),
        ("ambakeNormalisation", normalisation.into()),
    ]
    .map(|(name, text): (&str, String)| (name.to_string(), text))
    .into()
}

/// Says which files were made from a map.
pub fn summary(
    common: &Common,
    input: &Path,
    source: &Source,
    written: &[PathBuf],
) -> anyhow::Result<()> {
    if common.json {
        return say_json(&json!({
            "schema_version": 1, "map": input, "projection": source.layout.projection.name(),
            "orientation": source.layout.orientation.name(), "files": written,
        }));
    }
    if common.quiet {
        return Ok(());
    }
    say(&written
        .iter()
        .map(|path| format!("wrote {}\n", path.display()))
        .collect::<String>())
}
