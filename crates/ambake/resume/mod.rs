//! What is kept while a bake runs, so that little is lost with it: its finished tiles, in a journal of blocks.

pub(crate) mod block;

use crate::differ::difference;
use crate::error::Error;
use crate::memory::WAITING;
use ::bake::{BakedTile, KeepGathers};
use block::{BLOCK, Block, Filled, Widths};
use report::Journal;
use serde_json::Value;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The tag of the block that ends a part; no page has this number.
pub(crate) const END: u32 = u32::MAX;

/// What was baked is on the disk after this time at most, and the time of one batch of tiles.
pub(crate) const PERIOD: Duration = Duration::from_secs(20);
/// Saving takes this part of the time at most, as long as memory allows.
pub(crate) const SHARE: u32 = 50;

/// What a bake does about the state that an interrupted one left.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Resume {
    /// It goes on from it where scene, options and version are the same, and starts over where they are not. A note
    /// says which.
    #[default]
    IfFound,
    /// The same; but what has the place of the state and cannot be one, such as a link, is an error.
    Asked,
    /// It starts anew.
    Never,
}

impl Resume {
    /// True where the file at `path` is to be opened.
    pub(crate) fn wants(self, path: &Path) -> bool {
        std::fs::symlink_metadata(path).is_ok_and(|facts| match self {
            Self::IfFound => facts.is_file(),
            Self::Asked => true,
            Self::Never => false,
        })
    }
}

/// The finished tiles of a bake or of one of its shards.
pub(crate) struct Saved {
    path: PathBuf,
    /// What the journal says of itself; `key` in it decides the values.
    header: Value,
    widths: Widths,
    journal: Option<Journal>,
    /// What was found there, in a line.
    origin: Option<String>,
    /// Blocks of the journal by their page, as they were found.
    found: BTreeMap<u32, Vec<usize>>,
    waiting: Vec<Filled>,
    /// Bytes in `waiting`, about.
    bytes: usize,
    /// When the block in work was begun.
    clock: Instant,
    /// When the journal was written last, and how long that took.
    written: (Instant, Duration),
}

impl Saved {
    /// No tiles; the file is made when the first are written.
    pub fn new(path: PathBuf, header: Value, widths: Widths) -> Self {
        Self {
            path,
            header,
            widths,
            journal: None,
            origin: None,
            found: BTreeMap::new(),
            waiting: Vec::new(),
            bytes: 0,
            clock: Instant::now(),
            written: (Instant::now(), Duration::ZERO),
        }
    }

    /// Opens the file now and takes what it holds, where it is of the same bake. What tells of damage is returned:
    /// then the bake starts anew.
    ///
    /// # Errors
    /// The file cannot be written, or another run writes it.
    pub fn resume(&mut self) -> Result<Option<String>, Error> {
        let (mut journal, mut damage, other) = opened(&self.path, &self.header)?;
        for number in 0..journal.len() {
            // A part that was killed between its last block and its name.
            if journal.tag(number)? == Some(END) {
                continue;
            }
            let bytes = journal.block(number)?;
            let Some(block) = Block::decode(&bytes, self.widths) else {
                let path = self.path.display();
                damage = Some(format!("cannot read {path}: the file is damaged"));
                drop(journal);
                journal = Journal::resume(&self.path, &self.header, |_| false)?.0;
                self.found.clear();
                break;
            };
            self.found.entry(block.page).or_default().push(number);
        }
        self.journal = Some(journal);
        let path = self.path.display();
        self.origin = match (&damage, other) {
            (None, Some(differs)) => Some(format!(
                "what was saved in {path} is of another bake, {differs} differs; starting over"
            )),
            (None, None) if !self.found.is_empty() => {
                Some(format!("going on from what was saved in {path}"))
            }
            _ => None,
        };
        Ok(damage.map(|damage| format!("{damage}; starting over")))
    }

    /// The tiles of a page that were found, block by block.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn restore(&mut self, page: u32, mut take: impl FnMut(Block)) -> Result<(), Error> {
        let numbers = self.found.remove(&page).unwrap_or_default();
        if let Some(journal) = &mut self.journal {
            for number in numbers {
                Block::decode(&journal.block(number)?, self.widths)
                    .into_iter()
                    .for_each(&mut take);
            }
        }
        self.clock = Instant::now();
        Ok(())
    }

    /// Takes a finished tile, and brings what waits to the disk when it is time.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, page: u32, tile: &BakedTile) -> Result<(), Error> {
        let own = 4 * (tile.texels.len() + tile.values.len()) + size_of::<BakedTile>();
        let full = |block: &Filled| block.page != page || block.bytes.len() + own >= BLOCK;
        if self.waiting.last().is_none_or(full) {
            self.close();
            self.waiting.push(Filled::new(page));
        }
        if let Some(block) = self.waiting.last_mut() {
            block.add(tile);
        }
        self.bytes += own;
        let (last, cost) = self.written;
        if last.elapsed() >= PERIOD.max(cost * SHARE) || self.bytes as u64 > WAITING {
            self.flush()?;
        }
        Ok(())
    }

    /// What the bake goes on from, or why it does not, in a line.
    pub fn origin(&self) -> Option<&str> {
        self.origin.as_deref()
    }

    /// True where the file is there, with what was saved until now.
    pub fn is_begun(&self) -> bool {
        self.journal.is_some()
    }

    /// Gives the block in work the time that it took.
    fn close(&mut self) {
        if let Some(block) = self.waiting.last_mut() {
            block.seconds = self.clock.elapsed().as_secs_f64();
        }
        self.clock = Instant::now();
    }

    /// Brings everything that waits to the disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), Error> {
        let started = Instant::now();
        self.close();
        let journal = match &mut self.journal {
            Some(journal) => journal,
            none => none.insert(Journal::resume(&self.path, &self.header, |_| false)?.0),
        };
        for block in self.waiting.drain(..) {
            journal.append(&block.encode())?;
        }
        self.bytes = 0;
        self.written = (Instant::now(), started.elapsed());
        Ok(())
    }

    /// Brings everything to the disk with a last block, and gives the file its final name.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn end(mut self, last: &[u8], path: &Path) -> Result<(), Error> {
        self.flush()?;
        if let Some(journal) = &mut self.journal {
            journal.append(last)?;
            journal.rename(path)?;
        }
        Ok(())
    }

    /// The number of a page in a gather.
    fn number(&self, gather: u32, page: u32) -> u32 {
        (1 + gather) * self.widths.pages + page
    }

    /// Removes the file.
    pub fn remove(self) {
        report::remove_journal(&self.path);
    }
}

/// The journal at `path`, with its blocks where it is of the same job, else empty; what tells of damage; and by what it
/// is of another job, where it was one.
///
/// # Errors
/// The file cannot be written, or another run writes it.
pub(crate) fn opened(
    path: &Path,
    header: &Value,
) -> Result<(Journal, Option<String>, Option<String>), Error> {
    let other = Cell::new(None);
    let same = |found: &Value| {
        let same = (["key", "shard"].iter()).all(|part| found[part] == header[part]);
        if !same {
            let differs = difference(&found["key"], &header["key"]);
            other.set(Some(
                differs.unwrap_or_else(|| "what it tells of itself".into()),
            ));
        }
        same
    };
    let (journal, damage) = Journal::resume(path, header, same)?;
    Ok((journal, damage, other.take()))
}

impl KeepGathers for Saved {
    type Error = Error;

    fn found(&mut self, gather: u32, page: u32) -> Result<Vec<BakedTile>, Error> {
        let mut tiles = Vec::new();
        self.restore(self.number(gather, page), |block| tiles.extend(block.tiles))?;
        Ok(tiles)
    }

    fn keep(&mut self, gather: u32, page: u32, tile: &BakedTile) -> Result<(), Error> {
        self.add(self.number(gather, page), tile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::bake::PageStats;

    const WIDTHS: Widths = Widths {
        pages: 9,
        page: 3,
        gather: 5,
    };

    fn tile(index: u32, texels: u32) -> BakedTile {
        BakedTile {
            index,
            texels: (0..texels).collect(),
            values: (0..3 * texels).map(|v| 0.1 * v as f32).collect(),
            stats: PageStats {
                coverage: 1.0 / f64::from(texels + 1),
                ..PageStats::default()
            },
        }
    }

    #[test]
    fn what_was_baked_is_on_the_disk_after_a_period_whoever_ends_the_program() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state");
        let header = serde_json::json!({"key": "a", "shard": null});
        let mut saved = Saved::new(path.clone(), header.clone(), WIDTHS);
        saved.add(0, &tile(0, 4)).expect("a file");
        assert!(!path.exists(), "the disk is spared until then");
        // As if the last time lay a period back.
        let (written, cost) = saved.written;
        saved.written = (written - PERIOD, cost);
        saved.add(1, &tile(5, 2)).expect("a file");
        // No `flush`, no `Drop`: as a killed program leaves it.
        std::mem::forget(saved);
        let mut again = Saved::new(folder.path().join("copy"), header, WIDTHS);
        std::fs::copy(&path, &again.path).expect("a copy");
        assert_eq!(again.resume().expect("a file"), None);
        for (page, index) in [(0, 0), (1, 5)] {
            let mut found = Vec::new();
            let mut take = |block: Block| found.extend(block.tiles.into_iter().map(|t| t.index));
            again.restore(page, &mut take).expect("a file");
            assert_eq!(found, [index], "page {page}");
        }
    }

    #[test]
    fn pages_and_the_gathers_of_each_share_no_number() {
        let saved = Saved::new("state".into(), Value::Null, WIDTHS);
        let pages = 0..WIDTHS.pages;
        let gathers = (0..4).flat_map(|gather| pages.clone().map(move |page| (gather, page)));
        let numbers = gathers.map(|(gather, page)| saved.number(gather, page));
        let mut numbers: Vec<u32> = numbers.chain(pages.clone()).chain([END]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), 5 * 9 + 1);
    }

    #[test]
    fn a_saved_state_is_of_its_key_and_its_shard_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state");
        let header = |scene: &str, shard: u32| {
            serde_json::json!({"key": {"scene": scene}, "shard": [shard, 2],
                "given": "anything"})
        };
        let blocks = |header: Value| {
            let mut saved = Saved::new(path.clone(), header, WIDTHS);
            assert_eq!(saved.resume().expect("a file"), None);
            let said = saved.origin().unwrap_or_default().to_owned();
            let found = saved.found.len();
            saved.add(0, &tile(0, 4)).expect("a file");
            saved.flush().expect("a file");
            (found, said)
        };
        let case = |header: Value, found: usize, word: &str| {
            let (blocks, said) = blocks(header);
            assert!(blocks == found && said.contains(word), "{blocks}: {said}");
        };
        case(header("a", 1), 0, "");
        case(header("a", 1), 1, "going on");
        case(header("b", 1), 0, "the scene differs; starting over");
        case(header("b", 2), 0, "differs; starting over");
        let mut other = header("b", 2);
        other["given"] = "decides nothing".into();
        case(other, 1, "going on");
    }

    #[test]
    fn a_block_returns_bit_for_bit_and_no_other_bytes_are_taken() {
        let tiles = vec![tile(3, 5), tile(9, 0)];
        let mut block = Filled::new(7);
        tiles.iter().for_each(|tile| block.add(tile));
        block.seconds = 0.25;
        let bytes = block.encode();
        let back = Block::decode(&bytes, WIDTHS).expect("its own bytes");
        assert_eq!((back.page, back.tiles, back.seconds), (7, tiles, 0.25));
        let width = |page| Widths { page, ..WIDTHS };
        assert!(Block::decode(&bytes, width(2)).is_none(), "too many values");
        assert!(Block::decode(&bytes, width(4)).is_none(), "too few");
        let gathers = Widths {
            pages: 7,
            gather: 3,
            page: 1,
        };
        assert!(Block::decode(&bytes, gathers).is_some(), "of a gather");
        for cut in 1..=bytes.len() {
            assert!(Block::decode(&bytes[..bytes.len() - cut], WIDTHS).is_none());
        }
    }
}
