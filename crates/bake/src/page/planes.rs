//! A page in work or finished: its layers as planes of numbers.

use super::stats::PageStats;
use super::tile::{BakedTile, Columns};
use crate::mend::Mends;
use atlas::TILE;
use layers::Layer;
use rayon::prelude::*;

/// All values of one layer over a page.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerPlanes {
    /// The layer.
    pub layer: Layer,
    /// One plane of `size * size` values after another, one for each of [`Layer::channels`], row 0 on top.
    pub values: Vec<f32>,
}

/// A page in work or finished.
#[derive(Debug, Clone, PartialEq)]
pub struct BakedPage {
    /// Page number.
    pub page: u32,
    /// Edge in texels.
    pub size: u32,
    /// Sums over each tile in the raster's order, `None` for those that are not baked yet; empty when the page is
    /// finished.
    pub tiles: Vec<Option<PageStats>>,
    /// True when every tile is finished and gutters are filled.
    pub finished: bool,
    /// The layers so far, [`Layer::Coverage`] first. While a page is in work these are facts, from which the asked
    /// layers follow; when it is finished, those that were asked for.
    pub planes: Vec<LayerPlanes>,
    /// Sums over all texels, once the page is finished.
    pub stats: PageStats,
}

impl LayerPlanes {
    /// Planes of void texels.
    pub(crate) fn void(layer: Layer, texels: usize) -> Self {
        Self {
            layer,
            values: vec![layer.void(); texels * layer.channels().len()],
        }
    }
}

impl BakedPage {
    /// Texels of the page, void ones too.
    pub fn texels(&self) -> usize {
        self.size as usize * self.size as usize
    }

    /// All values of a layer, one plane of `size * size` after another, one for each of its channels; row 0 is on top.
    /// `None` where it was not asked for.
    pub fn layer(&self, layer: Layer) -> Option<&[f32]> {
        let found = self.planes.iter().find(|planes| planes.layer == layer);
        found.map(|planes| planes.values.as_slice())
    }

    /// A tile as it was stored; `None` where it is not in the page, or the page is finished. `number` is its row-major
    /// number over the page, which the raster knows.
    pub fn stored(&self, index: u32, number: u32) -> Option<BakedTile> {
        let stats = (*self.tiles.get(index as usize)?)?;
        let across = self.size.div_ceil(TILE);
        let [left, top] = [number % across * TILE, number / across * TILE];
        let rows = top..(top + TILE).min(self.size);
        let columns = left..(left + TILE).min(self.size);
        let places = rows.flat_map(|y| columns.clone().map(move |x| y * self.size + x));
        let coverage = self.layer(Layer::Coverage)?;
        let texels: Vec<u32> = places
            .filter(|&texel| coverage[texel as usize] > 0.0)
            .collect();
        let plane = self.texels();
        let columns = self.columns().0;
        let mut values = Vec::with_capacity(texels.len() * columns.len());
        for column in &columns {
            let channel = &self.planes[column.planes].values[column.channel * plane..][..plane];
            values.extend(texels.iter().map(|&texel| channel[texel as usize]));
        }
        (texels.len() as u64 == stats.texels).then_some(BakedTile {
            index,
            texels,
            values,
            stats,
        })
    }

    /// The values of one channel of a layer: `size * size` of them.
    ///
    /// # Panics
    /// Where the layer has no such channel.
    pub fn channel(&self, layer: Layer, channel: usize) -> Option<&[f32]> {
        let texels = self.texels();
        assert!(
            channel < layer.channels().len(),
            "channel {channel} of {}",
            layer.name()
        );
        self.layer(layer)
            .map(|values| &values[channel * texels..][..texels])
    }

    /// Puts a finished tile into the page; false, and nothing is done, where it does not fit.
    pub fn store(&mut self, tile: &BakedTile) -> bool {
        let columns = self.columns();
        if self.finished || !self.fits(tile, &columns) {
            return false;
        }
        let plane = self.texels();
        for (column, values) in columns.0.iter().zip(tile.channels()) {
            let planes = &mut self.planes[column.planes].values;
            let channel = &mut planes[column.channel * plane..][..plane];
            for (&texel, &value) in tile.texels.iter().zip(values) {
                channel[texel as usize] = value;
            }
        }
        self.count(tile);
        true
    }

    /// Every channel of its planes.
    pub(crate) fn columns(&self) -> Columns {
        let layers: Vec<Layer> = self.planes.iter().map(|planes| planes.layer).collect();
        Columns::of(&layers)
    }

    /// True where a tile may be put into the page; false where it has other numbers of texels or values than it says, a
    /// place outside of the page or of one square of the grid of tiles, or is there already.
    pub(crate) fn fits(&self, tile: &BakedTile, columns: &Columns) -> bool {
        let (plane, index) = (self.texels(), tile.index as usize);
        let across = self.size.div_ceil(TILE);
        let square = |texel: u32| (texel / self.size / TILE) * across + texel % self.size / TILE;
        index < (across * across) as usize
            && !self.has(tile.index)
            && tile.stats.texels == tile.texels.len() as u64
            && tile.values.len() == tile.texels.len() * columns.0.len()
            && tile
                .texels
                .iter()
                .all(|&texel| (texel as usize) < plane && square(texel) == square(tile.texels[0]))
    }

    /// True where it has the tile of this index.
    pub(crate) fn has(&self, index: u32) -> bool {
        self.tiles.get(index as usize).is_some_and(Option::is_some)
    }

    /// Notes that a tile is there.
    pub(crate) fn count(&mut self, tile: &BakedTile) {
        let index = tile.index as usize;
        self.tiles.resize(self.tiles.len().max(index + 1), None);
        self.tiles[index] = Some(tile.stats);
    }

    /// The planes of a layer that the page must have.
    pub(crate) fn planes_of(&mut self, layer: Layer) -> &mut [f32] {
        let found = self.planes.iter_mut().find(|planes| planes.layer == layer);
        let missing = || panic!("the page has no layer {}", layer.name());
        found.map_or_else(missing, |planes| &mut planes.values)
    }

    /// Mends a layer, where the page has it, by values between two.
    pub(super) fn mend(&mut self, layer: Layer, mends: &Mends, [least, most]: [f64; 2]) {
        if self.layer(layer).is_some() {
            let texels = self.texels();
            let planes = self.planes_of(layer).par_chunks_mut(texels);
            planes.for_each(|plane| drop(mends.apply(plane, least, most)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tiles_that_fit_a_page_are_stored() {
        let size = 2 * TILE;
        let texels = (size * size) as usize;
        let mut page = BakedPage {
            page: 0,
            size,
            tiles: Vec::new(),
            finished: false,
            planes: vec![
                LayerPlanes::void(Layer::Coverage, texels),
                LayerPlanes::void(Layer::Diffuse, texels),
            ],
            stats: PageStats::default(),
        };
        let tile = BakedTile {
            index: 3,
            texels: vec![TILE, TILE + 1, size + TILE],
            values: vec![1.0, 1.0, 0.5, 0.5, 0.25, 0.125],
            stats: PageStats {
                texels: 3,
                ..PageStats::default()
            },
        };
        let mut refused = |edit: &dyn Fn(&mut BakedTile)| {
            let mut other = tile.clone();
            edit(&mut other);
            assert!(!page.store(&other), "{other:?}");
            assert!(page.tiles.iter().all(Option::is_none));
        };
        refused(&|tile| tile.index = 4);
        refused(&|tile| tile.index = u32::MAX);
        refused(&|tile| tile.stats.texels = 4);
        refused(&|tile| tile.values.truncate(5));
        // Of the square beside, of the one below, and beyond the page.
        refused(&|tile| tile.texels[1] = TILE - 1);
        refused(&|tile| tile.texels[1] = TILE * size + TILE);
        refused(&|tile| tile.texels[1] = texels as u32);
        assert!(page.store(&tile));
        assert!(!page.store(&tile), "it is there");
        let diffuse = page.layer(Layer::Diffuse).expect("a layer");
        assert_eq!(diffuse[TILE as usize], 0.5);
        assert_eq!(diffuse[(size + TILE) as usize], 0.125);
    }
}
