//! Many probes: those in solids are moved to the nearest air, or marked.

use crate::{Error, Gather, Probe};
use glam::DVec3;
use layers::Progress;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where a probe stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Where it was asked for.
    There,
    /// In the nearest air.
    Moved,
    /// Where it was asked for, in a solid or behind surfaces: its light is that of no air.
    Invalid,
    /// Where it was asked for, and nothing was gathered: its light is that of the probes around it.
    Between,
}

/// A probe and where it was asked for, in coordinates of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Where it was asked for.
    pub asked: DVec3,
    /// How far it got.
    pub state: State,
    /// Its light.
    pub probe: Probe,
}

/// Share of directions that must meet no back of a surface where there is air. Above a ground without a bottom all do,
/// below it half of them.
pub(crate) const LEAST_VALIDITY: f64 = 0.75;

/// How far from a surface a moved probe stands, as a share of the way that it may be moved.
const CLEARANCE: f64 = 0.1;

/// Gathers the probes at places of the world, each with the number by which its sample points are labelled, and hands
/// them over one by one, in any order.
///
/// * `most`: how far a probe in a solid, or behind a surface, may be moved, in scene units; 0 marks it.
///
/// The values do not depend on the number of threads, nor on what else is gathered. `progress` hears of probes.
///
/// # Errors
/// [`Error::Cancelled`], or what `take` returns.
pub fn gather<E: From<Error> + Send>(
    gather: &Gather<'_>,
    wanted: &[(u32, DVec3)],
    most: f64,
    progress: &dyn Progress,
    take: impl Fn(u32, Placed) -> Result<(), E> + Sync,
) -> Result<(), E> {
    let done = AtomicU64::new(0);
    let each = wanted.par_iter().with_max_len(1);
    each.try_for_each(|&(number, asked)| {
        if progress.cancelled() {
            return Err(Error::Cancelled.into());
        }
        let placed = place(gather, number, asked, most);
        progress.rays(u64::from(placed.probe.rays));
        let before = done.fetch_add(1, Ordering::Relaxed);
        progress.advance(before + 1, wanted.len() as u64);
        take(number, placed)
    })
}

/// The probe at a place, or in the air past the nearest surface that keeps it in.
fn place(gather: &Gather<'_>, number: u32, asked: DVec3, most: f64) -> Placed {
    let probe = gather.probe(number, asked);
    let placed = |state, probe| Placed {
        asked,
        state,
        probe,
    };
    if probe.validity >= LEAST_VALIDITY {
        return placed(State::There, probe);
    }
    if let Some((surface, far)) = probe.way_out {
        let air = surface + far * (CLEARANCE * most);
        if air.distance(asked) <= most {
            let moved = gather.probe(number, air);
            if moved.validity >= LEAST_VALIDITY {
                return placed(State::Moved, moved);
            }
        }
    }
    placed(State::Invalid, probe)
}
