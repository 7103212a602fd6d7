//! How many rays the tiles of a page take.
//!
//! With a target, every texel takes a few rays first. What they say of the error of each tile, after denoising,
//! decides how many it takes: with errors that fall like N^-q the error of a page, its root mean square, would be
//! least at a given number of rays where N is proportional to s^(2/(1 + 2q)), s being the error of a tile at equal
//! rays. Half of that power is taken: few rays tell s roughly, and denoising carries a tile's error to those beside
//! it. A tile's own error decides, but where it has few texels: what lies beside it on the page is often another
//! surface. Numbers are powers of two, which are the best numbers of points, or three quarters of them, which are
//! nearly as good. Where these are many, a part of them is tried first, from which it is a shorter way to all. The
//! rays of pilots are thrown away: a value that had a part in the choice of its rays would be biased. The texels that
//! they found are kept. But where the first pilot's rays are enough for all of the page, it is the page.

use super::baker::Baker;
use super::directional::holds as is_directional;
use super::finish::settle;
use super::planes::BakedPage;
use super::tile::BakedTile;
use crate::choice::Choice;
use crate::options::{Bounces, Denoise, Effort, Options, Seams};
use atlas::TILE;
use layers::Layer;
use std::convert::Infallible;

/// Rays of the first pilot, and the fewest of a tile.
const PILOT: u32 = 4;

/// The second pilot takes one in so many of the rays that the first one asks for, where that is more than so many.
/// Fewer are not worth what texels cost beside their rays.
const PART: u32 = 32;
const WORTH: f64 = 8.0;

/// What a pilot says of so few texels counts half of what it says of them and those about them: among a handful there
/// may be none whose rays differ.
const FEW: f64 = 16.0;

/// How errors fall with the number of rays, after denoising and without: like its power of minus this.
const DENOISED: f64 = 0.55;
const PLAIN: f64 = 0.7;

/// Steps of the scale of all numbers that are tried, for each doubling.
const STEPS: i32 = 8;

/// A target of the root mean square error of a page.
struct Target {
    error: f64,
    /// Or so much of the value, where that is larger.
    relative: f64,
}

/// What the pilot says of a tile.
#[derive(Clone, Copy, Default)]
struct Found {
    texels: f64,
    /// Sum of the squares of errors over what they may be.
    squares: f64,
}

/// How many rays the tiles of a page take.
#[derive(Default)]
pub(super) struct Spent {
    /// Those that each texel of a tile takes over the hemisphere, tile by tile.
    rays: Vec<u32>,
    /// The tiles of the pilot, where its rays are enough.
    pilot: Vec<BakedTile>,
}

impl Spent {
    /// A tile that is baked, or the rays that its texels take.
    pub fn tile(&self, index: u32) -> Result<BakedTile, u32> {
        let known = self.pilot.get(index as usize);
        known.cloned().ok_or_else(|| self.rays[index as usize])
    }
}

impl From<Vec<u32>> for Spent {
    fn from(rays: Vec<u32>) -> Self {
        let pilot = Vec::new();
        Self { rays, pilot }
    }
}

impl Baker<'_> {
    /// The rays that each texel of a tile takes over the hemisphere, tile by tile. Where a target is set, they are
    /// found by a few rays of every texel.
    pub fn rays(&self, page: u32) -> &[u32] {
        &self.spent(page).rays
    }

    pub(super) fn spent(&self, page: u32) -> &Spent {
        self.spent[page as usize].get_or_init(|| spend(self, page))
    }
}

fn spend(baker: &Baker<'_>, page: u32) -> Spent {
    let tiles = baker.raster(page).tiles().len();
    match baker.options.effort {
        Effort::Rays(rays) => vec![rays; tiles].into(),
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
            let (found, pilot) = target.pilot(baker, page, vec![PILOT; tiles]);
            let rays = allot(&found, falls, max_rays);
            if rays.iter().all(|&rays| rays == PILOT) {
                return Spent { rays, pilot };
            }
            drop(pilot);
            let part: Vec<u32> = (rays.iter())
                .map(|rays| (round(f64::from(rays / PART)) as u32).max(PILOT))
                .collect();
            if mean(&found, &part) <= WORTH {
                return rays.into();
            }
            let (found, _) = target.pilot(baker, page, part.clone());
            allot(&carried(&found, &part, falls), falls, max_rays).into()
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
    let mut seen: Vec<u32> = (found.iter().filter(|found| found.texels > 0.0))
        .map(|found| rays(found, step))
        .collect();
    seen.sort_unstable();
    // What nobody sees is not to look like noise either.
    let unseen = seen.get(seen.len() / 2).copied().unwrap_or(PILOT.min(most));
    let all = found.iter().map(|found| match found.texels > 0.0 {
        true => rays(found, step),
        false => unseen,
    });
    all.collect()
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
    /// What so many rays of the texels of each tile say of the tiles of a page, and the tiles by their index if they have
    /// all that the page does.
    fn pilot(
        &self,
        baker: &Baker<'_>,
        number: u32,
        rays: Vec<u32>,
    ) -> (Vec<Found>, Vec<BakedTile>) {
        let options = pilot_options(baker);
        let pilot = baker.seeking(&options);
        let _ = pilot.spent[number as usize].set(rays.into());
        let mut page = pilot.start(number);
        let is_whole = pilot.layers() == baker.layers();
        let mut baked = Vec::new();
        let Ok(_) = pilot.fill(&mut page, &(), &mut |tile| {
            baked.extend(is_whole.then_some(tile));
            Ok::<_, Infallible>(())
        });
        baked.sort_unstable_by_key(|tile| tile.index);
        settle(
            &mut page,
            &pilot.site(),
            &watched(baker).map(|(value, _)| value),
        );
        let across = page.size.div_ceil(TILE);
        let mut grid = vec![Found::default(); (across * across) as usize];
        let errors = Errors::of(&page, baker, self);
        for texel in 0..page.texels() {
            if let Some(square) = errors.square(texel) {
                let [x, y] = [texel as u32 % page.size, texel as u32 / page.size];
                let tile = &mut grid[(y / TILE * across + x / TILE) as usize];
                tile.texels += 1.0;
                tile.squares += square;
            }
        }
        let tiles = baker.raster(number);
        let found = tiles
            .tiles()
            .iter()
            .map(|&tile| beside(&grid, across, tile));
        (found.collect(), baked)
    }
}

/// What is known of a tile, with as much as [`FEW`] texels know of it and those about it.
fn beside(grid: &[Found], across: u32, tile: u32) -> Found {
    let [x, y] = [tile % across, tile / across];
    let own = grid[tile as usize];
    let mut all = Found::default();
    for y in y.saturating_sub(1)..(y + 2).min(across) {
        for x in x.saturating_sub(1)..(x + 2).min(across) {
            let other = grid[(y * across + x) as usize];
            all.texels += other.texels;
            all.squares += other.squares;
        }
    }
    let mean = all.squares / all.texels.max(1.0);
    Found {
        texels: own.texels,
        squares: own.texels * (own.squares + FEW * mean) / (own.texels + FEW),
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
        // A tile that nobody sees takes what most do.
        let unseen = allot(&[Found::default(), of(4.0), of(0.25), of(4.0)], 0.5, 16_384);
        assert_eq!(unseen[0], unseen[1]);
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

    #[test]
    fn a_tile_of_few_texels_is_known_by_those_about_it() {
        let of = |texels: f64, error: f64| Found {
            texels,
            squares: texels * error * error,
        };
        let mut grid = vec![of(256.0, 1.0); 9];
        (grid[4], grid[8]) = (of(2.0, 0.0), of(256.0, 0.0));
        let error = |tile: u32| {
            let found = beside(&grid, 3, tile);
            (found.squares / found.texels).sqrt()
        };
        assert!((0.8..0.95).contains(&error(4)), "{}", error(4));
        assert!((0.99..=1.0).contains(&error(0)), "{}", error(0));
        assert!(error(8) < 0.2, "{}", error(8));
    }

    #[test]
    fn a_pilot_that_is_enough_is_the_page() {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/resting_sphere.obj"
        );
        let scene = std::sync::Arc::new(scene::load(file.as_ref()).expect("a scene"));
        let of = |effort: Effort| Options {
            effort,
            ..Options::default()
        };
        let to = |error: f64| {
            of(Effort::Target {
                error,
                relative: 0.0,
                max_rays: 1024,
            })
        };
        let (plan, world) = crate::Plan::of(&scene, &to(1.0)).expect("a plan");
        let layout = atlas::Options {
            page_size: 128,
            ..Default::default()
        };
        let atlas = atlas::layout(&scene, &layout, &|| false).expect("a layout");
        let kind = rays::BackendKind::Obvhs(rays::TreeKind::default());
        let backend = rays::build(kind, &world, 0).expect("a backend");
        let page = |options: &Options, seeks: bool| {
            let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, options);
            let pilot = seeks.then(|| baker.seeking(options));
            let mut page = baker.start(0);
            pilot.as_ref().unwrap_or(&baker).run(&mut page, &());
            page
        };
        let easy = page(&to(1.0), false);
        let pilot = page(&of(Effort::Rays(PILOT)), true);
        assert!(easy.planes == pilot.planes && easy.stats.rays == pilot.stats.rays);
        // One that asks for more takes none of the pilot's rays.
        let hard = page(&to(0.004), false);
        assert!(hard.stats.rays > 2 * easy.stats.rays);
        assert!(hard.stats.errors.squares < 0.5 * easy.stats.errors.squares);
    }
}
