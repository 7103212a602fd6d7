//! Whose a texel is: which chart covers it, and where.

use super::border::Chart;
use atlas::{Footprint, PageRaster, TILE, Tile};
use glam::DVec2;
use rayon::prelude::*;
use scene::Scene;

/// A page with what is needed to tell whose its texels are.
pub(super) struct Page<'a> {
    pub scene: &'a Scene,
    /// The chart of each triangle, mesh by mesh.
    pub charts: &'a [Vec<u32>],
    pub raster: &'a PageRaster<'a>,
    /// Its edge in texels.
    pub size: u32,
    /// The share of each texel that can be seen; `None` where all can.
    pub validity: Option<&'a [f32]>,
}

/// What covers a texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Owner {
    /// The only chart; `None` where there are several.
    pub chart: Option<Chart>,
    /// Centroid of the footprint, in texels of the page.
    pub middle: DVec2,
}

impl Page<'_> {
    /// The owner of each of these texels, which ascend; `None` where no chart covers it.
    pub fn owners(&self, texels: &[u32]) -> Vec<Option<Owner>> {
        let across = self.size.div_ceil(TILE);
        let tile = |texel: u32| (texel / self.size / TILE) * across + texel % self.size / TILE;
        let mut order: Vec<usize> = (0..texels.len()).collect();
        order.par_sort_by_key(|&i| tile(texels[i]));
        let groups: Vec<&[usize]> = order
            .chunk_by(|&i, &j| tile(texels[i]) == tile(texels[j]))
            .collect();
        let found = groups.par_iter().flat_map_iter(|group| {
            let number = tile(texels[group[0]]);
            let index = self.raster.tiles().binary_search(&number).ok();
            let cut = index.map(|index| self.raster.tile(index));
            group.iter().map(move |&i| {
                let owner = cut.as_ref().and_then(|cut| self.owner(cut, texels[i]));
                (i, owner)
            })
        });
        let mut owners = vec![None; texels.len()];
        for (i, owner) in found.collect::<Vec<_>>() {
            owners[i] = owner;
        }
        owners
    }

    fn owner(&self, tile: &Tile, texel: u32) -> Option<Owner> {
        let own = (texel / self.size, texel % self.size);
        let place = |footprint: &Footprint| (footprint.y, footprint.x);
        let at = tile.footprints.binary_search_by_key(&own, place).ok()?;
        let footprint = &tile.footprints[at];
        let pieces = tile.pieces_of(footprint);
        let chart = |piece: &atlas::Piece| {
            let mesh = self.scene.instances[piece.instance as usize].mesh;
            [
                piece.instance,
                self.charts[mesh as usize][piece.triangle as usize],
            ]
        };
        let first = chart(&pieces[0]);
        Some(Owner {
            chart: pieces
                .iter()
                .all(|piece| chart(piece) == first)
                .then_some(first),
            middle: self.raster.middle(tile, footprint),
        })
    }

    /// The centre of a texel, in texels of the page.
    pub fn centre(&self, texel: u32) -> DVec2 {
        let (x, y) = (texel % self.size, texel / self.size);
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }
}
