//! `STEM.state` and `STEM.P.state`: the finished tiles of a bake as they were before whole pages were worked on, for
//! `--update`.
//!
//! Both are journals (see `report`'s `checkpoint`). The head's header has the bake's key; its first block is JSON
//! (claims on the layout and the content of objects), the others are the layout. A block of a page is a line of JSON
//! (tiles, their fingerprints and sums) and packed bytes: for each texel its place in its tile (u8), then the values,
//! channel by channel, first the low bytes of all (f32, little-endian). A tile says by its fingerprint what it was made
//! from, so each stands for itself.

use crate::error::Error;
use ::bake::{BakedPage, BakedTile, Fingerprint, PageStats};
use atlas::{Atlas, Claim, TILE};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use report::Journal;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

/// Tiles in a block.
const BLOCK: usize = 64;
/// Blocks that are packed or unpacked together.
const BATCH: usize = 32;

/// The name of the head.
pub(crate) fn head_name(stem: &str) -> String {
    format!("{stem}.state")
}

/// The name of a page's tiles.
pub(crate) fn tiles_name(stem: &str, page: u32) -> String {
    format!("{stem}.{page}.state")
}

/// What a finished bake says of itself.
pub(crate) struct Head {
    /// Everything but the scene that decides the values of tiles.
    pub key: Value,
    pub facts: Facts,
    pub atlas: Atlas,
}

#[derive(Serialize, Deserialize)]
pub(crate) struct Facts {
    /// What each instance claimed of the layout.
    pub claims: Vec<Claim>,
    /// Names of the objects, and hashes of their content in hex.
    pub objects: Vec<(String, String)>,
}

/// A tile of a state.
pub(crate) struct Kept {
    /// Row-major number over the page.
    pub number: u32,
    /// Without its index, which the layout decides.
    pub tile: BakedTile,
}

#[derive(Serialize, Deserialize)]
struct Line {
    number: u32,
    fingerprint: Fingerprint,
    texels: usize,
    stats: PageStats,
}

impl Head {
    pub fn write(&self, file: &mut File) -> Result<(), report::Error> {
        let facts = serde_json::to_vec(&self.facts).expect("plain structs become JSON");
        let blocks = std::iter::once(facts).chain(report::layout_blocks(&self.atlas));
        report::write_journal(file, &self.key, blocks)
    }

    /// The head at `path`; `None` where there is none.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        let Some(mut journal) = Journal::open(path)? else {
            return Ok(None);
        };
        let blocks = (0..journal.len()).map(|number| journal.block(number));
        let mut blocks = blocks.collect::<Result<Vec<_>, _>>()?.into_iter();
        let facts = blocks
            .next()
            .and_then(|facts| serde_json::from_slice(&facts).ok());
        let atlas = report::layout_of_blocks(&blocks.collect::<Vec<_>>());
        let (Some(facts), Some(atlas)) = (facts, atlas) else {
            return Err(Error::Damaged {
                path: path.display().to_string(),
            });
        };
        Ok(Some(Self {
            key: journal.header().clone(),
            facts,
            atlas,
        }))
    }
}

/// Writes the tiles of a page that has all of them and is not finished. `tiles` has the number and the fingerprint of
/// each.
pub(crate) fn write_tiles(
    file: &mut File,
    key: &Value,
    page: &BakedPage,
    tiles: &[(u32, Fingerprint)],
) -> Result<(), report::Error> {
    let indexed: Vec<(usize, &(u32, Fingerprint))> = tiles.iter().enumerate().collect();
    let batches = indexed.chunks(BLOCK * BATCH).flat_map(|batch| {
        let blocks: Vec<Vec<u8>> = batch
            .par_chunks(BLOCK)
            .map(|block| encode(page, block))
            .collect();
        blocks
    });
    report::write_journal(file, key, batches)
}

/// Hands over the tiles at `path` for which `wanted` holds; nothing where there is no such file, or it is another
/// bake's.
///
/// # Errors
/// The file is damaged. What was handed over before is sound.
pub(crate) fn read_tiles(
    path: &Path,
    key: &Value,
    page_size: u32,
    columns: usize,
    wanted: impl Fn(u32, &Fingerprint) -> bool + Sync,
    mut take: impl FnMut(Kept),
) -> Result<(), Error> {
    let Some(mut journal) = Journal::open(path)?.filter(|found| found.header() == key) else {
        return Ok(());
    };
    let numbers: Vec<usize> = (0..journal.len()).collect();
    for batch in numbers.chunks(BATCH) {
        let blocks = batch.iter().map(|&number| journal.block(number));
        let blocks = blocks.collect::<Result<Vec<_>, _>>()?;
        let decoded: Vec<Option<Vec<Kept>>> = blocks
            .par_iter()
            .map(|bytes| decode(bytes, page_size, columns, &wanted))
            .collect();
        for tiles in decoded {
            let damaged = || Error::Damaged {
                path: path.display().to_string(),
            };
            tiles.ok_or_else(damaged)?.into_iter().for_each(&mut take);
        }
    }
    Ok(())
}

fn encode(page: &BakedPage, block: &[(usize, &(u32, Fingerprint))]) -> Vec<u8> {
    let (mut lines, mut places, mut tiles) = (Vec::new(), Vec::new(), Vec::new());
    for &(index, &(number, fingerprint)) in block {
        // A tile that the page cannot give back is baked anew by whoever wants it.
        let Some(tile) = page.stored(index as u32, number) else {
            continue;
        };
        lines.push(Line {
            number,
            fingerprint,
            texels: tile.texels.len(),
            stats: tile.stats,
        });
        let place = |&texel: &u32| {
            let [x, y] = [texel % page.size, texel / page.size];
            (y % TILE * TILE + x % TILE) as u8
        };
        places.extend(tile.texels.iter().map(place));
        tiles.push(tile);
    }
    let texels = places.len();
    let columns = tiles.iter().map(|tile| tile.channels().count());
    let columns = columns.max().unwrap_or(0);
    let mut bytes = places;
    bytes.resize(texels * (1 + 4 * columns), 0);
    let planes = &mut bytes[texels..];
    let mut first = 0;
    for tile in &tiles {
        for (column, values) in tile.channels().enumerate() {
            for k in 0..4 {
                let plane = &mut planes[(column * 4 + k) * texels + first..];
                for (byte, value) in plane.iter_mut().zip(values) {
                    *byte = value.to_le_bytes()[k];
                }
            }
        }
        first += tile.texels.len();
    }
    let mut block = serde_json::to_vec(&lines).expect("plain structs become JSON");
    block.push(b'\n');
    let mut packed = ZlibEncoder::new(block, Compression::fast());
    packed
        .write_all(&bytes)
        .and_then(|()| packed.finish())
        .expect("memory takes what is written")
}

/// The wanted tiles of a block; `None` where its bytes are something else.
fn decode(
    block: &[u8],
    page_size: u32,
    columns: usize,
    wanted: impl Fn(u32, &Fingerprint) -> bool,
) -> Option<Vec<Kept>> {
    let end = block.iter().position(|&byte| byte == b'\n')?;
    let lines: Vec<Line> = serde_json::from_slice(&block[..end]).ok()?;
    if !lines
        .iter()
        .any(|line| wanted(line.number, &line.fingerprint))
    {
        return Some(Vec::new());
    }
    let texels = lines
        .iter()
        .try_fold(0usize, |sum, line| sum.checked_add(line.texels))?;
    let size = columns
        .checked_mul(4)?
        .checked_add(1)?
        .checked_mul(texels)?;
    let mut bytes = Vec::new();
    let unpacked = ZlibDecoder::new(&block[end + 1..]).take(size as u64 + 1);
    if { unpacked }.read_to_end(&mut bytes).ok()? != size {
        return None;
    }
    let (places, values) = bytes.split_at(texels);
    let across = page_size.div_ceil(TILE);
    let mut first = 0;
    let mut tiles = Vec::new();
    for line in lines {
        let own = first..first + line.texels;
        first = own.end;
        if !wanted(line.number, &line.fingerprint) {
            continue;
        }
        let value = |texel: usize, column: usize| {
            let byte = |k: usize| values[(column * 4 + k) * texels + texel];
            f32::from_le_bytes([0, 1, 2, 3].map(byte))
        };
        let [left, top] = [line.number % across * TILE, line.number / across * TILE];
        let place = |&place: &u8| {
            let [x, y] = [u32::from(place) % TILE, u32::from(place) / TILE];
            (top + y) * page_size + left + x
        };
        tiles.push(Kept {
            number: line.number,
            tile: BakedTile {
                index: 0,
                texels: places[own.clone()].iter().map(place).collect(),
                values: (0..columns)
                    .flat_map(|column| own.clone().map(move |texel| value(texel, column)))
                    .collect(),
                stats: line.stats,
            },
        });
    }
    Some(tiles)
}
