//! The GGX lobes of sixteen lanes, as the rays of the hemisphere see them.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::step::Step;
use crate::integrate::sums::{GlossSums, REPLICATES};
use ambient::ggx::lobes16;
use ambient::lanes::{LANES, Wide};
use ambient::sampling::Guide;
use glam::DVec3;
use std::f32::consts::TAU;
use std::rc::Rc;

/// What the hemisphere rays of a texel bring to its GGX lobe.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beside {
    /// They count for the lobe.
    pub shares: bool,
    pub sums: [GlossSums; REPLICATES as usize],
    /// Where they were sent, if not everywhere alike.
    pub guide: Option<Rc<Guide>>,
}

/// What the lanes of a gang gather for their lobes.
pub(super) struct LaneGloss {
    alpha: Wide,
    /// Lanes whose lobes gather.
    used: u32,
    sums: Box<Lanes<f64>>,
    block: Box<Lanes<f32>>,
}

/// As [`GlossSums`].
#[derive(Clone, Copy, Default)]
struct Lanes<T> {
    open: [[T; LANES]; 2],
    all: [[T; LANES]; 2],
    light: [[[T; LANES]; 3]; 2],
}

impl LaneGloss {
    pub fn new() -> Self {
        Self {
            alpha: [1.0; LANES],
            used: 0,
            sums: Box::default(),
            block: Box::default(),
        }
    }

    /// Forgets all lanes and what they gathered.
    pub fn clear(&mut self) {
        self.used = 0;
        *self.sums = Lanes::default();
    }

    /// Lets a lane gather for a lobe of this α.
    pub fn set(&mut self, lane: usize, alpha: f64) {
        self.alpha[lane] = alpha as f32;
        self.used |= 1 << lane;
    }

    /// True where a lane gathers.
    pub fn is_used(&self) -> bool {
        self.used != 0
    }

    /// Adds the directions of a step, which the hemisphere drew, by the balance heuristic beside as many that the lobes draw. `light` is
    /// that of a map above its floor, as open lanes see it.
    #[inline(always)]
    pub fn add(
        &mut self,
        step: &Step,
        open: u32,
        [normal, view]: [&[Wide; 3]; 2],
        light: Option<&[Wide; 3]>,
    ) {
        let lobes = lobes16(&self.alpha, normal, view, &step.directions);
        let mut values = [[0.0; LANES]; 2];
        let mut is_open = [0.0; LANES];
        for l in 0..LANES {
            let even = 1.0 / (TAU * step.weights[1][l]);
            let value = lobes.density[l] * lobes.weight[l] / (lobes.density[l] + even);
            values[0][l] = value;
            values[1][l] = value * lobes.fresnel[l];
            is_open[l] = (open >> l & 1) as f32;
        }
        for k in 0..2 {
            for l in 0..LANES {
                self.block.all[k][l] += values[k][l];
                self.block.open[k][l] += values[k][l] * is_open[l];
            }
        }
        let Some(light) = light else {
            return;
        };
        for k in 0..2 {
            for c in 0..3 {
                for l in 0..LANES {
                    self.block.light[k][c][l] += values[k][l] * light[c][l];
                }
            }
        }
    }

    /// Takes the sums of a block.
    pub fn absorb(&mut self) {
        let add = |sums: &mut [[f64; LANES]], block: &[[f32; LANES]]| {
            for (sum, value) in sums.as_flattened_mut().iter_mut().zip(block.as_flattened()) {
                *sum += f64::from(*value);
            }
        };
        let (sums, block) = (&mut *self.sums, &*self.block);
        add(&mut sums.open, &block.open);
        add(&mut sums.all, &block.all);
        for (sums, block) in sums.light.iter_mut().zip(&block.light) {
            add(sums, block);
        }
        *self.block = Lanes::default();
    }

    /// Adds what a lane gathered from so many points to its replicate.
    pub fn collect(&self, lane: usize, points: u64, into: &mut GlossSums) {
        if self.used >> lane & 1 == 0 {
            return;
        }
        let of = |lanes: &[[f64; LANES]; 2]| lanes.map(|values| values[lane]);
        *into += GlossSums {
            open: of(&self.sums.open),
            all: of(&self.sums.all),
            light: self.sums.light.map(|rgb| DVec3::from(rgb.map(|c| c[lane]))),
            points: points as u32,
        };
    }
}
