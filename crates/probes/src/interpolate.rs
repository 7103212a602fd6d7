//! What a look-up between the probes of a volume gives, and what that costs.

use crate::volume::LEAST_VALIDITY;
use crate::{Grid, Placed, State};
use ambient::harmonics::matt_rms;
use ambient::sampling::Stream;
use glam::DVec3;

/// What linear interpolation between probes misses of the light E / π at random places in the air, all normals and
/// channels together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interpolation {
    /// Places that were looked at.
    pub places: usize,
    /// Mean light of the probes, E / π.
    pub mean: f64,
    /// Root mean square of what is missed, E / π.
    pub rms: f64,
    /// What one place in a hundred misses more than.
    pub p99: f64,
    /// What of the root mean square is the standard error of the probes themselves.
    pub noise: f64,
}

/// Stream label of the places.
const PLACES: u32 = 8;

/// Fills light of invalid probes from their neighbours in a grid: means of those that share a face, layer by layer.
/// Nothing changes where no probe is valid.
pub fn fill<T: Clone>(grid: &Grid, values: &mut [T], valid: &[bool], mean: impl Fn(&[&T]) -> T) {
    let mut valid = valid.to_vec();
    loop {
        let reached: Vec<(usize, T)> = (0..values.len())
            .filter(|&k| !valid[k])
            .filter_map(|k| {
                let near: Vec<&T> = (grid.neighbours(k))
                    .filter(|&k| valid[k])
                    .map(|k| &values[k])
                    .collect();
                (!near.is_empty()).then(|| (k, mean(&near)))
            })
            .collect();
        if reached.is_empty() {
            return;
        }
        for (k, value) in reached {
            values[k] = value;
            valid[k] = true;
        }
    }
}

/// Random places of a box, of which probes tell what interpolation costs. It is the one that the grid was made for:
/// cells may stand out of it.
pub fn tried(seed: u64, [low, high]: [DVec3; 2], count: usize) -> impl Iterator<Item = DVec3> {
    let stream = Stream::new(seed, u32::MAX, 0, PLACES, 0);
    (0..count).map(move |number| {
        let [x, y, z, _] = stream.point(number as u32);
        low + (high - low) * DVec3::new(x, y, z)
    })
}

/// What interpolation between the probes of a grid costs at those places of `found` that are in the air; `None` where
/// there is none.
///
/// * `filled`: the light of the grid's probes, invalid ones filled.
pub fn interpolation(
    grid: &Grid,
    probes: &[Placed],
    filled: &[Vec<DVec3>],
    found: &[Placed],
) -> Option<Interpolation> {
    let square = |rms: DVec3| rms.dot(rms) / 3.0;
    let (mut missed, mut noise) = (Vec::new(), 0.0);
    let in_air = found
        .iter()
        .filter(|placed| placed.state == State::There && placed.probe.validity >= LEAST_VALIDITY);
    for placed in in_air {
        let mut off = placed.probe.light.clone();
        noise += square(matt_rms(&placed.probe.std_err));
        for (probe, weight) in grid.taps(placed.asked) {
            for (off, value) in off.iter_mut().zip(&filled[probe]) {
                *off -= weight * *value;
            }
            noise += weight * weight * square(matt_rms(&probes[probe].probe.std_err));
        }
        missed.push(square(matt_rms(&off)));
    }
    if missed.is_empty() {
        return None;
    }
    missed.sort_unstable_by(f64::total_cmp);
    let count = missed.len() as f64;
    let root = (4.0 * std::f64::consts::PI).sqrt();
    let mean = |light: &Vec<DVec3>| light[0].element_sum() / (3.0 * root);
    Some(Interpolation {
        places: missed.len(),
        mean: filled.iter().map(mean).sum::<f64>() / filled.len() as f64,
        rms: (missed.iter().sum::<f64>() / count).sqrt(),
        p99: missed[(0.99 * (count - 1.0)).round() as usize].sqrt(),
        noise: (noise / count).sqrt(),
    })
}
