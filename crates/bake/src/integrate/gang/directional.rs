//! Sums of directions over the rays of sixteen lanes: where a texel is open, and whence its light comes.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::step::{Drawn, Step};
use crate::integrate::estimate::{Known, Quantity};
use crate::integrate::sums::{Technique, corrected};
use crate::integrate::task::Task;
use crate::integrate::terms::Directional;
use ambient::lanes::{LANES, Wide};
use glam::DVec3;
use std::ops::AddAssign;

/// Sums of one replicate.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DirectionSums {
    /// Open directions by their two weights: cosine-weighted and uniform.
    open: [DVec3; 2],
    /// All directions by the same weights.
    all: [DVec3; 2],
    /// Light above the sky's floor divided by the sky's scale, (1/4pi) of its integral; then the same times each axis
    /// of its direction. Linear RGB.
    light: [DVec3; 4],
}

/// What the lanes of a gang gather.
pub(super) struct LaneDirections {
    sums: Box<Lanes<f64>>,
    block: Box<Lanes<f32>>,
}

#[derive(Clone, Copy, Default)]
struct Lanes<T> {
    open: [[[T; LANES]; 3]; 2],
    all: [[[T; LANES]; 3]; 2],
    light: [[[T; LANES]; 3]; 4],
}

impl LaneDirections {
    pub fn new() -> Self {
        Self {
            sums: Box::default(),
            block: Box::default(),
        }
    }

    /// Forgets what was gathered.
    pub fn clear(&mut self) {
        *self.sums = Lanes::default();
    }

    #[inline(always)]
    pub fn add(&mut self, step: &Step, open: u32) {
        let mut is_open = [0.0; LANES];
        for l in 0..LANES {
            is_open[l] = (open >> l & 1) as f32;
        }
        for k in 0..2 {
            for a in 0..3 {
                for l in 0..LANES {
                    let value = step.weights[k][l] * step.directions[a][l];
                    self.block.all[k][a][l] += value;
                    self.block.open[k][a][l] += value * is_open[l];
                }
            }
        }
    }

    /// Adds the light above the floor of a map that lanes see, each by its share of the power heuristic among the
    /// techniques that cover the hemisphere; `density` is that of hemisphere directions, in 1/sr.
    #[inline(always)]
    pub fn add_light(&mut self, step: &Step, light: &[Wide; 3], shares: &Wide, density: &Wide) {
        const SPHERE: f32 = 4.0 * std::f32::consts::PI;
        for l in 0..LANES {
            let weight = match step.drawn {
                Drawn::Hemisphere => shares[l] / (SPHERE * density[l].max(f32::MIN_POSITIVE)),
                Drawn::Lobe(_) => 0.0,
                Drawn::Sky(..) => shares[l] / SPHERE,
            };
            for c in 0..3 {
                let value = weight * light[c][l];
                self.block.light[0][c][l] += value;
                for a in 0..3 {
                    self.block.light[1 + a][c][l] += value * step.directions[a][l];
                }
            }
        }
    }

    /// Takes the sums of a block.
    pub fn absorb(&mut self) {
        let add = |sums: &mut [[f64; LANES]; 3], block: &[[f32; LANES]; 3]| {
            for (sums, block) in sums.as_flattened_mut().iter_mut().zip(block.as_flattened()) {
                *sums += f64::from(*block);
            }
        };
        let (sums, block) = (&mut *self.sums, &*self.block);
        for k in 0..2 {
            add(&mut sums.open[k], &block.open[k]);
            add(&mut sums.all[k], &block.all[k]);
        }
        for (sums, block) in sums.light.iter_mut().zip(&block.light) {
            add(sums, block);
        }
        *self.block = Lanes::default();
    }

    /// Adds what a lane gathered to its replicate.
    pub fn collect(&self, lane: usize, into: &mut DirectionSums) {
        let vector = |of: &[[f64; LANES]; 3]| DVec3::from(of.map(|axis| axis[lane]));
        *into += DirectionSums {
            open: self.sums.open.each_ref().map(vector),
            all: self.sums.all.each_ref().map(vector),
            light: self.sums.light.each_ref().map(vector),
        };
    }
}

impl AddAssign for DirectionSums {
    fn add_assign(&mut self, other: Self) {
        let add = |a: &mut [DVec3], b: &[DVec3]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        add(&mut self.open, &other.open);
        add(&mut self.all, &other.all);
        add(&mut self.light, &other.light);
    }
}

impl DirectionSums {
    /// What each replicate says of texel `i`, whose rays gave these sums.
    ///
    /// With β the slope of a share, a mean is `Σ w (V - β) L / n` and β times that of an open texel: what rays that all
    /// agree have drawn unevenly does not count, so that an open texel is exact and a closed one 0.
    pub fn terms(
        replicates: &[Self; 2],
        task: &Task<'_>,
        gathered: &Known<'_>,
        i: usize,
    ) -> [Directional; 2] {
        let normal = gathered.from.texels[i].normal;
        let cosines = gathered.slopes(i, Quantity::Diffuse);
        let even = gathered.slopes(i, Quantity::Visibility);
        [0, 1].map(|k: usize| {
            let (own, sums) = (&replicates[k], &gathered.from.sums[i][k]);
            let points = sums.points.max(1);
            let mut terms = Directional::default();
            if gathered.from.technique == Technique::Hemisphere {
                let mean = |weight: usize, slope: f64, open: DVec3| {
                    (own.open[weight] - slope * own.all[weight]) / points as f64 + slope * open
                };
                terms.bent = mean(0, cosines[k], normal * (2.0 / 3.0));
                let mean = 0.5 * mean(1, even[k], 0.5 * normal);
                let share = corrected(sums.visibility.over(points), even[k], 1.0);
                terms.light = Directional::even(DVec3::from(task.sky.floor()), 0.5 * share, mean);
            }
            if let Some(map) = task.sky.map() {
                let scale = map.scale() / points as f64;
                for (light, above) in terms.light.iter_mut().zip(own.light) {
                    *light += above * scale;
                }
            }
            terms
        })
    }
}
