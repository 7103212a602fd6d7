//! How far a bake is from the bare loop of `rtcOccluded16` over the very same packets.

use crate::Subject;
use bake::{Denoise, Effort, Options};
use rayon::prelude::*;
use rays::{Coherence, EmbreeBackend, Lanes, PacketWidth, Ray, RayBackend, RayPacket, SurfaceHit};
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
    /// Wall seconds of everything between the ray scene and writing: tiles cut, texels surveyed, rays cast, pages
    /// filled.
    pub bake_seconds: f64,
    /// Wall seconds of the bare loop.
    pub bare_seconds: f64,
    /// Rays of each.
    pub rays: u64,
    /// `bake_seconds / bare_seconds`.
    pub ratio: f64,
}

/// How long the packets of a bake take alone, in packets of another width or with another hint.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Loop {
    /// Threads.
    pub threads: usize,
    /// Rays of a packet, 8 or 16. Packets of 8 are the halves of those of 16.
    pub width: usize,
    /// Whether Embree is told that the rays of a packet are nearly parallel.
    pub coherent: bool,
    /// Wall seconds.
    pub seconds: f64,
    /// Rays that were traced.
    pub rays: u64,
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

    fn closest_that(&self, ray: &Ray, stops: rays::Stops) -> Option<SurfaceHit> {
        self.inner.closest_that(ray, stops)
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

/// Rays of a texel where a target was asked for.
const UNDER_TARGET: u32 = 256;

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
    // What is done after the rays is no part of the ratio, and rays that a target throws away would be.
    let options = &Options {
        denoise: Denoise::Off,
        effort: match options.effort {
            Effort::Target { .. } => Effort::Rays(UNDER_TARGET),
            rays => rays,
        },
        ..options.clone()
    };
    let (packets, active) = record(subject, options, embree)?;
    let rays = count(&active);
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

/// Traces the packets of page 0 through the safe wrapper, `repeats` times at each number of threads: in packets of 16
/// and of 8, without and with the hint that rays are coherent, in turn.
///
/// Costs 1,036 bytes a packet of memory.
///
/// # Errors
/// A pool of threads could not be made.
pub fn loops(
    subject: Subject<'_>,
    options: &Options,
    embree: &EmbreeBackend,
    threads: &[usize],
    repeats: usize,
) -> Result<Vec<Loop>, rayon::ThreadPoolBuildError> {
    let (packets, active) = record(subject, options, embree)?;
    let rays = count(&active);
    let halved: Vec<_> = packets.iter().zip(&active).flat_map(halves).collect();
    let (halved, of_halved): (Vec<_>, Vec<_>) = halved.into_iter().unzip();
    let mut loops = Vec::new();
    for &threads in threads {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        for _ in 0..repeats {
            for (width, coherent) in [(16, false), (16, true), (8, false), (8, true)] {
                let started = Instant::now();
                let blocked = pool.install(|| match width {
                    16 => trace(embree, &packets, &active, coherent),
                    _ => trace(embree, &halved, &of_halved, coherent),
                });
                let seconds = started.elapsed().as_secs_f64();
                assert!(blocked <= rays, "{blocked} of {rays} rays blocked");
                loops.push(Loop {
                    threads,
                    width,
                    coherent,
                    seconds,
                    rays,
                });
            }
        }
    }
    Ok(loops)
}

/// The packets of page 0 and their active lanes.
fn record(
    subject: Subject<'_>,
    options: &Options,
    embree: &EmbreeBackend,
) -> Result<(Vec<RayPacket<16>>, Vec<u32>), rayon::ThreadPoolBuildError> {
    let recorder = Recorder {
        inner: embree,
        packets: Mutex::default(),
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| subject.bake(&recorder, options));
    let recorded = recorder.packets.into_inner();
    let recorded = recorded.unwrap_or_else(PoisonError::into_inner);
    Ok(recorded.into_iter().unzip())
}

/// Rays of packets with these active lanes.
fn count(active: &[u32]) -> u64 {
    let lanes = active.iter().map(|lanes| u64::from(lanes.count_ones()));
    lanes.sum()
}

/// The two halves of a packet that have active lanes.
fn halves((packet, &active): (&RayPacket<16>, &u32)) -> impl Iterator<Item = (RayPacket<8>, u32)> {
    let half = |first: usize| {
        let mut half = RayPacket::<8>::new();
        for lane in 0..8 {
            half.set(lane, &packet.get(first + lane));
        }
        (half, active >> first & 0xff)
    };
    [half(0), half(8)]
        .into_iter()
        .filter(|(_, active)| *active != 0)
}

/// Traces packets with all threads, and counts the rays that are blocked.
fn trace<const N: usize>(
    embree: &EmbreeBackend,
    packets: &[RayPacket<N>],
    active: &[u32],
    coherent: bool,
) -> u64
where
    Lanes<N>: PacketWidth,
{
    let coherence = match coherent {
        true => Coherence::Coherent,
        false => Coherence::Incoherent,
    };
    let blocks = packets.par_chunks(BLOCK).zip(active.par_chunks(BLOCK));
    let blocked = blocks.map(|(packets, active)| {
        let mut blocked = vec![0u32; packets.len()];
        let scene = embree.scene();
        scene.occluded_packets(packets, active, &mut blocked, coherence);
        blocked
            .iter()
            .map(|lanes| u64::from(lanes.count_ones()))
            .sum::<u64>()
    });
    blocked.sum()
}
