//! Bakes pages of an atlas: tiles in parallel, results into planes in a fixed order.

use super::compose::BakedTexel;
use super::directional;
use super::finish::{Site, finish};
use super::planes::{BakedPage, LayerPlanes};
use super::stats::PageStats;
use super::terms::{finds_seals, working_layers};
use super::tile::{BakedTile, Column, Columns};
use crate::bounce::{GatherPilot, Taken};
use crate::choice::Choice;
use crate::clock::ThreadClock;
use crate::integrate::{Coat, Task, Terms, integrate, seals};
use crate::options::{AmbientCoefficient, Buried, Footprint, Model, Options, View};
use crate::plan::Plan;
use crate::seams::Across;
use crate::survey::{Surveyor, Texel};
use ambient::closed_form::phong_open;
use ambient::sampling::Stream;
use atlas::{Atlas, PageRaster, Rasters, Tile};
use glam::DVec3;
use layers::{Layer, Progress};
use pulp::Arch;
use rayon::prelude::*;
use rays::{PlaneErrors, RayBackend, Solids, World};
use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// What tiles are handed to, one at a time, as each is finished.
pub type Take<'t, E> = dyn FnMut(BakedTile) -> Result<(), E> + Send + 't;

/// Everything that stays the same over the pages of a bake.
pub struct Baker<'a> {
    pub(crate) world: &'a World,
    pub(crate) plan: &'a Plan,
    pub(crate) backend: &'a dyn RayBackend,
    pub(crate) atlas: &'a Atlas,
    pub(crate) options: &'a Options,
    pub(crate) errors: PlaneErrors,
    /// What buries samples; `None` where nothing can.
    pub(crate) solids: Option<&'a Solids>,
    /// What finished pages hold on seams that they share with others. Pages are finished in their order; one that is
    /// finished without those before it is not tied to them.
    across: Across,
    rasters: Rasters,
    /// Rays of the texels of each tile, by page.
    pub(super) spent: Vec<OnceLock<Vec<u32>>>,
    /// Texels finished so far, over all pages.
    done: AtomicU64,
}

/// The texels of a tile with what their rays found, one number of each list for each texel.
struct Integrated {
    texels: Vec<Texel>,
    terms: Vec<Terms>,
    coats: Vec<Coat>,
    sealed: Vec<f32>,
    /// The specular term of an open texel with this material and view; 0 where it does not reflect specularly.
    open_specular: Vec<f64>,
}

/// What a few tiles, spread over the atlas, took.
#[derive(Debug, Clone, Copy)]
pub struct Pilot {
    /// Texels of these tiles.
    pub texels: u64,
    /// Rays spent on them.
    pub rays: u64,
    /// Processor seconds that they took.
    pub cpu_seconds: f64,
    /// Their predicted part of the whole cost, 0..=1.
    pub share: f64,
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
            Buried::Drop => Some(world.solids()).filter(|solids| !solids.is_idle()),
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
            across: Across::default(),
            rasters: Rasters::default(),
            spent: vec![OnceLock::new(); atlas.page_count as usize],
            done: AtomicU64::new(0),
        }
    }

    /// The triangles of a page, by tile.
    pub(crate) fn raster(&self, page: u32) -> PageRaster<'a> {
        self.rasters.page(self.world.scene(), self.atlas, page)
    }

    /// An empty page to start from.
    pub fn start(&self, page: u32) -> BakedPage {
        let size = self.atlas.page_size;
        let texels = size as usize * size as usize;
        BakedPage {
            page,
            size,
            tiles: Vec::new(),
            finished: false,
            planes: self
                .layers()
                .into_iter()
                .map(|layer| LayerPlanes::void(layer, texels))
                .collect(),
            stats: PageStats::default(),
        }
    }

    /// The layers that are kept while tiles are baked, coverage first.
    pub fn layers(&self) -> Vec<Layer> {
        working_layers(self.options, self.plan, self.solids.is_some())
    }

    /// Continues a page until it is finished or the listener cancels. The result does not depend on the number of
    /// threads or on where the page was interrupted.
    pub fn run(&self, page: &mut BakedPage, progress: &dyn Progress) {
        let Ok(whole) = self.fill(page, progress, &mut |_| Ok::<_, Infallible>(()));
        if whole {
            self.finish(page, progress);
        }
    }

    /// Bakes the tiles that a page lacks, and hands each to `save` once it is finished; false where the listener
    /// cancelled before the last. The page holds facts then, see [`BakedPage::planes`], until it is finished.
    ///
    /// # Errors
    /// Those of `save`, which end the run.
    pub fn fill<E: Send>(
        &self,
        page: &mut BakedPage,
        progress: &dyn Progress,
        save: &mut Take<'_, E>,
    ) -> Result<bool, E> {
        let raster = self.raster(page.page);
        let started = Instant::now();
        page.tiles.resize(raster.tiles().len(), None);
        let before = page.tiles.iter().flatten().map(|tile| tile.texels).sum();
        self.done.fetch_add(before, Ordering::Relaxed);
        let wanted: Vec<u32> = (0..page.tiles.len() as u32)
            .filter(|&tile| page.tiles[tile as usize].is_none())
            .collect();
        let total = self.atlas.audit.texels;
        let number = page.page;
        let whole = self.tiles(&raster, number, &wanted, (progress, total), &mut |tile| {
            page.store(&tile);
            save(tile)
        })?;
        page.stats.seconds += started.elapsed().as_secs_f64();
        Ok(whole)
    }

    /// What the last steps of its pages need.
    pub(crate) fn site(&self) -> Site<'_> {
        Site {
            world: self.world,
            plan: self.plan,
            atlas: self.atlas,
            options: self.options,
            mends: self.solids.is_some(),
            across: &self.across,
            rasters: &self.rasters,
        }
    }

    /// Makes the layers that were asked for of a page that has all its tiles.
    pub fn finish(&self, page: &mut BakedPage, progress: &dyn Progress) {
        progress.phase("denoising and closing seams");
        let started = Instant::now();
        for tile in std::mem::take(&mut page.tiles).iter().flatten() {
            page.stats.append(tile);
        }
        finish(page, &self.site());
        page.stats.seconds += started.elapsed().as_secs_f64();
    }

    /// Bakes tiles of a page, given by their index, and hands each to `take`; false where the listener cancelled before
    /// the last. `total` texels are what progress is told of.
    ///
    /// # Errors
    /// Those of `take`, which end the run.
    pub fn run_tiles<E: Send>(
        &self,
        page: u32,
        wanted: &[u32],
        (progress, total): (&dyn Progress, u64),
        take: &mut Take<'_, E>,
    ) -> Result<bool, E> {
        let raster = self.raster(page);
        self.tiles(&raster, page, wanted, (progress, total), take)
    }

    /// Tiles of a page that are not baked yet.
    pub fn missing(&self, page: &BakedPage) -> usize {
        let raster = self.raster(page.page);
        let tiles = raster.tiles().len();
        tiles - page.tiles.iter().take(tiles).flatten().count()
    }

    /// Counts texels as done that an earlier run baked.
    pub fn count_done(&self, texels: u64) {
        self.done.fetch_add(texels, Ordering::Relaxed);
    }

    fn tiles<E: Send>(
        &self,
        raster: &PageRaster<'_>,
        page: u32,
        wanted: &[u32],
        (progress, total): (&dyn Progress, u64),
        take: &mut Take<'_, E>,
    ) -> Result<bool, E> {
        progress.phase("baking");
        let columns = Columns::of(&self.layers());
        let rays = match wanted.is_empty() {
            true => &[][..],
            false => self.rays(page),
        };
        let taking = Mutex::new((take, Ok(())));
        let tile = |&index: &u32| {
            if progress.cancelled() {
                return None;
            }
            let cut = self.cut(raster, index as usize);
            let tile = self.tile(&cut, page, rays[index as usize]);
            let result = self.result(index, &columns, &tile);
            let own = result.stats.texels;
            let done = self.done.fetch_add(own, Ordering::Relaxed) + own;
            progress.rays(result.stats.rays);
            progress.advance(done.min(total), total);
            let mut taking = taking.lock().unwrap_or_else(PoisonError::into_inner);
            let (take, taken) = &mut *taking;
            if taken.is_ok() {
                *taken = take(result);
            }
            taken.is_ok().then_some(())
        };
        // Singly: of a run of tiles that one thread has begun no other could take the rest.
        let whole = wanted.par_iter().with_max_len(1).try_for_each(tile);
        let (_, taken) = taking.into_inner().unwrap_or_else(PoisonError::into_inner);
        taken.map(|()| whole.is_some())
    }

    /// Bakes up to `tiles` tiles spread over the atlas, for estimates.
    pub fn pilot(&self, tiles: usize) -> Pilot {
        let pages = 0..self.atlas.page_count;
        let each = tiles.div_ceil(pages.len().max(1)).max(1);
        let (mut cost, mut all) = (0.0, 0.0);
        let gather = GatherPilot::of(self);
        let mut gathered = Vec::new();
        let mut pilot = Pilot {
            texels: 0,
            rays: 0,
            cpu_seconds: 0.0,
            share: 0.0,
        };
        for page in pages {
            let raster = self.raster(page);
            let rays = self.rays(page);
            let costs = self.costs(page);
            all += costs.iter().sum::<f64>();
            // Equal steps through the tiles by cost, so that dear and cheap ones are picked as often as they are there.
            let mut order: Vec<usize> = (0..costs.len()).collect();
            order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
            let step = order.len().div_ceil(each).max(1);
            let picked: Vec<usize> = order.into_iter().skip(step / 2).step_by(step).collect();
            cost += picked.iter().map(|&tile| costs[tile]).sum::<f64>();
            let baked: Vec<(u64, u64, f64, Option<Taken>)> = picked
                .into_par_iter()
                .with_max_len(1)
                .map(|index| {
                    let clock = ThreadClock::now();
                    let Integrated { texels, terms, .. } =
                        self.tile(&self.cut(&raster, index), page, rays[index]);
                    let rays = terms.iter().map(|terms| terms.rays).sum();
                    let seconds = clock.seconds();
                    let taken = gather
                        .as_ref()
                        .map(|gather| gather.tile(&raster, page, index));
                    (texels.len() as u64, rays, seconds, taken)
                })
                .collect();
            for (texels, rays, seconds, taken) in baked {
                pilot.texels += texels;
                pilot.rays += rays;
                pilot.cpu_seconds += seconds;
                gathered.extend(taken);
            }
        }
        if let Some(gather) = gather {
            let (rays, seconds) = gather.all(&gathered.into_iter().sum());
            pilot.rays += rays;
            pilot.cpu_seconds += seconds;
        }
        pilot.share = if all > 0.0 { cost / all } else { 1.0 };
        pilot
    }

    /// The footprints of a tile.
    pub(crate) fn cut(&self, raster: &PageRaster<'_>, index: usize) -> Tile {
        let surveyor = self.surveyor();
        match self.options.footprint {
            Footprint::Texel => raster.whole_tile(index, |of| surveyor.keeps_whole(of)),
            Footprint::Centre => raster.centres(index),
        }
    }

    fn tile(&self, tile: &Tile, page: u32, rays: u32) -> Integrated {
        let options = self.options;
        let task = Task {
            backend: self.backend,
            arch: Arch::new(),
            seed: options.seed,
            page,
            size: self.atlas.page_size,
            rays,
            points: options.points,
            view: match options.view {
                View::Eye(eye) => View::Eye(eye - self.world.origin()),
                View::Normal => View::Normal,
            },
            model: options.model,
            shading: options.shading,
            t_max: options.max_distance.unwrap_or(f32::INFINITY),
            mixture: self.plan.mixture,
            full_lobes: options.full_highlights,
            hemisphere: self.plan.models(Choice::Diffuse),
            directional: options.is_directional(),
            any_view: options.any_view(),
            sky: &options.sky,
            draw_sky: options.draw_sky,
        };
        let texels = self.survey(tile, page);
        let lobes = self.plan.models(Choice::Specular);
        let specular: Vec<bool> = texels.iter().map(|t| lobes && self.reflects(t)).collect();
        let coats = Coat::of_all(&task, &texels);
        let terms = integrate(&task, &texels, &coats, &specular);
        let sealed = match finds_seals(options, self.plan) {
            true => seals(&task, &texels, &terms),
            false => vec![0.0; texels.len()],
        };
        let open_specular = |texel: &Texel| match options.model {
            Model::Ggx => 1.0,
            Model::Phong => {
                let view = task.view_from(texel.position, texel.normal);
                phong_open(
                    texel.material.exponent,
                    texel.normal.dot(view),
                    texel.normal.cross(view).length(),
                )
            }
        };
        let open_specular =
            texels.iter().zip(specular).map(
                |(texel, reflects)| {
                    if reflects { open_specular(texel) } else { 0.0 }
                },
            );
        Integrated {
            open_specular: open_specular.collect(),
            terms,
            coats,
            sealed,
            texels,
        }
    }

    /// k_a of a texel.
    fn ambient(&self, texel: &Texel) -> DVec3 {
        let own = || {
            let scene = self.world.scene();
            let mesh = scene.instances[texel.object as usize].mesh;
            let material = scene.meshes[mesh as usize].material;
            scene.materials[material as usize].ambient
        };
        match self.options.ambient {
            AmbientCoefficient::Albedo => texel.material.albedo,
            AmbientCoefficient::Rgb(rgb) => DVec3::from(rgb.map(f64::from)),
            AmbientCoefficient::Material => own().map_or(texel.material.albedo, |ka| ka.as_dvec3()),
        }
    }

    fn surveyor(&self) -> Surveyor<'_> {
        Surveyor {
            world: self.world,
            atlas: self.atlas,
            errors: &self.errors,
            overrides: &self.options.overrides,
            plan: self.plan,
            solids: self.solids,
            under: self.options.under,
        }
    }

    /// The texels of a tile, ready to be integrated.
    pub(crate) fn survey(&self, tile: &Tile, page: u32) -> Vec<Texel> {
        let (seed, size) = (self.options.seed, self.atlas.page_size);
        self.surveyor().texels(tile, |x, y, term| {
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
    fn result(&self, index: u32, columns: &Columns, tile: &Integrated) -> BakedTile {
        let size = self.atlas.page_size;
        let value = |texel: &BakedTexel, column: &Column| match column.layer {
            Layer::AnyView | Layer::AnyView4 | Layer::AnyView8 => {
                let any = texel.terms.any_view.as_ref();
                any.map_or(0.0, |any| any.coefficients.0[column.channel] as f32)
            }
            layer if directional::holds(layer) => {
                directional::packed(texel.terms, layer, column.channel) as f32
            }
            layer => texel.values(layer)[column.channel],
        };
        let baked = tile.texels.iter().enumerate();
        let baked = baked.map(|(i, texel)| BakedTexel {
            texel,
            terms: &tile.terms[i],
            coat: &tile.coats[i],
            ambient: self.ambient(texel),
            sealed: tile.sealed[i],
            open_specular: tile.open_specular[i],
        });
        let baked: Vec<BakedTexel> = baked.collect();
        let mut values = Vec::with_capacity(baked.len() * columns.0.len());
        for column in &columns.0 {
            values.extend(baked.iter().map(|texel| value(texel, column)));
        }
        let mut stats = PageStats::default();
        for (texel, terms) in tile.texels.iter().zip(&tile.terms) {
            let [coverage, seen] = [texel.coverage, texel.seen.share].map(f64::from);
            stats.texels += 1;
            stats.coverage += coverage;
            stats.buried += u64::from(seen == 0.0);
            stats.buried_area += coverage * (1.0 - seen);
            if seen > 0.0 {
                stats.errors.add(terms.diffuse, [texel.x, texel.y]);
                stats.irradiance_squares += terms.irradiance.std_err.powi(2);
            }
            stats.rays += terms.rays;
        }
        let texels = tile.texels.iter();
        BakedTile {
            index,
            texels: texels.map(|texel| texel.y * size + texel.x).collect(),
            values,
            stats,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Effort;
    use std::sync::Arc;

    #[test]
    fn a_tile_that_cannot_be_saved_ends_the_run_and_the_next_goes_on_to_the_same_page() {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/resting_sphere.obj"
        );
        let scene = Arc::new(scene::load(file.as_ref()).expect("a scene"));
        let options = Options {
            effort: Effort::Rays(4),
            ..Options::default()
        };
        let (plan, world) = Plan::of(&scene, &options).expect("a plan");
        let layout = atlas::Options {
            page_size: 128,
            ..Default::default()
        };
        let atlas = atlas::layout(&scene, &layout, &|| false).expect("a layout");
        let kind = rays::BackendKind::Obvhs(rays::Layout::default());
        let backend = rays::build(kind, &world, 0).expect("a backend");
        let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, &options);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build();
        let pool = pool.expect("threads");
        let mut whole = baker.start(0);
        pool.install(|| baker.run(&mut whole, &()));
        let tiles = baker.raster(0).tiles().len();
        assert!(tiles > 8 && whole.finished, "{tiles} tiles");

        let mut page = baker.start(0);
        let mut handed = 0;
        let ended = pool.install(|| {
            baker.fill(&mut page, &(), &mut |_| {
                handed += 1;
                if handed == 3 { Err("full") } else { Ok(()) }
            })
        });
        assert_eq!(ended, Err("full"));
        // None is handed on after the one that failed.
        assert_eq!((handed, baker.missing(&page)), (3, tiles - 3));
        pool.install(|| baker.run(&mut page, &()));
        assert!(page.finished && page.planes == whole.planes);
    }
}
