//! Bakes pages of an atlas: tiles in parallel, results into planes in a fixed order.

use super::compose::BakedTexel;
use super::finish::{finish, working_layers};
use super::planes::{BakedPage, LayerPlanes};
use super::stats::PageStats;
use crate::choice::Choice;
use crate::integrate::{Task, ggx, integrate};
use crate::options::{Buried, Footprint, Model, Options, View};
use crate::plan::Plan;
use crate::seams::Seams;
use crate::survey::{Surveyor, Texel};
use ambient::sampling::Stream;
use atlas::{Atlas, PageRaster, Tile};
use layers::{Layer, Progress};
use pulp::Arch;
use rayon::prelude::*;
use rays::{PlaneErrors, RayBackend, Solids, World};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Tiles whose results are kept together: a bake stops between two of these batches.
const BATCH: usize = 256;

/// Everything that stays the same over the pages of a bake.
pub struct Baker<'a> {
    pub(crate) world: &'a World,
    pub(crate) plan: &'a Plan,
    pub(crate) backend: &'a dyn RayBackend,
    pub(crate) atlas: &'a Atlas,
    pub(crate) options: &'a Options,
    errors: PlaneErrors,
    /// What buries samples; `None` where nothing can.
    pub(crate) solids: Option<Solids>,
    /// Texels finished so far, over all pages.
    done: AtomicU64,
}

/// What a few tiles, spread over the atlas, took.
#[derive(Debug, Clone, Copy)]
pub struct Pilot {
    /// Texels of these tiles.
    pub texels: u64,
    /// Rays spent on them.
    pub rays: u64,
    /// Seconds that they took.
    pub seconds: f64,
}

impl<'a> Baker<'a> {
    /// A baker of `atlas` with these parts.
    pub fn new(
        world: &'a World,
        plan: &'a Plan,
        backend: &'a dyn RayBackend,
        atlas: &'a Atlas,
        options: &'a Options,
    ) -> Self {
        let solids = match options.buried {
            Buried::Drop => Some(Solids::of(world)).filter(|solids| solids.count() > 0),
            Buried::Keep => None,
        };
        Self {
            solids,
            world,
            plan,
            backend,
            atlas,
            options,
            errors: PlaneErrors::of(world),
            done: AtomicU64::new(0),
        }
    }

    /// An empty page to start from.
    pub fn start(&self, page: u32) -> BakedPage {
        let size = self.atlas.page_size;
        let texels = size as usize * size as usize;
        BakedPage {
            page,
            size,
            tiles_done: 0,
            finished: false,
            planes: working_layers(self.options, self.plan, self.solids.is_some())
                .into_iter()
                .map(|layer| LayerPlanes::void(layer, texels))
                .collect(),
            stats: PageStats::default(),
        }
    }

    /// Continues a page until it is finished or the listener cancels. The result does not depend on the number of threads or on where
    /// the page was interrupted.
    pub fn run(&self, page: &mut BakedPage, progress: &dyn Progress) {
        let total = self.atlas.audit.texels;
        let raster = PageRaster::new(self.world.scene(), self.atlas, page.page);
        let tiles = raster.tiles().len();
        let started = Instant::now();
        self.done.fetch_add(page.stats.texels, Ordering::Relaxed);
        while page.tiles_done < tiles {
            let batch = page.tiles_done..(page.tiles_done + BATCH).min(tiles);
            let columns = columns(page);
            let results: Vec<Option<TileResult>> = batch
                .clone()
                .into_par_iter()
                .map(|index| {
                    if progress.cancelled() {
                        return None;
                    }
                    let texels = self.tile(&self.cut(&raster, index), page.page);
                    let result = self.result(&columns, &texels);
                    let own = result.stats.texels;
                    let done = self.done.fetch_add(own, Ordering::Relaxed) + own;
                    progress.rays(result.stats.rays);
                    progress.advance(done, total);
                    Some(result)
                })
                .collect();
            for result in results {
                let Some(result) = result else {
                    page.stats.seconds += started.elapsed().as_secs_f64();
                    return;
                };
                result.store(&columns, page);
                page.tiles_done += 1;
            }
        }
        let seams = Seams::find(self.world, self.atlas, page.page, self.options.seams);
        let mends = self.solids.is_some();
        finish(
            page,
            self.options,
            self.plan,
            self.world,
            &raster,
            &seams,
            mends,
        );
        page.stats.seconds += started.elapsed().as_secs_f64();
    }

    /// Bakes up to `tiles` tiles spread over the atlas, for estimates.
    pub fn pilot(&self, tiles: usize) -> Pilot {
        let started = Instant::now();
        let (mut texels, mut rays) = (0, 0);
        for page in 0..self.atlas.page_count {
            let raster = PageRaster::new(self.world.scene(), self.atlas, page);
            let share = tiles.div_ceil(self.atlas.page_count as usize).max(1);
            let step = raster.tiles().len().div_ceil(share).max(1);
            let picked: Vec<usize> = (0..raster.tiles().len()).step_by(step).collect();
            let baked: Vec<BakedTexel> = picked
                .into_par_iter()
                .flat_map_iter(|index| self.tile(&self.cut(&raster, index), page))
                .collect();
            texels += baked.len() as u64;
            rays += baked.iter().map(|t| t.terms.rays).sum::<u64>();
        }
        Pilot {
            texels,
            rays,
            seconds: started.elapsed().as_secs_f64(),
        }
    }

    /// The footprints of a tile.
    pub(crate) fn cut(&self, raster: &PageRaster<'_>, index: usize) -> Tile {
        match self.options.footprint {
            Footprint::Texel => raster.tile(index),
            Footprint::Centre => raster.centres(index),
        }
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
            view: match options.view {
                View::Eye(eye) => View::Eye(eye - self.world.origin()),
                View::Normal => View::Normal,
            },
            shading: options.shading,
            t_max: options.max_distance.unwrap_or(f32::INFINITY),
            mixture: self.plan.mixture,
            hemisphere: self.plan.models(Choice::Diffuse),
            bent: options.layers.contains(&Layer::Bent),
            sky: &options.sky,
            draw_sky: options.draw_sky,
        };
        let texels = self.survey(tile, page);
        let lobes = self.plan.models(Choice::Specular);
        let specular: Vec<bool> = texels.iter().map(|t| lobes && self.reflects(t)).collect();
        let microfacets = options.model == Model::Ggx;
        let terms = match microfacets {
            false => integrate(&task, &texels, &specular),
            true => {
                let mut terms = integrate(&task, &texels, &vec![false; texels.len()]);
                let reflecting = terms.iter_mut().zip(&texels).zip(&specular);
                for ((terms, texel), _) in reflecting.filter(|(_, reflects)| **reflects) {
                    let lobe = ggx::terms(&task, texel);
                    (terms.specular, terms.reflection) = (lobe.specular, lobe.reflection);
                    terms.halves.specular = lobe.halves.specular;
                    terms.halves.reflection = lobe.halves.reflection;
                    terms.rays += lobe.rays;
                }
                terms
            }
        };
        let coloured = |texel: &Texel| {
            let mut material = texel.material;
            let mut base = material.albedo;
            if microfacets {
                let view = task.view_from(texel.position, texel.normal);
                [base, material.specular] = ggx::colours(&material, texel.normal.dot(view));
            }
            (material, base)
        };
        texels
            .iter()
            .zip(terms)
            .map(|(texel, terms)| (texel, terms, coloured(texel)))
            .map(|(texel, terms, (material, base))| BakedTexel {
                index: texel.y * self.atlas.page_size + texel.x,
                coverage: texel.coverage,
                object: texel.object,
                terms,
                material,
                base,
                position: texel.position,
                normal: texel.normal,
                geometric: texel.geometric,
                validity: texel.seen.share,
            })
            .collect()
    }

    /// The texels of a tile, ready to be integrated.
    pub(crate) fn survey(&self, tile: &Tile, page: u32) -> Vec<Texel> {
        let surveyor = Surveyor {
            world: self.world,
            errors: &self.errors,
            overrides: &self.options.overrides,
            plan: self.plan,
            solids: self.solids.as_ref(),
        };
        let (seed, size) = (self.options.seed, self.atlas.page_size);
        surveyor.texels(tile, |x, y, term| {
            Stream::new(seed, page, y * size + x, term, 0)
        })
    }

    /// True where the texel's specular term is worth its rays: its material reflects, or the term itself was asked for.
    pub(crate) fn reflects(&self, texel: &Texel) -> bool {
        texel.material.specular.max_element() > 0.0
            || self.options.overrides.exponent.is_some()
            || !self.options.allows(Choice::Specular)
    }

    /// What the page keeps of a tile.
    fn result(&self, columns: &[Column], texels: &[BakedTexel]) -> TileResult {
        let size = self.atlas.page_size;
        let mut result = TileResult::default();
        for texel in texels {
            let mut values = (Layer::Coverage, texel.values(Layer::Coverage));
            for column in columns {
                if column.layer != values.0 {
                    values = (column.layer, texel.values(column.layer));
                }
                result.values.push(values.1[column.channel]);
            }
            result.texels.push(texel.index);
            let stats = &mut result.stats;
            stats.texels += 1;
            stats.coverage += f64::from(texel.coverage);
            stats.buried += u64::from(texel.validity == 0.0);
            stats.buried_area += f64::from(texel.coverage) * (1.0 - f64::from(texel.validity));
            let place = [texel.index % size, texel.index / size];
            if texel.validity > 0.0 {
                stats.errors.add(texel.terms.diffuse, place);
                stats.irradiance_squares += texel.terms.irradiance.std_err.powi(2);
            }
            stats.rays += texel.terms.rays;
        }
        result
    }
}

/// One channel of one layer that the page keeps.
struct Column {
    /// Index into the page's planes.
    planes: usize,
    layer: Layer,
    channel: usize,
}

/// Every channel of a page, layer by layer.
fn columns(page: &BakedPage) -> Vec<Column> {
    let channels = |(planes, layer): (usize, Layer)| {
        (0..layer.channels().len()).map(move |channel| Column {
            planes,
            layer,
            channel,
        })
    };
    let layers = page.planes.iter().map(|planes| planes.layer).enumerate();
    layers.flat_map(channels).collect()
}

/// A finished tile: its texels, and the values of each in the order of the columns.
#[derive(Default)]
struct TileResult {
    texels: Vec<u32>,
    values: Vec<f32>,
    stats: PageStats,
}

impl TileResult {
    fn store(&self, columns: &[Column], page: &mut BakedPage) {
        let plane = page.texels();
        for (&texel, values) in self.texels.iter().zip(self.values.chunks(columns.len())) {
            for (column, &value) in columns.iter().zip(values) {
                let at = column.channel * plane + texel as usize;
                page.planes[column.planes].values[at] = value;
            }
        }
        page.stats.append(&self.stats);
    }
}
