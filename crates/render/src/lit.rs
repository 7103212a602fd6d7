//! The lit scene of a bake whose pages come one after another: what a camera sees is found once, then each page adds
//! the light of its texels.

use crate::progress::each;
use crate::shown::Layer;
use crate::{Camera, Direct, Error, Sample, TexelPlace};
use environment::Image;
use glam::{DVec3, Vec2, Vec3};
use layers::Progress;
use rays::SurfaceHit;

/// Samples across a pixel in which surfaces end, for few would be pepper along joints.
const FINE: u32 = 4;

/// Texels from a pixel to the next one, at most, where one sample shows them.
const COARSE: f32 = 1.0;

/// The cosine between the normals of a surface that bends little, at least, and the sine of how far it climbs.
const ALIKE: f64 = 0.9;
const LEVEL: f64 = 0.3;

/// A picture that waits for its pages.
pub struct Lit {
    size: [u32; 2],
    /// The surfaces of every sample, front to back, one sample after another, and where each begins, with the end.
    seen: Vec<Seen>,
    samples: Vec<usize>,
    /// Where each pixel's samples begin, with the end.
    pixels: Vec<usize>,
}

/// A surface that a camera sample shows.
struct Seen {
    /// The share of the sample that it makes up.
    share: f32,
    /// What the surfaces before it leave of the channels for their mean.
    tint: Vec3,
    /// What is known of its radiance so far.
    radiance: Vec3,
    /// Where the rest stands; the page is [`Seen::KNOWN`] where nothing is missing.
    page: u32,
    uv: Vec2,
}

impl Seen {
    const KNOWN: u32 = u32::MAX;
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

    /// True where two samples meet the same surfaces: they bend little, and go on from one to the other.
    fn are_same(one: &[Face], other: &[Face]) -> bool {
        let pairs = || one.iter().zip(other);
        one.len() == other.len() && pairs().all(|(one, other)| Face::are_one(one, other))
    }

    fn are_one(one: &Face, other: &Face) -> bool {
        let way = other.place - one.place;
        one.instance == other.instance
            && one.normal.dot(other.normal) > ALIKE
            && way.dot(one.normal).abs() <= LEVEL * way.length()
    }
}

impl Lit {
    /// What a camera sees with one sample for each pixel amid a surface whose texels are no smaller than pixels, with a
    /// regular `grid` by `grid` of them elsewhere, and with more where surfaces end. What a see-through surface leaves
    /// shows what is behind it.
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
            let layers = direct.layers(&sample);
            let seen = layers.seen.into_iter().map(|Layer { hit, share, tint }| {
                let (radiance, place) = direct.beside_texels(&sample, &hit, place(&hit));
                let seen = Seen {
                    share,
                    tint,
                    radiance: radiance.as_vec3(),
                    page: place.map_or(Seen::KNOWN, |place| place.page),
                    uv: place.map_or(Vec2::ZERO, |place| place.uv),
                };
                (seen, Face::of(direct, &sample, &hit))
            });
            seen.unzip::<_, _, Vec<Seen>, Vec<Face>>()
        };
        let first = each(pixels, 0, progress, |pixel| sample(1, pixel, 0))?;
        let around = |pixel: usize| near(camera.size, pixel).map(|near| &first[near]);
        let is_one =
            |pixel: usize| around(pixel).all(|near| Face::are_same(&first[pixel].1, &near.1));
        // How far it is from pixel to pixel on the page, at most.
        let step = |own: &Seen, near: &Seen| (near.uv - own.uv).abs().max_element() * edge as f32;
        let has_texels = |pixel: usize| {
            let own = &first[pixel].0;
            let is_near =
                |(own, near): (&Seen, &Seen)| near.page == own.page && step(own, near) <= COARSE;
            own.iter().all(|seen| seen.page != Seen::KNOWN)
                && around(pixel).all(|(near, _)| own.iter().zip(near).all(is_near))
        };
        let wanted = |pixel: usize| match () {
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
        let mut lit = Lit {
            size: camera.size,
            seen: Vec::new(),
            samples: vec![0],
            pixels: vec![0],
        };
        for ((first, _), finer) in first.into_iter().zip(finer) {
            let samples = match finer.is_empty() {
                true => vec![first],
                false => finer,
            };
            for seen in samples {
                lit.seen.extend(seen);
                lit.samples.push(lit.seen.len());
            }
            lit.pixels.push(lit.samples.len() - 1);
        }
        Ok(lit)
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
        let pixel = |ends: &[usize]| {
            let (mut radiance, mut met) = (DVec3::ZERO, 0.0);
            let samples = &self.samples[ends[0]..=ends[1]];
            for ends in samples.windows(2) {
                let seen = &self.seen[ends[0]..ends[1]];
                let share: f32 = seen.iter().map(|seen| seen.share).sum();
                if share > 0.0 {
                    let light = |seen: &Seen| seen.share * seen.radiance * seen.tint;
                    let sum: Vec3 = seen.iter().map(light).sum();
                    radiance += f64::from(share) * shown(sum / share).as_dvec3();
                    met += f64::from(share);
                }
            }
            let all = (ends[1] - ends[0]) as f64;
            ((radiance / all).as_vec3().to_array(), (met / all) as f32)
        };
        let (pixels, alpha) = self.pixels.windows(2).map(pixel).unzip();
        let image = Image {
            width: self.size[0] as usize,
            height: self.size[1] as usize,
            pixels,
        };
        (image, alpha)
    }
}

/// A pixel and those beside and above it.
fn near(size: [u32; 2], pixel: usize) -> impl Iterator<Item = usize> {
    let [width, height] = size.map(|n| n as usize);
    let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let rows = around(pixel / width, height);
    rows.flat_map(move |y| around(pixel % width, width).map(move |x| y * width + x))
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

    /// What 16 pixels across show of sheets that stop this share of the light, one behind another.
    fn through(sheets: usize, share: f32, place: fn(&SurfaceHit) -> Option<TexelPlace>) -> Lit {
        let sheet = |k: usize| {
            let corner = Vec3::new(-32.0, -32.0, -1.0 - k as f32);
            [corner, Vec3::X * 64.0, Vec3::Y * 64.0]
        };
        let sheets: Vec<_> = (0..sheets).map(sheet).collect();
        let (world, backend) = see_through(&sheets, share);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = direct(&surfaces, backend.as_ref(), &lamps);
        let camera = Camera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, 1.0, [16; 2]).unwrap();
        Lit::look(&direct, &camera, 1, &(), 1, place).unwrap()
    }

    #[test]
    fn a_see_through_surface_covers_its_share_of_every_pixel() {
        for share in [0.125, 0.5] {
            let (_, alpha) = through(1, share, |_| None).picture(|radiance| radiance);
            assert_eq!(alpha, [share; 256]);
        }
    }

    #[test]
    fn panes_behind_one_another_are_laid_over_one_another() {
        let page = |hit: &SurfaceHit| {
            Some(TexelPlace {
                page: hit.instance,
                uv: Vec2::splat(0.5),
            })
        };
        let mut lit = through(3, 0.5, page);
        lit.add(0, 1, [&[1.0], &[0.0], &[0.0]]);
        lit.add(1, 1, [&[0.0], &[1.0], &[0.0]]);
        lit.add(2, 1, [&[0.0], &[0.0], &[1.0]]);
        let (picture, alpha) = lit.picture(|radiance| radiance);
        // Each stops half of what the ones before it leave.
        assert_eq!(alpha, [0.875; 256]);
        let off = |pixel: &[f32; 3]| (Vec3::from(*pixel) - Vec3::new(0.5, 0.25, 0.125)).abs();
        let off = picture.pixels.iter().map(|pixel| off(pixel).max_element());
        let off = off.fold(0.0, f32::max);
        // Divided by 7/8 to be shown and multiplied by it again: a rounding or two.
        assert!(off <= f32::EPSILON, "{off}");
        // A surface shown whole is one before which nothing is left of what it stops.
        let (_, alpha) = through(40, 0.5, page).picture(|radiance| radiance);
        assert_eq!(alpha, [1.0; 256]);
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
