//! Finished tiles as blocks of a journal, and back.
//!
//! A block is the page (u32; those of a gather of light count on where the pages before end), a line of JSON (the tiles
//! and the seconds that they took), and for each tile its texels (u32) and their values (f32, texel by texel). Numbers
//! are little-endian.

use crate::job::Job;
use ::bake::{BakedTile, Baker, PageStats};
use layers::Layer;
use serde::{Deserialize, Serialize};

/// A block is closed at this size in bytes.
pub(super) const BLOCK: usize = 4 << 20;

/// How many values a texel of a tile has.
#[derive(Clone, Copy)]
pub(crate) struct Widths {
    /// Pages of the bake.
    pub pages: u32,
    /// Of the tiles of pages, and of those of gathers.
    pub page: usize,
    pub gather: usize,
}

impl Widths {
    fn of(&self, page: u32) -> usize {
        match page < self.pages {
            true => self.page,
            false => self.gather,
        }
    }
}

impl Job {
    /// How many values a texel has while it is baked by `baker`, and while light bounces.
    pub(crate) fn widths(&self, baker: &Baker<'_>) -> Widths {
        let width = |layers: Vec<Layer>| layers.iter().map(|l| l.channels().len()).sum();
        Widths {
            pages: self.atlas().page_count,
            page: width(baker.layers()),
            gather: width(baker.layers_of_gathers()),
        }
    }
}

/// A block that was read.
pub(crate) struct Block {
    pub page: u32,
    pub tiles: Vec<BakedTile>,
    /// Seconds that its tiles took.
    pub seconds: f64,
}

/// A block that is being filled. Its tiles are one piece of memory, which the system takes back as a whole; of
/// thousands of small ones it would get hardly any.
pub(super) struct Filled {
    pub page: u32,
    tiles: Vec<LineTile>,
    /// Texels and values of the tiles.
    pub bytes: Vec<u8>,
    pub seconds: f64,
}

/// The line of a block.
#[derive(Serialize, Deserialize)]
struct Line {
    pub seconds: f64,
    tiles: Vec<LineTile>,
}

/// A tile in the line of a block.
#[derive(Serialize, Deserialize)]
struct LineTile {
    index: u32,
    texels: usize,
    stats: PageStats,
}

impl Filled {
    pub fn new(page: u32) -> Self {
        Self {
            page,
            tiles: Vec::new(),
            bytes: Vec::with_capacity(BLOCK),
            seconds: 0.0,
        }
    }

    pub fn add(&mut self, tile: &BakedTile) {
        self.tiles.push(LineTile {
            index: tile.index,
            texels: tile.texels.len(),
            stats: tile.stats,
        });
        let texels = tile.texels.iter().map(|texel| texel.to_le_bytes());
        let values = tile.values.iter().map(|value| value.to_le_bytes());
        let start = self.bytes.len();
        let count = tile.texels.len() + tile.values.len();
        self.bytes.resize(start + 4 * count, 0);
        let room = self.bytes[start..].as_chunks_mut().0.iter_mut();
        room.zip(texels.chain(values))
            .for_each(|(to, own)| *to = own);
    }

    pub fn encode(self) -> Vec<u8> {
        let (seconds, tiles) = (self.seconds, self.tiles);
        let line = Line { seconds, tiles };
        let mut bytes = self.page.to_le_bytes().to_vec();
        bytes.extend(serde_json::to_vec(&line).expect("plain structs become JSON"));
        bytes.push(b'\n');
        bytes.extend(self.bytes);
        bytes
    }
}

impl Block {
    /// The block in `bytes`; `None` where they are something else.
    pub fn decode(bytes: &[u8], widths: Widths) -> Option<Self> {
        let (page, rest) = bytes.split_first_chunk()?;
        let page = u32::from_le_bytes(*page);
        let columns = widths.of(page);
        let end = rest.iter().position(|&byte| byte == b'\n')?;
        let line: Line = serde_json::from_slice(&rest[..end]).ok()?;
        let mut rest = &rest[end + 1..];
        let mut take = |count: usize| {
            let (own, others) = rest.split_at_checked(count.checked_mul(4)?)?;
            rest = others;
            Some(own.as_chunks::<4>().0)
        };
        let mut tiles = Vec::with_capacity(line.tiles.len());
        for LineTile {
            index,
            texels,
            stats,
        } in line.tiles
        {
            let places = take(texels)?.iter().map(|b| u32::from_le_bytes(*b));
            let values = take(texels.checked_mul(columns)?)?.iter();
            let values: Vec<f32> = values.map(|b| f32::from_le_bytes(*b)).collect();
            tiles.push(BakedTile {
                index,
                texels: places.collect(),
                values,
                stats,
            });
        }
        let seconds = line.seconds;
        rest.is_empty().then_some(Self {
            page,
            tiles,
            seconds,
        })
    }
}
