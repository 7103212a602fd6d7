//! A page in work as a checkpoint, and back.

use ::bake::{BakedPage, LayerPlanes, PageStats};
use layers::Layer;
use report::{
    Checkpoint, Error, checkpoint_path, read_checkpoint, remove_checkpoint, write_checkpoint,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The place and the key of a bake's saved states.
pub(crate) struct Saved {
    dir: PathBuf,
    stem: String,
    /// Everything that decides the values.
    key: Value,
}

impl Saved {
    pub fn new(dir: &Path, stem: &str, key: Value) -> Self {
        Self {
            dir: dir.to_owned(),
            stem: stem.into(),
            key,
        }
    }

    /// Saves a page.
    pub fn write(&self, page: &BakedPage) -> Result<(), Error> {
        let layers: Vec<Layer> = page.planes.iter().map(|planes| planes.layer).collect();
        let planes = page.planes.iter().map(|planes| planes.values.clone());
        let checkpoint = Checkpoint {
            key: self.key.clone(),
            state: json!({
                "tiles_done": page.tiles_done,
                "finished": page.finished,
                "stats": page.stats,
                "layers": layers,
            }),
            planes: planes.collect(),
        };
        write_checkpoint(&self.path(page.page), &checkpoint)
    }

    /// Puts a saved state into a page that was just started; leaves it as it is where nothing fitting was saved.
    pub fn restore(&self, page: &mut BakedPage) -> Result<(), Error> {
        let Some(saved) = read_checkpoint(&self.path(page.page), &self.key)? else {
            return Ok(());
        };
        let tiles = saved.state["tiles_done"].as_u64();
        let finished = saved.state["finished"].as_bool();
        let stats = serde_json::from_value::<PageStats>(saved.state["stats"].clone());
        let layers = serde_json::from_value::<Vec<String>>(saved.state["layers"].clone());
        let (Some(tiles), Some(finished), Ok(stats), Ok(layers)) = (tiles, finished, stats, layers)
        else {
            return Ok(());
        };
        let planes = layers.iter().zip(saved.planes).map(|(name, values)| {
            let layer = Layer::from_name(name)?;
            let fits = values.len() == page.texels() * layer.channels().len();
            fits.then_some(LayerPlanes { layer, values })
        });
        let Some(planes) = planes.collect::<Option<Vec<LayerPlanes>>>() else {
            return Ok(());
        };
        let same = planes.len() == page.planes.len()
            && planes
                .iter()
                .zip(&page.planes)
                .all(|(a, b)| a.layer == b.layer);
        if finished || same {
            page.planes = planes;
            page.tiles_done = tiles as usize;
            page.finished = finished;
            page.stats = stats;
        }
        Ok(())
    }

    /// Removes the states of `pages` pages.
    pub fn clear(&self, pages: u32) {
        for page in 0..pages {
            remove_checkpoint(&self.path(page));
        }
    }

    fn path(&self, page: u32) -> PathBuf {
        checkpoint_path(&self.dir, &self.stem, page)
    }
}
