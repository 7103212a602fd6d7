//! A finished bake in memory.

use crate::job::Job;
use ::bake::{BakedPage, BounceStats, PageStats};
use layers::Layer;

/// Every page of a finished bake, and what is needed to write them.
#[derive(Debug)]
pub struct Baked {
    job: Job,
    pages: Vec<Page>,
    bounces: Option<BounceStats>,
}

/// One page of the atlas: square, row 0 is the top of the picture and v = 0.
#[derive(Debug, Clone)]
pub struct Page(pub(crate) BakedPage);

impl Page {
    /// Page number from 0.
    pub fn number(&self) -> u32 {
        self.0.page
    }

    /// Edge in texels.
    pub fn size(&self) -> u32 {
        self.0.size
    }

    /// All values of a layer: one plane of `size * size` after another, one for each of [`Layer::channels`]. Empty
    /// where the layer was not asked for. A texel that no chart touches has coverage 0, even where a gutter filled it.
    pub fn layer(&self, layer: Layer) -> &[f32] {
        self.0.layer(layer).unwrap_or_default()
    }

    /// The values of one channel of a layer, `size * size` of them; empty where the layer was not asked for.
    ///
    /// # Panics
    /// Where the layer has no such channel.
    pub fn channel(&self, layer: Layer, channel: usize) -> &[f32] {
        self.0.channel(layer, channel).unwrap_or_default()
    }

    /// The layers that the page has.
    pub fn layers(&self) -> impl Iterator<Item = Layer> {
        self.0.planes.iter().map(|planes| planes.layer)
    }

    /// Texels, rays and errors of the page.
    pub fn stats(&self) -> &PageStats {
        &self.0.stats
    }
}

impl Baked {
    pub(crate) fn new(job: Job, pages: Vec<Page>, bounces: Option<BounceStats>) -> Self {
        Self {
            job,
            pages,
            bounces,
        }
    }

    /// The pages in order.
    pub fn pages(&self) -> impl ExactSizeIterator<Item = &Page> {
        self.pages.iter()
    }

    /// The page of this number.
    ///
    /// # Panics
    /// Where there is no such page; [`Baked::pages`] tells how many there are.
    pub fn page(&self, number: usize) -> &Page {
        &self.pages[number]
    }

    /// What the gathers of light that bounces added; `None` where they were not asked for.
    pub fn bounces(&self) -> Option<&BounceStats> {
        self.bounces.as_ref()
    }

    /// What was baked, and how.
    pub fn job(&self) -> &Job {
        &self.job
    }
}
