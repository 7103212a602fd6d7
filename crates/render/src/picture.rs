//! Samples of a camera's pixels to a picture.

use crate::Camera;
use glam::DVec3;
use maps::Image;
use rayon::prelude::*;

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

/// The picture whose pixels are means of `radiance` over a regular `grid` by `grid` of samples, a box filter.
///
/// Sums are per pixel in the order of the samples, so the picture does not depend on the number of threads.
///
/// # Panics
/// Where `grid` is 0.
pub fn picture(camera: &Camera, grid: u32, radiance: impl Fn(&Sample) -> DVec3 + Sync) -> Image {
    assert!(grid > 0, "a pixel has samples");
    let [width, height] = camera.size;
    let pixels = (0..width * height)
        .into_par_iter()
        .with_min_len(16)
        .map(|pixel| {
            let place =
                |at: u32, step: u32| f64::from(at) + (f64::from(step) + 0.5) / f64::from(grid);
            let sum: DVec3 = (0..grid * grid)
                .map(|number| {
                    let x = place(pixel % width, number % grid);
                    let y = place(pixel / width, number / grid);
                    radiance(&Sample {
                        pixel,
                        number,
                        eye: camera.eye,
                        direction: camera.direction(x, y),
                    })
                })
                .sum();
            (sum / f64::from(grid * grid)).as_vec3().to_array()
        })
        .collect();
    Image {
        width: width as usize,
        height: height as usize,
        pixels,
    }
}
