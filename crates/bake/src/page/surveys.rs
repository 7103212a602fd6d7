//! Texels that are needed again: those of the pilot of a target, of gathers after the page is finished.

use crate::survey::Texel;
use rustc_hash::FxHashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Texels that are kept at most, over all pages, and the bytes that each takes with what lies under it. Others are made
/// again, which gives the same.
const MOST: u64 = 1 << 19;
const BYTES: u64 = 700;

/// Texels of tiles that were made.
#[derive(Debug, Default)]
pub(super) struct Surveys(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    /// By page and tile.
    tiles: FxHashMap<(u32, u32), Texels>,
    texels: u64,
}

/// The texels of a tile.
pub(super) type Texels = Arc<Vec<Texel>>;

/// The bytes that so many texels take at most where they are kept.
pub fn bytes_of_surveys(texels: u64) -> u64 {
    texels.min(MOST) * BYTES
}

/// The share of so many texels that are made anew wherever they are needed, 0..=1.
pub(crate) fn remade(texels: u64) -> f64 {
    1.0 - (MOST as f64 / texels.max(1) as f64).min(1.0)
}

impl Surveys {
    /// The texels of a tile, by page and index, which `make` makes. They are kept while others will ask for them.
    pub fn of(&self, tile: (u32, u32), is_last: bool, make: impl FnOnce() -> Vec<Texel>) -> Texels {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept().tiles.get(&tile).cloned();
        let texels = found.unwrap_or_else(|| Arc::new(make()));
        let own = texels.len() as u64;
        let mut kept = kept();
        if is_last {
            kept.texels -= kept.tiles.remove(&tile).map_or(0, |_| own);
        } else if kept.texels + own <= MOST && kept.tiles.insert(tile, texels.clone()).is_none() {
            kept.texels += own;
        }
        texels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_made_once_and_let_go_by_the_last_that_asks() {
        let surveys = Surveys::default();
        let mut made = 0;
        for (is_last, wanted) in [(false, 1), (false, 1), (true, 1), (true, 2), (true, 3)] {
            let texels = surveys.of((0, 7), is_last, || {
                made += 1;
                Vec::new()
            });
            assert_eq!((texels.len(), made), (0, wanted));
        }
        // Above the most, they are made each time.
        surveys.0.lock().expect("a lock").texels = MOST + 1;
        for wanted in [4, 5] {
            surveys.of((0, 8), false, || {
                made += 1;
                Vec::new()
            });
            assert_eq!(made, wanted);
        }
    }
}
