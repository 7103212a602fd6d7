//! A picture in memory.

use crate::Error;
use std::path::Path;

/// A picture of linear radiance, W·sr⁻¹·m⁻² up to one constant. Row 0 is the top; rows follow each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// `width * height` pixels as red, green, blue.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A picture of one colour.
    ///
    /// # Panics
    /// Where a side is 0.
    pub fn filled(width: usize, height: usize, color: [f32; 3]) -> Image {
        assert!(width > 0 && height > 0, "a picture of {width} x {height}");
        Image {
            width,
            height,
            pixels: vec![color; width * height],
        }
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// Outside the picture.
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        assert!(x < self.width, "column {x} of {}", self.width);
        self.pixels[y * self.width + x]
    }

    /// # Errors
    /// [`Error::Pixel`] with the first value that is NaN, infinite or negative. `path` is named in it.
    pub fn check(&self, path: &Path) -> Result<(), Error> {
        let sound = |v: &f32| v.is_finite() && *v >= 0.0;
        let Some(at) = self.pixels.iter().position(|p| !p.iter().all(sound)) else {
            return Ok(());
        };
        let channel = self.pixels[at].iter().position(|v| !sound(v)).unwrap_or(0);
        Err(Error::Pixel {
            path: path.to_owned(),
            x: at % self.width,
            y: at / self.width,
            channel: ["red", "green", "blue"][channel],
            value: self.pixels[at][channel],
        })
    }
}
