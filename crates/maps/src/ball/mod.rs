//! A photograph of a mirrored sphere to radiance by direction (section 4 of the 1984 text).
//!
//! The camera stands on the ball's axis, far away or at a distance in ball radii. The mirror direction of a point is
//! exact; its inverse is one equation in one unknown. Behind the ball lies a cone that no ray reaches: its half angle
//! is asin(1/d).

mod blend;
#[cfg(test)]
mod blend_tests;
mod find;
mod gray;
mod optics;
mod photo;
#[cfg(test)]
mod tests;

pub use find::{Found, find};
pub use optics::Optics;
pub use photo::{Circle, Photo};

use crate::gains::Gains;
use blend::Views;
use environment::{Error, Image, Projection};
use rayon::prelude::*;

/// The surroundings as a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Unwrapped {
    /// Radiance; a texel that no photograph shows holds the mean over all directions that are seen.
    pub image: Image,
    /// 0 where nothing is seen, else the resolution of what is shown, relative to the middle of the finest ball, up to
    /// 1.
    pub confidence: Vec<f32>,
    /// Solid angle that is seen, sr.
    pub seen: f64,
}

/// What photographs of one ball are to be multiplied by, so that they agree where two of them see well.
///
/// # Errors
/// [`Error::Shape`] as [`unwrap`], or where some photograph shares too little with the others.
pub fn gains(photos: &[Photo]) -> Result<Gains, Error> {
    for (index, photo) in photos.iter().enumerate() {
        photo.check(index + 1)?;
    }
    Gains::of(photos.len(), &Views::of(photos).shared())
}

/// The map of `size` texels that the photographs show, divided by the ball's reflectance.
///
/// A direction comes from the photograph that resolves it best, its pixels a radian falling to 0 toward the rim; others
/// join within a fifth of that, so that seams are soft and a lamp at one ball's rim stays out of what another sees
/// well. Texels are means over their solid angle, in which directions that are seen better weigh more, by as many
/// samples as the photograph has pixels there.
///
/// ```
/// use environment::{Image, Projection};
/// use ambake_maps::ball::{Circle, Optics, Photo, unwrap};
/// // A ball of reflectance 1/2 in a white room.
/// let image = Image::filled(64, 64, [0.5; 3]);
/// let circle = Circle { x: 32.0, y: 32.0, radius: 30.0 };
/// let photo = Photo { image: &image, circle, from: [0.0, 0.0, 1.0], optics: Optics::Near(4.0) };
/// let room = unwrap(&[photo], Projection::Polar, (64, 32), [0.5; 3])?;
/// assert!(room.image.pixels.iter().all(|p| (p[0] - 1.0).abs() < 1e-6));
/// // The cone behind the ball is not seen: half angle asin(1/4), 1.6 % of the sphere.
/// assert!(room.confidence.contains(&0.0) && room.seen < 4.0 * std::f64::consts::PI);
/// # Ok::<(), environment::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for no photograph, a size that the projection cannot have, a circle that leaves its picture, a
/// camera along ±y or at a distance of at most 1, or a reflectance that is not above 0.
pub fn unwrap(
    photos: &[Photo],
    projection: Projection,
    size: (usize, usize),
    reflectance: [f64; 3],
) -> Result<Unwrapped, Error> {
    if photos.is_empty() {
        return Err(Error::Shape(
            "no photograph is given; name at least one".into(),
        ));
    }
    if !reflectance.iter().all(|r| r.is_finite() && *r > 0.0) {
        return Err(Error::Shape(format!(
            "a reflectance of {reflectance:?} cannot be divided out; give values above 0"
        )));
    }
    for (index, photo) in photos.iter().enumerate() {
        photo.check(index + 1)?;
    }
    projection.check(size.0, size.1)?;
    let views = Views::of(photos);
    let areas = projection.solid_angles(size);
    // Pixels by radian are densest in the middle of a ball; texels are widest where their solid angle is largest.
    let widest = areas.iter().copied().fold(0.0, f64::max).sqrt();
    let samples = (2.0 * views.finest * widest).ceil();
    let samples = samples.clamp(2.0, 16.0) as usize;
    let texel = |index: usize| {
        let (i, j) = (index % size.0, index / size.0);
        let (mut sum, mut weights, mut area) = ([0.0; 3], 0.0, 0.0);
        for k in 0..samples * samples {
            let part = |k: usize| (k as f64 + 0.5) / samples as f64;
            let (x, y) = (i as f64 + part(k % samples), j as f64 + part(k / samples));
            let weight = projection.density(size, x, y);
            area += weight;
            let direction = projection.direction(size, x, y);
            if let Some((color, confidence)) = direction.and_then(|d| views.look(d)) {
                weights += weight * confidence;
                sum = std::array::from_fn(|c| sum[c] + weight * confidence * color[c]);
            }
        }
        if weights > 0.0 {
            let value = |c: usize| (sum[c] / weights / reflectance[c]).min(f64::from(f32::MAX));
            (
                std::array::from_fn(|c| value(c) as f32),
                (weights / area) as f32,
            )
        } else {
            ([0.0; 3], 0.0)
        }
    };
    let texels: Vec<([f32; 3], f32)> = (0..size.0 * size.1).into_par_iter().map(texel).collect();
    let (mut seen, mut total) = (0.0, [0.0; 3]);
    for ((color, confidence), omega) in texels.iter().zip(&areas) {
        if *confidence > 0.0 {
            seen += omega;
            total = std::array::from_fn(|c| total[c] + omega * f64::from(color[c]));
        }
    }
    let fill = total.map(|v| if seen > 0.0 { (v / seen) as f32 } else { 0.0 });
    let pixel = |((color, c), omega): (&([f32; 3], f32), &f64)| match (*c > 0.0, *omega > 0.0) {
        (true, _) => *color,
        (false, true) => fill,
        // Beside a cross or a disc.
        (false, false) => [0.0; 3],
    };
    let image = Image {
        width: size.0,
        height: size.1,
        pixels: texels.iter().zip(&areas).map(pixel).collect(),
    };
    let confidence = texels.into_iter().map(|(_, c)| c).collect();
    Ok(Unwrapped {
        image,
        confidence,
        seen,
    })
}
