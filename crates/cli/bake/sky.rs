//! `--sky`: a colour or an illumination map.

use crate::map::args::Input;
use crate::map::file::Source;
use crate::parse::color;
use ::bake::Sky;
use anyhow::Context;
use maps::SkyMap;
use maps::{Layout, Orientation, Projection};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What was typed.
#[derive(Debug, Clone, PartialEq)]
pub enum SkyArg {
    /// R,G,B.
    Uniform([f32; 3]),
    /// A picture.
    File(PathBuf),
}

/// A colour where the text is made of numbers and commas, else a file.
pub fn sky(text: &str) -> Result<SkyArg, String> {
    let numbers = |part: &str| part.trim().is_empty() || part.trim().parse::<f64>().is_ok();
    if text.split(',').all(numbers) {
        color(text).map(SkyArg::Uniform)
    } else {
        Ok(SkyArg::File(text.into()))
    }
}

/// The sky, and what outputs say of it: everything that decides its values.
pub fn load(arg: &SkyArg) -> anyhow::Result<(Sky, Value)> {
    match arg {
        SkyArg::Uniform(sky) => Ok((Sky::Uniform(*sky), json!(sky))),
        SkyArg::File(path) => {
            let map = read(path)?;
            let (width, height) = map.size();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
            let described = json!({
                "file": name,
                "hash": blake3::hash(&bytes).to_hex().as_str(),
                "size": [width, height],
                "mean": map.mean(),
            });
            Ok((Sky::Map(Arc::new(map)), described))
        }
    }
}

/// The map in a file, made polar where it is not: with as many texels about the equator, its energy kept.
fn read(path: &Path) -> anyhow::Result<SkyMap> {
    let source = Source::read(&Input {
        input: path.to_owned(),
        from: None,
        from_orientation: None,
    })?;
    let polar = Layout {
        projection: Projection::Polar,
        orientation: Orientation::Ambake,
        size: match source.layout.projection {
            Projection::Polar => source.layout.size,
            _ => (source.texels(), source.texels().div_ceil(2)),
        },
    };
    let image = maps::convert_image(&source.image, source.layout, polar)
        .with_context(|| path.display().to_string())?;
    Ok(SkyMap::new(image.width, &image.pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_a_colour_and_words_a_file() {
        assert_eq!(sky("1,0.5,0"), Ok(SkyArg::Uniform([1.0, 0.5, 0.0])));
        assert_eq!(sky("room.hdr"), Ok(SkyArg::File("room.hdr".into())));
        assert_eq!(sky("a,b.exr"), Ok(SkyArg::File("a,b.exr".into())));
        for wrong in ["", "1", "1,2", "1,2,3,4", "1,2,-3", "1,2,nan"] {
            assert!(sky(wrong).is_err(), "{wrong}");
        }
    }
}
