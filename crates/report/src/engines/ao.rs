//! The diffuse term as a grey picture: 1 is open. It carries no colour space chunk: it is linear, and glTF readers must
//! not look for one.

use super::PageLight;
use super::mips::{fill, is_filled};
use png::{BitDepth, ColorType, Encoder};
use std::sync::LazyLock;

/// Edge of the square of thresholds that 8 bits are dithered with.
const TILE: usize = 64;

/// 16-bit grey: `round(65535 v)`.
pub fn deep(page: &PageLight<'_>) -> Vec<u8> {
    let values = values(page);
    let bytes = values.iter().flat_map(|v| {
        let number = (f64::from(*v) * 65535.0).round() as u16;
        number.to_be_bytes()
    });
    encode(page.size, BitDepth::Sixteen, &bytes.collect::<Vec<_>>())
}

/// 8-bit grey, dithered by blue noise: a smooth slope shows no bands. Values that 8 bits hold, 0 and 1 among them,
/// stay.
pub fn dithered(page: &PageLight<'_>) -> Vec<u8> {
    let (dither, edge) = (Dither::new(), page.size as usize);
    let byte = |(i, v): (usize, &f32)| dither.byte(*v, i % edge, i / edge);
    let bytes: Vec<u8> = values(page).iter().enumerate().map(byte).collect();
    encode(page.size, BitDepth::Eight, &bytes)
}

/// The diffuse term, what lies between charts filled.
fn values(page: &PageLight<'_>) -> Vec<f32> {
    let mut pixels: Vec<[f32; 1]> = page.diffuse.iter().map(|v| [v.clamp(0.0, 1.0)]).collect();
    let filled = is_filled(&page.coverage, page.size, page.rings);
    fill(&mut pixels, page.size, &filled);
    pixels.into_iter().flatten().collect()
}

/// Thresholds for 8 bits.
pub(super) struct Dither(&'static [f32]);

impl Dither {
    pub fn new() -> Self {
        static NOISE: LazyLock<Vec<f32>> = LazyLock::new(blue_noise);
        Self(&NOISE)
    }

    /// The byte of a value 0..=1 in this column and row.
    pub fn byte(&self, value: f32, x: usize, y: usize) -> u8 {
        let threshold = self.0[y % TILE * TILE + x % TILE];
        (f64::from(value) * 255.0 + f64::from(threshold)).round() as u8
    }
}

/// A square of thresholds, each once, above -1/2 and below 1/2, whose neighbours differ: each next is put into the
/// largest void that those before left (R. Ulichney, "The void-and-cluster method for dither array generation", 1993).
/// The square repeats.
fn blue_noise() -> Vec<f32> {
    const SIGMA: f32 = 1.5;
    let count = TILE * TILE;
    let far = |d: usize| d.min(TILE - d) as f32;
    let kernel: Vec<f32> = (0..count)
        .map(|i| {
            let (x, y) = (far(i % TILE), far(i / TILE));
            (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp()
        })
        .collect();
    let mut energy = vec![0.0f32; count];
    let mut thresholds = vec![0.0; count];
    for rank in 0..count {
        let numbered = energy.iter().enumerate();
        let lowest = numbered.fold((0, f32::INFINITY), |best, (i, &energy)| {
            if energy < best.1 { (i, energy) } else { best }
        });
        let place = lowest.0;
        thresholds[place] = (rank as f32 + 0.5) / count as f32 - 0.5;
        let (column, row) = (place % TILE, place / TILE);
        for (y, energy) in energy.chunks_exact_mut(TILE).enumerate() {
            let kernel = &kernel[(y + TILE - row) % TILE * TILE..][..TILE];
            let (before, after) = energy.split_at_mut(column);
            let (first, last) = kernel.split_at(TILE - column);
            let pairs = after.iter_mut().zip(first);
            let pairs = pairs.chain(before.iter_mut().zip(last));
            pairs.for_each(|(energy, more)| *energy += more);
        }
        energy[place] = f32::INFINITY;
    }
    thresholds
}

fn encode(size: u32, depth: BitDepth, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, size, size);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(depth);
    let why = "a PNG in memory with matching sizes";
    let mut writer = encoder.write_header().expect(why);
    writer.write_image_data(bytes).expect(why);
    writer.finish().expect(why);
    file
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::preview::decoded;
    use std::borrow::Cow;

    /// A page of one value.
    pub fn page(value: f32) -> PageLight<'static> {
        let plane: Cow<[f32]> = Cow::Owned(vec![value; 64 * 64]);
        PageLight {
            page: 0,
            size: 64,
            rings: 4,
            mips: 0,
            coverage: Cow::Owned(vec![1.0; 64 * 64]),
            light: [plane.clone(), plane.clone(), plane.clone()],
            diffuse: plane,
            lit: None,
            sh: None,
        }
    }

    #[test]
    fn sixteen_bits_are_rounded() {
        assert_eq!(decoded(&deep(&page(0.25))).1[..2], 16384u16.to_be_bytes());
        assert_eq!(decoded(&deep(&page(2.0))).1[..2], [255, 255]);
    }

    #[test]
    fn dither_keeps_the_mean_spreads_evenly_and_leaves_what_fits() {
        for exact in [0u8, 51, 255] {
            let (_, flat) = decoded(&dithered(&page(f32::from(exact) / 255.0)));
            assert!(flat.iter().all(|&v| v == exact), "{exact}");
        }
        let (_, bytes) = decoded(&dithered(&page(100.25 / 255.0)));
        assert!(bytes.iter().all(|&v| v == 100 || v == 101));
        // Each block of 8 x 8 has about its share of the brighter quarter: white noise would stray by 3.5.
        for block in 0..64 {
            let (x, y) = (block % 8 * 8, block / 8 * 8);
            let bright = (0..64)
                .filter(|i| bytes[(y + i / 8) * 64 + x + i % 8] == 101)
                .count();
            assert!((12..=20).contains(&bright), "{bright} of 64");
        }
    }
}
