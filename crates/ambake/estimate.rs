//! What a bake will take: texels, rays, memory and time, before it is begun.

use crate::job::Job;
use crate::memory::{Memory, resident};

/// Seconds to finish and write a channel of a texel with one thread.
const FINISHING: f64 = 1.2e-7;

/// What a bake will take.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Texels that a chart touches, over all pages.
    pub texels: u64,
    /// Rays in all.
    pub rays: u64,
    /// Largest resident memory in bytes.
    pub memory_bytes: u64,
    /// Wall time of baking and writing in seconds, on this machine and with these threads.
    pub seconds: f64,
}

impl Job {
    /// What the bake will take, from about a hundredth of its tiles.
    pub fn estimate(&self) -> Estimate {
        let pilot = self.pilot(self.tiles_of_pilot());
        let texels = self.atlas().audit.texels;
        let share = pilot.share.max(f64::MIN_POSITIVE);
        let memory = Memory::of(self.options(), self.baker().layers());
        let page = u64::from(self.atlas().page_size).pow(2);
        let pages = u64::from(self.atlas().page_count);
        let used = resident().unwrap_or(0) + memory.page(page, texels.div_ceil(pages));
        let threads = self.within(rayon::current_num_threads) as f64;
        let written = (page * pages * memory.channels()) as f64;
        Estimate {
            texels,
            rays: (pilot.rays as f64 / share).round() as u64,
            memory_bytes: used.max(crate::peak_memory().unwrap_or(0)),
            seconds: pilot.seconds / share + FINISHING * written / threads.sqrt(),
        }
    }

    fn tiles_of_pilot(&self) -> usize {
        let tile = u64::from(atlas::TILE).pow(2);
        (self.atlas().audit.texels / tile / 100).clamp(48, 256) as usize
    }
}
