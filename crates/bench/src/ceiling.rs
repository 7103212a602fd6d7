//! How far a bake is from the bare loop of `rtcOccluded16` over the very same packets.

use crate::Subject;
use bake::{Denoise, Options};
use rayon::prelude::*;
use rays::{Coherence, EmbreeBackend, Ray, RayBackend, RayPacket, SurfaceHit};
use serde::Serialize;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Packets that one task of the bare loop traces.
const BLOCK: usize = 4096;

/// One paired measurement.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Pair {
    /// Threads of both.
    pub threads: usize,
    /// Wall seconds of everything between the ray scene and writing: tiles cut, texels surveyed, rays cast, pages filled.
    pub bake_seconds: f64,
    /// Wall seconds of the bare loop.
    pub bare_seconds: f64,
    /// Rays of each.
    pub rays: u64,
    /// `bake_seconds / bare_seconds`.
    pub ratio: f64,
}

/// Keeps every packet that passes through it.
struct Recorder<'a> {
    inner: &'a EmbreeBackend,
    packets: Mutex<Vec<(RayPacket<16>, u32)>>,
}

impl RayBackend for Recorder<'_> {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, coherence: Coherence) -> u32 {
        let mut kept = *packet;
        for lane in (0..16).filter(|lane| active >> lane & 1 == 0) {
            let none = RayPacket::<16>::new().get(lane);
            kept.set(
                lane,
                &Ray {
                    t_max: f32::NEG_INFINITY,
                    ..none
                },
            );
        }
        self.packets
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push((kept, active));
        self.inner.occluded16(packet, active, coherence)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.inner.occluded(ray)
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        self.inner.closest(ray)
    }

    fn name(&self) -> &'static str {
        self.inner.name()
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }

    fn memory_bytes(&self) -> u64 {
        self.inner.memory_bytes()
    }
}

/// Bakes page 0 and replays its packets, in turn, `repeats` times at each number of threads.
///
/// Costs 516 bytes a packet of memory.
///
/// # Errors
/// A pool of threads could not be made.
pub fn ceiling(
    subject: Subject<'_>,
    options: &Options,
    embree: &EmbreeBackend,
    threads: &[usize],
    repeats: usize,
) -> Result<Vec<Pair>, rayon::ThreadPoolBuildError> {
    // What is done after the rays is no part of the ratio.
    let options = &Options {
        denoise: Denoise::Off,
        ..options.clone()
    };
    let recorder = Recorder {
        inner: embree,
        packets: Mutex::default(),
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| subject.bake(&recorder, options));
    let recorded = recorder
        .packets
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    let (packets, active): (Vec<_>, Vec<_>) = recorded.into_iter().unzip();
    let rays = active
        .iter()
        .map(|lanes| u64::from(lanes.count_ones()))
        .sum();
    let loops: Vec<_> = packets
        .chunks(BLOCK)
        .zip(active.chunks(BLOCK))
        .map(|(packets, active)| embree.scene().recording(packets, active))
        .collect();
    let mut pairs = Vec::new();
    for &threads in threads {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        for _ in 0..repeats {
            let started = Instant::now();
            let page = pool.install(|| subject.bake(embree, options));
            let bake_seconds = started.elapsed().as_secs_f64();
            let started = Instant::now();
            let blocked: u64 = pool.install(|| loops.par_iter().map(|l| l.replay()).sum());
            let bare_seconds = started.elapsed().as_secs_f64();
            assert!(
                blocked <= rays && page.stats.rays == rays,
                "{blocked} blocked, {} of {rays} rays",
                page.stats.rays
            );
            pairs.push(Pair {
                threads,
                bake_seconds,
                bare_seconds,
                rays,
                ratio: bake_seconds / bare_seconds,
            });
        }
    }
    Ok(pairs)
}
