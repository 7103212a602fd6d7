//! What the lanes of a gang gather.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::step::Step;
use crate::integrate::sums::{Sums, Technique, Weights};
use ambient::lanes::LANES;
use glam::DVec3;

/// Sums over a lane's rays: weights of all rays and of the open ones, for two quantities; rays cast.
#[derive(Clone, Copy, Default)]
pub(super) struct LaneSums<T> {
    pub all: [[T; LANES]; 2],
    pub open: [[T; LANES]; 2],
    /// Light of a map above its floor: by the normal; by the lobe without colour and times (1 - V·H)^5.
    pub light: [[[T; LANES]; 3]; 3],
    pub rays: [u32; LANES],
}

impl LaneSums<f32> {
    #[inline(always)]
    pub fn add(&mut self, step: &Step, open: u32, cast: u32) {
        let mut is_open = [0.0; LANES];
        for l in 0..LANES {
            is_open[l] = (open >> l & 1) as f32;
            self.rays[l] += cast >> l & 1;
        }
        for k in 0..2 {
            for l in 0..LANES {
                let w = step.weights[k][l];
                self.all[k][l] += w;
                self.open[k][l] += w * is_open[l];
            }
        }
    }
}

impl LaneSums<f64> {
    #[inline(always)]
    pub fn absorb(&mut self, block: &LaneSums<f32>) {
        for l in 0..LANES {
            for k in 0..2 {
                self.all[k][l] += f64::from(block.all[k][l]);
                self.open[k][l] += f64::from(block.open[k][l]);
            }
            for a in 0..3 {
                for k in 0..3 {
                    self.light[k][a][l] += f64::from(block.light[k][a][l]);
                }
            }
            self.rays[l] += block.rays[l];
        }
    }

    /// What one lane gathered with a technique, from so many points.
    pub fn of_lane(&self, technique: Technique, lane: usize, points: u64) -> Sums {
        let weights = |k: usize| Weights {
            open: self.open[k][lane],
            all: self.all[k][lane],
        };
        let vector = |of: &[[f64; LANES]; 3]| DVec3::new(of[0][lane], of[1][lane], of[2][lane]);
        let mut sums = Sums {
            points,
            rays: u64::from(self.rays[lane]),
            ..Sums::default()
        };
        let reflection = || [vector(&self.light[1]), vector(&self.light[2])];
        match technique {
            Technique::Hemisphere => {
                (sums.diffuse, sums.visibility) = (weights(0), weights(1));
                sums.irradiance = vector(&self.light[0]);
            }
            Technique::Lobe => {
                sums.lobe = [weights(0), weights(1)];
                sums.reflection = reflection();
            }
            Technique::Sky => {
                sums.irradiance = vector(&self.light[0]);
                sums.reflection = reflection();
            }
        }
        sums
    }
}
