//! Samples of a camera's pixels to a picture.

use crate::progress::each;
use crate::{Camera, Error};
use environment::Image;
use glam::DVec3;
use layers::Progress;

/// A ray through a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// `y * width + x` of its pixel.
    pub pixel: u32,
    /// Its number within the pixel, row by row from the top.
    pub number: u32,
    /// The camera's eye.
    pub eye: DVec3,
    /// Unit direction away from the eye.
    pub direction: DVec3,
}

impl Sample {
    /// A sample of a pixel's regular `grid` by `grid`.
    pub fn of(camera: &Camera, grid: u32, pixel: u32, number: u32) -> Sample {
        let width = camera.size[0];
        let place = |at: u32, step: u32| f64::from(at) + (f64::from(step) + 0.5) / f64::from(grid);
        let x = place(pixel % width, number % grid);
        let y = place(pixel / width, number / grid);
        Sample {
            pixel,
            number,
            eye: camera.eye,
            direction: camera.direction(x, y),
        }
    }
}

/// The picture whose pixels are means of `radiance` over a regular `grid` by `grid` of samples, a box filter.
///
/// Sums are per pixel in the order of the samples, so the picture does not depend on the number of threads.
///
/// `progress` hears of pixels.
///
/// # Errors
/// [`Error::Cancelled`].
///
/// # Panics
/// Where `grid` is 0.
pub fn picture(
    camera: &Camera,
    grid: u32,
    progress: &dyn Progress,
    radiance: impl Fn(&Sample) -> DVec3 + Sync,
) -> Result<Image, Error> {
    assert!(grid > 0, "a pixel has samples");
    let [width, height] = camera.size;
    let mean = |pixel: usize| {
        let sum: DVec3 = (0..grid * grid)
            .map(|number| radiance(&Sample::of(camera, grid, pixel as u32, number)))
            .sum();
        (sum / f64::from(grid * grid)).as_vec3().to_array()
    };
    let (width, height) = (width as usize, height as usize);
    Ok(Image {
        width,
        height,
        pixels: each(width * height, 1, progress, mean)?,
    })
}
