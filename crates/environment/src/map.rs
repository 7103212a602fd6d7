//! Pictures with a projection: look-up by direction, energy, samples.

use crate::projection::{self, Direction, Projection};
use crate::{Error, Image};

/// Radiance from every direction: the picture I of the 1984 text.
///
/// ```
/// use ambake_environment::{IlluminationMap, Image, Projection};
/// let mut image = Image::filled(64, 32, [1.0; 3]);
/// image.pixels[..64 * 16].fill([3.0; 3]);
/// let map = IlluminationMap::new(image, Projection::Polar)?;
/// assert_eq!(map.nearest([0.0, 1.0, 0.0]), [3.0; 3]);
/// // On the horizon, between a texel of 3 and one of 1.
/// assert!((map.bilinear([0.6, 0.0, 0.8])[0] - 2.0).abs() < 1e-6);
/// // Radiance 3 over half of the sphere, 1 over the other.
/// assert!((map.integral()[0] / std::f64::consts::TAU - 4.0).abs() < 1e-12);
/// # Ok::<(), ambake_environment::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct IlluminationMap {
    image: Image,
    projection: Projection,
}

impl IlluminationMap {
    /// The picture as a map.
    ///
    /// # Errors
    /// [`Error::Shape`] where the picture cannot have this projection.
    ///
    /// # Panics
    /// Where the picture does not have `width * height` pixels.
    pub fn new(image: Image, projection: Projection) -> Result<Self, Error> {
        projection.check(image.width, image.height)?;
        assert_eq!(image.pixels.len(), image.width * image.height);
        Ok(Self { image, projection })
    }

    /// The picture.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The picture, taken out.
    pub fn into_image(self) -> Image {
        self.image
    }

    /// How directions are laid out in it.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        (self.image.width, self.image.height)
    }

    /// The texel that shows this direction of unit length.
    pub fn nearest(&self, direction: Direction) -> [f32; 3] {
        self.image.pixels[self.texel(direction)]
    }

    /// Bilinear interpolation between the centres of four texels, over seams, poles and edges.
    pub fn bilinear(&self, direction: Direction) -> [f32; 3] {
        let mut sum = [0.0f64; 3];
        for (texel, weight) in self.taps(direction) {
            let pixel = self.image.pixels[texel];
            sum = std::array::from_fn(|c| sum[c] + weight * f64::from(pixel[c]));
        }
        sum.map(|v| v as f32)
    }

    /// Index of the texel that shows this direction.
    pub fn texel(&self, direction: Direction) -> usize {
        texel(self.projection, self.size(), direction)
    }

    /// Up to four texels around a direction, with weights that add up to 1.
    pub fn taps(&self, direction: Direction) -> [(usize, f64); 4] {
        taps(self.projection, self.size(), direction)
    }

    /// ∫ I dω over the sphere by exact solid angles, red, green and blue.
    pub fn integral(&self) -> [f64; 3] {
        let size = self.size();
        let mut sum = [0.0; 3];
        for (j, row) in self.image.pixels.chunks_exact(size.0).enumerate() {
            let mut of_row = [0.0; 3];
            for (i, pixel) in row.iter().enumerate() {
                let omega = self.projection.solid_angle(size, i, j);
                of_row = std::array::from_fn(|c| of_row[c] + omega * f64::from(pixel[c]));
            }
            sum = std::array::from_fn(|c| sum[c] + of_row[c]);
        }
        sum
    }
}

/// Index of the texel that shows a direction.
pub(crate) fn texel(projection: Projection, size: (usize, usize), direction: Direction) -> usize {
    let (x, y) = projection.place(size, direction);
    let column = (x.max(0.0) as usize).min(size.0 - 1);
    let row = (y.max(0.0) as usize).min(size.1 - 1);
    row * size.0 + column
}

/// Up to four texels around a direction, with weights that add up to 1.
pub(crate) fn taps(
    projection: Projection,
    size: (usize, usize),
    direction: Direction,
) -> [(usize, f64); 4] {
    if let Projection::Cube | Projection::Cross | Projection::Strip = projection {
        return projection::cube_taps(projection, size, direction);
    }
    let (x, y) = projection.place(size, direction);
    let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (fx, fy) = (x - 0.5 - left, y - 0.5 - top);
    let (i, j) = (left as isize, top as isize);
    let mut taps = [
        (i, j, (1.0 - fx) * (1.0 - fy)),
        (i + 1, j, fx * (1.0 - fy)),
        (i, j + 1, (1.0 - fx) * fy),
        (i + 1, j + 1, fx * fy),
    ]
    .map(|(i, j, weight)| match projection.wrap(size, i, j) {
        Some(texel) => (texel, weight),
        None => (0, 0.0),
    });
    let total: f64 = taps.iter().map(|(_, weight)| weight).sum();
    if total < 1e-3 {
        // At the rim of a disc all four centres may lie outside.
        return [
            (texel(projection, size, direction), 1.0),
            (0, 0.0),
            (0, 0.0),
            (0, 0.0),
        ];
    }
    taps.iter_mut().for_each(|(_, weight)| *weight /= total);
    taps
}
