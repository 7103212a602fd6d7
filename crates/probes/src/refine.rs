//! Which probes of a volume are gathered: where light changes evenly, every second one tells what is between.

use crate::{Grid, Placed, Probe, State};
use ambient::harmonics::matt_rms;
use glam::DVec3;

/// Along each axis so many steps lie between probes that are always gathered, and between those that say whether
/// these are enough.
const APART: usize = 2;
const WIDE: usize = 2 * APART;

/// The probes that are still to be gathered before [`complete`] fills the rest: every second one along each axis first,
/// then all around those whose neighbours, twice as far, do not tell their light.
///
/// * `missed`: the most that these may be off, of the light E / π, 1 under an open sky of 1; root mean square over
///   normals and channels, beyond what is noise.
pub fn lacking(grid: &Grid, placed: &[Option<Placed>], missed: f64) -> Vec<usize> {
    let absent = |&probe: &usize| placed[probe].is_none();
    let apart = (0..placed.len()).filter(|&probe| stands(grid, probe, APART));
    let first: Vec<usize> = apart.clone().filter(absent).collect();
    if !first.is_empty() {
        return first;
    }
    let mut uneven = vec![false; placed.len()];
    for probe in apart {
        uneven[probe] = is_uneven(grid, placed, probe, missed);
    }
    let around = |probe: &usize| around(grid, *probe, APART).any(|(near, _)| uneven[near]);
    (0..placed.len()).filter(absent).filter(around).collect()
}

/// All probes of a volume, those that were not gathered mixed of the gathered ones around them.
///
/// # Panics
/// Where [`lacking`] has not come to its end.
pub fn complete(grid: &Grid, placed: Vec<Option<Placed>>) -> Vec<Placed> {
    let mixed: Vec<(usize, Placed)> = (0..placed.len())
        .filter(|&probe| placed[probe].is_none())
        .map(|probe| (probe, mix(grid, &placed, probe)))
        .collect();
    let mut whole = placed;
    for (probe, placed) in mixed {
        whole[probe] = Some(placed);
    }
    whole.into_iter().flatten().collect()
}

/// Whether a probe is one of those that stand so many steps apart, up to the last along each axis.
fn stands(grid: &Grid, probe: usize, apart: usize) -> bool {
    let at = grid.at(probe);
    let counts = grid.counts.to_array();
    (0..3).all(|axis| at[axis].is_multiple_of(apart) || at[axis] + 1 == counts[axis] as usize)
}

/// Those of them that are about a probe, with weights that add up to 1.
fn around(grid: &Grid, probe: usize, apart: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
    let at = grid.at(probe);
    let counts = grid.counts.to_array().map(|n| n as usize);
    let sides: [[(usize, f64); 2]; 3] = std::array::from_fn(|axis| {
        let low = at[axis] / apart * apart;
        let high = (low + apart).min(counts[axis] - 1);
        let part = match high - low {
            0 => 0.0,
            steps => (at[axis] - low) as f64 / steps as f64,
        };
        [(low, 1.0 - part), (high, part)]
    });
    (0..8).filter_map(move |corner: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| sides[axis][corner >> axis & 1]);
        let weight = x.1 * y.1 * z.1;
        (weight > 0.0).then_some((x.0 + counts[0] * (y.0 + counts[1] * z.0), weight))
    })
}

/// Whether a gathered probe, or one that tells it, stands in no air, or what they tell is off by more than `missed`.
fn is_uneven(grid: &Grid, placed: &[Option<Placed>], probe: usize, missed: f64) -> bool {
    let there = |probe: usize| {
        let placed = placed[probe].as_ref();
        placed.filter(|placed| placed.state == State::There)
    };
    let Some(own) = there(probe) else {
        return true;
    };
    let square = |rms: DVec3| rms.dot(rms) / 3.0;
    let mut off = own.probe.light.clone();
    let mut noise = square(matt_rms(&own.probe.std_err));
    if stands(grid, probe, WIDE) {
        return false;
    }
    for (near, weight) in around(grid, probe, WIDE) {
        let Some(near) = there(near) else {
            return true;
        };
        for (off, value) in off.iter_mut().zip(&near.probe.light) {
            *off -= weight * *value;
        }
        noise += weight * weight * square(matt_rms(&near.probe.std_err));
    }
    square(matt_rms(&off)) > missed * missed + noise
}

/// The probe that those around it tell.
fn mix(grid: &Grid, placed: &[Option<Placed>], probe: usize) -> Placed {
    let near: Vec<(&Probe, f64)> = around(grid, probe, APART)
        .map(|(near, weight)| {
            (
                &placed[near].as_ref().expect("a gathered probe").probe,
                weight,
            )
        })
        .collect();
    let first = near[0].0;
    let sum = |of: &dyn Fn(&Probe) -> &Vec<DVec3>| -> Vec<DVec3> {
        let one = |k: usize| {
            near.iter()
                .map(|(probe, weight)| of(probe)[k] * *weight)
                .sum()
        };
        (0..of(first).len()).map(one).collect()
    };
    let error = |k: usize| {
        let squares = near
            .iter()
            .map(|(probe, w)| (probe.std_err[k] * *w).powf(2.0));
        squares.sum::<DVec3>().map(f64::sqrt)
    };
    let texel = |k: usize| {
        [0, 1].map(|of| {
            near.iter()
                .map(|(probe, w)| probe.distance[k][of] * *w as f32)
                .sum()
        })
    };
    let place = grid.place(probe);
    Placed {
        asked: place,
        state: State::Between,
        probe: Probe {
            place,
            light: sum(&|probe| &probe.light),
            std_err: (0..first.std_err.len()).map(error).collect(),
            rays: 0,
            parts: std::array::from_fn(|part| sum(&|probe| &probe.parts[part])),
            validity: near.iter().map(|(probe, w)| probe.validity * w).sum(),
            distance: (0..first.distance.len()).map(texel).collect(),
            way_out: None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec3;

    const GRID: Grid = Grid {
        low: DVec3::ZERO,
        cell: DVec3::ONE,
        counts: UVec3::new(10, 5, 8),
    };

    /// A probe whose light has this mean, known but for an error.
    fn made(probe: usize, value: f64, error: f64) -> Placed {
        let place = GRID.place(probe);
        let all = |value: f64| vec![DVec3::splat(value); 4];
        Placed {
            asked: place,
            state: State::There,
            probe: Probe {
                place,
                light: all(value),
                std_err: all(error),
                rays: 64,
                parts: [all(value), all(0.0), all(0.0)],
                validity: 1.0,
                distance: vec![[2.0, 4.0]],
                way_out: None,
            },
        }
    }

    /// How many are gathered of light that is so in each place, and the light of all.
    fn refined(value: &dyn Fn(DVec3) -> f64, error: f64, missed: f64) -> (usize, Vec<Placed>) {
        let mut placed = vec![None; GRID.len() as usize];
        loop {
            let next = lacking(&GRID, &placed, missed);
            if next.is_empty() {
                break;
            }
            for probe in next {
                placed[probe] = Some(made(probe, value(GRID.place(probe)), error));
            }
        }
        let gathered = placed.iter().flatten().count();
        (gathered, complete(&GRID, placed))
    }

    /// Every second of ten, five and eight, and the last.
    const FIRST: usize = 6 * 3 * 5;

    #[test]
    fn light_that_changes_evenly_is_told_by_every_second_probe() {
        let value = |p: DVec3| 1.0 + p.x - 0.5 * p.y + 0.25 * p.z;
        let (gathered, all) = refined(&value, 0.0, 1e-9);
        assert_eq!(gathered, FIRST);
        for (probe, placed) in all.iter().enumerate() {
            let off = placed.probe.light[0].x - value(GRID.place(probe));
            assert!(off.abs() < 1e-12, "{probe}: {off}");
            assert_eq!(placed.probe.distance, [[2.0, 4.0]]);
            let between = placed.state == State::Between;
            assert_eq!(between, placed.probe.rays == 0);
        }
    }

    #[test]
    fn a_step_is_gathered_whole_and_nothing_far_from_it() {
        let value = |p: DVec3| f64::from(u8::from(p.x > 7.0));
        let (gathered, all) = refined(&value, 0.0, 0.01);
        // Columns 5 to 7, of which the first round had a part of the middle one.
        assert_eq!(gathered, FIRST + 3 * 40 - 15);
        for (probe, placed) in all.iter().enumerate() {
            let place = GRID.place(probe);
            assert_eq!(placed.probe.light[0].x, value(place), "{place}");
            let is_near = (5..8).contains(&GRID.at(probe)[0]);
            let is_gathered = placed.state == State::There;
            assert_eq!(is_gathered, is_near || stands(&GRID, probe, APART));
        }
        // Noise is no step.
        let noisy = |p: DVec3| 0.1 * (p.x * 7919.0 + p.y * 104_729.0).sin();
        assert_eq!(refined(&noisy, 0.5, 0.01).0, FIRST);
        assert!(refined(&noisy, 0.0, 0.01).0 > 300);
    }

    #[test]
    fn what_stands_in_no_air_tells_nobody() {
        let mut placed: Vec<Option<Placed>> = vec![None; GRID.len() as usize];
        for probe in lacking(&GRID, &placed, 1.0) {
            placed[probe] = Some(made(probe, 1.0, 0.0));
        }
        assert!(lacking(&GRID, &placed, 1.0).is_empty());
        // One of those that nobody else tells.
        placed[0].as_mut().expect("the first").state = State::Moved;
        let next = lacking(&GRID, &placed, 1.0);
        let near = |&probe: &usize| GRID.place(probe).max_element() < 5.0;
        assert!(next.contains(&1) && next.iter().all(near), "{next:?}");
    }
}
