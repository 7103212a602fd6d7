//! What tiles cost, and how they are dealt to the shards of a bake.

use super::baker::Baker;
use crate::choice::Choice;
use rayon::prelude::*;
use scene::MaterialModel;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Cost of a texel that takes no rays, where an integral by rays costs 1.
const FREE: f64 = 0.02;
/// Cost of a triangle in a tile, which is cut out and surveyed.
const PIECE: f64 = 0.2;

/// Deals the tiles of page after page to shards, so that each has the same predicted cost. It depends on the costs
/// alone, so that every shard comes to the same answer.
#[derive(Debug, Clone)]
pub struct Deal {
    /// What each shard has so far, the least loaded on top.
    loads: BinaryHeap<Reverse<Load>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Load {
    cost: f64,
    shard: u32,
}

impl Eq for Load {}

impl PartialOrd for Load {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Load {
    fn cmp(&self, other: &Self) -> Ordering {
        let cost = self.cost.total_cmp(&other.cost);
        cost.then(self.shard.cmp(&other.shard))
    }
}

impl Deal {
    /// A deal to so many shards, at least 1.
    pub fn new(shards: u32) -> Self {
        let empty = |shard| Reverse(Load { cost: 0.0, shard });
        Self {
            loads: (0..shards.max(1)).map(empty).collect(),
        }
    }

    /// The shard of each tile of the next page, from its cost: the dearest goes first, each to the shard that has
    /// least.
    pub fn page(&mut self, costs: &[f64]) -> Vec<u32> {
        let mut order: Vec<usize> = (0..costs.len()).collect();
        order.sort_by(|&a, &b| costs[b].total_cmp(&costs[a]).then(a.cmp(&b)));
        let mut shards = vec![0; costs.len()];
        for tile in order {
            let Some(mut least) = self.loads.peek_mut() else {
                break;
            };
            shards[tile] = least.0.shard;
            least.0.cost += costs[tile];
        }
        shards
    }
}

impl Baker<'_> {
    /// What each tile of a page costs, by its index: texels times integrals that take rays, without a unit. It is a
    /// function of the scene, the layout and the options alone.
    pub fn costs(&self, page: u32) -> Vec<f64> {
        let scene = self.world.scene();
        let raster = self.raster(page);
        let meshes = scene.meshes.iter();
        let reflects: Vec<bool> = meshes.map(|mesh| self.may_reflect(mesh)).collect();
        let lit = self.options.sky.map().is_some();
        let count = |yes: bool| f64::from(u8::from(yes));
        let weight = |[instance, triangle]: [u32; 2]| {
            let mesh = scene.instances[instance as usize].mesh as usize;
            let cast = lit || !self.plan.open.contains(instance, triangle);
            match cast {
                true => 1.0 + count(reflects[mesh]) + count(lit),
                false => FREE,
            }
        };
        (0..raster.tiles().len())
            .into_par_iter()
            .map(|tile| {
                let areas = raster.areas(tile);
                areas.map(|(of, area)| area * weight(of) + PIECE).sum()
            })
            .collect()
    }

    /// True where texels of the mesh may take rays over the lobe.
    fn may_reflect(&self, mesh: &scene::Mesh) -> bool {
        let own = match &self.world.scene().materials[mesh.material as usize].surface {
            MaterialModel::Phong { specular, .. }
            | MaterialModel::SpecularGlossiness { specular, .. } => specular.max_element() > 0.0,
            MaterialModel::MetallicRoughness { .. } => true,
        };
        let overrides = &self.options.overrides;
        let tinted = overrides
            .specular
            .map_or(own, |rgb| rgb.iter().any(|&v| v > 0.0));
        let forced = overrides.exponent.is_some() || !self.options.allows(Choice::Specular);
        self.plan.models(Choice::Specular) && (forced || tinted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_get_the_same_cost_and_every_tile_once() {
        let costs: Vec<f64> = (0..1000u32).map(|i| f64::from(i * 7919 % 263)).collect();
        for shards in [1, 3, 8, 700, 2000] {
            let mut deal = Deal::new(shards);
            let mut loads = vec![0.0; shards as usize];
            for page in costs.chunks(300) {
                let of = deal.page(page);
                assert_eq!(of.len(), page.len());
                for (shard, cost) in of.iter().zip(page) {
                    loads[*shard as usize] += cost;
                }
            }
            let most = loads.iter().copied().fold(0.0, f64::max);
            let mean = costs.iter().sum::<f64>() / f64::from(shards);
            assert!(most <= mean + 263.0, "{shards}: {most} against {mean}");
        }
    }

    #[test]
    fn dealing_again_gives_the_same_shards() {
        let costs = [3.0, 1.0, 3.0, 0.0, 2.0];
        let deal = || [Deal::new(2), Deal::new(2)].map(|mut deal| deal.page(&costs));
        let [a, b] = deal();
        assert_eq!(a, b);
        assert_eq!(a, [0, 1, 1, 1, 0]);
    }
}
