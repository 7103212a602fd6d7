//! A few tiles baked for estimates.

use super::baker::Baker;
use super::integrated::Integrated;
use crate::bounce::{GatherPilot, Taken};
use crate::clock::ThreadClock;
use rayon::prelude::*;

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

impl Baker<'_> {
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
                    let texels = self.texels(&raster, page, index);
                    let Integrated { texels, terms, .. } = self.tile(texels, page, rays[index]);
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
}
