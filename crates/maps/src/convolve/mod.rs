//! Convolution of an illumination map with a lobe: the maps D and S of G. Miller, R. Hoffman (1984), section 6.
//!
//! A texel counts as an area of constant radiance, and the lobe is integrated over that area: a constant map comes out
//! constant at any size. Lobes act on spherical harmonics by one factor an order (Funk-Hecke); the cosine, whose series
//! converges slowly, is integrated in closed form along the rows of a polar map. Suns within one texel are summed
//! apart.

mod analysis;
mod cosine;
mod grid;
mod legendre;
mod lights;
mod lobe;
mod points;
mod rings;
mod synthesis;
#[cfg(test)]
mod tests;
mod tiles;

use crate::{Error, ReflectionMap};
use ambient::convention::VARNISH_1984;
use environment::{IlluminationMap, Image, Projection, convert};
use lights::Lights;
pub use lobe::{Lobe, Normalise};
use rayon::prelude::*;

/// A reflection map that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The reflectance function.
    pub lobe: Lobe,
    /// What the integral is multiplied by.
    pub normalise: Normalise,
    /// How directions are laid out in the result.
    pub projection: Projection,
    /// Width and height of the result in texels.
    pub size: (usize, usize),
}

/// The reflection maps of one illumination map. Values are those at the centres of texels; where a texel's centre shows
/// nothing they are 0. The result does not depend on the number of threads.
///
/// ```
/// use environment::{IlluminationMap, Image, Projection};
/// use ambake_maps::{Lobe, Normalise, Request, convolve};
/// let sky = IlluminationMap::new(Image::filled(64, 32, [1.0; 3]), Projection::Polar)?;
/// let (lobe, normalise) = (Lobe::Phong(50.0), Normalise::Radiance);
/// let request = Request { lobe, normalise, projection: Projection::Polar, size: (64, 32) };
/// let maps = convolve(&sky, &[request])?;
/// assert!(maps[0].image().pixels.iter().all(|p| (p[0] - 1.0).abs() < 1e-6));
/// # Ok::<(), ambake_maps::Error>(())
/// ```
///
/// # Errors
/// [`Error::Environment`] for a size that does not fit its projection, [`Error::Lobe`] for a lobe that is none.
pub fn convolve(map: &IlluminationMap, requests: &[Request]) -> Result<Vec<ReflectionMap>, Error> {
    let mut plans = Vec::new();
    for request in requests {
        request.projection.check(request.size.0, request.size.1)?;
        plans.push(Plan::of(map, request)?);
    }
    let lights = Lights::of(map);
    let areas = lights.as_ref().map_or(map, |(_, rest)| rest);
    let order = plans.iter().filter_map(Plan::order).max();
    let series = order.map(|order| analysis::analyse(areas, order));
    let results = requests.iter().zip(&plans).map(|(request, plan)| {
        let scale = request.lobe.scale(request.normalise);
        let mut image = match (plan, &series) {
            (Plan::Identity, _) => {
                return Ok(ReflectionMap::new(
                    mirror(map, request)?,
                    request.projection,
                )?);
            }
            (Plan::Cosine(power), _) => cosine::integrate(areas, request, *power, scale),
            (Plan::Points(power), _) => points::integrate(areas, request, *power, scale),
            (Plan::Series(zonal), Some(series)) => {
                let zonal: Vec<f64> = zonal.iter().map(|c| c * scale).collect();
                synthesis::synthesise(series, &zonal, request.projection, request.size)
            }
            (Plan::Series(_), None) => {
                unreachable!("a series is analysed where a plan asks for it")
            }
        };
        if let Some((lights, _)) = &lights {
            lights.add(request, scale, &mut image);
        }
        if let Lobe::Varnish(_) = request.lobe {
            let coat = mirror(map, request)?;
            for (sum, coat) in image.pixels.iter_mut().zip(&coat.pixels) {
                *sum = std::array::from_fn(|c| sum[c] + VARNISH_1984 as f32 * coat[c]);
            }
        }
        Ok(ReflectionMap::new(image, request.projection)?)
    });
    results.collect()
}

/// The diffuse map D for the cosine lobe in radiance normalisation: 1 under a constant map of 1.
///
/// ```
/// use environment::{IlluminationMap, Image, Projection};
/// use ambake_maps::diffuse;
/// // The upper half of the sky shines: 1 for a normal up, 1/2 for a level one, nearly 0 for one down.
/// let mut image = Image::filled(64, 32, [0.0; 3]);
/// image.pixels[..64 * 16].fill([1.0; 3]);
/// let d = diffuse(&IlluminationMap::new(image, Projection::Polar)?, (72, 36))?;
/// for (normal, exact) in [([0.0, 1.0, 0.0], 1.0), ([1.0, 0.0, 0.0], 0.5), ([0.0, -1.0, 0.0], 0.0)] {
///     let value = d.bilinear(normal)[0];
///     assert!((value - exact).abs() < 2e-3, "{normal:?}: {value}");
/// }
/// # Ok::<(), ambake_maps::Error>(())
/// ```
///
/// # Errors
/// As [`convolve`].
pub fn diffuse(map: &IlluminationMap, size: (usize, usize)) -> Result<ReflectionMap, Error> {
    one(map, Lobe::Lambert, size)
}

/// The specular map S for the lobe xⁿ in radiance normalisation: 1 under a constant map of 1.
///
/// ```
/// use environment::{IlluminationMap, Image, Projection};
/// use ambake_maps::specular;
/// let sky = IlluminationMap::new(Image::filled(64, 32, [0.5; 3]), Projection::Polar)?;
/// let s = specular(&sky, 50.0, (128, 64))?;
/// // Looked up by the mirror direction.
/// assert!((s.bilinear([0.6, 0.0, 0.8])[0] - 0.5).abs() < 1e-6);
/// # Ok::<(), ambake_maps::Error>(())
/// ```
///
/// # Errors
/// As [`convolve`].
pub fn specular(
    map: &IlluminationMap,
    exponent: f64,
    size: (usize, usize),
) -> Result<ReflectionMap, Error> {
    one(map, Lobe::Phong(exponent), size)
}

fn one(map: &IlluminationMap, lobe: Lobe, size: (usize, usize)) -> Result<ReflectionMap, Error> {
    let request = Request {
        lobe,
        normalise: Normalise::Radiance,
        projection: Projection::Polar,
        size,
    };
    Ok(convolve(map, &[request])?.remove(0))
}

/// How a request is answered.
enum Plan {
    /// S = I.
    Identity,
    /// Closed form along rows for x^0 or x^1 on the hemisphere.
    Cosine(u32),
    /// The same as a sum over small areas, for maps without rows.
    Points(u32),
    /// Zonal coefficients 2π ∫ k P_l, from order 0.
    Series(Vec<f64>),
}

/// Pairs of a texel and a result that are summed directly rather than left to the slow series of the cosine.
const MAX_PAIRS: usize = 100_000_000_000;

impl Plan {
    fn of(map: &IlluminationMap, request: &Request) -> Result<Plan, Error> {
        request.lobe.check()?;
        let power = match request.lobe {
            Lobe::Mirror => return Ok(Plan::Identity),
            Lobe::Lambert => Some(1),
            Lobe::Phong(n) | Lobe::Varnish(n) if n == 0.0 || n == 1.0 => Some(n as u32),
            _ => None,
        };
        let (width, height) = map.size();
        let pairs = width * height * request.size.0 * request.size.1;
        Ok(match power {
            Some(power) if map.projection() == Projection::Polar => Plan::Cosine(power),
            Some(power) if pairs <= MAX_PAIRS => Plan::Points(power),
            _ => Plan::Series(request.lobe.zonal()?),
        })
    }

    fn order(&self) -> Option<usize> {
        match self {
            Plan::Series(zonal) => Some(zonal.len() - 1),
            _ => None,
        }
    }
}

/// The map itself in the layout of a request: bit for bit where that is its own.
fn mirror(map: &IlluminationMap, request: &Request) -> Result<Image, Error> {
    if (map.projection(), map.size()) == (request.projection, request.size) {
        return Ok(map.image().clone());
    }
    Ok(convert(map, request.projection, request.size)?.into_image())
}

/// A picture from the value at each texel's centre; 0 where that shows nothing.
fn picture(request: &Request, value: impl Fn([f64; 3]) -> [f64; 3] + Sync) -> Image {
    let (width, height) = request.size;
    let pixel = |at: usize| {
        let (x, y) = ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        let direction = request.projection.direction(request.size, x, y);
        direction.map_or([0.0; 3], |d| value(d).map(|v| v as f32))
    };
    Image {
        width,
        height,
        pixels: (0..width * height).into_par_iter().map(pixel).collect(),
    }
}
