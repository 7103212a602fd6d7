//! The parts of a sharded bake into its files.

use crate::differ::difference;
use crate::error::Error;
use crate::job::Job;
use crate::resume::{Block, END, Saved};
use crate::shard::{Shard, is_complete, part_name, state_name};
use crate::update::Tracker;
use crate::write::{Writer, Written};
use layers::Progress;
use report::{Journal, Output, PhaseReport};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Shards that a message names at most.
const NAMED: usize = 8;

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
    /// The parts in a directory.
    ///
    /// # Errors
    /// There are none, or those of several bakes; one is missing, damaged or unfinished; or they do not belong
    /// together. The message names which, and what to do.
    pub fn find(dir: &Path) -> Result<Self, Error> {
        let fail = |problem: String| Error::Parts {
            dir: dir.display().to_string(),
            problem,
        };
        let entries = std::fs::read_dir(dir).map_err(|e| fail(e.to_string()))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        // Those in work count too, so that an array of which no shard is done yet is not taken for none.
        let found: BTreeSet<(String, u32)> = names
            .filter_map(|name| {
                let work = name.strip_prefix('.');
                let work = work.and_then(|name| name.strip_suffix(".ambake-resume"));
                let (stem, shard) = parse(name.strip_suffix(".part").or(work)?)?;
                Some((stem, shard.of))
            })
            .collect();
        let mut found = found.into_iter();
        let (stem, of) = match (found.next(), found.next()) {
            (Some(set), None) => set,
            (None, _) => {
                return Err(fail(
                    "no part of a sharded bake is here; `ambake bake SCENE -o DIR --shard I/N` makes them".into(),
                ));
            }
            (Some((a, n)), Some((b, m))) => {
                return Err(fail(format!(
                    "parts of several bakes are here (`{a}` in {n} and `{b}` in {m}); remove those that are not wanted"
                )));
            }
        };
        let (mut parts, mut missing) = (Vec::new(), Vec::new());
        for shard in (1..=of).map(|index| Shard { index, of }) {
            let open = Journal::open(&dir.join(part_name(&stem, shard)));
            let mut journal = open.map_err(|error| {
                fail(format!("{error}; delete it and run --shard {shard} again"))
            })?;
            if let Some(found) = &mut journal
                && !is_complete(found)?
            {
                journal = None;
            }
            match journal {
                Some(mut journal) => {
                    let pages = (0..journal.len()).map(|block| journal.tag(block));
                    let pages = pages.map(|page| page.map(|page| page.unwrap_or(END)));
                    let pages = pages.collect::<Result<Vec<u32>, _>>()?;
                    parts.push(Part {
                        shard,
                        journal,
                        pages,
                    });
                }
                _ if missing.len() > NAMED => missing.push(String::new()),
                _ => {
                    let begun = dir.join(state_name(&stem, Some(shard))).exists();
                    let word = if begun { " (begun)" } else { "" };
                    missing.push(format!("{shard}{word}"));
                }
            }
        }
        if !missing.is_empty() {
            let count = missing.len();
            let more = match count.saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            missing.truncate(NAMED);
            return Err(fail(format!(
                "{count} of {of} parts of `{stem}` missing: {}{more}; run these with `--shard I/{of}`, then merge again",
                missing.join(", ")
            )));
        }
        let parts = Self {
            dir: dir.to_owned(),
            parts,
        };
        parts.check()?;
        Ok(parts)
    }

    /// What whoever ran the shards gave along.
    pub fn given(&self) -> &Value {
        &self.parts[0].journal.header()["given"]
    }

    /// Checks that all parts are of one bake.
    fn check(&self) -> Result<(), Error> {
        let first = &self.parts[0];
        for part in &self.parts[1..] {
            let (a, b) = (first.journal.header(), part.journal.header());
            if let Some(what) = difference(&a["key"], &b["key"]) {
                return Err(self.fail(format!(
                    "parts {} and {} do not belong together: {what} differs; run one of them again",
                    first.shard, part.shard
                )));
            }
        }
        Ok(())
    }

    fn fail(&self, problem: String) -> Error {
        Error::Parts {
            dir: self.dir.display().to_string(),
            problem,
        }
    }
}

/// The stem and the shard of a part's name without its ending.
fn parse(name: &str) -> Option<(String, Shard)> {
    let (stem, shard) = name.rsplit_once('.')?;
    let (index, of) = shard.split_once("-of-")?;
    let shard = Shard {
        index: index.parse().ok()?,
        of: of.parse().ok()?,
    };
    (1..=shard.of)
        .contains(&shard.index)
        .then(|| (stem.into(), shard))
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
        let state = parts.dir.join(state_name(&self.scene().stem(), None));
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
                        let (dir, shard) = (parts.dir.display().to_string(), part.shard);
                        let problem = format!(
                            "{path} does not fit the bake; delete it and run --shard {shard} again"
                        );
                        return Err(Error::Parts { dir, problem });
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
            self.within(|| writer.page(&page))?;
            writing += clock.elapsed().as_secs_f64();
        }
        let clock = Instant::now();
        let bounced = self.bounce_saving(&mut waiting, &mut saved, progress)?;
        finishing += clock.elapsed().as_secs_f64();
        let clock = Instant::now();
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
    fn names_of_parts_are_taken_apart_from_behind() {
        let shard = |index, of| Shard { index, of };
        assert_eq!(
            parse("a.b 50%.3-of-12"),
            Some(("a.b 50%".into(), shard(3, 12)))
        );
        for wrong in [
            "a.0-of-3",
            "a.4-of-3",
            "a.-1-of-3",
            "a",
            "a.1-of-",
            "3-of-4",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }

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
