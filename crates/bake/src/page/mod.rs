//! Bakes one page of the atlas: tiles in parallel, results into planes in a fixed order, gutters last.

mod compose;

pub use compose::BakedTexel;

use crate::denoise::{NEEDED, filter};
use crate::integrate::{Task, integrate, validity};
use crate::options::{Denoise, Options};
use crate::plan::{Choice, Plan};
use crate::survey::{Surveyor, Texel};
use atlas::{Atlas, Dilation, PageRaster, RINGS, Tile};
use glam::Vec3;
use layers::Layer;
use pulp::Arch;
use rayon::prelude::*;
use rays::{PlaneErrors, RayBackend, World};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Tiles that are baked between two looks at the stop flag's effect; results are kept batch by batch.
const BATCH: usize = 256;

/// What a running bake tells, and how it is told to stop. Read it from any thread.
#[derive(Debug, Default)]
pub struct Progress {
    /// Texels finished so far, over all pages.
    pub texels: AtomicU64,
    /// Rays spent so far, over all pages.
    pub rays: AtomicU64,
    /// Set to end the bake after the tiles in work.
    pub stop: AtomicBool,
}

/// Everything that stays the same over the pages of a bake.
pub struct Bake<'a> {
    world: &'a World,
    plan: &'a Plan,
    backend: &'a dyn RayBackend,
    atlas: &'a Atlas,
    options: &'a Options,
    errors: PlaneErrors,
}

/// One channel of one layer over a page: `size * size` values, row 0 on top.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Its layer.
    pub layer: Layer,
    /// Index into [`Layer::channels`].
    pub channel: usize,
    /// The values.
    pub values: Vec<f32>,
}

/// A page in work or finished.
#[derive(Debug, Clone, PartialEq)]
pub struct BakedPage {
    /// Page number.
    pub page: u32,
    /// Edge in texels.
    pub size: u32,
    /// Tiles finished, in the raster's order.
    pub tiles_done: usize,
    /// True when every tile is finished and gutters are filled.
    pub finished: bool,
    /// Planes of all asked layers, [`Layer::Coverage`] first, then those that only the filter needs.
    pub planes: Vec<Plane>,
    /// Sums over the finished texels.
    pub stats: PageStats,
}

/// Statistics of a page.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PageStats {
    /// Texels that a chart touches.
    pub texels: u64,
    /// Sum of their coverage: used area in texels.
    pub coverage: f64,
    /// Sum of the standard error of diffuse.
    pub error_sum: f64,
    /// Sum of its square.
    pub error_squares: f64,
    /// Sum of its fourth power.
    pub error_fourths: f64,
    /// Largest standard error of diffuse, and the first texel (column, row) that has it.
    pub error_max: f64,
    /// See `error_max`.
    pub worst: [u32; 2],
    /// Sum of the squared standard error of irradiance.
    #[serde(default)]
    pub irradiance_squares: f64,
    /// Rays spent.
    pub rays: u64,
    /// Texels finished in closed form.
    pub closed_form: u64,
    /// Seconds spent on tiles.
    pub seconds: f64,
}

impl BakedPage {
    /// Leaves out the layers that only the filter needed.
    pub fn keep_asked(&mut self, options: &Options) {
        self.planes
            .retain(|p| p.layer == Layer::Coverage || options.layers.contains(&p.layer));
    }

    /// The values of a layer's channel.
    ///
    /// # Panics
    /// Where the page has no such plane.
    pub(crate) fn channel(&self, layer: Layer, channel: usize) -> &[f32] {
        let mut planes = self.planes.iter();
        let found = planes.find(|p| (p.layer, p.channel) == (layer, channel));
        let missing = || panic!("the page has no channel {channel} of {}", layer.name());
        found.map_or_else(missing, |plane| &plane.values)
    }

    /// As [`BakedPage::channel`], to be changed.
    pub(crate) fn channel_mut(&mut self, layer: Layer, channel: usize) -> &mut [f32] {
        let mut planes = self.planes.iter_mut();
        let found = planes.find(|p| (p.layer, p.channel) == (layer, channel));
        let missing = || panic!("the page has no channel {channel} of {}", layer.name());
        found.map_or_else(missing, |plane| &mut plane.values)
    }
}

impl PageStats {
    /// Counts a texel's standard error of diffuse.
    pub(crate) fn add_error(&mut self, error: f64, texel: [u32; 2]) {
        self.error_sum += error;
        self.error_squares += error * error;
        self.error_fourths += error.powi(4);
        if error > self.error_max {
            (self.error_max, self.worst) = (error, texel);
        }
    }

    /// As if no error had been counted.
    pub(crate) fn forget_errors(&mut self) {
        (self.error_sum, self.error_squares, self.error_fourths) = (0.0, 0.0, 0.0);
        (self.error_max, self.worst) = (0.0, [0; 2]);
    }

    /// Estimated root mean square error of the diffuse term over the texels.
    pub fn rmse(&self) -> f64 {
        (self.error_squares / self.texels.max(1) as f64).sqrt()
    }

    /// Estimated root mean square error of the irradiance over the texels, mean of its channels.
    pub fn irradiance_rmse(&self) -> f64 {
        (self.irradiance_squares / self.texels.max(1) as f64).sqrt()
    }

    /// What the true root mean square error stays below with 99.9 % confidence.
    ///
    /// The sum of squared errors of independent normal texels has the relative variance `2/t`, its estimate from four replicates
    /// each `2/3t`, where `t = (Σ s²)² / Σ s⁴` counts unequal texels as fewer. The normal quantile is 3.09.
    pub fn rmse_bound(&self) -> f64 {
        if self.error_squares == 0.0 {
            return 0.0;
        }
        let relative = self.error_fourths / (self.error_squares * self.error_squares);
        self.rmse() * (1.0 + 3.09 * ((2.0 + 2.0 / 3.0) * relative).sqrt()).sqrt()
    }
}

impl<'a> Bake<'a> {
    /// A bake of `atlas` with these parts.
    pub fn new(
        world: &'a World,
        plan: &'a Plan,
        backend: &'a dyn RayBackend,
        atlas: &'a Atlas,
        options: &'a Options,
    ) -> Self {
        Self {
            world,
            plan,
            backend,
            atlas,
            options,
            errors: PlaneErrors::of(world),
        }
    }

    /// An empty page to start from.
    pub fn start(&self, page: u32) -> BakedPage {
        let size = self.atlas.page_size;
        let texels = size as usize * size as usize;
        let mut layers = vec![Layer::Coverage];
        layers.extend(
            self.options
                .layers
                .iter()
                .copied()
                .filter(|&l| l != Layer::Coverage),
        );
        if self.options.denoise == Denoise::Regression {
            let missing: Vec<Layer> = NEEDED.into_iter().filter(|l| !layers.contains(l)).collect();
            layers.extend(missing);
        }
        let planes = layers
            .into_iter()
            .flat_map(|layer| (0..layer.channels().len()).map(move |channel| (layer, channel)))
            .map(|(layer, channel)| Plane {
                layer,
                channel,
                values: vec![layer.void(); texels],
            })
            .collect();
        BakedPage {
            page,
            size,
            tiles_done: 0,
            finished: false,
            planes,
            stats: PageStats::default(),
        }
    }

    /// Continues a page until it is finished or `progress.stop` is set. The result does not depend on the number of
    /// threads or on where the page was interrupted.
    pub fn run(&self, page: &mut BakedPage, progress: &Progress) {
        let raster = PageRaster::new(self.world.scene(), self.atlas, page.page);
        let tiles = raster.tiles().len();
        let started = Instant::now();
        while page.tiles_done < tiles {
            let batch = page.tiles_done..(page.tiles_done + BATCH).min(tiles);
            let layers: Vec<(Layer, usize)> =
                page.planes.iter().map(|p| (p.layer, p.channel)).collect();
            let results: Vec<Option<TileResult>> = batch
                .clone()
                .into_par_iter()
                .map(|index| {
                    if progress.stop.load(Ordering::Relaxed) {
                        return None;
                    }
                    let texels = self.tile(&raster.tile(index), page.page);
                    let result = self.result(&layers, &texels);
                    let (done, rays) = (result.stats.texels, result.stats.rays);
                    progress.texels.fetch_add(done, Ordering::Relaxed);
                    progress.rays.fetch_add(rays, Ordering::Relaxed);
                    Some(result)
                })
                .collect();
            for result in results {
                let Some(result) = result else {
                    page.stats.seconds += started.elapsed().as_secs_f64();
                    return;
                };
                result.store(page);
                page.tiles_done += 1;
            }
        }
        if self.options.denoise == Denoise::Regression {
            filter(page, self.plan, self.options.sky.floor());
        }
        page.stats.seconds += started.elapsed().as_secs_f64();
        fill_gutters(page);
        page.finished = true;
    }

    /// Bakes up to `tiles` tiles spread over the atlas, for estimates: (texels, rays, seconds).
    pub fn pilot(&self, tiles: usize) -> (u64, u64, f64) {
        let started = Instant::now();
        let (mut texels, mut rays) = (0, 0);
        for page in 0..self.atlas.page_count {
            let raster = PageRaster::new(self.world.scene(), self.atlas, page);
            let share = tiles.div_ceil(self.atlas.page_count as usize).max(1);
            let step = raster.tiles().len().div_ceil(share).max(1);
            let picked: Vec<usize> = (0..raster.tiles().len()).step_by(step).collect();
            let baked: Vec<BakedTexel> = picked
                .into_par_iter()
                .flat_map_iter(|index| self.tile(&raster.tile(index), page))
                .collect();
            texels += baked.len() as u64;
            rays += baked.iter().map(|t| t.terms.rays).sum::<u64>();
        }
        (texels, rays, started.elapsed().as_secs_f64())
    }

    fn tile(&self, tile: &Tile, page: u32) -> Vec<BakedTexel> {
        let options = self.options;
        let task = Task {
            backend: self.backend,
            arch: Arch::new(),
            seed: options.seed,
            page,
            size: self.atlas.page_size,
            effort: options.effort,
            pattern: options.pattern,
            points: options.points,
            view: options.view,
            t_max: options.max_distance.unwrap_or(f32::INFINITY),
            mixture: self.plan.mixture,
            hemisphere: self.plan.models(Choice::Diffuse),
            bent: options.layers.contains(&Layer::Bent),
            sky: &options.sky,
            draw_sky: options.draw_sky,
        };
        let surveyor = Surveyor {
            world: self.world,
            errors: &self.errors,
            overrides: &options.overrides,
            plan: self.plan,
        };
        let texels = surveyor.texels(tile, |x, y, term| task.stream(x, y, term, 0));
        let lobes = self.plan.models(Choice::Specular);
        let specular: Vec<bool> = texels.iter().map(|t| lobes && self.reflects(t)).collect();
        let terms = integrate(&task, &texels, &specular);
        let validities = options.layers.contains(&Layer::Validity);
        texels
            .iter()
            .zip(terms)
            .map(|(texel, terms)| BakedTexel {
                index: texel.y * self.atlas.page_size + texel.x,
                coverage: texel.coverage,
                object: texel.object,
                terms,
                material: texel.material,
                position: texel.position,
                normal: texel.normal,
                geometric: texel.geometric,
                validity: if validities {
                    validity(&task, texel, self.world)
                } else {
                    1.0
                },
            })
            .collect()
    }

    /// True where the texel's specular term is worth its rays: its material reflects, or the term itself was asked for.
    fn reflects(&self, texel: &Texel) -> bool {
        texel.material.specular.max_element() > 0.0
            || self.options.overrides.exponent.is_some()
            || !self.options.allows(Choice::Specular)
    }

    /// What the page keeps of a tile.
    fn result(&self, layers: &[(Layer, usize)], texels: &[BakedTexel]) -> TileResult {
        let sky = self.options.sky.mean();
        let mut result = TileResult::default();
        for texel in texels {
            let mut values = (Layer::Coverage, texel.values(Layer::Coverage, sky));
            for &(layer, channel) in layers {
                if layer != values.0 {
                    values = (layer, texel.values(layer, sky));
                }
                result.values.push(values.1[channel]);
            }
            result.texels.push(texel.index);
            let error = texel.terms.errors[0];
            let stats = &mut result.stats;
            stats.texels += 1;
            stats.coverage += f64::from(texel.coverage);
            let size = self.atlas.page_size;
            stats.add_error(error, [texel.index % size, texel.index / size]);
            stats.irradiance_squares += texel.terms.light_errors[0].powi(2);
            stats.rays += texel.terms.rays;
            stats.closed_form += u64::from(texel.terms.rays == 0);
        }
        result
    }
}

/// A finished tile: its texels, and the values of each in the order of the page's planes.
#[derive(Default)]
struct TileResult {
    texels: Vec<u32>,
    values: Vec<f32>,
    stats: PageStats,
}

impl TileResult {
    fn store(&self, page: &mut BakedPage) {
        let planes = page.planes.len();
        for (&texel, values) in self.texels.iter().zip(self.values.chunks(planes)) {
            for (plane, &value) in page.planes.iter_mut().zip(values) {
                plane.values[texel as usize] = value;
            }
        }
        let (all, own) = (&mut page.stats, &self.stats);
        all.texels += own.texels;
        all.coverage += own.coverage;
        all.error_sum += own.error_sum;
        all.error_squares += own.error_squares;
        all.error_fourths += own.error_fourths;
        if own.error_max > all.error_max {
            (all.error_max, all.worst) = (own.error_max, own.worst);
        }
        all.irradiance_squares += own.irradiance_squares;
        all.rays += own.rays;
        all.closed_form += own.closed_form;
    }
}

/// Fills the gutter texels of every layer that dilates, and renews the length of directions there.
fn fill_gutters(page: &mut BakedPage) {
    let dilation = Dilation::new(&page.planes[0].values, page.size, RINGS);
    page.planes
        .par_iter_mut()
        .filter(|plane| plane.layer.dilates())
        .for_each(|plane| {
            dilation.apply(&mut plane.values);
        });
    for layer in [Layer::Normal, Layer::Geometric, Layer::Bent] {
        let Some(first) = page.planes.iter().position(|plane| plane.layer == layer) else {
            continue;
        };
        for &target in dilation.targets() {
            let at = |c: usize| page.planes[first + c].values[target as usize];
            let unit = Vec3::new(at(0), at(1), at(2)).normalize_or_zero();
            for c in 0..3 {
                page.planes[first + c].values[target as usize] = unit[c];
            }
        }
    }
}
