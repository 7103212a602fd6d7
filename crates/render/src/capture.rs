//! Illumination maps of simulated environments: G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984), 5.2.
//!
//! Six pictures of 90 degrees from the place of an object, on the faces of a cube; or the same rays sent straight
//! through the texels of another projection, which spares a resampling. Luminous surfaces are bright patches; every
//! other surface is a secondary source, shaded as [`Direct`] does. A light without extent has no picture: its energy
//! over the square of its distance goes into the texels about its direction.

use crate::progress::each;
use crate::{Direct, Error, Light, Sample};
use environment::{IlluminationMap, Image, Projection};
use glam::DVec3;
use layers::Progress;
use rays::Ray;

/// How a point light enters a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointForm {
    /// Energy over distance squared, divided by the texel's solid angle: the map's integral grows by E/d² whatever its
    /// size.
    Radiance,
    /// Energy over distance squared, added to the texel's value, as the text says. What it lights then depends on the
    /// size of the map.
    Raw,
}

/// The light that arrives at `at`, seen in every texel of a map; a [`Projection::Cube`] is the six pictures themselves.
///
/// Each texel is the mean over a `grid` by `grid` of its cells, weighed by their exact solid angles, so what is uniform
/// stays exactly so. Texels that show nothing are 0. The values do not depend on the number of threads. `progress`
/// hears of texels.
///
/// # Errors
/// [`environment::Error::Shape`] for a size that does not fit the projection; [`Error::Cancelled`].
///
/// # Panics
/// Where `grid` is 0.
pub fn capture(
    direct: &Direct<'_>,
    at: DVec3,
    projection: Projection,
    size: (usize, usize),
    grid: usize,
    progress: &dyn Progress,
) -> Result<IlluminationMap, Error> {
    assert!(grid > 0, "a texel has cells");
    projection.check(size.0, size.1)?;
    let cells = (size.0 * grid, size.1 * grid);
    let texel = |texel: usize| {
        let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
        for number in 0..grid * grid {
            let x = texel % size.0 * grid + number % grid;
            let y = texel / size.0 * grid + number / grid;
            let omega = projection.solid_angle(cells, x, y);
            if omega == 0.0 {
                continue;
            }
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            // The middle of a cell that a disc's rim cuts may lie outside.
            let direction = projection
                .direction(cells, x, y)
                .unwrap_or_else(|| projection.nearest_direction(cells, x, y));
            let sample = Sample {
                pixel: texel as u32,
                number: number as u32,
                eye: at,
                direction: direction.into(),
            };
            sum += omega * direct.radiance(&sample);
            whole += omega;
        }
        let mean = if whole > 0.0 { sum / whole } else { sum };
        mean.as_vec3().to_array()
    };
    let image = Image {
        width: size.0,
        height: size.1,
        pixels: each(size.0 * size.1, 1, progress, texel)?,
    };
    Ok(IlluminationMap::new(image, projection)?)
}

/// The map with the point lights of `direct` that nothing hides from `at`. Distant lights are left out.
///
/// A light is shared by the four texels around its direction, so that its mean direction is kept and what it lights
/// hardly depends on the size of the map.
///
/// # Errors
/// [`environment::Error::Shape`] for a light at `at` itself, or too near for a finite value.
pub fn add_points(
    map: IlluminationMap,
    direct: &Direct<'_>,
    at: DVec3,
    form: PointForm,
) -> Result<IlluminationMap, Error> {
    let (projection, size) = (map.projection(), map.size());
    let points = direct.lights.iter().filter_map(|light| match light {
        Light::Point { position, .. } => Some((*position, light.at(at, [0.5; 2]))),
        _ => None,
    });
    let mut added = Vec::new();
    for (position, arrival) in points {
        let fail = |problem: &str| {
            environment::Error::Shape(format!(
                "the point light at {position} {problem}; move it or --at"
            ))
        };
        if arrival.toward == DVec3::ZERO {
            return Err(fail("is where the map is captured").into());
        }
        let ray = Ray {
            origin: at.as_vec3().to_array(),
            direction: arrival.toward.as_vec3().to_array(),
            t_min: 0.0,
            t_max: arrival.distance as f32,
        };
        let passed = direct.surfaces.world().passed(direct.backend, &ray);
        if passed == DVec3::ZERO {
            continue;
        }
        for (texel, weight) in map.taps(arrival.toward.to_array()) {
            let omega = match form {
                PointForm::Radiance => projection.solid_angle(size, texel % size.0, texel / size.0),
                PointForm::Raw => 1.0,
            };
            if weight > 0.0 {
                let value = arrival.irradiance * (weight / omega) * passed;
                if !value.as_vec3().is_finite() {
                    return Err(fail("is too near").into());
                }
                added.push((texel, value));
            }
        }
    }
    let mut image = map.into_image();
    for (texel, value) in added {
        let pixel = &mut image.pixels[texel];
        *pixel = (DVec3::from(pixel.map(f64::from)) + value)
            .as_vec3()
            .to_array();
    }
    Ok(IlluminationMap::new(image, projection)?)
}
