//! Bakes pages of an atlas: tiles in parallel, results into planes in a fixed order.

use super::finish::{Site, finish};
use super::planes::{BakedPage, LayerPlanes};
use super::stats::PageStats;
use super::surveys::Surveys;
use super::terms::working_layers;
use super::tile::{BakedTile, Columns};
use crate::options::{Buried, Options};
use crate::plan::Plan;
use crate::seams::Across;
use atlas::{Atlas, PageRaster, Rasters};
use layers::{Layer, Progress};
use rayon::prelude::*;
use rays::{Covering, PlaneErrors, RayBackend, Solids, World};
use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
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
    /// What covers what, where the options say how far above it.
    pub(crate) covering: Option<Arc<Covering>>,
    /// What finished pages hold on seams that they share with others. Pages are finished in their order; one that is
    /// finished without those before it is not tied to them.
    across: Across,
    rasters: Rasters,
    /// Texels that were made and are needed again; a pilot shares those of its baker.
    pub(super) surveys: Arc<Surveys>,
    /// It only says how large errors are, by points of its own.
    pub(super) is_pilot: bool,
    /// How many rays tiles take, by page.
    pub(super) rays: Vec<OnceLock<Vec<u32>>>,
    /// Texels finished so far, over all pages.
    done: AtomicU64,
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
        let asked = options.under.filter(|&under| under > 0.0);
        let covering = (asked.filter(|_| options.buried == Buried::Drop))
            // What lies between once and twice as high covers by half.
            .map(|under| Arc::new(world.solids().covering(2.0 * under)));
        Self::covered(world, plan, backend, atlas, options, covering)
    }

    /// A baker of the same that only says how large errors are.
    pub(super) fn seeking<'b>(&'b self, options: &'b Options) -> Baker<'b> {
        let (world, plan, backend) = (self.world, self.plan, self.backend);
        Baker {
            surveys: Arc::clone(&self.surveys),
            is_pilot: true,
            ..Baker::covered(
                world,
                plan,
                backend,
                self.atlas,
                options,
                self.covering.clone(),
            )
        }
    }

    /// A baker where what covers what is known.
    fn covered(
        world: &'a World,
        plan: &'a Plan,
        backend: &'a dyn RayBackend,
        atlas: &'a Atlas,
        options: &'a Options,
        covering: Option<Arc<Covering>>,
    ) -> Self {
        let covers = covering.as_ref().is_some_and(|of| !of.is_empty());
        let solids = match options.buried {
            Buried::Drop => Some(world.solids()).filter(|solids| covers || !solids.is_idle()),
            Buried::Keep => None,
        };
        Self {
            solids,
            covering,
            world,
            plan,
            backend,
            atlas,
            options,
            errors: PlaneErrors::of(world),
            across: Across::default(),
            rasters: Rasters::default(),
            surveys: Arc::default(),
            is_pilot: false,
            rays: (0..atlas.page_count).map(|_| OnceLock::new()).collect(),
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
        let rays = (!wanted.is_empty()).then(|| self.rays(page));
        let taking = Mutex::new((take, Ok(())));
        let tile = |&index: &u32| {
            if progress.cancelled() {
                return None;
            }
            let rays = rays?[index as usize];
            let texels = self.texels(raster, page, index as usize);
            let result = self.result(index, &columns, &self.tile(texels, page, rays));
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
        let kind = rays::BackendKind::Obvhs(rays::TreeKind::default());
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
