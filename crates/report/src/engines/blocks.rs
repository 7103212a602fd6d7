//! Blocks of 4 x 4 texels in 16 bytes, which graphics processors read as they are: BC6H of light, BC7 of occlusion.
//!
//! The encoder is the crate `block_compression`. It uses sums, products, quotients and square roots of 32-bit numbers
//! alone, and a block depends on its own texels alone: the bytes are the same on every processor, at any number of
//! threads.

use super::LightLevel;
use crate::engine_table::BLOCK;
use block_compression::encode::{compress_rgba8, compress_rgba16};
use block_compression::{BC6HSettings, BC7Settings, CompressionVariant};
use half::f16;
use rayon::prelude::*;

/// Blocks of unsigned BC6H: 16-bit floats, three channels.
pub fn light(level: &LightLevel) -> Vec<u8> {
    // `very_slow` takes six times as long for 0.7 dB.
    let variant = CompressionVariant::BC6H(BC6HSettings::basic());
    let texel = |[r, g, b]: [f32; 3]| [r, g, b, 1.0].map(f16::from_f32);
    encode(level, texel, |texels, blocks, width| {
        compress_rgba16(variant, texels, blocks, width, BLOCK, 4 * width);
    })
}

/// Blocks of BC7: values 0..=1 in 8 bits, grey and opaque.
pub fn grey(level: &LightLevel) -> Vec<u8> {
    let variant = CompressionVariant::BC7(BC7Settings::opaque_basic());
    let texel = |[v, ..]: [f32; 3]| {
        let byte = (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        [byte, byte, byte, 255]
    };
    encode(level, texel, |texels, blocks, width| {
        compress_rgba8(variant, texels, blocks, width, BLOCK, 4 * width);
    })
}

/// The blocks row by row. Those over the edge of a level that is smaller than a block repeat its last column and row.
fn encode<T: Copy + Send>(
    level: &LightLevel,
    texel: impl Fn([f32; 3]) -> [T; 4] + Sync,
    compress: impl Fn(&[T], &mut [u8], u32) + Sync,
) -> Vec<u8> {
    let (edge, rows) = (level.size as usize, BLOCK as usize);
    let width = edge.next_multiple_of(rows);
    let row = |row: usize| {
        let at = |i: usize| {
            let (x, y) = (i % width, row * rows + i / width);
            texel(level.pixels[y.min(edge - 1) * edge + x.min(edge - 1)])
        };
        let texels: Vec<[T; 4]> = (0..rows * width).map(at).collect();
        let mut blocks = vec![0; 16 * width / rows];
        compress(texels.as_flattened(), &mut blocks, width as u32);
        blocks
    };
    let rows: Vec<Vec<u8>> = (0..width / rows).into_par_iter().map(row).collect();
    rows.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(size: u32, pixel: impl Fn(usize, usize) -> [f32; 3]) -> LightLevel {
        let edge = size as usize;
        let pixels = (0..edge * edge).map(|i| pixel(i % edge, i / edge));
        LightLevel {
            size,
            pixels: pixels.collect(),
        }
    }

    /// Calls `see` with column, row, block and place in the block of each texel of a level of this size.
    fn texels(size: u32, mut see: impl FnMut(usize, usize, usize, usize)) {
        let edge = size as usize;
        for i in 0..edge * edge {
            let (x, y) = (i % edge, i / edge);
            let block = y / 4 * edge.div_ceil(4) + x / 4;
            see(x, y, block, y % 4 * 4 + x % 4);
        }
    }

    /// Red, green and blue of the sixteen texels of a block.
    fn read(blocks: &[u8], block: usize) -> [f32; 48] {
        let mut read = [0.0; 48];
        bcdec_rs::bc6h_float(&blocks[16 * block..][..16], &mut read, 12, false);
        read
    }

    #[test]
    fn light_of_a_wide_range_comes_back_within_five_per_cent() {
        // It falls by a factor of e every 16 texels. The ends of a block have 10 bits or more, steps of 3 to 6 % of
        // which half is lost, and a step between them is 1.2 %.
        let shown = level(64, |x, y| {
            let fall = (-((x + y) as f32) / 16.0).exp();
            [4000.0 * fall, 1000.0 * fall, 3.0 * fall]
        });
        let blocks = light(&shown);
        assert_eq!(blocks.len(), 64 * 64);
        texels(64, |x, y, block, at| {
            let read = read(&blocks, block);
            let expected = shown.pixels[y * 64 + x];
            for c in 0..3 {
                let off = (read[3 * at + c] - expected[c]).abs() / expected[c];
                assert!(off < 0.05, "{x} {y}: {} {expected:?}", read[3 * at + c]);
            }
        });
    }

    #[test]
    fn black_white_and_the_largest_half_float_stay() {
        for value in [0.0, 1.0, 65504.0] {
            let read = read(&light(&level(4, |_, _| [value; 3])), 0);
            // The ends of a block's colours have 10 to 16 bits.
            let stays = |v: &f32| (v - value).abs() <= value * 0.002;
            assert!(read.iter().all(stays), "{value}: {read:?}");
        }
    }

    #[test]
    fn grey_comes_back_within_two_steps_of_eight_bits_and_opaque() {
        let wave = |x: usize, y: usize| ((x * 3 + y * 5) as f32 / 9.0).sin() * 0.05;
        let shown = level(32, |x, y| [wave(x, y) + x as f32 / 40.0; 3]);
        let blocks = grey(&shown);
        assert_eq!(blocks.len(), 32 * 32);
        texels(32, |x, y, block, at| {
            let mut read = [0; 64];
            bcdec_rs::bc7(&blocks[16 * block..][..16], &mut read, 16);
            let expected = shown.pixels[y * 32 + x][0].clamp(0.0, 1.0) * 255.0;
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| f32::from(read[4 * at + c]));
            assert!(a >= 254.0, "{a}");
            for v in [r, g, b] {
                assert!((v - expected).abs() <= 2.5, "{x} {y}: {v} {expected}");
            }
        });
    }

    #[test]
    fn levels_smaller_than_a_block_are_whole_blocks_of_their_own_texels() {
        for size in [1, 2, 3, 6] {
            let blocks = light(&level(size, |x, _| [1.0 + x as f32; 3]));
            assert_eq!(blocks.len() as u32, 16 * size.div_ceil(4).pow(2));
            texels(size, |x, _, block, at| {
                let (read, expected) = (read(&blocks, block), 1.0 + x as f32);
                let off = (read[3 * at] - expected).abs();
                assert!(off < 0.05 * expected, "{size}: {read:?}");
            });
        }
    }
}
