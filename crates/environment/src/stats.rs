//! What a map holds in numbers, sound or not.

use crate::{Direction, Error, Image, Projection};

/// Figures of a map, weighed by exact solid angles. Texels that show nothing of the sphere do not count, and neither do
/// those with a value that is NaN or infinite, but for their number.
#[derive(Debug, Clone, PartialEq)]
pub struct MapStats {
    /// Mean radiance, red, green and blue.
    pub mean: [f64; 3],
    /// ∫ I dω, radiance times sr.
    pub integral: [f64; 3],
    /// Solid angle of all that counts, in sr; 4π where every value is finite.
    pub solid_angle: f64,
    /// The largest value of any channel.
    pub maximum: f32,
    /// Column and row of the first texel that holds it.
    pub maximum_at: [usize; 2],
    /// The direction in the middle of that texel; `None` where a disc's rim cuts it and the middle lies outside.
    pub maximum_direction: Option<Direction>,
    /// The least value of any channel.
    pub minimum: f32,
    /// Texels with a value that is NaN or infinite.
    pub non_finite: u64,
    /// Texels with a finite value below 0, which is no radiance.
    pub negative: u64,
}

impl MapStats {
    /// The figures of a picture in this projection; its values may be any.
    ///
    /// # Errors
    /// [`Error::Shape`] for a picture that cannot have this projection, and where no texel is finite.
    pub fn of(image: &Image, projection: Projection) -> Result<MapStats, Error> {
        let size = (image.width, image.height);
        projection.check(size.0, size.1)?;
        let (mut integral, mut solid_angle) = ([0.0; 3], 0.0);
        let (mut maximum, mut place) = (f32::NEG_INFINITY, [0, 0]);
        let (mut minimum, mut non_finite, mut negative) = (f32::INFINITY, 0, 0);
        for (at, pixel) in image.pixels.iter().enumerate() {
            let (x, y) = (at % size.0, at / size.0);
            let omega = projection.solid_angle(size, x, y);
            if omega == 0.0 {
                continue;
            }
            if !pixel.iter().all(|v| v.is_finite()) {
                non_finite += 1;
                continue;
            }
            negative += u64::from(pixel.iter().any(|v| *v < 0.0));
            solid_angle += omega;
            integral = std::array::from_fn(|c| integral[c] + omega * f64::from(pixel[c]));
            let largest = pixel.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            minimum = pixel.iter().copied().fold(minimum, f32::min);
            if largest > maximum {
                (maximum, place) = (largest, [x, y]);
            }
        }
        if solid_angle == 0.0 {
            return Err(Error::Shape(
                "no pixel is finite; repair the picture".into(),
            ));
        }
        let [x, y] = place.map(|k| k as f64 + 0.5);
        Ok(MapStats {
            mean: integral.map(|v| v / solid_angle),
            integral,
            solid_angle,
            maximum,
            maximum_at: place,
            maximum_direction: projection.direction(size, x, y),
            minimum,
            non_finite,
            negative,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_constant_map_has_its_value_as_mean_and_four_pi_of_it_as_integral() {
        for projection in Projection::all() {
            let (width, height) = projection.size(32);
            let image = Image::filled(width, height, [0.5, 1.0, 2.0]);
            let stats = MapStats::of(&image, projection).unwrap();
            for (c, value) in [0.5, 1.0, 2.0].into_iter().enumerate() {
                // Some hundred solid angles are added, each rounded.
                let (mean, integral) = (stats.mean[c], stats.integral[c]);
                assert!((mean - value).abs() < 1e-12, "{projection:?}: {mean}");
                let exact = 4.0 * PI * value;
                assert!(
                    (integral - exact).abs() < 1e-9,
                    "{projection:?}: {integral} for {exact}"
                );
            }
            assert_eq!((stats.maximum, stats.minimum), (2.0, 0.5), "{projection:?}");
        }
    }

    #[test]
    fn unsound_texels_are_counted_and_left_out() {
        let mut image = Image::filled(8, 4, [1.0; 3]);
        image.pixels[3] = [f32::NAN, 1.0, 1.0];
        image.pixels[4] = [1.0, f32::INFINITY, 1.0];
        image.pixels[13] = [1.0, -2.0, 7.0];
        let stats = MapStats::of(&image, Projection::Polar).unwrap();
        assert_eq!((stats.non_finite, stats.negative), (2, 1));
        assert_eq!((stats.maximum, stats.minimum), (7.0, -2.0));
        assert_eq!(stats.maximum_at, [5, 1]);
        let gap = 2.0 * Projection::Polar.solid_angle((8, 4), 0, 0);
        let area = stats.solid_angle;
        assert!((area - (4.0 * PI - gap)).abs() < 1e-12, "{area}");
        let none = Image::filled(8, 4, [f32::NAN; 3]);
        let error = MapStats::of(&none, Projection::Polar).unwrap_err();
        assert!(error.to_string().contains("no pixel is finite"), "{error}");
    }
}
