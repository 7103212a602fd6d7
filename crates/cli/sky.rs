//! `--sky`: a colour or an illumination map.

use crate::args::color;
use ::bake::Sky;
use maps::SkyFile;
use serde_json::{Value, json};
use std::path::PathBuf;
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
            let SkyFile { name, hash, map } = maps::read_sky(path)?;
            let (width, height) = map.size();
            let described = json!({
                "file": name,
                "hash": hash,
                "size": [width, height],
                "mean": map.mean(),
            });
            Ok((Sky::Map(Arc::new(map)), described))
        }
    }
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
