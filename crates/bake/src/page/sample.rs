//! The tiles of a page that a pilot looks at, and what these say of the others.
//!
//! A part of a page says nearly as well as the whole how many rays a target takes. What counts is that each part is
//! large enough to be denoised as the page will be, and that the parts are spread over the page, since what lies side
//! by side is often one surface.

use super::planes::{BakedPage, LayerPlanes};
use super::stats::PageStats;
use super::tile::BakedTile;
use atlas::{PageRaster, TILE};
use layers::Layer;

/// Edge of a block, in tiles.
const BLOCK: u32 = 3;

/// One block in so many is looked at, but no fewer than [`FEWEST`].
const ONE_IN: usize = 20;
const FEWEST: usize = 10;

/// Blocks nearer than so many tiles say equally much of a tile.
const NEAR: f64 = 4.0;

/// What a tile's own texels say of it counts half where they are so few: among a handful there may be none whose rays
/// differ.
const FEW: f64 = 16.0;

/// What a pilot says of a tile.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Found {
    pub texels: f64,
    /// Sum of the squares of errors over what they may be.
    pub squares: f64,
}

impl Found {
    fn add(&mut self, other: Self, weight: f64) {
        self.texels += weight * other.texels;
        self.squares += weight * other.squares;
    }

    fn mean(&self) -> f64 {
        self.squares / self.texels.max(f64::MIN_POSITIVE)
    }
}

/// The texels of a sample of a page of so many, at most: blocks may be fuller than others.
pub fn sampled(texels: u64) -> u64 {
    let block = u64::from(BLOCK * TILE).pow(2);
    texels.min((2 * FEWEST as u64 * block).max(2 * texels / ONE_IN as u64))
}

/// Tiles that lie in blocks, of a page and of one that holds nothing but these blocks.
pub(super) struct Sample {
    tiles: Vec<Sampled>,
    /// Edge of a page of the sample alone, in tiles.
    across: u32,
}

#[derive(Clone, Copy)]
struct Sampled {
    /// Index into the raster's tiles.
    index: u32,
    /// Column and row on the page, in tiles.
    at: [u32; 2],
    /// Column and row on a page of the sample alone, in tiles.
    place: [u32; 2],
}

impl Sample {
    /// A sample of a page, the same whenever it is asked for.
    pub fn of(raster: &PageRaster<'_>, size: u32) -> Self {
        let at = |&tile: &u32| place(tile, size);
        let block = |[x, y]: [u32; 2]| morton(x / BLOCK, y / BLOCK);
        let mut blocks: Vec<u64> = raster.tiles().iter().map(at).map(block).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let step = ONE_IN.min(blocks.len() / FEWEST).max(1);
        let blocks: Vec<u64> = blocks.into_iter().skip(step / 2).step_by(step).collect();
        let across = (blocks.len() as f64).sqrt().ceil() as u32;
        let sampled = |(index, at): (usize, [u32; 2])| {
            let number = blocks.binary_search(&block(at)).ok()? as u32;
            let corner = [number % across, number / across];
            Some(Sampled {
                index: index as u32,
                at,
                place: [0, 1].map(|k| corner[k] * BLOCK + at[k] % BLOCK),
            })
        };
        Self {
            tiles: raster
                .tiles()
                .iter()
                .map(at)
                .enumerate()
                .filter_map(sampled)
                .collect(),
            across: across * BLOCK,
        }
    }

    /// Indices into the raster's tiles.
    pub fn tiles(&self) -> Vec<u32> {
        self.tiles.iter().map(|tile| tile.index).collect()
    }

    /// A page of these tiles alone, of a page of this size.
    pub fn page(&self, layers: Vec<Layer>, baked: Vec<BakedTile>, size: u32) -> BakedPage {
        let own = self.across * TILE;
        let void = |layer| LayerPlanes::void(layer, own as usize * own as usize);
        let mut page = BakedPage {
            page: 0,
            size: own,
            tiles: Vec::new(),
            finished: false,
            planes: layers.into_iter().map(void).collect(),
            stats: PageStats::default(),
        };
        for tile in baked {
            let sampled = self
                .tiles
                .binary_search_by_key(&tile.index, |tile| tile.index);
            let Ok([x, y]) = sampled.map(|k| self.tiles[k].place) else {
                continue;
            };
            let texel = |texel: &u32| {
                (y * TILE + texel / size % TILE) * own + x * TILE + texel % size % TILE
            };
            page.store(&BakedTile {
                index: y * self.across + x,
                texels: tile.texels.iter().map(texel).collect(),
                ..tile
            });
        }
        page
    }

    /// What is known of each tile of a page by what was found of the texels of the sample's page: by its own texels,
    /// and by the blocks about it.
    pub fn spread(
        &self,
        squares: &[Option<f64>],
        raster: &PageRaster<'_>,
        size: u32,
    ) -> Vec<Found> {
        let edge = (self.across * TILE) as usize;
        let wide = self.across / BLOCK;
        let mut tiles = vec![Found::default(); (self.across * self.across) as usize];
        for (texel, square) in squares.iter().enumerate() {
            let [x, y] = [texel % edge, texel / edge].map(|k| k as u32 / TILE);
            let found = square.map_or(Found::default(), |square| Found {
                texels: 1.0,
                squares: square,
            });
            tiles[(y * self.across + x) as usize].add(found, 1.0);
        }
        let mut own = vec![Found::default(); raster.tiles().len()];
        let mut blocks = vec![([0.0; 2], Found::default()); (wide * wide) as usize];
        for tile in &self.tiles {
            let [x, y] = tile.place;
            let found = tiles[(y * self.across + x) as usize];
            own[tile.index as usize] = found;
            let (middle, block) = &mut blocks[(y / BLOCK * wide + x / BLOCK) as usize];
            *middle = (tile.at).map(|k| f64::from(k / BLOCK * BLOCK) + 0.5 * f64::from(BLOCK - 1));
            block.add(found, 1.0);
        }
        let texels = own.iter().map(|own| own.texels).sum::<f64>() / self.tiles.len() as f64;
        let scale = 1.0 + self.doubt(&blocks, own.len());
        let of = |(&number, own): (&u32, &Found)| {
            let at = place(number, size).map(f64::from);
            let mut about = Found::default();
            for (block, found) in &blocks {
                let far: f64 = (0..2).map(|k| (at[k] - block[k]).powi(2)).sum();
                about.add(*found, 1.0 / (NEAR * NEAR + far));
            }
            let texels = if own.texels > 0.0 { own.texels } else { texels };
            let mean = (own.squares + FEW * about.mean()) / (own.texels + FEW);
            Found {
                texels,
                squares: scale * mean * texels,
            }
        };
        raster.tiles().iter().zip(&own).map(of).collect()
    }

    /// The standard error of what blocks say of so many tiles of a page, over what they say: by so much they may miss
    /// what is dear.
    fn doubt(&self, blocks: &[([f64; 2], Found)], tiles: usize) -> f64 {
        let mut all = Found::default();
        blocks.iter().for_each(|(_, found)| all.add(*found, 1.0));
        let off = |found: &Found| (found.squares - all.mean() * found.texels).powi(2);
        let off = blocks
            .iter()
            .map(|(_, found)| off(found))
            .sum::<f64>()
            .sqrt();
        let left = 1.0 - self.tiles.len() as f64 / tiles as f64;
        off / all.squares.max(f64::MIN_POSITIVE) * left.sqrt()
    }
}

/// Column and row of a tile of a page of this size.
fn place(tile: u32, size: u32) -> [u32; 2] {
    let across = size.div_ceil(TILE);
    [tile % across, tile / across]
}

/// The number of a place along a curve that fills the plane: the bits of its column and its row in turn.
fn morton(x: u32, y: u32) -> u64 {
    let bits = |number: u32| {
        (0..32)
            .map(|k| (u64::from(number) >> k & 1) << (2 * k))
            .sum::<u64>()
    };
    bits(x) | bits(y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere on a floor, on a page of this size.
    fn page(size: u32, test: impl FnOnce(&PageRaster<'_>)) {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/resting_sphere.obj"
        );
        let scene = scene::load(file.as_ref()).expect("a scene");
        let layout = atlas::Options {
            page_size: size,
            ..Default::default()
        };
        let atlas = atlas::layout(&scene, &layout, &|| false).expect("a layout");
        test(&atlas::Rasters::default().page(&scene, &atlas, 0));
    }

    #[test]
    fn a_part_of_a_page_in_whole_blocks_is_looked_at() {
        page(1024, |raster| {
            let sample = Sample::of(raster, 1024);
            let share = sample.tiles.len() as f64 / raster.tiles().len() as f64;
            assert!((0.03..0.08).contains(&share), "{share}");
            let block = |tile: &Sampled| tile.at.map(|k| k / BLOCK);
            let looked_at = |at: [u32; 2]| sample.tiles.iter().any(|tile| tile.at == at);
            for &tile in raster.tiles() {
                let at = place(tile, 1024);
                let is_of_one = sample
                    .tiles
                    .iter()
                    .any(|tile| block(tile) == at.map(|k| k / BLOCK));
                assert_eq!(looked_at(at), is_of_one);
            }
            // In every quarter of the page that has tiles.
            for quarter in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                let has = |at: [u32; 2]| at.map(|k| k / 32) == quarter;
                assert_eq!(
                    raster.tiles().iter().any(|&tile| has(place(tile, 1024))),
                    sample.tiles.iter().any(|tile| has(tile.at)),
                );
            }
        });
        // All of a page of few tiles.
        page(64, |raster| {
            assert_eq!(Sample::of(raster, 64).tiles.len(), raster.tiles().len());
        });
    }

    #[test]
    fn tiles_are_known_by_their_texels_and_by_the_blocks_about_them() {
        page(512, |raster| {
            let sample = Sample::of(raster, 512);
            // Each texel of a tile says the number of the tile.
            let baked = sample.tiles.iter().map(|tile| {
                let [x, y] = tile.at.map(|k| k * TILE);
                let texels = (0..TILE * TILE).map(|k| (y + k / TILE) * 512 + x + k % TILE);
                BakedTile {
                    index: tile.index,
                    texels: texels.collect(),
                    values: vec![1.0 + tile.index as f32; (TILE * TILE) as usize],
                    stats: PageStats {
                        texels: u64::from(TILE * TILE),
                        ..PageStats::default()
                    },
                }
            });
            let page = sample.page(vec![Layer::Coverage], baked.collect(), 512);
            let values = page.layer(Layer::Coverage).expect("a layer");
            let told = |of: &dyn Fn(f64) -> f64| {
                let squares = values
                    .iter()
                    .map(|&value| (value > 0.0).then(|| of(f64::from(value))));
                sample.spread(&squares.collect::<Vec<_>>(), raster, 512)
            };
            // The same everywhere leaves no doubt.
            for found in told(&|_| 2.0) {
                assert_eq!(found.texels, 256.0);
                assert!((found.squares - 2.0 * 256.0).abs() < 1e-9);
            }
            let found = told(&|number| number);
            let own = sample
                .tiles
                .iter()
                .map(|tile| (tile.index, found[tile.index as usize]));
            let over = own.map(|(index, found)| found.mean() / f64::from(1 + index));
            let over: Vec<f64> = over.collect();
            // By one factor, but for what few texels could say.
            let middle = over[over.len() / 2];
            assert!(middle > 1.0, "{middle}");
            let near = over[1..]
                .iter()
                .filter(|over| (*over / middle - 1.0).abs() < 0.15);
            assert!(near.count() > over.len() * 3 / 4, "{over:?}");
            // Tiles that were not looked at are between.
            let most = raster.tiles().len() as f64 * middle * 1.1;
            assert!(
                found
                    .iter()
                    .all(|found| (0.0..most).contains(&found.mean()))
            );
        });
    }
}
