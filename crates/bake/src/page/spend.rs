//! How many rays the tiles of a page take.
//!
//! With a target, the texels of a sample of tiles take a few rays first ([`super::sample`]). What they say of the
//! error of each tile, after denoising, decides how many it takes: with errors that fall like N^-q the error of a
//! page, its root mean square, would be least at a given number of rays where N is proportional to s^(2/(1 + 2q)), s
//! being the error of a tile at equal rays. Half of that power is taken: few rays tell s roughly, and denoising
//! carries a tile's error to those beside it. Numbers are powers of two, which are the best numbers of points, or
//! three quarters of them, which are nearly as good. Where these are many, a part of them is tried first, from which
//! it is a shorter way to all. The rays of pilots are thrown away: a value that had a part in the choice of its rays
//! would be biased. The texels that they found are kept.

use super::baker::Baker;
use super::directional::holds as is_directional;
use super::finish::settle;
use super::planes::BakedPage;
use super::sample::{Found, Sample};
use crate::choice::Choice;
use crate::options::{Bounces, Denoise, Effort, Options, Seams};
use layers::Layer;
use std::convert::Infallible;

/// Rays of the first pilot, and the fewest of a tile.
const PILOT: u32 = 8;

/// The second pilot takes one in so many of the rays that the first one asks for, where that is more than so many.
/// Fewer are not worth what texels cost beside their rays.
const PART: u32 = 8;
const WORTH: f64 = 8.0;

/// How errors fall with the number of rays, after denoising and without: like its power of minus this.
const DENOISED: f64 = 0.55;
const PLAIN: f64 = 0.7;

/// The squares of denoised errors of a page over those of a sample, whose blocks are cut off from what they would be
/// denoised with.
const CUT_OFF: f64 = 0.8;

/// Steps of the scale of all numbers that are tried, for each doubling.
const STEPS: i32 = 8;

/// A target of the root mean square error of a page.
struct Target {
    error: f64,
    /// Or so much of the value, where that is larger.
    relative: f64,
}

impl Baker<'_> {
    /// The rays that each texel of a tile takes over the hemisphere, tile by tile. Where a target is set, they are
    /// found by a few rays of a sample of the tiles.
    pub fn rays(&self, page: u32) -> &[u32] {
        self.rays[page as usize].get_or_init(|| spend(self, page))
    }
}

fn spend(baker: &Baker<'_>, page: u32) -> Vec<u32> {
    let raster = baker.raster(page);
    let tiles = raster.tiles().len();
    match baker.options.effort {
        Effort::Rays(rays) => vec![rays; tiles],
        Effort::Target {
            error,
            relative,
            max_rays,
        } => {
            let target = Target { error, relative };
            let falls = match baker.options.denoise {
                Denoise::Regression => DENOISED,
                _ => PLAIN,
            };
            if tiles == 0 {
                return Vec::new();
            }
            let sample = Sample::of(&raster, baker.atlas.page_size);
            let found = target.pilot(baker, page, vec![PILOT; tiles], &sample);
            let rays = allot(&found, falls, max_rays);
            let part: Vec<u32> = (rays.iter())
                .map(|rays| (round(f64::from(rays / PART)) as u32).max(PILOT))
                .collect();
            if mean(&found, &part) <= WORTH {
                return rays;
            }
            let found = target.pilot(baker, page, part.clone(), &sample);
            allot(&carried(&found, &part, falls), falls, max_rays)
        }
    }
}

/// The mean number of rays of the texels that count.
fn mean(found: &[Found], rays: &[u32]) -> f64 {
    let texels: f64 = found.iter().map(|found| found.texels).sum();
    let rays = found.iter().zip(rays);
    let sum: f64 = rays.map(|(f, rays)| f.texels * f64::from(*rays)).sum();
    sum / texels.max(1.0)
}

/// What a pilot of these rays says, carried to those of the first.
fn carried(found: &[Found], rays: &[u32], falls: f64) -> Vec<Found> {
    let of = found.iter().zip(rays).map(|(found, &rays)| Found {
        texels: found.texels,
        squares: found.squares * (f64::from(rays) / f64::from(PILOT)).powf(2.0 * falls),
    });
    of.collect()
}

/// Rays by which the root mean square of all errors is what it may be, or the most.
fn allot(found: &[Found], falls: f64, most: u32) -> Vec<u32> {
    let pilot = f64::from(PILOT);
    let rays = |found: &Found, step: i32| {
        let error = (found.squares / found.texels.max(1.0)).sqrt();
        let scale = (f64::from(step) / f64::from(STEPS)).exp2();
        let even = pilot * scale * error.powf(1.0 / (1.0 + 2.0 * falls));
        (round(even) as u32).clamp(PILOT.min(most), most)
    };
    let texels: f64 = found.iter().map(|found| found.texels).sum();
    let excess = |step: i32| {
        let left = |found: &Found| {
            found.squares * (f64::from(rays(found, step)) / pilot).powf(-2.0 * falls)
        };
        found.iter().map(left).sum::<f64>() / texels.max(1.0)
    };
    let spent = |step: i32| {
        let mut found = found.iter().filter(|found| found.squares > 0.0);
        found.all(|found| rays(found, step) == most)
    };
    let steps: Vec<i32> = (-16 * STEPS..64 * STEPS).collect();
    let step = steps.partition_point(|&step| excess(step) > 1.0 && !spent(step));
    let step = steps.get(step).copied().unwrap_or(64 * STEPS);
    found.iter().map(|found| rays(found, step)).collect()
}

/// The nearest number of those that are as good as any: powers of two, and three quarters of them.
fn round(rays: f64) -> f64 {
    let log = rays.max(1.0).log2();
    let (whole, part) = (log.floor().exp2(), log - log.floor());
    let middle = 1.5_f64.log2();
    match part {
        part if part < 0.5 * middle => whole,
        part if part < 0.5 * (1.0 + middle) => 1.5 * whole,
        _ => 2.0 * whole,
    }
}

impl Target {
    /// What so many rays of the texels of each tile of a sample say of the tiles of a page.
    fn pilot(&self, baker: &Baker<'_>, number: u32, rays: Vec<u32>, sample: &Sample) -> Vec<Found> {
        let options = pilot_options(baker);
        let pilot = baker.seeking(&options);
        let _ = pilot.rays[number as usize].set(rays);
        let mut baked = Vec::new();
        let Ok(_) = pilot.run_tiles(number, &sample.tiles(), (&(), 0), &mut |tile| {
            baked.push(tile);
            Ok::<_, Infallible>(())
        });
        let size = baker.atlas.page_size;
        let mut page = sample.page(pilot.layers(), baked, size);
        let values = watched(baker).map(|(value, _)| value);
        settle(&mut page, &pilot.site(), &values);
        let errors = Errors::of(&page, baker, self);
        let squares: Vec<Option<f64>> = (0..page.texels()).map(|k| errors.square(k)).collect();
        let mut found = sample.spread(&squares, &baker.raster(number), size);
        if options.denoise == Denoise::Regression {
            found.iter_mut().for_each(|found| found.squares *= CUT_OFF);
        }
        found
    }
}

/// A bake of a few rays that only says how large errors are.
fn pilot_options(baker: &Baker<'_>) -> Options {
    let options = baker.options;
    // What no tile tells but at some cost.
    let is_dear = |layer: &Layer| is_directional(*layer) || layer.is_any_view();
    let mut layers = options.layers.clone();
    layers.retain(|layer| !is_dear(layer));
    let denoise = match options.denoise {
        Denoise::Regression => Denoise::Regression,
        _ => Denoise::Off,
    };
    // Later steps keep errors; without any, they are asked for.
    if denoise == Denoise::Off && options.seams == Seams::Off {
        for (choice, layer) in [
            (Choice::Diffuse, Layer::StdErrDiffuse),
            (Choice::Specular, Layer::StdErrSpecular),
        ] {
            if baker.plan.models(choice) && !layers.contains(&layer) {
                layers.push(layer);
            }
        }
    }
    Options {
        effort: Effort::Rays(PILOT),
        bounces: Bounces::Off,
        lights: Vec::new(),
        denoise,
        layers,
        ..options.clone()
    }
}

/// The terms that a target is about, with their standard errors.
fn watched(baker: &Baker<'_>) -> [(Layer, Layer); 2] {
    match baker.options.sky.map() {
        None => [
            (Layer::Diffuse, Layer::StdErrDiffuse),
            (Layer::Specular, Layer::StdErrSpecular),
        ],
        Some(_) => [
            (Layer::Irradiance, Layer::StdErrIrradiance),
            (Layer::Reflection, Layer::StdErrReflection),
        ],
    }
}

/// A term of the pilot: its values, their errors, what the largest value is, and what of the error comes through.
struct Watched<'a> {
    values: &'a [f32],
    std_errs: &'a [f32],
    unit: f64,
    weights: Option<&'a [f32]>,
}

/// The planes of a pilot that say how large errors are.
struct Errors<'a> {
    coverage: Option<&'a [f32]>,
    validity: Option<&'a [f32]>,
    terms: Vec<Watched<'a>>,
    target: &'a Target,
    texels: usize,
}

impl<'a> Errors<'a> {
    fn of(page: &'a BakedPage, baker: &Baker<'_>, target: &'a Target) -> Self {
        let options = baker.options;
        let unit = match options.sky.map() {
            None => 1.0,
            Some(_) => options.sky.brightness(),
        };
        let terms = watched(baker).into_iter().filter_map(|(term, std_err)| {
            let weights = match term {
                Layer::Specular | Layer::Reflection if !options.full_highlights => {
                    Some(page.layer(Layer::Reflectance)?)
                }
                _ => None,
            };
            Some(Watched {
                values: page.layer(term)?,
                std_errs: page.layer(std_err)?,
                unit,
                weights,
            })
        });
        Self {
            coverage: page.layer(Layer::Coverage),
            validity: page.layer(Layer::Validity),
            terms: terms.collect(),
            target,
            texels: page.texels(),
        }
    }

    /// The square of a texel's largest error over what it may be; `None` for texels that nothing covers or nobody sees.
    fn square(&self, texel: usize) -> Option<f64> {
        let above = |plane: Option<&[f32]>| plane.is_none_or(|plane| plane[texel] > 0.0);
        if !above(self.coverage) || !above(self.validity) {
            return None;
        }
        let mean = |plane: &[f32]| {
            let channels = plane.chunks(self.texels);
            let count = channels.len() as f64;
            channels
                .map(|channel| f64::from(channel[texel]))
                .sum::<f64>()
                / count
        };
        let square = |term: &Watched<'_>| {
            let value = mean(term.values);
            let allowed = (self.target.error * term.unit).max(self.target.relative * value);
            let error = f64::from(term.std_errs[texel]) * term.weights.map_or(1.0, mean);
            (error / allowed).powi(2)
        };
        Some(self.terms.iter().map(square).fold(0.0, f64::max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the tiles have sixteen times the error of the others.
    #[test]
    fn rays_go_where_errors_are_and_meet_the_target() {
        let of = |error: f64| Found {
            texels: 256.0,
            squares: 256.0 * error * error,
        };
        let found = [of(0.25), of(4.0), of(0.25), of(4.0), of(0.0)];
        let rays = allot(&found, 0.5, 16_384);
        let good = |rays: &u32| rays.is_power_of_two() || (rays / 3).is_power_of_two();
        assert!(rays.iter().all(good), "{rays:?}");
        assert_eq!(rays[1], 4 * rays[0], "a half of the power of 1");
        let pilot = f64::from(PILOT);
        let left = |found: &Found, &rays: &u32| found.squares * pilot / f64::from(rays);
        let left: f64 = found.iter().zip(&rays).map(|(f, r)| left(f, r)).sum();
        // A step of rounding more rays than needed, at most.
        assert!((0.4..=1.0).contains(&(left / 1280.0)), "{rays:?}: {left}");
        assert_eq!(allot(&found, 0.5, 16)[1], 16);
        assert_eq!(allot(&[of(0.0)], 0.5, 64), [PILOT]);
        assert_eq!(allot(&[Found::default()], 0.5, 64), [PILOT]);
        // What other numbers of rays tell is the same once it is carried back.
        let many = [2, 32].map(|more| PILOT * more);
        let told = many.map(|rays| Found {
            texels: 256.0,
            squares: 5.0 * f64::from(PILOT) / f64::from(rays),
        });
        assert!(
            carried(&told, &many, 0.5)
                .iter()
                .all(|found| (found.squares - 5.0).abs() < 1e-9)
        );
    }
}
