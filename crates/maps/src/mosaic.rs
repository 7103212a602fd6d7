//! Six photographs of an environment to one cube without seams: section 5.1 (1) of the 1984 text.
//!
//! The camera stands still and looks along the six axes. Its field of view is 90 degrees or more; what is more is shown
//! by two or three photographs, which tells their gains, and there they fade into each other.

use crate::gains::{Both, Gains};
use environment::cube::{meet, on_face, on_plane};
use environment::{Direction, Error, Image};
use rayon::prelude::*;

/// The cube, and what was corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Mosaic {
    /// The faces below each other, as [`environment::Projection::Cube`] has them.
    pub image: Image,
    /// What the photographs were multiplied by.
    pub gains: Gains,
}

/// Samples of a texel in each direction.
const SAMPLES: usize = 2;

/// The cube that six square photographs show, toward +x, -x, +y, -y, +z and -z, each with the axes of that face of a
/// cube.
///
/// * `fov`: what a photograph spans from side to side, in radians, from π/2 below π. At π/2 the photographs touch:
///   gains are told from their outermost pixels, and nothing fades.
/// * `equal`: find the gains and undo them.
///
/// # Errors
/// [`Error::Shape`] for photographs that are not square or of different sizes, another field of view, or photographs
/// that are too dark to tell their gains.
pub fn mosaic(photos: &[Image; 6], fov: f64, equal: bool) -> Result<Mosaic, Error> {
    let side = photos[0].width;
    for (number, photo) in photos.iter().enumerate() {
        if (photo.width, photo.height) != (side, side) {
            return Err(Error::Shape(format!(
                "photograph {} is {} x {} pixels; six squares of one size belong together, crop them alike",
                number + 1,
                photo.width,
                photo.height
            )));
        }
    }
    let wide = (0.5 * fov).tan();
    // Half of 90 degrees has a tangent just below 1.
    let whole = fov.is_finite() && fov < std::f64::consts::PI && wide > 1.0 - 1e-9;
    if !whole {
        return Err(Error::Shape(format!(
            "six photographs of {} degrees do not show everything; \
             their field of view is 90 degrees or more, below 180",
            fov.to_degrees()
        )));
    }
    let views = Views {
        photos,
        wide: wide.max(1.0),
    };
    let gains = match equal {
        true => Gains::of(6, &views.shared())?,
        false => Gains::none(6),
    };
    // As fine as the photographs are in their middle.
    let edge = ((side as f64 / views.wide).round() as usize).max(1);
    let texel = |at: usize| {
        let (x, y) = (at % edge, at / edge % edge);
        let mut sum = [0.0; 3];
        for k in 0..SAMPLES * SAMPLES {
            let place = |at: usize, k: usize| {
                2.0 * (at as f64 + (k as f64 + 0.5) / SAMPLES as f64) / edge as f64 - 1.0
            };
            let [s, t] = [place(x, k % SAMPLES), place(y, k / SAMPLES)];
            let value = views.look(on_face(at / (edge * edge), s, t), &gains);
            sum = std::array::from_fn(|c| sum[c] + value[c]);
        }
        sum.map(|v| (v / (SAMPLES * SAMPLES) as f64).min(f64::from(f32::MAX)) as f32)
    };
    let pixels = (0..6 * edge * edge).into_par_iter().map(texel).collect();
    Ok(Mosaic {
        image: Image {
            width: edge,
            height: 6 * edge,
            pixels,
        },
        gains,
    })
}

/// The photographs, and the tangent of half their field of view.
struct Views<'a> {
    photos: &'a [Image; 6],
    wide: f64,
}

impl Views<'_> {
    /// What the photographs show together in a direction.
    fn look(&self, direction: Direction, gains: &Gains) -> [f64; 3] {
        let own = meet(direction).0;
        let (mut sum, mut shares) = ([0.0; 3], 0.0);
        for photo in 0..6 {
            let Some(place) = self.place(photo, direction) else {
                continue;
            };
            let share = match self.wide > 1.0 {
                true => self.share(place),
                false => f64::from(u8::from(photo == own)),
            };
            if share > 0.0 {
                let value = self.at(photo, place);
                let factors = gains.factors[photo];
                sum = std::array::from_fn(|c| sum[c] + share * factors[c] * value[c]);
                shares += share;
            }
        }
        sum.map(|v| v / shares)
    }

    /// What a photograph counts at a place: 1 where no other shows it, 0 at its rim, smooth between.
    fn share(&self, [s, t]: [f64; 2]) -> f64 {
        let out = s.abs().max(t.abs());
        let part = (self.wide - out) / (self.wide - 1.0 / self.wide);
        let part = part.clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    }

    /// The place of a direction on the plane of a photograph that shows it.
    fn place(&self, photo: usize, direction: Direction) -> Option<[f64; 2]> {
        let place = on_plane(photo, direction)?;
        let most = self.wide + 1e-9;
        place.iter().all(|v| v.abs() <= most).then_some(place)
    }

    /// The value at a place, between the centres of four pixels.
    fn at(&self, photo: usize, place: [f64; 2]) -> [f64; 3] {
        let image = &self.photos[photo];
        let last = image.width - 1;
        let along = |v: f64| {
            let at = 0.5 * (v / self.wide + 1.0) * image.width as f64 - 0.5;
            let at = at.clamp(0.0, last as f64);
            (at as usize, at - at.floor())
        };
        let ((x, fx), (y, fy)) = (along(place[0]), along(place[1]));
        let (right, low) = ((x + 1).min(last), (y + 1).min(last));
        let corners = [
            (x, y, (1.0 - fx) * (1.0 - fy)),
            (right, y, fx * (1.0 - fy)),
            (x, low, (1.0 - fx) * fy),
            (right, low, fx * fy),
        ];
        corners.iter().fold([0.0; 3], |sum, &(x, y, share)| {
            let value = image.at(x, y);
            std::array::from_fn(|c| sum[c] + share * f64::from(value[c]))
        })
    }

    /// Directions that two photographs show: through the pixels of each that another shows too; where they only touch,
    /// on the edge beside the outermost pixels.
    fn shared(&self) -> Vec<Both> {
        let side = self.photos[0].width;
        let touch = self.wide == 1.0;
        let pixel = |at: usize| {
            let (photo, x, y) = (at / (side * side), at % side, at / side % side);
            let place = |k: usize| self.wide * (2.0 * (k as f64 + 0.5) / side as f64 - 1.0);
            let mut place = [place(x), place(y)];
            let rim = [x, y].map(|k| k == 0 || k == side - 1);
            if touch {
                // Corners belong to three.
                if rim[0] == rim[1] {
                    return Vec::new();
                }
                let across = usize::from(rim[1]);
                place[across] = place[across].signum();
            } else if place.iter().all(|v| v.abs() * self.wide < 1.0) {
                return Vec::new();
            }
            let direction = on_face(photo, place[0], place[1]);
            let others = (photo + 1..6).filter_map(|other| {
                let there = self.place(other, direction)?;
                Some(Both {
                    photos: [photo, other],
                    values: [self.at(photo, place), self.at(other, there)],
                })
            });
            others.collect()
        };
        let pixels = (0..6 * side * side).into_par_iter();
        pixels.flat_map_iter(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use environment::Projection;

    /// A sky with clouds and a bright patch, in three colours.
    fn sky([x, y, z]: Direction) -> [f64; 3] {
        let clouds = 1.0 + 0.3 * (9.0 * x + 2.0 * z).sin() * (7.0 * y - 3.0 * z).cos();
        let sun = 20.0 * (40.0 * (0.6 * x + 0.64 * y + 0.48 * z - 1.0)).exp();
        [0.4, 0.6, 1.0].map(|c| c * clouds * (1.2 + y) + sun)
    }

    /// Numbers of a sequence that looks like chance, about normal with deviation 1.
    fn noise(seed: &mut u64) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            *seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            sum += (*seed >> 11) as f64 / (1u64 << 53) as f64;
        }
        sum
    }

    /// Six photographs with gains and relative noise.
    fn taken(side: usize, fov: f64, gains: &[[f64; 3]; 6], grain: f64, seed: u64) -> [Image; 6] {
        let mut seed = seed;
        let wide = (0.5 * fov).tan();
        std::array::from_fn(|photo| {
            let mut image = Image::filled(side, side, [0.0; 3]);
            for (at, pixel) in image.pixels.iter_mut().enumerate() {
                let place = |k: usize| wide * (2.0 * (k as f64 + 0.5) / side as f64 - 1.0);
                let value = sky(on_face(photo, place(at % side), place(at / side)));
                *pixel = std::array::from_fn(|c| {
                    let noisy = value[c] * gains[photo][c] * (1.0 + grain * noise(&mut seed));
                    noisy.max(0.0) as f32
                });
            }
            image
        })
    }

    /// Gains of a fifth, up and down.
    fn uneven(seed: u64) -> [[f64; 3]; 6] {
        let mut seed = seed;
        [(); 6].map(|()| [(); 3].map(|()| (0.2 * noise(&mut seed)).exp()))
    }

    /// Factor times gain over the geometric mean of the gains, as logarithms: 0 where the gains are undone.
    fn left(found: &Gains, gains: &[[f64; 3]; 6]) -> Vec<[f64; 3]> {
        let mean: [f64; 3] =
            std::array::from_fn(|c| gains.iter().map(|g| g[c].ln()).sum::<f64>() / 6.0);
        let photo =
            |k: usize| std::array::from_fn(|c| (found.factors[k][c] * gains[k][c]).ln() - mean[c]);
        (0..6).map(photo).collect()
    }

    #[test]
    fn gains_are_found_within_their_stated_errors() {
        let fov = 100f64.to_radians();
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 0..6 {
            let gains = uneven(seed);
            let photos = taken(96, fov, &gains, 0.02, 77 + seed);
            let found = mosaic(&photos, fov, true).unwrap().gains;
            for (photo, off) in left(&found, &gains).iter().enumerate() {
                for c in 0..3 {
                    assert!(off[c].abs() < 0.002, "{photo} {c}: {off:?}");
                    squares += (off[c] / found.std_err[photo][c]).powi(2);
                    count += 1.0;
                }
            }
        }
        let ratio = f64::sqrt(squares / count);
        println!("off by {ratio:.2} of what is stated");
        assert!((0.5..1.5).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_mosaic_of_uneven_photographs_is_the_sky_without_an_edge() {
        let fov = 100f64.to_radians();
        let gains = uneven(3);
        let photos = taken(128, fov, &gains, 0.0, 1);
        let worst = |equal: bool| {
            let found = mosaic(&photos, fov, equal).unwrap();
            let size = (found.image.width, found.image.height);
            let mut worst = 0.0_f64;
            for (at, pixel) in found.image.pixels.iter().enumerate() {
                let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
                let exact = sky(Projection::Cube.direction(size, x, y).unwrap());
                for c in 0..3 {
                    let mean = gains.iter().map(|g| g[c].ln()).sum::<f64>() / 6.0;
                    let off = f64::from(pixel[c]) / (exact[c] * mean.exp()) - 1.0;
                    worst = worst.max(off.abs());
                }
            }
            worst
        };
        let (before, after) = (worst(false), worst(true));
        println!("the worst texel is off by {before:.4} before, {after:.5} after");
        // What interpolation between pixels of 1.1 degrees makes of the patch.
        assert!(before > 0.2 && after < 0.01, "{before} {after}");
    }

    #[test]
    fn equal_photographs_stay_as_they_are_and_odd_ones_are_refused() {
        let one = Image::filled(16, 16, [0.25, 0.5, 2.0]);
        let same: [Image; 6] = std::array::from_fn(|_| one.clone());
        for degrees in [90.0_f64, 120.0] {
            let found = mosaic(&same, degrees.to_radians(), true).unwrap();
            assert!(
                found
                    .gains
                    .factors
                    .iter()
                    .flatten()
                    .all(|f| (f - 1.0).abs() < 1e-12)
            );
            let even = |p: &[f32; 3]| (p[2] - 2.0).abs() < 1e-6 && (p[0] - 0.25).abs() < 1e-6;
            assert!(found.image.pixels.iter().all(even));
        }
        let text = |photos: &[Image; 6], degrees: f64| {
            mosaic(photos, degrees.to_radians(), true)
                .unwrap_err()
                .to_string()
        };
        assert!(text(&same, 80.0).contains("90 degrees"));
        let mut odd = same.clone();
        odd[2] = Image::filled(16, 8, [1.0; 3]);
        assert!(text(&odd, 90.0).contains("photograph 3 is 16 x 8"));
        odd[2] = Image::filled(16, 16, [0.0; 3]);
        assert!(text(&odd, 100.0).contains("photograph 3 shows too little"));
    }
}
