//! The least and the largest alpha of an image, block by block: what most alpha tests of rays need of it.
//!
//! Rays meet leaves and fences in no order, so each look-up in a large image waits for memory. Most of such an image is
//! wholly opaque or wholly clear, and its blocks are so few that they stay near the processor.

use crate::Image;

/// Edge of a block in texels.
const EDGE: u32 = 4;

/// Of each block of an image's texels and of those beside it, the least and the largest alpha.
#[derive(Debug, Clone)]
pub struct AlphaBlocks {
    /// Blocks in a row.
    across: usize,
    ranges: Vec<[u8; 2]>,
}

impl AlphaBlocks {
    /// Those of an image.
    pub fn of(image: &Image) -> Self {
        let [width, height] = [image.width, image.height];
        let across = width.div_ceil(EDGE);
        let mut ranges = Vec::with_capacity((across * height.div_ceil(EDGE)) as usize);
        let mut columns = Vec::new();
        for row in 0..height.div_ceil(EDGE) {
            columns.clear();
            columns.resize(width as usize, NONE);
            for y in within(row, height) {
                let texels = &image.pixels[y as usize * width as usize..][..width as usize];
                for (column, texel) in columns.iter_mut().zip(texels) {
                    *column = joined(*column, [texel[3]; 2]);
                }
            }
            ranges.extend((0..across).map(|block| {
                let own = within(block, width).map(|x| columns[x as usize]);
                own.fold(NONE, joined)
            }));
        }
        Self {
            across: across as usize,
            ranges,
        }
    }

    /// The least and the largest alpha, 0..=1, of a texel and those beside it.
    pub(crate) fn about(&self, x: u32, y: u32) -> [f32; 2] {
        let [x, y] = [x, y].map(|at| (at / EDGE) as usize);
        self.ranges[y * self.across + x].map(|code| f32::from(code) / 255.0)
    }
}

/// The range of nothing.
const NONE: [u8; 2] = [u8::MAX, 0];

fn joined(a: [u8; 2], b: [u8; 2]) -> [u8; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The texels of a block and those beside it along an axis of so many; where an image repeats, the first and the last
/// are side by side.
fn within(block: u32, edge: u32) -> impl Iterator<Item = u32> {
    let first = block * EDGE + edge - 1;
    (first..first + EDGE + 2).map(move |at| at % edge)
}
