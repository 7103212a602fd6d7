//! The lit scene of a bake whose pages come one after another: what a camera sees is found once, then each page adds
//! the light of its texels.

use crate::progress::each;
use crate::{Camera, Direct, Error, Sample, TexelPlace};
use glam::{DVec3, Vec2, Vec3};
use layers::Progress;
use maps::Image;
use rays::SurfaceHit;

/// Samples across a pixel where something see-through may stand: which rays it stops is told ray by ray, and few
/// would be pepper.
const FINE: u32 = 6;

/// A picture that waits for its pages.
pub struct Lit {
    size: [u32; 2],
    /// Every sample of a pixel after another, pixel by pixel, and where each pixel begins, with the end.
    seen: Vec<Seen>,
    starts: Vec<usize>,
}

/// What one camera sample shows.
struct Seen {
    /// What is known of its radiance so far.
    radiance: Vec3,
    /// Where the rest stands; the page is [`Seen::KNOWN`] where nothing is missing, and [`Seen::VOID`] where no
    /// surface is met.
    page: u32,
    uv: Vec2,
    /// Met something see-through.
    is_glass: bool,
}

impl Seen {
    const KNOWN: u32 = u32::MAX;
    const VOID: u32 = u32::MAX - 1;
}

impl Lit {
    /// What a camera sees with a regular `grid` by `grid` of samples for each pixel, and more about see-through
    /// surfaces.
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
        let [width, height] = camera.size.map(|n| n as usize);
        let pixels = width * height;
        let look = |grid: u32, pixel: usize| -> (Vec<Seen>, bool) {
            let mut is_glass = false;
            let samples = (0..grid * grid).map(|number| {
                let sample = Sample::of(camera, grid, pixel as u32, number);
                let Some(hit) = direct.hit(&sample) else {
                    return Seen {
                        radiance: Vec3::ZERO,
                        page: Seen::VOID,
                        uv: Vec2::ZERO,
                        is_glass: false,
                    };
                };
                let met_glass = direct.surfaces.is_see_through(hit.instance);
                is_glass |= met_glass;
                let (radiance, place) = direct.beside_texels(&sample, &hit, place(&hit));
                Seen {
                    radiance: radiance.as_vec3(),
                    page: place.map_or(Seen::KNOWN, |place| place.page),
                    uv: place.map_or(Vec2::ZERO, |place| place.uv),
                    is_glass: met_glass,
                }
            });
            (samples.collect(), is_glass)
        };
        let mut all = each(pixels, 0, progress, |pixel| look(grid, pixel))?;
        let is_glass: Vec<bool> = all.iter().map(|(_, is_glass)| *is_glass).collect();
        // Where all samples of a pixel went through it, one beside met it.
        let is_near = |pixel: &usize| {
            let around =
                |at: usize, end: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(end);
            let mut rows = around(pixel / width, height);
            rows.any(|y| around(pixel % width, width).any(|x| is_glass[y * width + x]))
        };
        let fine: Vec<usize> = (0..pixels)
            .filter(is_near)
            .filter(|_| grid < FINE)
            .collect();
        let finer = each(fine.len(), 0, progress, |k| look(FINE, fine[k]))?;
        for (pixel, seen) in fine.into_iter().zip(finer) {
            all[pixel] = seen;
        }
        let mut starts = vec![0];
        starts.extend(all.iter().scan(0, |end, (seen, _)| {
            *end += seen.len();
            Some(*end)
        }));
        let seen = all.into_iter().flat_map(|(seen, _)| seen).collect();
        Ok(Lit {
            size: camera.size,
            seen,
            starts,
        })
    }

    /// Adds the light of a page of `edge * edge` texels, three planes, bilinear.
    pub fn add(&mut self, page: u32, edge: u32, planes: [&[f32]; 3]) {
        for seen in self.seen.iter_mut().filter(|seen| seen.page == page) {
            let place = TexelPlace { page, uv: seen.uv };
            seen.radiance += place.bilinear(edge, planes).as_vec3();
        }
    }

    /// The picture of all that came in, linear and before black, and the share of each pixel that shows surfaces.
    pub fn picture(&self) -> (Image, Vec<f32>) {
        let shares: Vec<Share> = (0..self.starts.len() - 1)
            .map(|pixel| Share::of(self.samples(pixel)))
            .collect();
        let pixel = |pixel: usize| {
            let samples = self.samples(pixel);
            let share = self.share(&shares, pixel);
            // All samples count alike, but for how many met glass: the pixels around know that too.
            let (mut radiance, mut met) = (DVec3::ZERO, 0.0);
            for seen in samples {
                let weight = match seen.is_glass {
                    true => share / shares[pixel].met,
                    false => (1.0 - share) / (shares[pixel].all - shares[pixel].met),
                };
                radiance += weight * seen.radiance.as_dvec3();
                met += weight * f64::from(u8::from(seen.page != Seen::VOID));
            }
            (radiance.as_vec3().to_array(), met as f32)
        };
        let (pixels, alpha) = (0..shares.len()).map(pixel).unzip();
        let image = Image {
            width: self.size[0] as usize,
            height: self.size[1] as usize,
            pixels,
        };
        (image, alpha)
    }

    fn samples(&self, pixel: usize) -> &[Seen] {
        &self.seen[self.starts[pixel]..self.starts[pixel + 1]]
    }

    /// The share of a pixel's samples that glass stops: that of all pixels about it that differ from it by no more than
    /// chance may.
    fn share(&self, shares: &[Share], pixel: usize) -> f64 {
        let own = shares[pixel];
        if own.met == 0.0 || own.met == own.all {
            return own.met / own.all;
        }
        let [width, height] = self.size.map(|n| n as usize);
        let around = |at: usize, end: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(end);
        let rows = around(pixel / width, height);
        let near = rows.flat_map(|y| around(pixel % width, width).map(move |x| y * width + x));
        let alike = near
            .map(|at| shares[at])
            .filter(|other| own.is_like(*other));
        let (met, all) = alike.fold((0.0, 0.0), |(met, all), of| (met + of.met, all + of.all));
        met / all
    }
}

/// Pixels this far away tell that there may be glass, and how much of a pixel it stops.
const AROUND: usize = 2;

/// How many samples of a pixel met something see-through, and how many there are.
#[derive(Clone, Copy)]
struct Share {
    met: f64,
    all: f64,
}

impl Share {
    fn of(samples: &[Seen]) -> Self {
        Self {
            met: samples.iter().filter(|seen| seen.is_glass).count() as f64,
            all: samples.len() as f64,
        }
    }

    /// Whether both may be of one share: they differ by three standard deviations at most.
    fn is_like(self, other: Self) -> bool {
        let mean = (self.met + other.met) / (self.all + other.all);
        let variance = mean * (1.0 - mean) * (1.0 / self.all + 1.0 / other.all);
        (self.met / self.all - other.met / other.all).powi(2) <= 9.0 * variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lamps;
    use crate::fixture::{ground, see_through, world};
    use rays::{RayBackend, Surfaces};

    /// A matt scene under a sky of 1.
    fn direct<'a>(
        surfaces: &'a Surfaces<'a>,
        backend: &'a dyn RayBackend,
        lamps: &'a Lamps,
    ) -> Direct<'a> {
        Direct {
            rays: 4,
            ..Direct::new(surfaces, backend, lamps)
        }
    }

    #[test]
    fn pages_light_what_they_hold_and_the_rest_is_integrated() {
        let (world, backend) = world(&[ground()]);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = direct(&surfaces, backend.as_ref(), &lamps);
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
        let (picture, alpha) = lit.picture();
        assert_eq!((picture.pixels[0], alpha[0]), ([0.0; 3], 0.0), "the sky");
        assert_eq!((alpha[12], alpha[15]), (1.0, 1.0));
        assert_eq!(picture.pixels[12], [0.25, 0.5, 0.75], "texels of page 1");
        assert_eq!(picture.pixels[15], [1.0; 3], "integrated");
    }

    #[test]
    fn a_see_through_surface_is_no_pepper() {
        let sheet = [Vec3::new(-8.0, -8.0, -1.0), Vec3::X * 16.0, Vec3::Y * 16.0];
        let (world, backend) = see_through(sheet, 0.5);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = direct(&surfaces, backend.as_ref(), &lamps);
        let camera = Camera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, 1.0, [16, 16]).unwrap();
        let (_, alpha) = Lit::look(&direct, &camera, 1, &(), |_| None)
            .unwrap()
            .picture();
        // 36 rays of which half are stopped have a standard deviation of 0.083; nearly 25 pixels tell it together.
        let off = alpha.iter().map(|alpha| (alpha - 0.5).powi(2)).sum::<f32>();
        assert!((off / 256.0).sqrt() < 0.03, "{alpha:?}");
    }
}
