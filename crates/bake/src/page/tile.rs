//! A finished tile: what the page keeps of its texels.

use super::stats::PageStats;
use layers::Layer;

/// A finished tile of a page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BakedTile {
    /// Index into the raster's tiles.
    pub index: u32,
    /// Its texels, row-major over the page.
    pub texels: Vec<u32>,
    /// Channel by channel, in the order of [`Baker::layers`](super::Baker::layers) and of their channels, one value
    /// for each texel.
    pub values: Vec<f32>,
    /// Sums over its texels.
    pub stats: PageStats,
}

impl BakedTile {
    /// The values of each channel, channel by channel.
    pub fn channels(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.texels.len().max(1))
    }
}

/// Every channel of the layers that a page keeps, layer by layer.
pub(crate) struct Columns(pub Vec<Column>);

/// One channel of one layer.
pub(crate) struct Column {
    /// Index into the page's planes.
    pub planes: usize,
    pub layer: Layer,
    pub channel: usize,
}

impl Columns {
    pub fn of(layers: &[Layer]) -> Self {
        let channels = |(planes, &layer): (usize, &Layer)| {
            (0..layer.channels().len()).map(move |channel| Column {
                planes,
                layer,
                channel,
            })
        };
        Self(layers.iter().enumerate().flat_map(channels).collect())
    }
}
