//! Light that bounces: surfaces send on what they receive, gather after gather.
//!
//! A gather integrates, at every texel, the radiosity of the surfaces that its rays meet: albedo at the hit, textures
//! included, times the irradiance that the pages hold there. The first one meets the light of sky and lights that
//! surfaces have received, and surfaces that shine by themselves; the next ones meet what the gather before has added.
//! The sum of all is the Neumann series of the radiosity equation (C. Goral, K. Torrance, D. Greenberg, B. Battaile,
//! "Modeling the Interaction of Light Between Diffuse Surfaces", 1984):
//!
//! ```text
//! E0 = sky + lights     E1 = gather(albedo E0 + emission)          Ek+1 = gather(albedo Ek)          E = E0 + E1 + E2
//! + ...
//! ```
//!
//! Lights without extent come first, by a gather of their own ([`Baker::bounce`] runs it whether or not light bounces).
//!
//! Only the sum is shown, and `E - E0 = gather(albedo (E0 + E1 + E2 + ...) + emission)`. So all gathers but the last
//! take few rays, and smooth what they find over neighbours: the last one, which has all rays, averages it over all the
//! texels that its rays meet. What is left of their noise is in the spread of its replicates, which meet different
//! texels. Highlights send nothing on, so only the last gather integrates lobes.
//!
//! Without a number of gathers they go on until so little changes in the ratio of one to the next that the rest is a
//! geometric series, whose sum is added.
//!
//! What the last gather finds is one page of light beside each finished page. It is mended, denoised, made seamless and
//! dilated as the terms are, and then added to the layers that show light.

mod add;
mod gather;
mod kernel;
mod light;
mod patches;
mod pilot;
mod radiosity;
mod spots;

pub use light::BounceStats;
pub(crate) use pilot::{GatherPilot, Taken};

use crate::choice::Choice;
use crate::labels;
use crate::options::{Bounces, Effort, View};
use crate::page::{BakedPage, BakedTile, Baker, light_layers};
use crate::survey::Texel;
use ambient::sampling::Stream;
use atlas::TILE;
use gather::{Gather, Integral, Points};
use glam::DVec3;
use layers::{Layer, Progress};
use light::{LightPage, TexelLight};
use patches::Patch;
use radiosity::{PageLight, Radiosity};
use rayon::prelude::*;
use rays::{Lamps, Light};
use rustc_hash::FxHashMap;
use spots::{Reach, Spots};
use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Independent sets of a texel's gathers: more than its first rays have, because fewer neighbours share what their
/// spread tells.
const REPLICATES: u32 = 4;

/// The most gathers of `auto`: a closed room of albedo 0.9 has sent on all but a thousandth of its light by then.
const MOST: u32 = 64;
/// `auto` stops where no more than this share of the light is missing: half a step of 8 bits. A target error takes its
/// place.
const ENOUGH: f64 = 1.0 / 512.0;
/// One texel in so many tells its neighbours which bright surfaces can be seen.
const PROBED: u32 = 4;
/// Gathers before the last take one of so many rays.
const FEWER: u32 = 8;
/// Rays of a gather where a target decides those of the terms.
const RAYS: u32 = 256;

/// Where the finished tiles of gathers are kept while light bounces, so that a run that was interrupted goes on amid
/// them. Gathers and pages count from 0; the values of a tile are those of [`Baker::layers_of_gathers`], of one gather
/// alone.
pub trait KeepGathers: Send {
    /// Why they could not be kept.
    type Error: Send;

    /// The tiles of a page that an earlier run finished in a gather; asked for once.
    ///
    /// # Errors
    /// They cannot be read.
    fn found(&mut self, gather: u32, page: u32) -> Result<Vec<BakedTile>, Self::Error>;

    /// Takes a finished tile.
    ///
    /// # Errors
    /// It cannot be kept.
    fn keep(&mut self, gather: u32, page: u32, tile: &BakedTile) -> Result<(), Self::Error>;
}

/// Keeps nothing.
impl KeepGathers for () {
    type Error = Infallible;

    fn found(&mut self, _: u32, _: u32) -> Result<Vec<BakedTile>, Infallible> {
        Ok(Vec::new())
    }

    fn keep(&mut self, _: u32, _: u32, _: &BakedTile) -> Result<(), Infallible> {
        Ok(())
    }
}

impl Baker<'_> {
    /// Adds the light of lights and what surfaces send on to all pages of the bake, which must be finished, and drops
    /// the layers that only this needed. `None` where the listener cancels; the pages then stand as they were. Tiles of
    /// gathers go through `kept`: a run that finds those of one that was interrupted ends with the same values.
    ///
    /// # Errors
    /// Those of `kept`, which end the run.
    pub fn bounce<K: KeepGathers>(
        &self,
        pages: &mut [BakedPage],
        kept: &mut K,
        progress: &dyn Progress,
    ) -> Result<Option<BounceStats>, K::Error> {
        let started = Instant::now();
        let mut stats = BounceStats::default();
        let layers = self.layers_of_gathers();
        // Rays of each page: those of gathers whose pages of light are added, and those of the others.
        let mut shown = vec![0; pages.len()];
        let mut hidden = shown.clone();
        let count = |rays: &mut [u64], light: &[LightPage]| {
            (rays.iter_mut().zip(light)).for_each(|(rays, light)| *rays += light.rays);
        };
        let lights = self.lights();
        // The gather of the lights comes before all others.
        let first = u32::from(!lights.is_empty());
        if !lights.is_empty() {
            progress.phase("gather of lights");
            let spots = Spots::default();
            let gather = Gather {
                lights: &lights,
                ..self.gather(&[], true, &spots)
            };
            let dark = pages.iter().map(|page| LightPage::new(page, &layers));
            let mut light: Vec<LightPage> = dark.collect();
            if self
                .gathered(&gather, 0, &mut light, kept, progress)?
                .is_none()
            {
                return Ok(None);
            }
            count(&mut shown, &light);
            for (page, light) in pages.iter_mut().zip(light) {
                add::add(page, light.finished(self), true);
            }
        }
        if self.plan.models(Choice::Bounces) {
            let lamps = Lamps::of(self.world);
            let lamps = (!lamps.is_empty()).then_some(&lamps);
            let dark = || pages.iter().map(|page| LightPage::new(page, &layers));
            let mut sum: Vec<PageLight> = pages.iter().map(first_light).collect();
            let mut sent = sum.clone();
            let Some(patches) = self.patches(progress) else {
                return Ok(None);
            };
            stats.start(pages);
            while stats.goes_on(self.options.bounces.before_last(), self.enough()) {
                let spots = Spots::of(&patches, &sent);
                let gather = Gather {
                    lamps: lamps.filter(|_| stats.gathers == 0),
                    ..self.gather(&sent, false, &spots)
                };
                let mut light: Vec<LightPage> = dark().collect();
                let number = first + stats.gathers;
                progress.phase(&format!("gather {}", stats.gathers + 1));
                let gathered = self.gathered(&gather, number, &mut light, kept, progress)?;
                let Some(gathered) = gathered else {
                    return Ok(None);
                };
                for (sum, gathered) in sum.iter_mut().zip(&gathered) {
                    sum.add(gathered, 1.0);
                }
                sent = gathered;
                count(&mut hidden, &light);
                stats.end_gather(&light);
            }
            if self.options.bounces == Bounces::Auto {
                for (sum, sent) in sum.iter_mut().zip(&sent) {
                    sum.add(sent, stats.rest());
                }
                stats.end_series();
            }
            drop(sent);
            let spots = Spots::of(&patches, &sum);
            let gather = Gather {
                lamps,
                ..self.gather(&sum, true, &spots)
            };
            let mut light: Vec<LightPage> = dark().collect();
            let number = first + stats.gathers;
            progress.phase("last gather");
            let gathered = self.gathered(&gather, number, &mut light, kept, progress)?;
            if gathered.is_none() {
                return Ok(None);
            }
            stats.end_last(&light);
            count(&mut shown, &light);
            for (page, light) in pages.iter_mut().zip(light) {
                add::add(page, light.finished(self), false);
            }
        }
        let seconds = started.elapsed().as_secs_f64();
        let all = (shown.iter().chain(&hidden).sum::<u64>() as f64).max(1.0);
        for ((page, shown), hidden) in pages.iter_mut().zip(shown).zip(hidden) {
            page.stats.rays += hidden;
            page.stats.seconds += seconds * (shown + hidden) as f64 / all;
            let asked = |layer| layer == Layer::Coverage || self.options.layers.contains(&layer);
            page.planes.retain(|planes| asked(planes.layer));
        }
        Ok(Some(stats))
    }

    /// The layers that a gather brings light to, and facts of surfaces beside them.
    pub fn layers_of_gathers(&self) -> Vec<Layer> {
        light_layers(self.options, self.plan, self.solids.is_some())
    }

    /// The share of the light that may be missing under `auto`.
    fn enough(&self) -> f64 {
        match self.options.effort {
            Effort::Rays(_) => ENOUGH,
            Effort::Target { error, .. } => error,
        }
    }

    /// The lights without extent that are modelled, in the world's coordinates.
    fn lights(&self) -> Vec<Light> {
        let lights = self.options.lights.iter();
        let lights = lights.filter(|_| self.plan.models(Choice::Lights));
        lights
            .map(|light| light.from_origin(self.world.origin()))
            .collect()
    }

    /// The surfaces of all pages that send light on.
    fn patches(&self, progress: &dyn Progress) -> Option<Vec<Vec<Patch>>> {
        let size = self.atlas.page_size;
        let page = |page: u32| {
            let raster = self.raster(page);
            let tile = |index| {
                if progress.cancelled() {
                    return None;
                }
                let texels = self.texels(&raster, page, index);
                let patches = texels.iter();
                Some(
                    patches
                        .filter_map(|t| Patch::of(t, t.y * size + t.x))
                        .collect(),
                )
            };
            let tiles = (0..raster.tiles().len()).into_par_iter();
            let tiles = tiles.with_max_len(1).map(tile);
            let tiles: Option<Vec<Vec<Patch>>> = tiles.collect();
            Some(tiles?.concat())
        };
        (0..self.atlas.page_count).map(page).collect()
    }

    /// What a gather reads that is sent this light and no other. The last one takes all rays.
    fn gather<'g>(&'g self, sent: &'g [PageLight], last: bool, spots: &'g Spots) -> Gather<'g> {
        let rays = match self.options.effort {
            Effort::Rays(rays) => rays,
            Effort::Target { max_rays, .. } => RAYS.min(max_rays),
        };
        Gather {
            backend: self.backend,
            radiosity: Radiosity {
                world: self.world,
                atlas: self.atlas,
                overrides: &self.options.overrides,
                pages: sent,
            },
            lamps: None,
            lights: &[],
            spots,
            last,
            points: (if last { rays } else { rays / FEWER } / REPLICATES).max(1),
            shading: self.options.shading,
            view: match self.options.view {
                View::Eye(eye) => View::Eye(eye - self.world.origin()),
                View::Normal => View::Normal,
            },
            model: self.options.model,
            t_max: self.options.max_distance.unwrap_or(f32::INFINITY),
        }
    }

    /// Runs a gather over all pages, adds what it received to `light`, and returns it as what the next one is sent;
    /// `None` where the listener cancels.
    fn gathered<K: KeepGathers>(
        &self,
        gather: &Gather<'_>,
        number: u32,
        light: &mut [LightPage],
        kept: &mut K,
        progress: &dyn Progress,
    ) -> Result<Option<Vec<PageLight>>, K::Error> {
        let (done, total) = (AtomicU64::new(0), self.atlas.audit.texels);
        let advance = |texels: usize| {
            let own = texels as u64;
            progress.advance(done.fetch_add(own, Ordering::Relaxed) + own, total);
        };
        let mut received = Vec::new();
        for (page, light) in (0..).zip(light.iter_mut()) {
            let raster = self.raster(page);
            let mut next = light.dark();
            light.begin();
            for tile in kept.found(number, page)? {
                if light.add(&tile, &mut next) {
                    advance(tile.texels.len());
                }
            }
            let tiles = 0..raster.tiles().len() as u32;
            let wanted: Vec<u32> = tiles.filter(|&tile| !light.has(tile)).collect();
            let columns = light.columns();
            let adding = Mutex::new((light, &mut next, &mut *kept, Ok(())));
            let tile = |&index: &u32| {
                if progress.cancelled() {
                    return None;
                }
                let texels = self.texels(&raster, page, index as usize);
                let texels = self.tile_light(gather, number, page as usize, &texels);
                let tile = light::tile(index, &texels, &columns);
                progress.rays(tile.stats.rays);
                advance(tile.texels.len());
                let mut adding = adding.lock().unwrap_or_else(PoisonError::into_inner);
                let (light, next, kept, saved) = &mut *adding;
                if saved.is_ok() {
                    light.add(&tile, next);
                    *saved = kept.keep(number, page, &tile);
                }
                saved.is_ok().then_some(())
            };
            let whole = wanted.par_iter().with_max_len(1).try_for_each(tile);
            let (.., saved) = adding.into_inner().unwrap_or_else(PoisonError::into_inner);
            saved?;
            if whole.is_none() {
                return Ok(None);
            }
            received.push(next);
        }
        Ok(Some(received))
    }

    /// What the texels of a tile receive.
    fn tile_light(
        &self,
        gather: &Gather<'_>,
        number: u32,
        page: usize,
        texels: &[Texel],
    ) -> Vec<TexelLight> {
        let size = self.atlas.page_size;
        let lobes = self.plan.models(Choice::Specular);
        let mut light: Vec<TexelLight> = texels
            .iter()
            .map(|texel| TexelLight::dark(texel, texel.y * size + texel.x))
            .collect();
        // Some texels of each object go first and tell the others what can be seen.
        let mut reach: FxHashMap<u32, Reach> = FxHashMap::default();
        let first = |texel: &Texel| (texel.x + 2 * texel.y).is_multiple_of(PROBED);
        for probes in [true, false] {
            let known = reach.clone();
            for (texel, light) in texels.iter().zip(&mut light) {
                // What nothing stands above sees no surface; what is buried is filled from its neighbours.
                let dark = texel.open && gather.lights.is_empty();
                if first(texel) != probes || dark || texel.seen.share == 0.0 {
                    continue;
                }
                let stream = |integral: u32, count: u32, points: Points, replicate: u32| {
                    let label = labels::BOUNCE + 6 * number + 3 * integral + points as u32;
                    let tile = 1 << 31 | (texel.y / TILE * size.div_ceil(TILE) + texel.x / TILE);
                    let stream =
                        Stream::new(self.options.seed, page as u32, tile, label, replicate);
                    stream.joint(
                        [texel.x, texel.y],
                        TILE.ilog2(),
                        &(0..count.next_power_of_two()),
                    )
                };
                let mut learnt = match probes {
                    true => Reach::default(),
                    false => known.get(&texel.object).copied().unwrap_or_default(),
                };
                let count = gather.points;
                let diffuse = |points, replicate| stream(0, count, points, replicate);
                let (irradiance, rays) =
                    gather.receive(texel, Integral::Irradiance, count, diffuse, &mut learnt);
                (light.irradiance, light.rays) = (irradiance, rays);
                if probes {
                    reach.entry(texel.object).or_default().add(&learnt);
                }
                if lobes && gather.last && self.reflects(texel) {
                    let share = gather.lobe_share(texel, self.options.full_highlights);
                    let count = ((count as f32 * share) as u32).max(1);
                    let lobe = |points, replicate| stream(1, count, points, replicate);
                    let (reflection, rays) =
                        gather.receive(texel, Integral::Reflection, count, lobe, &mut learnt);
                    light.reflection = reflection;
                    light.rays += rays;
                }
            }
        }
        light::pool(&mut light, size, !gather.last);
        light
    }
}

/// The light of a finished page that surfaces send on first: that of the sky and of lights.
fn first_light(page: &BakedPage) -> PageLight {
    let channel = |layer, channel| page.channel(layer, channel).unwrap_or_default();
    let [r, g, b] = [0, 1, 2].map(|c| channel(Layer::Irradiance, c));
    let (coverage, validity) = (channel(Layer::Coverage, 0), page.layer(Layer::Validity));
    let seen = |texel: usize| validity.is_none_or(|validity| validity[texel] > 0.0);
    PageLight {
        irradiance: (0..page.texels()).map(|i| [r[i], g[i], b[i]]).collect(),
        holds: (0..page.texels())
            .map(|i| coverage[i] > 0.0 && seen(i))
            .collect(),
    }
}

/// The mean of the channels.
fn mean(rgb: DVec3) -> f64 {
    rgb.element_sum() / 3.0
}

#[cfg(test)]
mod tests;
