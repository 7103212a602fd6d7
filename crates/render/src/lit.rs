//! The lit scene of a bake whose pages come one after another: what a camera sees is found once, then each page adds
//! the light of its texels.

use crate::progress::each;
use crate::{Camera, Direct, Error, Sample, TexelPlace};
use environment::Image;
use glam::{DVec3, Vec2, Vec3};
use layers::Progress;
use rays::SurfaceHit;

/// Samples across a pixel in which surfaces end, for few would be pepper along joints, and across one in which
/// something see-through may stand: which rays it stops is told ray by ray.
const FINE: u32 = 4;
const FINEST: u32 = 6;

/// Texels from a pixel to the next one, at most, where one sample shows them.
const COARSE: f32 = 1.0;

/// The cosine between the normals of a surface that bends little, at least, and the sine of how far it climbs.
const ALIKE: f64 = 0.9;
const LEVEL: f64 = 0.3;

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

    const NOTHING: Seen = Seen {
        radiance: Vec3::ZERO,
        page: Seen::VOID,
        uv: Vec2::ZERO,
        is_glass: false,
    };
}

/// Where a camera sample meets a surface.
#[derive(Clone, Copy)]
struct Face {
    instance: u32,
    place: DVec3,
    normal: DVec3,
}

impl Face {
    fn of(direct: &Direct<'_>, sample: &Sample, hit: &SurfaceHit) -> Face {
        let world = direct.surfaces.world();
        let [a, b, c] = world.corners(hit.instance, hit.triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Face {
            instance: hit.instance,
            place: sample.eye + f64::from(hit.t) * sample.direction,
            normal: normal * -normal.dot(sample.direction).signum(),
        }
    }

    /// True where two samples meet one surface, or none: it bends little, and goes on from one to the other.
    fn are_one(one: Option<Face>, other: Option<Face>) -> bool {
        let (Some(one), Some(other)) = (one, other) else {
            return one.is_none() && other.is_none();
        };
        let way = other.place - one.place;
        one.instance == other.instance
            && one.normal.dot(other.normal) > ALIKE
            && way.dot(one.normal).abs() <= LEVEL * way.length()
    }
}

impl Lit {
    /// What a camera sees with one sample for each pixel amid a surface whose texels are no smaller than pixels, with a
    /// regular `grid` by `grid` of them elsewhere, and with more where surfaces end and about see-through ones.
    ///
    /// * `place`: where the texels of a hit lie, on pages of `edge * edge` texels; surfaces without any are integrated.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn look(
        direct: &Direct<'_>,
        camera: &Camera,
        grid: u32,
        progress: &dyn Progress,
        edge: u32,
        place: impl Fn(&SurfaceHit) -> Option<TexelPlace> + Sync,
    ) -> Result<Lit, Error> {
        let pixels: usize = camera.size.map(|n| n as usize).iter().product();
        let sample = |grid: u32, pixel: usize, number: u32| {
            let sample = Sample::of(camera, grid, pixel as u32, number);
            let Some(hit) = direct.hit(&sample) else {
                return (Seen::NOTHING, None);
            };
            let (radiance, place) = direct.beside_texels(&sample, &hit, place(&hit));
            let seen = Seen {
                radiance: radiance.as_vec3(),
                page: place.map_or(Seen::KNOWN, |place| place.page),
                uv: place.map_or(Vec2::ZERO, |place| place.uv),
                is_glass: direct.surfaces.is_see_through(hit.instance),
            };
            (seen, Some(Face::of(direct, &sample, &hit)))
        };
        let first = each(pixels, 0, progress, |pixel| sample(1, pixel, 0))?;
        let around = |pixel: usize| near(camera.size, pixel, 1).map(|near| &first[near]);
        let glass: Vec<bool> = first.iter().map(|(seen, _)| seen.is_glass).collect();
        let has_glass = glass.contains(&true);
        let is_by_glass = |pixel: usize| near(camera.size, pixel, TELLING).any(|at| glass[at]);
        let is_one = |pixel: usize| around(pixel).all(|near| Face::are_one(first[pixel].1, near.1));
        // How far it is from pixel to pixel on the page, at most.
        let has_texels = |pixel: usize| {
            let own = &first[pixel].0;
            let step = |near: &Seen| (near.uv - own.uv).abs().max_element() * edge as f32;
            let is_near = |near: &Seen| near.page == own.page && step(near) <= COARSE;
            own.page != Seen::KNOWN && around(pixel).all(|(near, _)| is_near(near))
        };
        let wanted = |pixel: usize| match () {
            () if has_glass && is_by_glass(pixel) => FINEST,
            () if !is_one(pixel) => FINE,
            () if has_texels(pixel) => 1,
            () => grid,
        };
        let wanted: Vec<u32> = each(pixels, 0, &(), wanted)?;
        let finer = each(pixels, 0, progress, |pixel| match wanted[pixel] {
            1 => Vec::new(),
            grid => (0..grid * grid)
                .map(|number| sample(grid, pixel, number).0)
                .collect(),
        })?;
        let (mut seen, mut starts) = (Vec::new(), vec![0]);
        for ((first, _), finer) in first.into_iter().zip(finer) {
            match finer.is_empty() {
                true => seen.push(first),
                false => seen.extend(finer),
            }
            starts.push(seen.len());
        }
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

    /// The picture of all that came in, before black, and the share of each pixel that shows surfaces. `shown` tells
    /// how the radiance of a sample is shown, so that one which is a hundred times as bright as those about it does not
    /// outshine them.
    pub fn picture(&self, shown: impl Fn(Vec3) -> Vec3) -> (Image, Vec<f32>) {
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
                radiance += weight * shown(seen.radiance).as_dvec3();
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
        let near = near(self.size, pixel, AROUND);
        let alike = near
            .map(|at| shares[at])
            .filter(|other| own.is_like(*other));
        let (met, all) = alike.fold((0.0, 0.0), |(met, all), of| (met + of.met, all + of.all));
        met / all
    }
}

/// Pixels this far away tell that there may be glass: of what stops a twentieth, one of their samples is met all but
/// surely.
const TELLING: usize = 4;

/// Pixels this far away tell how much of a pixel glass stops.
const AROUND: usize = 2;

/// A pixel and those no more than so many beside and above it.
fn near(size: [u32; 2], pixel: usize, most: usize) -> impl Iterator<Item = usize> {
    let [width, height] = size.map(|n| n as usize);
    let around = move |at: usize, end: usize| at.saturating_sub(most)..(at + most + 1).min(end);
    let rows = around(pixel / width, height);
    rows.flat_map(move |y| around(pixel % width, width).map(move |x| y * width + x))
}

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
    use crate::fixture::{Sheet, ground, see_through, white, world};
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
        let mut lit = Lit::look(&direct, &camera, 2, &(), 1, place).unwrap();
        lit.add(0, 1, [&[9.0], &[9.0], &[9.0]]);
        lit.add(1, 1, [&[0.25], &[0.5], &[0.75]]);
        let (picture, alpha) = lit.picture(|radiance| radiance);
        assert_eq!((picture.pixels[0], alpha[0]), ([0.0; 3], 0.0), "the sky");
        assert_eq!((alpha[12], alpha[15]), (1.0, 1.0));
        assert_eq!(picture.pixels[12], [0.25, 0.5, 0.75], "texels of page 1");
        assert_eq!(picture.pixels[15], [1.0; 3], "integrated");
    }

    /// What so many pixels across show of a sheet that stops this share of rays.
    fn through(share: f32, edge: u32) -> Lit {
        let sheet = [Vec3::new(-8.0, -8.0, -1.0), Vec3::X * 16.0, Vec3::Y * 16.0];
        let (world, backend) = see_through(sheet, share);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = direct(&surfaces, backend.as_ref(), &lamps);
        let camera = Camera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, 1.0, [edge; 2]).unwrap();
        Lit::look(&direct, &camera, 1, &(), 1, |_| None).unwrap()
    }

    #[test]
    fn a_see_through_surface_is_no_pepper() {
        let (_, alpha) = through(0.5, 16).picture(|radiance| radiance);
        // 36 rays of which half are stopped have a standard deviation of 0.083; nearly 25 pixels tell it together.
        let off = alpha.iter().map(|alpha| (alpha - 0.5).powi(2)).sum::<f32>();
        assert!((off / 256.0).sqrt() < 0.03, "{alpha:?}");
    }

    #[test]
    fn a_surface_that_stops_little_is_seen_all_over() {
        let lit = through(0.1, 32);
        // A pixel of one sample would show none of it.
        let few = lit.starts.windows(2).filter(|ends| ends[1] - ends[0] < 36);
        assert_eq!(few.count(), 0);
    }

    #[test]
    fn a_joint_is_a_faint_line_and_no_pepper() {
        // Two tiles, a fifth of a pixel apart along a line that leans by three in ten, over something that shines.
        let [along, wide] = [Vec3::new(30.0, 0.0, 100.0), Vec3::X * 50.0];
        let tile = |x: f32| white([Vec3::new(x, 0.0, -50.0), along, wide]);
        let bright = Sheet {
            emission: Vec3::splat(9.0),
            albedo: Vec3::ZERO,
            ..white([Vec3::new(-65.0, -0.01, -50.0), along, 2.0 * wide])
        };
        let (world, backend) = world(&[tile(-65.0), tile(-14.8), bright]);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = direct(&surfaces, backend.as_ref(), &lamps);
        let eye = DVec3::Y * 16.0;
        let fov = 2.0 * 0.5f64.atan();
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::NEG_Z, fov, [16, 16]).unwrap();
        let lit = Lit::look(&direct, &camera, 1, &(), 1, |_| None).unwrap();
        let (picture, _) = lit.picture(|radiance| radiance);
        // Sixteen samples of which a fifth is bright: 8 / 5 more than the tiles' 1, give or take a fourth of 8.
        for row in picture.pixels.chunks_exact(16) {
            let more: f32 = row.iter().map(|pixel| pixel[0] - 1.0).sum();
            assert!((0.0..4.0).contains(&more), "{more}: {row:?}");
        }
    }
}
