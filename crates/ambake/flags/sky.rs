//! `--sky`: a colour or an illumination map.

use super::parse::color;
use crate::error::Error;
use crate::sky::Sky;
use std::path::PathBuf;

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

impl SkyArg {
    /// The sky, its picture read.
    pub fn load(&self) -> Result<Sky, Error> {
        match self {
            Self::Uniform(radiance) => Ok(Sky::uniform(*radiance)),
            Self::File(path) => Sky::load(path),
        }
    }

    /// The file of its picture.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Uniform(_) => None,
            Self::File(path) => Some(path),
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
