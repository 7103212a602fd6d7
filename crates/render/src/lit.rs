//! The lit scene of a bake whose pages come one after another: what a camera sees is found once, then each page adds the
//! light of its texels.

use crate::progress::each;
use crate::{Camera, Direct, Error, Sample, TexelPlace};
use glam::{DVec3, Vec2, Vec3};
use layers::Progress;
use maps::Image;
use rays::SurfaceHit;

/// A picture that waits for its pages.
pub struct Lit {
    size: [u32; 2],
    grid: u32,
    /// Every sample of a pixel after another, pixel by pixel.
    seen: Vec<Seen>,
}

/// What one camera sample shows.
struct Seen {
    /// What is known of its radiance so far.
    radiance: Vec3,
    /// Where the rest stands; the page is [`Seen::KNOWN`] where nothing is missing.
    page: u32,
    uv: Vec2,
}

impl Seen {
    const KNOWN: u32 = u32::MAX;
}

impl Lit {
    /// What a camera sees with a regular `grid` by `grid` of samples for each pixel.
    ///
    /// * `place`: where the texels of a hit lie; surfaces without any are integrated.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn look(
        direct: &Direct<'_>,
        camera: &Camera,
        grid: u32,
        progress: &dyn Progress,
        place: impl Fn(&SurfaceHit) -> Option<TexelPlace> + Sync,
    ) -> Result<Lit, Error> {
        let [width, height] = camera.size;
        let count = grid * grid;
        let look = |index: usize| {
            let sample = Sample::of(camera, grid, index as u32 / count, index as u32 % count);
            let (radiance, place) = direct.beside_texels(&sample, &place);
            Seen {
                radiance: radiance.as_vec3(),
                page: place.map_or(Seen::KNOWN, |place| place.page),
                uv: place.map_or(Vec2::ZERO, |place| place.uv),
            }
        };
        Ok(Lit {
            size: camera.size,
            grid,
            seen: each((width * height * count) as usize, 0, progress, look)?,
        })
    }

    /// Adds the light of a page of `edge * edge` texels, three planes, bilinear.
    pub fn add(&mut self, page: u32, edge: u32, planes: [&[f32]; 3]) {
        for seen in self.seen.iter_mut().filter(|seen| seen.page == page) {
            let place = TexelPlace { page, uv: seen.uv };
            seen.radiance += place.bilinear(edge, planes).as_vec3();
        }
    }

    /// The picture of all that came in, linear.
    pub fn picture(&self) -> Image {
        let count = (self.grid * self.grid) as usize;
        let mean = |samples: &[Seen]| {
            let sum: DVec3 = samples.iter().map(|seen| seen.radiance.as_dvec3()).sum();
            (sum / count as f64).as_vec3().to_array()
        };
        Image {
            width: self.size[0] as usize,
            height: self.size[1] as usize,
            pixels: self.seen.chunks_exact(count).map(mean).collect(),
        }
    }
}

/// The radiance behind the lit scene: a pale blue as bright as the sky's mean, so that white surfaces stand out.
pub fn backdrop(sky: DVec3) -> DVec3 {
    DVec3::new(0.5, 0.65, 0.85) * (sky.element_sum() / 3.0)
}

/// Whole stops by which a picture is brightened (or darkened) so that it can be seen: 0 where the median of its surfaces lies
/// between 0.08 and 1.2, otherwise what brings it near 0.3. Pixels that are exactly `background` do not count.
pub fn exposure(picture: &Image, background: DVec3) -> i32 {
    let background = background.as_vec3().to_array();
    let surfaces = picture.pixels.iter().filter(|pixel| **pixel != background);
    let mut bright: Vec<f32> = surfaces.map(|p| p[1].max(0.5 * (p[0] + p[2]))).collect();
    bright.sort_unstable_by(f32::total_cmp);
    match bright.get(bright.len() / 2) {
        Some(&median) if median > 1e-6 && !(0.08..=1.2).contains(&median) => {
            (0.3 / f64::from(median)).log2().round() as i32
        }
        _ => 0,
    }
}

/// A picture brightened by so many stops.
pub fn exposed(mut picture: Image, stops: f64) -> Image {
    let factor = stops.exp2() as f32;
    for value in picture.pixels.iter_mut().flatten() {
        *value *= factor;
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ground, world};
    use crate::{Lamps, Model};
    use rays::{Overrides, Surfaces};

    #[test]
    fn pages_light_what_they_hold_and_the_rest_is_integrated() {
        let (world, backend) = world(&[ground()]);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = Direct {
            surfaces: &surfaces,
            backend: backend.as_ref(),
            model: Model::Lambert,
            rays: 4,
            sky: DVec3::ONE,
            background: DVec3::splat(7.0),
            lights: &[],
            max_distance: f32::INFINITY,
            overrides: Overrides::default(),
            seed: 0,
            lamps: &lamps,
        };
        let eye = DVec3::new(0.0, 1.0, 0.0);
        let camera = Camera::new(eye, eye - DVec3::Z, DVec3::Y, 1.0, [4, 4]).unwrap();
        // Texels on the left; nothing on the right, where an open white ground under a sky of 1 is 1.
        let place = |hit: &SurfaceHit| {
            let x = world.corners(hit.instance, hit.triangle);
            let [b, c] = hit.barycentric.map(f64::from);
            let x = x[0].x * (1.0 - b - c) + x[1].x * b + x[2].x * c;
            (x < 0.0).then_some(TexelPlace {
                page: 1,
                uv: Vec2::splat(0.5),
            })
        };
        let mut lit = Lit::look(&direct, &camera, 2, &(), place).unwrap();
        lit.add(0, 1, [&[9.0], &[9.0], &[9.0]]);
        lit.add(1, 1, [&[0.25], &[0.5], &[0.75]]);
        let picture = lit.picture();
        assert_eq!(picture.pixels[0], [7.0; 3], "the sky");
        assert_eq!(picture.pixels[12], [0.25, 0.5, 0.75], "texels of page 1");
        assert_eq!(picture.pixels[15], [1.0; 3], "integrated");
    }

    #[test]
    fn only_pictures_that_cannot_be_seen_are_exposed_otherwise() {
        let picture = |value: f32| Image {
            width: 2,
            height: 1,
            pixels: vec![[value; 3], [1.0; 3]],
        };
        for (value, stops) in [(0.3, 0), (0.09, 0), (0.02, 4), (9.0, -5), (0.0, 0)] {
            assert_eq!(exposure(&picture(value), DVec3::ONE), stops, "{value}");
        }
    }
}
