//! Reflection maps of places: what a mirror shows there, and rougher surfaces.

use crate::Error;
use crate::gather::{Gather, PAGE};
use ambient::sampling::Stream;
use environment::{IlluminationMap, Image, Projection, convert};
use glam::DVec3;
use layers::Progress;
use maps::{Lobe, Normalise, Request, convolve};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// A cube of what surfaces of one roughness reflect, by the mirror direction; the diffuse one by the normal.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Roughness, 0..=1; 0 for a mirror.
    pub roughness: f64,
    /// Six faces below each other as [`Projection::Cube`] has them, linear RGB.
    pub image: Image,
    /// Standard error of its values: root mean square over texels and channels.
    pub error: f64,
}

/// The reflection maps of a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflection {
    /// Where, in coordinates of the world.
    pub place: DVec3,
    /// From a mirror on, each half as wide, the last one of roughness 1.
    pub levels: Vec<Level>,
    /// E / π on a matt surface.
    pub diffuse: Level,
    /// How far surfaces are toward +x, -x, +y, -y, +z and -z; infinite where there are none.
    pub walls: [f64; 6],
}

/// Edge of the smallest level, and of the diffuse map.
pub const LEAST_EDGE: usize = 8;
const DIFFUSE_EDGE: usize = 16;

/// Rays of a texel in each of the two halves from which errors are told.
const RAYS: u32 = 8;

/// Stream label.
const CAPTURE: u32 = 9;

impl Gather<'_> {
    /// The reflection maps of a place from its [`capture`](Self::capture) by both halves of the rays. Each makes maps
    /// of its own. Their mean is kept, and what they differ by tells its error.
    ///
    /// # Panics
    /// For images that are no such cubes.
    pub fn reflection(&self, place: DVec3, halves: [Image; 2]) -> Reflection {
        let edge = halves[0].width;
        assert!(edge.is_power_of_two() && edge >= LEAST_EDGE, "edge {edge}");
        let count = (edge / LEAST_EDGE).ilog2() as usize + 1;
        let roughness = |level: usize| level as f64 / (count - 1).max(1) as f64;
        // Lobes are integrated on polar maps, along whose rows that is quick, with twice the texels of the cube.
        let polar = |lobe, edge: usize| Request {
            lobe,
            normalise: Normalise::Radiance,
            projection: Projection::Polar,
            size: (8 * edge, 4 * edge),
        };
        let rough = (1..count).map(|level| polar(Lobe::Ggx(roughness(level)), edge >> level));
        let requests: Vec<Request> = rough.chain([polar(Lobe::Lambert, DIFFUSE_EDGE)]).collect();
        let filtered = |half: Image| -> Result<Vec<Image>, maps::Error> {
            let half = IlluminationMap::new(half, Projection::Cube)?;
            let polar = convert(&half, Projection::Polar, Projection::Polar.size(4 * edge))?;
            let blurred = convolve(&polar, &requests)?;
            let edges = requests.iter().map(|request| request.size.0 / 8);
            let cubes = blurred.iter().zip(edges).map(|(map, edge)| cube(map, edge));
            Ok(std::iter::once(half.into_image()).chain(cubes).collect())
        };
        let maps = halves.map(|half| filtered(half).expect("sizes and lobes are sound"));
        let level = |k: usize| joined(&maps[0][k], &maps[1][k], roughness(k));
        let toward = [DVec3::X, DVec3::Y, DVec3::Z];
        Reflection {
            place,
            levels: (0..count).map(level).collect(),
            diffuse: Level {
                roughness: 1.0,
                ..level(count)
            },
            walls: std::array::from_fn(|side| {
                let axis = toward[side / 2] * if side % 2 == 0 { 1.0 } else { -1.0 };
                let hit = self
                    .backend
                    .closest(&self.ray(place.as_vec3().to_array(), axis));
                hit.map_or(f64::INFINITY, |hit| hit.t.into())
            }),
        }
    }

    /// The light that arrives, texel by texel of a face of a cube, by half of the rays. Lights that no ray meets have
    /// no picture and are left out: engines reflect them themselves. `progress` hears of texels.
    ///
    /// * `number`: labels the sample points, as `half`, 0 or 1, does.
    /// * `face`: of the six of [`Projection::Cube`].
    /// * `edge`: width of a face in texels, a power of two from [`LEAST_EDGE`] on.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn capture(
        &self,
        number: u32,
        [half, face]: [u32; 2],
        place: DVec3,
        edge: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<[f32; 3]>, Error> {
        let size = (edge, 6 * edge);
        let origin = place.as_vec3().to_array();
        let done = AtomicU64::new(0);
        let texel = |texel: usize| {
            let (x, y) = ((texel % edge) as f64, (texel / edge) as f64);
            let label = |term, replicate| {
                Stream::new(
                    self.seed ^ u64::from(number),
                    PAGE + 1,
                    texel as u32,
                    term,
                    replicate,
                )
            };
            let points = label(CAPTURE, half);
            let ray = |ray: u32| {
                let [u0, u1, ..] = points.point(ray);
                let shown = Projection::Cube.direction(size, x + u0, y + u1);
                let random = |term| label(CAPTURE + 1 + term, half + 2 * ray).point(0);
                self.radiance(origin, DVec3::from(shown.unwrap_or_default()), random)
            };
            let mean = (0..RAYS).map(ray).sum::<DVec3>() / f64::from(RAYS);
            mean.as_vec3().to_array()
        };
        let rows = face as usize * edge..(face as usize + 1) * edge;
        let rows = rows.into_par_iter().with_max_len(1).map(|row| {
            if progress.cancelled() {
                return None;
            }
            let pixels: Vec<[f32; 3]> = (row * edge..(row + 1) * edge).map(texel).collect();
            let before = done.fetch_add(edge as u64, Ordering::Relaxed);
            progress.advance(before + edge as u64, (edge * edge) as u64);
            Some(pixels)
        });
        let rows: Option<Vec<Vec<[f32; 3]>>> = rows.collect();
        Ok(rows.ok_or(Error::Cancelled)?.concat())
    }

    /// Radiance that arrives along a ray of this unit direction.
    fn radiance(
        &self,
        origin: [f32; 3],
        direction: DVec3,
        random: impl Fn(u32) -> [f64; 4],
    ) -> DVec3 {
        let (hit, tint) = self.met(origin, direction);
        tint * match hit {
            None => self.sky.radiance(direction),
            Some(hit) => self.surfaces.emission(&hit) + self.reflected(hit, direction, random),
        }
    }
}

/// A map looked up in the middles of a cube's texels.
fn cube(map: &IlluminationMap, edge: usize) -> Image {
    let size = (edge, 6 * edge);
    let texel = |texel: usize| {
        let (x, y) = ((texel % edge) as f64 + 0.5, (texel / edge) as f64 + 0.5);
        map.bilinear(Projection::Cube.direction(size, x, y).unwrap_or_default())
    };
    Image {
        width: size.0,
        height: size.1,
        pixels: (0..size.0 * size.1).map(texel).collect(),
    }
}

/// The mean of two halves, and its error by what they differ.
fn joined(a: &Image, b: &Image, roughness: f64) -> Level {
    let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
    let both = || a.pixels.iter().zip(&b.pixels);
    let square = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3)
            .map(|c| f64::from(0.5 * (a[c] - b[c])).powi(2))
            .sum::<f64>()
    };
    let count = 3.0 * a.pixels.len() as f64;
    Level {
        roughness,
        error: (both().map(square).sum::<f64>() / count).sqrt(),
        image: Image {
            width: a.width,
            height: a.height,
            pixels: both().map(mean).collect(),
        },
    }
}
