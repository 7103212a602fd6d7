//! Sums of texels, and their least squares for several planes at once, by conjugate gradients.
//!
//! M. Hestenes, E. Stiefel, "Methods of Conjugate Gradients for Solving Linear Systems", 1952, on the normal equations,
//! scaled by their diagonal. A sum of a seam reads at most eight texels, so a step is linear in the length of the
//! seams, nothing fills in, and the start, which is the page as it is, is near. That is why no factorisation is used.
//! Which texels a sum reads, and how, is the same for all planes; each plane has a lane of its own for what sums count
//! and what they lack. Sums run in a fixed order, and no lane looks at another.

use glam::{DVec4, Vec4};
use rayon::prelude::*;

/// Planes that are solved at once, each in a lane of a vector.
pub(super) const LANES: usize = 4;

/// Most steps, and the share of the first gradient at which they end. On a helmet of 2,400 charts half of this takes
/// nearly twice as many steps and leaves 1 % less at its seams.
const STEPS: usize = 100;
const ENOUGH: f64 = 2e-3;

/// An energy that no texel moves by: below it single precision ends, and steps would be divided by 0.
const NOTHING: f64 = 1e-20;

/// Numbers that one thread takes at a time.
const CHUNK: usize = 2048;

/// Texels and their weights.
type Taps = [(u32, f32)];

/// Lists of numbers with weights.
#[derive(Debug)]
struct Lists {
    starts: Vec<u32>,
    entries: Vec<(u32, f32)>,
}

impl Lists {
    fn of(&self, list: usize) -> &Taps {
        &self.entries[self.starts[list] as usize..self.starts[list + 1] as usize]
    }

    fn count(&self) -> usize {
        self.starts.len() - 1
    }

    fn sum(&self, list: usize, values: &[Vec4]) -> Vec4 {
        let sum = |sum, &(at, weight): &(u32, f32)| sum + weight * values[at as usize];
        self.of(list).iter().fold(Vec4::ZERO, sum)
    }

    /// What the others list: for each of `count` numbers, who has it.
    fn transposed(&self, count: usize) -> Self {
        let mut starts = vec![0u32; count + 1];
        for entry in &self.entries {
            starts[entry.0 as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut slots = starts.clone();
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for list in 0..self.count() {
            for &(at, weight) in self.of(list) {
                let slot = &mut slots[at as usize];
                entries[*slot as usize] = (list as u32, weight);
                *slot += 1;
            }
        }
        Self { starts, entries }
    }
}

/// Weighted sums of texels, by sum and by texel.
#[derive(Debug)]
pub(super) struct Sums {
    rows: Lists,
    columns: Lists,
}

impl Sums {
    /// Of so many texels, from look-ups and whether each is the last of its sum.
    pub fn new(texels: usize, looks: impl Iterator<Item = (bool, [(u32, f32); 4])>) -> Self {
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for (is_last, taps) in looks {
            entries.extend(taps.iter().filter(|tap| tap.1 != 0.0));
            if is_last {
                starts.push(entries.len() as u32);
            }
        }
        let rows = Lists { starts, entries };
        let columns = rows.transposed(texels);
        Self { rows, columns }
    }

    pub fn taps(&self, sum: usize) -> &Taps {
        self.rows.of(sum)
    }

    pub fn count(&self) -> usize {
        self.rows.count()
    }
}

/// What sums should be.
pub(super) struct Equations<'a> {
    pub sums: &'a Sums,
    /// What the square of what a sum lacks counts.
    pub weights: Vec<Vec4>,
    /// What each sum lacks as long as nothing moves.
    pub lacks: Vec<Vec4>,
}

impl Equations<'_> {
    /// Moves texels from where they are to the least squares. `free` has 1 for a texel that may move, else 0. A lane is
    /// done when the energy of its gradient is at most `rest`; where that is 0 it is told here, from the first
    /// gradient.
    pub fn solve(&self, moves: &mut [Vec4], free: &[Vec4], rest: &mut DVec4) {
        let (rows, columns) = (&self.sums.rows, &self.sums.columns);
        let zeros = |list: &[Vec4]| vec![Vec4::ZERO; list.len()];
        let mut scale = zeros(free);
        each(&mut scale, |i, scale| {
            let square = |sum, &(row, weight): &(u32, f32)| {
                sum + weight * weight * self.weights[row as usize]
            };
            let squares = columns.of(i).iter().fold(Vec4::ZERO, square);
            *scale = free[i] / squares.max(Vec4::splat(f32::MIN_POSITIVE));
            Vec4::ZERO
        });
        let mut pull = zeros(&self.lacks);
        each(&mut pull, |row, pull| {
            *pull = self.weights[row] * (self.lacks[row] - rows.sum(row, moves));
            Vec4::ZERO
        });
        let mut scaled = zeros(free);
        let turn = |pull: &[Vec4], scaled: &mut [Vec4]| {
            each(scaled, |i, scaled| {
                let gradient = columns.sum(i, pull);
                *scaled = scale[i] * gradient;
                *scaled * gradient
            })
        };
        let mut energy = turn(&pull, &mut scaled);
        *rest = DVec4::select(rest.cmpeq(DVec4::ZERO), energy * ENOUGH * ENOUGH, *rest);
        let mut direction = scaled.clone();
        let mut along = zeros(&self.lacks);
        for _ in 0..STEPS {
            let goes = energy.cmpgt(rest.max(DVec4::splat(NOTHING)));
            if !goes.any() {
                break;
            }
            let squares = each(&mut along, |row, along| {
                let sum = rows.sum(row, &direction);
                *along = self.weights[row] * sum;
                *along * sum
            });
            // Lanes that are done stay, so that none depends on the others.
            let going = |of: DVec4| DVec4::select(goes, of, DVec4::ZERO).as_vec4();
            let step = going(energy / squares);
            each(&mut pull, |row, pull| {
                *pull -= step * along[row];
                Vec4::ZERO
            });
            each(moves, |i, moved| {
                *moved += step * direction[i];
                Vec4::ZERO
            });
            let next = turn(&pull, &mut scaled);
            let keep = going(next / energy);
            each(&mut direction, |i, direction| {
                *direction = scaled[i] + keep * *direction;
                Vec4::ZERO
            });
            energy = next;
        }
    }
}

/// Changes each number by its index; the sum of what that returns, in an order that does not depend on the number of
/// threads.
fn each(numbers: &mut [Vec4], change: impl Fn(usize, &mut Vec4) -> Vec4 + Sync) -> DVec4 {
    let part = |(chunk, numbers): (usize, &mut [Vec4])| {
        let numbers = numbers.iter_mut().enumerate();
        let sum = |sum, (k, number)| sum + change(chunk * CHUNK + k, number);
        numbers.fold(Vec4::ZERO, sum).as_dvec4()
    };
    let chunks = numbers.par_chunks_mut(CHUNK).enumerate();
    let parts: Vec<DVec4> = chunks.map(part).collect();
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 (1 - x + y)² + x² + y² is least at x = -y = 4/9; with y held at 0, at x = 4/5.
    #[test]
    fn two_texels_meet_where_the_squares_are_least() {
        let none = (0, 0.0);
        let looks = [
            [(0, 1.0), (1, -1.0), none, none],
            [(0, 1.0), none, none, none],
            [(1, 1.0), none, none, none],
        ];
        let sums = Sums::new(2, looks.into_iter().map(|look| (true, look)));
        let equations = Equations {
            sums: &sums,
            weights: vec![Vec4::splat(4.0), Vec4::ONE, Vec4::ONE],
            lacks: vec![Vec4::ONE, Vec4::ZERO, Vec4::ZERO],
        };
        let mut moves = [Vec4::ZERO; 2];
        let free = [Vec4::new(1.0, 1.0, 0.0, 0.0), Vec4::X];
        let mut rest = DVec4::ZERO;
        equations.solve(&mut moves, &free, &mut rest);
        let exact = [
            Vec4::new(4.0 / 9.0, 0.8, 0.0, 0.0),
            Vec4::new(-4.0 / 9.0, 0.0, 0.0, 0.0),
        ];
        for (moved, exact) in moves.iter().zip(exact) {
            assert!(moved.abs_diff_eq(exact, 1e-6), "{moved} {exact}");
        }
    }

    #[test]
    fn differences_at_the_end_of_single_precision_move_nothing() {
        let none = (0, 0.0);
        let looks = [
            [(0, 0.75), (1, -0.25), none, none],
            [(1, 1.0), none, none, none],
        ];
        let sums = Sums::new(2, looks.into_iter().map(|look| (true, look)));
        for k in 0..200 {
            let lack = Vec4::splat(1e-20 * 0.95f32.powi(k));
            let equations = Equations {
                sums: &sums,
                weights: vec![Vec4::new(1.0, 0.1, 0.01, 0.003); 2],
                lacks: vec![lack, 0.5 * lack],
            };
            let (mut moves, mut rest) = ([Vec4::ZERO; 2], DVec4::ZERO);
            equations.solve(&mut moves, &[Vec4::ONE; 2], &mut rest);
            let is_rest = |moved: &Vec4| moved.is_finite() && moved.abs().max_element() < 1e-6;
            assert!(moves.iter().all(is_rest), "{k}: {moves:?}");
        }
    }
}
