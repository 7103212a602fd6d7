//! A page in work or finished: its layers as planes of numbers.

use super::stats::PageStats;
use super::tile::{BakedTile, Columns};
use layers::Layer;

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
    /// Sums over each tile in the raster's order, `None` for those that are not baked yet; empty when the page is finished.
    pub tiles: Vec<Option<PageStats>>,
    /// True when every tile is finished and gutters are filled.
    pub finished: bool,
    /// The layers so far, [`Layer::Coverage`] first. While a page is in work these are facts, from which the asked layers follow; when
    /// it is finished, those that were asked for.
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

    /// Puts a finished tile into the page; false, and nothing is done, where it does not fit: another number of values, a place outside
    /// of the page, or a tile that is there already.
    pub fn store(&mut self, tile: &BakedTile) -> bool {
        let layers: Vec<Layer> = self.planes.iter().map(|planes| planes.layer).collect();
        let columns = Columns::of(&layers);
        let (plane, index) = (self.texels(), tile.index as usize);
        let fits = index < plane
            && self.tiles.get(index).is_none_or(Option::is_none)
            && tile.values.len() == tile.texels.len() * columns.0.len()
            && tile.texels.iter().all(|&texel| (texel as usize) < plane);
        if self.finished || !fits {
            return false;
        }
        for (&texel, values) in tile.texels.iter().zip(tile.values.chunks(columns.0.len())) {
            for (column, &value) in columns.0.iter().zip(values) {
                let at = column.channel * plane + texel as usize;
                self.planes[column.planes].values[at] = value;
            }
        }
        self.tiles.resize(self.tiles.len().max(index + 1), None);
        self.tiles[index] = Some(tile.stats);
        true
    }

    /// The planes of a layer that the page must have.
    pub(crate) fn planes_of(&mut self, layer: Layer) -> &mut [f32] {
        let found = self.planes.iter_mut().find(|planes| planes.layer == layer);
        let missing = || panic!("the page has no layer {}", layer.name());
        found.map_or_else(missing, |planes| &mut planes.values)
    }
}
