//! A finished bake in memory.

use crate::error::Error;
use crate::job::Job;
use crate::write::{Writer, glb};
use ::bake::{BakedPage, BounceStats, PageStats};
use layers::Layer;
use report::Output;
use std::path::{Path, PathBuf};

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

    /// Writes everything that the command line writes: EXR pages, PNG previews, a GLB and `bake.json`. The directory is
    /// made where it is absent. Files appear together once all are complete.
    ///
    /// # Errors
    /// The directory cannot be written, or an output would replace an input.
    pub fn write(&self, dir: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let mut writer = Writer::new(&self.job, Output::create(dir.as_ref())?)?;
        for page in &self.pages {
            writer.page(&page.0)?;
        }
        Ok(writer
            .finish(self.job.phases().to_vec(), self.bounces)?
            .files)
    }

    /// Writes the scene as a GLB file: lightmap coordinates as `TEXCOORD_1` and, where diffuse was baked, the diffuse
    /// term as `occlusionTexture`.
    ///
    /// # Errors
    /// The file cannot be written, or it would replace an input.
    pub fn write_gltf(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let mut output = Output::for_file(path.as_ref())?;
        output.protect(self.job.inputs());
        let diffuse = self.pages.iter().map(|page| page.0.layer(Layer::Diffuse));
        let pictures: Option<Vec<Vec<u8>>> = diffuse
            .map(|values| Some(report::occlusion_png(self.pages[0].size(), values?)))
            .collect();
        let name = path.as_ref().file_name().unwrap_or_default();
        let bytes = glb(&self.job, pictures.as_deref())?;
        output.stage_bytes(&name.to_string_lossy(), &bytes)?;
        output.publish()?;
        Ok(())
    }
}
