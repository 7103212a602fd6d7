//! A page in work as a checkpoint, and back.

use ::bake::{BakedPage, PageStats};
use report::{
    Checkpoint, Error, checkpoint_path, read_checkpoint, remove_checkpoint, write_checkpoint,
};
use serde_json::{Value, json};
use std::path::Path;

/// The place and the key of a bake's saved states.
pub struct Saved<'a> {
    pub dir: &'a Path,
    pub stem: &'a str,
    /// Everything that decides the values.
    pub key: &'a Value,
}

impl Saved<'_> {
    /// Saves a page.
    pub fn write(&self, page: &BakedPage) -> Result<(), Error> {
        let state = json!({ "tiles_done": page.tiles_done, "finished": page.finished, "stats": page.stats });
        let planes = page
            .planes
            .iter()
            .map(|plane| plane.values.clone())
            .collect();
        let path = checkpoint_path(self.dir, self.stem, page.page);
        write_checkpoint(
            &path,
            &Checkpoint {
                key: self.key.clone(),
                state,
                planes,
            },
        )
    }

    /// Puts a saved state into a page that was just started. False where nothing fitting was saved.
    pub fn restore(&self, page: &mut BakedPage) -> Result<bool, Error> {
        let path = checkpoint_path(self.dir, self.stem, page.page);
        let Some(saved) = read_checkpoint(&path, self.key)? else {
            return Ok(false);
        };
        let fits = saved.planes.len() == page.planes.len()
            && saved
                .planes
                .iter()
                .zip(&page.planes)
                .all(|(saved, plane)| saved.len() == plane.values.len());
        let tiles = saved.state["tiles_done"].as_u64();
        let finished = saved.state["finished"].as_bool();
        let stats = serde_json::from_value::<PageStats>(saved.state["stats"].clone());
        let (true, Some(tiles), Some(finished), Ok(stats)) = (fits, tiles, finished, stats) else {
            return Ok(false);
        };
        for (plane, values) in page.planes.iter_mut().zip(saved.planes) {
            plane.values = values;
        }
        page.tiles_done = tiles as usize;
        page.finished = finished;
        page.stats = stats;
        Ok(true)
    }

    /// Removes the states of `pages` pages.
    pub fn clear(&self, pages: u32) {
        for page in 0..pages {
            remove_checkpoint(&checkpoint_path(self.dir, self.stem, page));
        }
    }
}
