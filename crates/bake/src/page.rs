//! Bakes one page of the atlas: tiles in parallel, results into planes in a fixed order, gutters last.

use crate::backend::RayBackend;
use crate::compose::BakedTexel;
use crate::integrate::{Task, integrate, validity};
use crate::layer::Layer;
use crate::options::Options;
use crate::plan::{Choice, Plan};
use crate::surface::PlaneErrors;
use crate::texel::Survey;
use crate::world::World;
use ambient::sampling::Stream;
use atlas::{Atlas, Dilation, Footprint, PageRaster, RINGS, Tile};
use glam::Vec3;
use rayon::prelude::*;
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
    /// Planes of all asked layers, [`Layer::Coverage`] first.
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
    /// Largest standard error of diffuse.
    pub error_max: f64,
    /// Rays spent.
    pub rays: u64,
    /// Texels finished in closed form.
    pub closed_form: u64,
    /// Seconds spent on tiles.
    pub seconds: f64,
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
            let results: Vec<Option<Vec<BakedTexel>>> = batch
                .clone()
                .into_par_iter()
                .map(|index| {
                    if progress.stop.load(Ordering::Relaxed) {
                        return None;
                    }
                    let texels = self.tile(&raster.tile(index), page.page);
                    progress
                        .texels
                        .fetch_add(texels.len() as u64, Ordering::Relaxed);
                    progress
                        .rays
                        .fetch_add(texels.iter().map(|t| t.terms.rays).sum(), Ordering::Relaxed);
                    Some(texels)
                })
                .collect();
            for result in results {
                let Some(texels) = result else {
                    page.stats.seconds += started.elapsed().as_secs_f64();
                    return;
                };
                for texel in &texels {
                    self.store(page, texel);
                }
                page.tiles_done += 1;
            }
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
        tile.footprints
            .iter()
            .map(|footprint| self.texel(tile, footprint, page))
            .collect()
    }

    fn texel(&self, tile: &Tile, footprint: &Footprint, page: u32) -> BakedTexel {
        let Options {
            rays,
            seed,
            view,
            max_distance,
            ..
        } = *self.options;
        let index = footprint.y * self.atlas.page_size + footprint.x;
        let stream = |term: u32, replicate: u32| Stream::new(seed, page, index, term, replicate);
        let survey = Survey::of(
            self.world,
            &self.errors,
            &self.options.overrides,
            tile,
            footprint,
            |term| stream(term, 0),
        );
        let task = Task {
            backend: self.backend,
            rays,
            view,
            t_max: max_distance.unwrap_or(f32::INFINITY),
            mixture: self.plan.mixture,
            specular: self.plan.models(Choice::Specular) && self.reflects(&survey),
            hemisphere: self.plan.models(Choice::Diffuse),
            bent: self.options.layers.contains(&Layer::Bent),
            open: survey
                .patches()
                .iter()
                .all(|p| self.plan.open.contains(p.instance, p.triangle)),
        };
        let validity = if self.options.layers.contains(&Layer::Validity) {
            validity(&task, &survey, self.world, stream)
        } else {
            1.0
        };
        BakedTexel {
            index,
            coverage: footprint.coverage,
            object: survey.object,
            terms: integrate(&task, &survey, stream),
            material: survey.material,
            position: survey.position,
            normal: survey.normal,
            geometric: survey.geometric,
            validity,
        }
    }

    /// True where the texel's specular term is worth its rays: its material reflects, or the term itself was asked for.
    fn reflects(&self, survey: &Survey<'_>) -> bool {
        survey.material.specular.max_element() > 0.0
            || self.options.overrides.exponent.is_some()
            || !self.options.allows(Choice::Specular)
    }

    fn store(&self, page: &mut BakedPage, texel: &BakedTexel) {
        let sky = Vec3::from(self.options.sky).as_dvec3();
        let mut values = (Layer::Coverage, texel.values(Layer::Coverage, sky));
        for plane in &mut page.planes {
            if plane.layer != values.0 {
                values = (plane.layer, texel.values(plane.layer, sky));
            }
            plane.values[texel.index as usize] = values.1[plane.channel];
        }
        let stats = &mut page.stats;
        stats.texels += 1;
        stats.coverage += f64::from(texel.coverage);
        stats.error_sum += texel.terms.errors[0];
        stats.error_max = stats.error_max.max(texel.terms.errors[0]);
        stats.rays += texel.terms.rays;
        stats.closed_form += u64::from(texel.terms.rays == 0);
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
