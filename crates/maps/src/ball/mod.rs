//! A photograph of a mirrored sphere to radiance by direction (section 4 of the 1984 text).
//!
//! The camera stands on the ball's axis, far away or at a distance in ball radii. The mirror direction of a point is exact;
//! its inverse is one equation in one unknown. Behind the ball lies a cone that no ray reaches: its half angle is
//! asin(1/d).

mod find;
mod gray;
mod optics;
#[cfg(test)]
mod tests;

pub use find::{Found, find};
pub use optics::Optics;

use crate::{Direction, Error, Image, Projection};
use rayon::prelude::*;

/// The outline of a ball, in pixels from the top left corner of the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Middle, to the right.
    pub x: f64,
    /// Middle, down.
    pub y: f64,
    /// Radius, above 0.
    pub radius: f64,
}

/// One photograph of a ball.
#[derive(Debug, Clone, Copy)]
pub struct Photo<'a> {
    /// The photograph, linear.
    pub image: &'a Image,
    /// The outline of the ball in it.
    pub circle: Circle,
    /// Direction from the ball to the camera, not along ±y; +y is upward in the photograph.
    pub from: Direction,
    /// The camera's distance.
    pub optics: Optics,
}

/// The surroundings as a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Unwrapped {
    /// Radiance; a texel that no photograph shows holds the mean over all directions that are seen.
    pub image: Image,
    /// 0 where nothing is seen, else the resolution relative to the middle of a ball, summed over the photographs.
    pub confidence: Vec<f32>,
    /// Solid angle that is seen, sr.
    pub seen: f64,
}

/// The map of `size` texels that the photographs show, divided by the ball's reflectance.
///
/// Several photographs are averaged with their resolution in the radial direction as weight: it falls to 0 toward the
/// rim, so bad borders give way. Texels are means over their solid angle, by as many samples as the photograph has pixels
/// there.
///
/// # Errors
/// [`Error::Shape`] for no photograph, a size that the projection cannot have, a circle that leaves its picture, a camera
/// along ±y or at a distance of at most 1, or a reflectance that is not above 0.
pub fn unwrap(
    photos: &[Photo],
    projection: Projection,
    size: (usize, usize),
    reflectance: [f64; 3],
) -> Result<Unwrapped, Error> {
    check(photos, reflectance)?;
    projection.check(size.0, size.1)?;
    let frames: Vec<[Direction; 3]> = photos.iter().map(|p| frame(p.from)).collect();
    let areas = projection.solid_angles(size);
    // Pixels by radian are densest in the middle of a ball; texels are widest where their solid angle is largest.
    let density = photos.iter().map(|p| p.circle.radius * p.optics.slope(0.0));
    let widest = areas.iter().copied().fold(0.0, f64::max).sqrt();
    let samples = (2.0 * density.fold(0.0, f64::max) * widest).ceil();
    let samples = samples.clamp(2.0, 16.0) as usize;
    let texel = |index: usize| {
        let (i, j) = (index % size.0, index / size.0);
        let (mut sum, mut weights, mut area) = ([0.0; 3], 0.0, 0.0);
        for k in 0..samples * samples {
            let part = |k: usize| (k as f64 + 0.5) / samples as f64;
            let (x, y) = (i as f64 + part(k % samples), j as f64 + part(k / samples));
            let weight = projection.density(size, x, y);
            area += weight;
            let Some(direction) = projection.direction(size, x, y) else {
                continue;
            };
            for (photo, frame) in photos.iter().zip(&frames) {
                if let Some((color, confidence)) = look(photo, frame, direction) {
                    weights += weight * confidence;
                    sum = std::array::from_fn(|c| sum[c] + weight * confidence * color[c]);
                }
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

/// Right, up and toward the camera.
fn frame(from: Direction) -> [Direction; 3] {
    let [x, y, z] = from;
    let length = (x * x + y * y + z * z).sqrt();
    let toward = from.map(|v| v / length);
    let flat = x.hypot(z);
    let right = [z / flat, 0.0, -x / flat];
    let up = [
        toward[1] * right[2] - toward[2] * right[1],
        toward[2] * right[0] - toward[0] * right[2],
        toward[0] * right[1] - toward[1] * right[0],
    ];
    [right, up, toward]
}

/// What a photograph shows in a direction and how well; `None` in the blind cone.
fn look(photo: &Photo, frame: &[Direction; 3], direction: Direction) -> Option<([f64; 3], f64)> {
    let dot = |a: &Direction| (0..3).map(|c| a[c] * direction[c]).sum::<f64>();
    let [x, y, z] = [dot(&frame[0]), dot(&frame[1]), dot(&frame[2])];
    let across = x.hypot(y);
    let alpha = photo.optics.point(across.atan2(z))?;
    // The outermost pixels are mixed with what stands behind the ball; the ring inside them takes their place.
    let inner = (photo.circle.radius - std::f64::consts::SQRT_2).max(0.0);
    let radius = (photo.circle.radius * photo.optics.radius(alpha)).min(inner);
    let (cos, sin) = if across > 0.0 {
        (x / across, y / across)
    } else {
        (1.0, 0.0)
    };
    let place = (photo.circle.x + radius * cos, photo.circle.y - radius * sin);
    let confidence = photo.optics.slope(alpha) / photo.optics.slope(0.0);
    Some((bilinear(photo.image, place), confidence))
}

/// Between the centres of four pixels.
fn bilinear(image: &Image, (x, y): (f64, f64)) -> [f64; 3] {
    let x = (x - 0.5).clamp(0.0, image.width as f64 - 1.0);
    let y = (y - 0.5).clamp(0.0, image.height as f64 - 1.0);
    let (i, j) = (x as usize, y as usize);
    let (fx, fy) = (x - i as f64, y - j as f64);
    let (right, low) = ((i + 1).min(image.width - 1), (j + 1).min(image.height - 1));
    let [a, b, c, d] = [
        image.at(i, j),
        image.at(right, j),
        image.at(i, low),
        image.at(right, low),
    ];
    std::array::from_fn(|k| {
        let top = f64::from(a[k]) * (1.0 - fx) + f64::from(b[k]) * fx;
        let bottom = f64::from(c[k]) * (1.0 - fx) + f64::from(d[k]) * fx;
        top * (1.0 - fy) + bottom * fy
    })
}

fn check(photos: &[Photo], reflectance: [f64; 3]) -> Result<(), Error> {
    let shape = |text: String| Err(Error::Shape(text));
    if photos.is_empty() {
        return shape("no photograph is given; name at least one".into());
    }
    if !reflectance.iter().all(|r| r.is_finite() && *r > 0.0) {
        return shape(format!(
            "a reflectance of {reflectance:?} cannot be divided out; give values above 0"
        ));
    }
    for (index, photo) in photos.iter().enumerate() {
        let (index, c) = (index + 1, photo.circle);
        let (w, h) = (photo.image.width as f64, photo.image.height as f64);
        // The outline may be off by a pixel.
        let inside =
            |middle: f64, side: f64| middle - c.radius >= -1.0 && middle + c.radius <= side + 1.0;
        let inside = c.radius > 0.0 && inside(c.x, w) && inside(c.y, h);
        if !inside {
            return shape(format!(
                "the circle {},{},{} of photograph {index} leaves its {w} x {h} pixels; correct --circle",
                c.x, c.y, c.radius
            ));
        }
        if let Optics::Near(d) = photo.optics
            && !(d > 1.0 && d.is_finite())
        {
            return shape(format!(
                "the camera of photograph {index} is {d} ball radii from the middle of the ball; it stands outside, give a --distance above 1"
            ));
        }
        let [x, y, z] = photo.from;
        if !(y.is_finite() && x.hypot(z).is_finite() && x.hypot(z) > 1e-9 * y.abs()) {
            return shape(format!(
                "the camera of photograph {index} is along {x},{y},{z}; give a direction that is not straight up or down"
            ));
        }
    }
    Ok(())
}
