//! The GGX lobes of sixteen lanes: directions drawn from them, and what hemisphere rays say of them.
//!
//! Where both are drawn they are weighed by the balance heuristic (E. Veach, L. Guibas, "Optimally Combining Sampling
//! Techniques for Monte Carlo Rendering", 1995), by the numbers in which they are.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::step::Step;
use super::surfaces::Frames;
use crate::integrate::lobe::Lobe;
use ambient::ggx::{Lobes, lobes16, sample16};
use ambient::lanes::{LANES, Wide};
use ambient::sampling::{Guide, Mixture};
use glam::DVec3;
use std::f32::consts::TAU;

/// The lobes of the lanes, and what hemisphere rays have gathered for them.
pub(super) struct LaneGloss {
    alpha: Wide,
    /// Lanes for whose lobes hemisphere rays count.
    joins: u32,
    sums: Weighed<f64>,
    block: Weighed<f32>,
}

/// Weights of open directions and of all, without colour and times (1 - V·H)^5.
#[derive(Clone, Copy, Default)]
struct Weighed<T> {
    open: [[T; LANES]; 2],
    all: [[T; LANES]; 2],
}

/// Directions drawn from lobes.
pub(super) struct Glossy {
    pub directions: [Wide; 3],
    /// What each weighs beside the hemisphere's, without colour and times (1 - V·H)^5.
    pub weights: [Wide; 2],
    pub lobes: Lobes,
}

impl LaneGloss {
    pub fn new() -> Self {
        Self {
            alpha: [1.0; LANES],
            joins: 0,
            sums: Weighed::default(),
            block: Weighed::default(),
        }
    }

    /// Forgets all lanes and what they gathered.
    pub fn clear(&mut self) {
        self.joins = 0;
        self.sums = Weighed::default();
    }

    pub fn set(&mut self, lane: usize, lobe: &Lobe) {
        self.alpha[lane] = lobe.alpha;
        self.joins |= u32::from(lobe.joins) << lane;
    }

    /// True where hemisphere rays count for a lane's lobe.
    pub fn joins(&self) -> bool {
        self.joins != 0
    }

    /// One direction of each lane, from unit views. `share` has the rays of each lobe for each ray of the hemisphere.
    #[inline(always)]
    pub fn draw(
        &self,
        (frames, view): (&Frames, &[Wide; 3]),
        u: [&Wide; 2],
        even: &Mixture,
        share: &Wide,
    ) -> Glossy {
        let normal = &frames.normal;
        let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
        let mut tangent = frames.to_world(&[[1.0; LANES], [0.0; LANES], [0.0; LANES]]);
        for l in 0..LANES {
            let (n, v) = (at(normal, l), at(view, l));
            let up = dot(n, v);
            let slant = [v[0] - up * n[0], v[1] - up * n[1], v[2] - up * n[2]];
            let length = dot(slant, slant).sqrt();
            // Along the normal any tangent serves.
            let leans = length > 1e-6;
            for a in 0..3 {
                let along = slant[a] / length.max(f32::MIN_POSITIVE);
                tangent[a][l] = if leans { along } else { tangent[a][l] };
            }
            (sin[l], cos[l]) = (if leans { length } else { 0.0 }, up);
        }
        let local = sample16(&self.alpha, [&sin, &cos], u[0], u[1]);
        let mut directions = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let (n, t) = (at(normal, l), at(&tangent, l));
            let side = [
                n[1] * t[2] - n[2] * t[1],
                n[2] * t[0] - n[0] * t[2],
                n[0] * t[1] - n[1] * t[0],
            ];
            for a in 0..3 {
                directions[a][l] = t[a] * local[0][l] + side[a] * local[1][l] + n[a] * local[2][l];
            }
        }
        let lobes = lobes16(&self.alpha, normal, view, &directions);
        let [steep, flat] = [even.cosine_share() as f32, 1.0 - even.cosine_share() as f32];
        let mut weights = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let own = share[l] * lobes.density[l];
            let above = dot(at(normal, l), at(&directions, l)).max(0.0);
            let other = (2.0 * steep * above + flat) / TAU;
            let shared = if self.joins >> l & 1 == 1 { other } else { 0.0 };
            weights[0][l] = lobes.weight[l] * own / (own + shared).max(f32::MIN_POSITIVE);
            weights[1][l] = weights[0][l] * lobes.fresnel[l];
        }
        Glossy {
            directions,
            weights,
            lobes,
        }
    }

    /// Corrects the weights of a lane whose hemisphere rays a guide sent.
    pub fn guided(
        &self,
        drawn: &mut Glossy,
        (lane, share): (usize, f32),
        normal: DVec3,
        (even, by): (&Mixture, &Guide),
    ) {
        if self.joins >> lane & 1 == 0 {
            return;
        }
        let direction = DVec3::from(at(&drawn.directions, lane).map(f64::from));
        let local = ambient::Frame::from_normal(normal).to_local(direction);
        if local.z <= 0.0 {
            return;
        }
        let other = even.pdf(local) * by.density(even.invert(local));
        let own = f64::from(share * drawn.lobes.density[lane]);
        let part = own / (own + other).max(f64::MIN_POSITIVE);
        drawn.weights[0][lane] = drawn.lobes.weight[lane] * part as f32;
        drawn.weights[1][lane] = drawn.weights[0][lane] * drawn.lobes.fresnel[lane];
    }

    /// What lobes say of directions: without colour and times (1 - V·H)^5 they weigh `weight` and `weight * fresnel`,
    /// times their density.
    #[inline(always)]
    pub fn says(&self, normal: &[Wide; 3], view: &[Wide; 3], directions: &[Wide; 3]) -> Lobes {
        lobes16(&self.alpha, normal, view, directions)
    }

    /// Adds the directions of a step that the hemisphere drew.
    #[inline(always)]
    pub fn add(&mut self, step: &Step, open: u32, [normal, view]: [&[Wide; 3]; 2], share: &Wide) {
        let lobes = self.says(normal, view, &step.directions);
        for l in 0..LANES {
            let even = 1.0 / (TAU * step.weights[1][l]);
            let all = share[l] * lobes.density[l] + even;
            let value = lobes.density[l] * lobes.weight[l] / all;
            let is_open = (open >> l & 1) as f32;
            for (k, value) in [value, value * lobes.fresnel[l]].into_iter().enumerate() {
                self.block.all[k][l] += value;
                self.block.open[k][l] += value * is_open;
            }
        }
    }

    /// Takes the sums of a block.
    pub fn absorb(&mut self) {
        let add = |sums: &mut [[f64; LANES]; 2], block: &[[f32; LANES]; 2]| {
            for (sum, value) in sums.as_flattened_mut().iter_mut().zip(block.as_flattened()) {
                *sum += f64::from(*value);
            }
        };
        add(&mut self.sums.open, &self.block.open);
        add(&mut self.sums.all, &self.block.all);
        self.block = Weighed::default();
    }

    /// Open and all weights of a lane for its lobe; `None` where it does not join.
    pub fn of_lane(&self, lane: usize) -> Option<[[f64; 2]; 2]> {
        let of = |lanes: &[[f64; LANES]; 2]| [lanes[0][lane], lanes[1][lane]];
        (self.joins >> lane & 1 == 1).then(|| [of(&self.sums.open), of(&self.sums.all)])
    }
}

#[inline(always)]
fn at(of: &[Wide; 3], lane: usize) -> [f32; 3] {
    [of[0][lane], of[1][lane], of[2][lane]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::super::step::Drawn;
    use super::*;

    /// Points of the unit square, sixteen at a time.
    fn points() -> impl Iterator<Item = [Wide; 2]> {
        const STEPS: u32 = 2048;
        (0..STEPS).map(|step| {
            let index = |l: usize| step * LANES as u32 + l as u32;
            let count = (STEPS * LANES as u32) as f32;
            let along = |l: usize| (index(l) as f32 + 0.5) / count;
            let across = |l: usize| index(l).reverse_bits() as f32 / 4_294_967_296.0;
            [std::array::from_fn(along), std::array::from_fn(across)]
        })
    }

    /// The mean over the lanes of what is added up over `points`.
    fn mean(sum: Wide) -> f64 {
        let sum: f64 = sum.iter().map(|&value| f64::from(value)).sum();
        sum / (LANES * points().count()) as f64
    }

    /// However few rays a lobe has beside those of the hemisphere, all directions of both weigh together what those of
    /// the lobe alone do.
    #[test]
    fn weights_of_lobe_and_hemisphere_add_up_to_those_of_the_lobe_alone() {
        let frames = Frames::about([[0.0; LANES], [0.0; LANES], [1.0; LANES]]);
        let even = Mixture::BALANCED;
        for (alpha, lean, share) in [
            (0.25, 0.0, 1.0),
            (0.25, 0.5, 0.125),
            (0.5, 1.2, 0.25),
            (1.0, 0.3, 0.0625),
        ] {
            let (sin, cos) = f32::sin_cos(lean);
            let view = [[sin; LANES], [0.0; LANES], [cos; LANES]];
            let rays = [share; LANES];
            let of = |joins| {
                let mut gloss = LaneGloss::new();
                (gloss.alpha, gloss.joins) = ([alpha; LANES], joins);
                gloss
            };
            let (alone, mut both) = (of(0), of(u32::from(u16::MAX)));
            let (mut expected, mut found) = ([0.0; LANES], [0.0; LANES]);
            for [u, v] in points() {
                let plain = alone.draw((&frames, &view), [&u, &v], &even, &rays);
                let joint = both.draw((&frames, &view), [&u, &v], &even, &rays);
                let (local, weights) = even.sample16(&u, &v);
                let step = Step {
                    directions: frames.to_world(&local),
                    weights,
                    above: u32::from(u16::MAX),
                    drawn: Drawn::Hemisphere,
                };
                both.add(&step, step.above, [&frames.normal, &view], &rays);
                for l in 0..LANES {
                    expected[l] += plain.weights[0][l];
                    found[l] += joint.weights[0][l];
                }
            }
            let (expected, of_lobe) = (mean(expected), mean(found));
            let of_hemisphere = mean(both.block.all[0]);
            let found = of_lobe + of_hemisphere;
            assert!(of_hemisphere > 0.1 * expected, "{alpha} {lean} {share}");
            assert!(
                (found / expected - 1.0).abs() < 3e-3,
                "{alpha} {lean} {share}: {found} {expected}"
            );
        }
    }
}
