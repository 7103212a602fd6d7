//! The parts of a sharded bake into its files.

use crate::differ::difference;
use crate::error::Error;
use crate::job::Job;
use crate::parts::{Kind, Shard, failed};
use crate::resume::block::Block;
use crate::resume::{END, Saved};
use crate::run_into::WRITING;
use crate::update::Tracker;
use crate::write::{Writer, Written};
use layers::Progress;
use report::{Journal, Output, PhaseReport};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// All parts of a sharded bake, complete and of one kind.
#[derive(Debug)]
pub struct Parts {
    dir: PathBuf,
    parts: Vec<Part>,
}

#[derive(Debug)]
struct Part {
    shard: Shard,
    journal: Journal,
    /// The page of each block.
    pages: Vec<u32>,
}

impl Parts {
    /// True where a directory has parts of a bake, in work or done.
    pub fn are_in(dir: &Path) -> bool {
        Kind::Bake.is_in(dir)
    }

    /// The parts in a directory.
    ///
    /// # Errors
    /// There are none, or those of several bakes; one is missing, damaged or unfinished; or they do not belong
    /// together. The message names which, and what to do.
    pub fn find(dir: &Path) -> Result<Self, Error> {
        let part = |(shard, mut journal): (Shard, Journal)| {
            let pages = (0..journal.len()).map(|block| journal.tag(block));
            let pages = pages.map(|page| page.map(|page| page.unwrap_or(END)));
            let pages = pages.collect::<Result<Vec<u32>, _>>()?;
            Ok(Part {
                shard,
                journal,
                pages,
            })
        };
        let parts = Kind::Bake.find(dir)?.into_iter().map(part);
        Ok(Self {
            dir: dir.to_owned(),
            parts: parts.collect::<Result<_, Error>>()?,
        })
    }

    /// What whoever ran the shards gave along.
    pub fn given(&self) -> &Value {
        &self.parts[0].journal.header()["given"]
    }

    fn fail(&self, problem: String) -> Error {
        failed(&self.dir, problem)
    }
}

impl Job {
    /// Writes into the parts' directory what a whole bake of this job writes there, and removes the parts. Light that
    /// is added to them is gathered
    /// here; a merge that was interrupted goes on from what it had gathered.
    ///
    /// # Errors
    /// The parts are of another bake, a tile lacks, the directory cannot be written, an output would replace an input,
    /// or [`Error::Cancelled`].
    pub fn merge(&self, mut parts: Parts, progress: &dyn Progress) -> Result<Written, Error> {
        // The ray library need not be the one that baked.
        let mut own = self.key();
        let theirs = parts.parts[0].journal.header()["key"].clone();
        own["backend"] = theirs["backend"].clone();
        if let Some(what) = difference(&theirs, &own) {
            return Err(parts.fail(format!(
                "{what} differs from when the parts were baked; run the shards again"
            )));
        }
        let mut writer = Writer::new(self, Output::exclusive(&parts.dir)?)?;
        let baker = self.baker();
        let mut tracker = Tracker::of(self, &baker);
        if let Some(backend) = theirs["backend"].as_str() {
            tracker.baked_with(backend);
        }
        let widths = self.widths(&baker);
        // Of gathers alone: tiles of pages stay in the parts until all is written.
        let state = parts
            .dir
            .join(Kind::Bake.state_name(&self.scene().stem(), None));
        let mut saved = Saved::new(state, json!({"key": self.key()}), widths);
        let adds_light = self.options().adds_light();
        if adds_light && let Some(damage) = saved.resume()? {
            progress.note(&damage);
        }
        let (mut finishing, mut writing) = (0.0, 0.0);
        let mut waiting = Vec::new();
        for number in 0..self.atlas().page_count {
            let clock = Instant::now();
            let mut page = baker.start(number);
            for part in &mut parts.parts {
                for block in (0..part.pages.len()).filter(|&block| part.pages[block] == number) {
                    let bytes = part.journal.block(block)?;
                    let block = Block::decode(&bytes, widths);
                    let stored = block.is_some_and(|block| {
                        page.stats.seconds += block.seconds;
                        block.tiles.iter().all(|tile| page.store(tile))
                    });
                    if !stored {
                        let path = part.journal.path().display();
                        let shard = part.shard;
                        let problem = format!(
                            "{path} does not fit the bake; delete it and run --shard {shard} again"
                        );
                        return Err(failed(&parts.dir, problem));
                    }
                }
            }
            let missing = baker.missing(&page);
            if missing > 0 {
                let problem = format!(
                    "{missing} tiles of page {number} are in no part; run the shards again"
                );
                return Err(parts.fail(problem));
            }
            let tiles = self.within(|| tracker.keep(&mut page, &|_| ()));
            self.within(|| writer.tiles(&page, tracker.key(), &tiles))?;
            self.within(|| baker.run(&mut page, progress));
            finishing += clock.elapsed().as_secs_f64();
            if !page.finished || progress.cancelled() {
                return Err(Error::Cancelled);
            }
            if adds_light {
                waiting.push(page);
                continue;
            }
            let clock = Instant::now();
            progress.phase(WRITING);
            self.within(|| writer.page(&page))?;
            writing += clock.elapsed().as_secs_f64();
        }
        let clock = Instant::now();
        let bounced = self.bounce_saving(&mut waiting, &mut saved, progress)?;
        finishing += clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        progress.phase(WRITING);
        for page in waiting {
            let written = self.within(|| writer.page(&page));
            written.map_err(self.unsaved(&saved))?;
        }
        writing += clock.elapsed().as_secs_f64();
        let mut phases = self.phases().to_vec();
        for (phase, seconds) in [("merge", finishing), ("write", writing)] {
            phases.push(PhaseReport {
                phase: phase.into(),
                seconds,
                ..PhaseReport::default()
            });
        }
        if let Some(backend) = theirs["backend"].as_str() {
            writer.baked_with(backend);
        }
        writer.tracked(tracker)?;
        let finished = writer.finish(phases, bounced);
        let written = finished.map_err(self.unsaved(&saved))?;
        if adds_light {
            saved.remove();
        }
        for part in &parts.parts {
            report::remove_journal(part.journal.path());
        }
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_difference_is_named_by_its_flag() {
        let key = |scene: &str, rays: u32| json!({"scene": scene, "options": {"max_rays": rays}});
        assert_eq!(difference(&key("a", 1), &key("a", 1)), None);
        assert_eq!(
            difference(&key("a", 1), &key("b", 2)),
            Some("the scene".into())
        );
        assert_eq!(
            difference(&key("a", 1), &key("a", 2)),
            Some("--max-rays".into())
        );
    }
}
