//! What a texel at a contact has to hold, so that look-ups beside the contact find the light that is there.
//!
//! A look-up mixes four texels. Beside a contact some of them are seen in part and some not at all. What is measured of
//! the former is the mean over their seen part, and the look-up at the middle of that part should find it. That is an
//! equation in up to four texels for each texel that is seen in part. What these leave open, light that runs as evenly
//! as it can decides: the second differences of the texels are asked to vanish, at a smaller weight (a thin plate; J.
//! Duchon, "Splines Minimizing Rotation-Invariant Semi-Norms in Sobolev Spaces", 1977). The least squares are taken
//! over a small window, and only for the texel in its middle. They are linear in what was measured, so the texel is a
//! sum of its neighbours with weights of geometry alone.

use ambient::solve::cholesky;
use glam::{DVec2, IVec2};

/// Texels of the window to each side of its middle.
pub(super) const RADIUS: i32 = 2;
const EDGE: usize = (2 * RADIUS + 1) as usize;
const TEXELS: usize = EDGE * EDGE;

/// What a second difference counts beside an equation of a look-up.
const BEND: f64 = 0.1;

/// What a first difference counts: it decides where nothing else does.
const STEP: f64 = 1e-3;

/// Weights below this, of the largest, are left out.
const LEAST: f64 = 1e-3;

/// What is known of a texel of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Holds {
    /// The value at its middle: all of it can be seen.
    Value,
    /// The mean about a place, in texels from the middle of the window.
    Mean(DVec2),
    /// Nothing.
    Nothing,
}

/// The texels of one surface about a texel.
#[derive(Debug)]
pub(super) struct Window([Option<Holds>; TEXELS]);

/// A sum of texels that is to be what a texel holds, or 0.
struct Equation {
    taps: [(usize, f64); 4],
    holds: Option<usize>,
    weight: f64,
}

impl Window {
    /// From the texels and what they hold, in texels from the middle.
    pub fn of(texels: impl Iterator<Item = (IVec2, Holds)>) -> Self {
        let mut window = Self([None; TEXELS]);
        for (at, holds) in texels {
            if let Some(slot) = slot(at) {
                window.0[slot] = Some(holds);
            }
        }
        window
    }

    /// The texel in the middle as a sum of what the window's texels hold; `None` where nothing is known.
    pub fn middle(&self) -> Option<Vec<(IVec2, f64)>> {
        let mut number = [usize::MAX; TEXELS];
        let mut unknowns = 0;
        for (slot, holds) in self.0.iter().enumerate() {
            if !matches!(holds, None | Some(Holds::Value)) {
                number[slot] = unknowns;
                unknowns += 1;
            }
        }
        let known = |holds: &&Option<Holds>| !matches!(holds, None | Some(Holds::Nothing));
        let middle = number[TEXELS / 2];
        if middle == usize::MAX || !self.0.iter().any(|holds| known(&holds)) {
            return None;
        }
        let equations = self.equations();
        let mut normal = [0.0; TEXELS * TEXELS];
        let normal = &mut normal[..unknowns * unknowns];
        for Equation { taps, weight, .. } in &equations {
            let taps = taps.iter().filter(|tap| tap.1 != 0.0);
            let mut own = [(0, 0.0); 4];
            let mut count = 0;
            for (i, w) in taps.map(|&(slot, w)| (number[slot], w)) {
                if i < unknowns {
                    own[count] = (i, w);
                    count += 1;
                }
            }
            // The half above the diagonal is all that is asked for.
            for &(i, a) in &own[..count] {
                for &(j, b) in own[..count].iter().filter(|(j, _)| *j >= i) {
                    normal[i * unknowns + j] += weight * b * a;
                }
            }
        }
        let mut row = [0.0; TEXELS];
        let row = &mut row[..unknowns];
        row[middle] = 1.0;
        if !cholesky(normal, row) {
            return None;
        }
        let mut weights = [0.0; TEXELS];
        for Equation {
            taps,
            holds,
            weight,
        } in &equations
        {
            let used = taps.iter().filter(|tap| tap.1 != 0.0);
            let of_row = |&(slot, w): &(usize, f64)| match number[slot] {
                usize::MAX => 0.0,
                i => w * row[i],
            };
            let along = weight * used.clone().map(of_row).sum::<f64>();
            if let Some(slot) = holds {
                weights[*slot] += along;
            }
            for &(slot, w) in used.filter(|tap| number[tap.0] == usize::MAX) {
                weights[slot] -= along * w;
            }
        }
        let least = LEAST * weights.iter().fold(0.0f64, |most, w| most.max(w.abs()));
        weights
            .iter_mut()
            .filter(|w| w.abs() < least)
            .for_each(|w| *w = 0.0);
        let total: f64 = weights.iter().sum();
        if total.is_nan() || total < 0.5 {
            return None;
        }
        let used = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
        Some(used.map(|(slot, w)| (at(slot), w / total)).collect())
    }

    /// Look-ups that are known, and light that runs evenly.
    fn equations(&self) -> Vec<Equation> {
        let has = |at: IVec2| slot(at).filter(|&slot| self.0[slot].is_some());
        let mut equations = Vec::with_capacity(4 * TEXELS);
        let mut even = |steps: &[(IVec2, f64)], weight: f64| {
            let mut taps = [(0, 0.0); 4];
            for (tap, &(at, w)) in taps.iter_mut().zip(steps) {
                match has(at) {
                    Some(slot) => *tap = (slot, w),
                    None => return,
                }
            }
            equations.push(Equation {
                taps,
                holds: None,
                weight,
            });
        };
        for here in (0..TEXELS).map(at) {
            let [right, down] = [IVec2::X, IVec2::Y];
            for step in [right, down] {
                even(
                    &[(here, 1.0), (here + step, -2.0), (here + 2 * step, 1.0)],
                    BEND * BEND,
                );
                even(&[(here, 1.0), (here + step, -1.0)], STEP * STEP);
            }
            let corners = [
                (here, 1.0),
                (here + right, -1.0),
                (here + down, -1.0),
                (here + right + down, 1.0),
            ];
            even(&corners, 2.0 * BEND * BEND);
        }
        for (slot, holds) in self.0.iter().enumerate() {
            if let Some(Holds::Mean(place)) = holds {
                let reach = place.floor().abs().max(place.ceil().abs()).max_element();
                if reach > f64::from(RADIUS) {
                    continue;
                }
                // A look-up that leaves the surface is left to the texel alone.
                let (taps, weight) = match look_up(*place, has) {
                    Some(taps) => (taps, 1.0),
                    None => ([(slot, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)], BEND),
                };
                equations.push(Equation {
                    taps,
                    holds: Some(slot),
                    weight,
                });
            }
        }
        equations
    }
}

/// The slots and weights of a bilinear look-up; `None` where it reads what is not there.
fn look_up(place: DVec2, has: impl Fn(IVec2) -> Option<usize>) -> Option<[(usize, f64); 4]> {
    let low = place.floor();
    let part = place - low;
    let low = low.as_ivec2();
    let mut taps = [(0, 0.0); 4];
    for (k, tap) in taps.iter_mut().enumerate() {
        let [dx, dy] = [k & 1, k >> 1];
        let along = |d: usize, part: f64| if d == 1 { part } else { 1.0 - part };
        let weight = along(dx, part.x) * along(dy, part.y);
        if weight > 0.0 {
            *tap = (has(low + IVec2::new(dx as i32, dy as i32))?, weight);
        }
    }
    Some(taps)
}

fn slot(at: IVec2) -> Option<usize> {
    let inside = at.abs().max_element() <= RADIUS;
    inside.then(|| (at.y + RADIUS) as usize * EDGE + (at.x + RADIUS) as usize)
}

fn at(slot: usize) -> IVec2 {
    IVec2::new((slot % EDGE) as i32, (slot / EDGE) as i32) - RADIUS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall that cuts the window along x = cut + y / 4: what lies to the right of it cannot be seen.
    fn beside_a_wall(cut: f64) -> Window {
        let texels = (0..TEXELS).map(at).map(|at| {
            let places = (0..64).map(|k| {
                at.as_dvec2() + (DVec2::new(f64::from(k % 8), f64::from(k / 8)) - 3.5) / 8.0
            });
            let seen: Vec<DVec2> = places.filter(|p| p.x < cut + 0.25 * p.y).collect();
            let holds = match seen.len() {
                0 => Holds::Nothing,
                64 => Holds::Value,
                n => Holds::Mean(seen.iter().sum::<DVec2>() / n as f64),
            };
            (at, holds)
        });
        Window::of(texels)
    }

    #[test]
    fn planes_are_carried_on_exactly_past_a_contact() {
        let plane = |p: DVec2| 0.4 + 0.1 * p.x - 0.03 * p.y;
        for cut in [-0.9, -0.45, -0.2, 0.0, 0.3, 0.49] {
            let window = beside_a_wall(cut);
            let value: f64 = window
                .middle()
                .expect("a value")
                .iter()
                .map(|&(at, weight)| match window.0[slot(at).expect("inside")] {
                    Some(Holds::Mean(place)) => weight * plane(place),
                    _ => weight * plane(at.as_dvec2()),
                })
                .sum();
            assert!((value - 0.4).abs() < 1e-3, "{cut}: {value}");
        }
    }

    #[test]
    fn where_nothing_is_known_nothing_is_made_up() {
        let nothing = (0..TEXELS).map(|slot| (at(slot), Holds::Nothing));
        assert_eq!(Window::of(nothing).middle(), None);
    }
}
