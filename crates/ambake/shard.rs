//! The shards of a bake: each bakes its share of the tiles into a part file, in any order and on any machine.

use crate::error::Error;
use crate::job::Job;
use crate::parts::{Kind, Shard, is_done};
use crate::resume::{END, Saved};
use crate::write::names::check_length;
use ::bake::Deal;
use layers::Progress;
use report::Output;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a shard left.
#[derive(Debug)]
#[non_exhaustive]
pub struct Part {
    /// The part file.
    pub path: PathBuf,
    /// True where it was complete before.
    pub already: bool,
    /// Tiles of this shard.
    pub tiles: u64,
    /// Texels baked now.
    pub texels: u64,
    /// Rays cast now.
    pub rays: u64,
    /// Its predicted share of the whole cost, 0..=1.
    pub share: f64,
}

impl Job {
    /// Everything that decides the values of the bake.
    pub(crate) fn key(&self) -> Value {
        json!({
            "version": crate::VERSION,
            "revision": crate::REVISION,
            "options": self.options().describe(),
            "scene": self.scene().content_hash,
            "layout": report::layout_hash(self.atlas()),
            "backend": self.backend().describe(),
        })
    }

    /// Bakes one shard into `dir`: its tiles go into a part file, which [`Parts`](crate::Parts) finds there. A shard
    /// that was interrupted continues; one that is complete already is left as it is. `given` is kept in the part for
    /// whoever merges.
    ///
    /// # Errors
    /// The directory cannot be written, another run bakes the same shard, or [`Error::Cancelled`].
    pub fn run_shard(
        &self,
        dir: &Path,
        shard: Shard,
        given: &Value,
        progress: &dyn Progress,
    ) -> Result<Part, Error> {
        let mut output = Output::create(dir)?;
        output.protect(self.inputs());
        let stem = self.scene().stem();
        check_length(dir, &Kind::Bake.state_name(&stem, Some(shard)))?;
        output.check(&Kind::Bake.part_name(&stem, shard))?;
        let path = dir.join(Kind::Bake.part_name(&stem, shard));
        let header = json!({
            "key": self.key(),
            "shard": [shard.index, shard.of],
            "given": given,
        });
        let baker = self.baker();
        let mut part = Part {
            path,
            already: false,
            tiles: 0,
            texels: 0,
            rays: 0,
            share: 0.0,
        };
        if is_done(&part.path, &header)? {
            part.already = true;
            return Ok(part);
        }
        let state = dir.join(Kind::Bake.state_name(&stem, Some(shard)));
        let mut saved = Saved::new(state, header, self.widths(&baker));
        if let Some(damage) = saved.resume()? {
            progress.note(&damage);
        }
        let started = Instant::now();
        let mut deal = Deal::new(shard.of);
        let (mut own, mut all) = (0.0, 0.0);
        for page in 0..self.atlas().page_count {
            let costs = self.within(|| baker.costs(page));
            let dealt = deal.page(&costs);
            let mut wanted: Vec<u32> = (0..costs.len() as u32)
                .filter(|&tile| dealt[tile as usize] + 1 == shard.index)
                .collect();
            own += wanted.iter().map(|&t| costs[t as usize]).sum::<f64>();
            all += costs.iter().sum::<f64>();
            part.tiles += wanted.len() as u64;
            let mut done = HashSet::new();
            saved.restore(page, |block| {
                for tile in block.tiles {
                    done.insert(tile.index);
                    baker.count_done(tile.stats.texels);
                }
            })?;
            wanted.retain(|tile| !done.contains(tile));
            let texels = self.atlas().audit.texels / u64::from(shard.of);
            let whole = self.within(|| {
                baker.run_tiles(page, &wanted, (progress, texels), &mut |tile| {
                    part.texels += tile.stats.texels;
                    part.rays += tile.stats.rays;
                    saved.add(page, &tile)
                })
            });
            let whole = whole.map_err(self.unsaved(&saved))?;
            if !whole {
                saved.flush()?;
                return Err(Error::Cancelled);
            }
        }
        part.share = if all > 0.0 { own / all } else { 0.0 };
        let mut last = END.to_le_bytes().to_vec();
        let facts = json!({"tiles": part.tiles, "seconds": started.elapsed().as_secs_f64()});
        last.extend(facts.to_string().into_bytes());
        saved.end(&last, &part.path)?;
        Ok(part)
    }
}
