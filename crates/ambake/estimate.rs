//! What a bake will take: texels, rays, memory, room on the disk and time, before it is begun.

use crate::job::Job;
use crate::memory::resident;
use ::bake::{Bounces, Denoise};

/// Processor seconds to compose and write a channel of a page texel, as EXR and as preview.
const WRITING: f64 = 1.2e-7;
/// The same to denoise a channel of a chart's texel, and to keep one for later updates.
const DENOISING: f64 = 3.5e-7;
const KEEPING: f64 = 1.7e-8;
/// The same to solve a channel at a point of a seam.
const JOINING: f64 = 7e-6;
/// The same for the picture of the lit scene and for all that does not grow.
const ONCE: f64 = 0.3;
/// Bytes of code and of tables that are first used while a bake is written.
const CODE: u64 = 8 << 20;
/// Bytes of a compressed 32-bit number, as a share: of pages with their previews, and of what is kept for later
/// updates.
const WRITTEN: f64 = 0.75;
const KEPT: f64 = 0.3;
/// Gathers of light of which there are as many as it takes, about.
const GATHERS: u64 = 8;

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
    /// Bytes of all files of the result; those of `STEM.P.state`, which `--update` needs, are among them.
    pub disk_bytes: u64,
    /// Bytes of these alone.
    pub state_bytes: u64,
    /// Bytes that are needed on the disk while it bakes: the result and the tiles that an interrupted bake goes on
    /// from.
    pub disk_peak_bytes: u64,
    /// Processor seconds of baking and writing, over all threads.
    pub cpu_seconds: f64,
    /// Wall time of baking and writing in seconds, with these threads on this machine while it does nothing else.
    pub seconds: f64,
}

impl Job {
    /// What the bake will take, from about a hundredth of its tiles.
    pub fn estimate(&self) -> Estimate {
        let pilot = self.pilot(self.tiles_of_pilot());
        let texels = self.atlas().audit.texels;
        let share = pilot.share.max(f64::MIN_POSITIVE);
        let memory = self.memory();
        let page = u64::from(self.atlas().page_size).pow(2);
        let pages = u64::from(self.atlas().page_count);
        let covered = texels.div_ceil(pages.max(1));
        let threads = self.within(rayon::current_num_threads);
        let charts = self.within(|| atlas::largest_charts(self.scene(), self.atlas(), threads));
        let seams = self
            .within(|| ::bake::seam_points(self.world(), self.atlas(), self.baker_options().seams));
        let most = seams.iter().copied().max().unwrap_or(0);
        let known = Some((charts.as_slice(), most));
        let peak = self.within(|| memory.pages(pages, page, covered, known));
        let used = resident().unwrap_or(0) + peak + CODE;
        let threads = threads as f64;
        let baking = pilot.cpu_seconds / share;
        let denoised = match self.options().denoises() {
            Denoise::Off => 0,
            _ => memory.denoised,
        };
        let finishing = ONCE
            + WRITING * (page * pages * self.channels()) as f64
            + DENOISING * (texels * denoised) as f64
            + JOINING * (seams.iter().sum::<u64>() * memory.denoised) as f64
            + KEEPING * (texels * memory.working) as f64;
        let room = self.room();
        Estimate {
            texels,
            rays: (pilot.rays as f64 / share).round() as u64,
            memory_bytes: used.max(crate::peak_memory().unwrap_or(0)),
            disk_bytes: room.result + room.state,
            state_bytes: room.state,
            disk_peak_bytes: room.peak(),
            cpu_seconds: baking + finishing,
            seconds: baking / threads + finishing / threads.sqrt(),
        }
    }

    /// Channels that are written.
    fn channels(&self) -> u64 {
        let layers = self.options().layers.iter();
        layers.map(|layer| layer.channels().len() as u64).sum()
    }

    /// About how many bytes the files of a bake take.
    pub(crate) fn room(&self) -> Room {
        let texels = self.atlas().audit.texels;
        let working = self.memory().working;
        let share = |channels: u64, share: f64| ((texels * 4 * channels) as f64 * share) as u64;
        // The written GLB has the geometry and the pictures of the scene.
        let inputs = self.scene().inputs.iter();
        let inputs = inputs.filter_map(|path| Some(std::fs::metadata(path).ok()?.len()));
        let light = self.memory().light;
        let gathers = match self.options().bounces {
            Bounces::Most(most) => u64::from(most),
            Bounces::Auto => GATHERS,
            Bounces::Off => 0,
        };
        let gathers = gathers + u64::from(!self.options().lights.is_empty());
        Room {
            result: share(self.channels(), WRITTEN) + inputs.sum::<u64>(),
            state: share(working, KEPT),
            journal: texels * 4 * (working + 1 + gathers * (light + 1)),
        }
    }

    fn tiles_of_pilot(&self) -> usize {
        let tile = u64::from(atlas::TILE).pow(2);
        (self.atlas().audit.texels / tile / 100).clamp(48, 256) as usize
    }
}

/// Bytes on the disk.
pub(crate) struct Room {
    /// Of pages, previews and models.
    result: u64,
    /// Of what later updates need.
    state: u64,
    /// Of finished tiles while the bake runs.
    journal: u64,
}

impl Room {
    /// At the moment before the result is complete.
    pub fn peak(&self) -> u64 {
        self.result + self.state + self.journal
    }
}
