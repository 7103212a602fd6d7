//! Pictures that are laid over others: section 1 of the 1984 text asks for objects matted into photographs.
//!
//! Alpha is the share of a pixel that shows the scene. Colours over black are multiplied by it already, so that
//! `picture + (1 - alpha) plate` is the object before the plate (T. Porter, T. Duff, "Compositing Digital Images",
//! SIGGRAPH 1984).

use crate::progress::each;
use crate::{Camera, Error, Sample};
use environment::Image;
use layers::Progress;

/// The share of each pixel that shows the scene, 0..=1: the mean `coverage` of the samples of [`crate::picture()`].
///
/// # Errors
/// [`Error::Cancelled`].
pub fn alpha(
    camera: &Camera,
    grid: u32,
    progress: &dyn Progress,
    coverage: impl Fn(&Sample) -> f32 + Sync,
) -> Result<Vec<f32>, Error> {
    let [width, height] = camera.size.map(|n| n as usize);
    each(width * height, 0, progress, |pixel| {
        let samples = (0..grid * grid).map(|k| Sample::of(camera, grid, pixel as u32, k));
        samples.map(|sample| coverage(&sample)).sum::<f32>() / (grid * grid) as f32
    })
}

/// Lays `picture`, which stands before black, over a plate of its size.
///
/// # Panics
/// Where the sizes differ.
pub fn over(picture: &mut Image, alpha: &[f32], plate: &Image) {
    let size = |image: &Image| (image.width, image.height);
    assert_eq!(size(picture), size(plate));
    let pixels = picture.pixels.iter_mut().zip(alpha).zip(&plate.pixels);
    for ((pixel, alpha), behind) in pixels {
        *pixel = [0, 1, 2].map(|c| pixel[c] + (1.0 - alpha) * behind[c]);
    }
}
