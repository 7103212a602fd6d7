//! Where the rays of one point of every lane start, and where they go.

use super::Gang;
use super::gloss::LaneGloss;
use super::step::{Drawn, Kernel, Step};
use super::surfaces::{Frames, mirrored};
use crate::integrate::sums::Technique;
use crate::integrate::task::Task;
use crate::options::{Shading, View};
use ambient::sampling::{self, LANES, Wide};
use glam::DVec3;

impl Gang<'_> {
    /// Moves a lane to another cell of its texel.
    #[inline(always)]
    pub(super) fn walk(&mut self, lane: usize, to: u32) {
        let cells = &self.texels[self.lanes[lane].texel].cells;
        let [old, new] = [self.cell[lane], to].map(|number| cells.cell(number as usize));
        self.cell[lane] = to;
        self.surfaces.set_position([lane], cells, to as usize);
        if !new.shades_like(old) {
            self.surfaces.set_normal([lane], new);
            self.stale = true;
        }
    }

    /// Fills the packet with the rays of one point of every lane.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        task: &Task<'_>,
        technique: Technique,
        [u0, u1]: [&Wide; 2],
        at: &[Wide; 2],
    ) -> Step {
        if self.stale {
            self.frames = Frames::about(self.surfaces.normals(at));
            self.stale = self.surfaces.smooth != 0;
        }
        let normal = &self.frames.normal;
        self.surfaces.origins(at, &mut self.packet.origin);
        let (directions, weights, drawn) = match technique {
            Technique::Hemisphere => {
                let (local, weights) = task.mixture.sample16(u0, u1);
                (self.frames.to_world(&local), weights, Drawn::Hemisphere)
            }
            Technique::Lobe => match &self.gloss {
                Some(gloss) => self.glossy(task, gloss, [u0, u1]),
                None => self.lobe(task, [u0, u1]),
            },
            Technique::Sky => {
                let Some(sky) = task.sky.map() else {
                    unreachable!("a uniform sky has no directions to draw");
                };
                let (directions, texels) = sky.sample16(u0, u1);
                let axes = match (&self.gloss, task.view) {
                    (Some(_), view) => self.frames.views_of(view, &self.packet.origin),
                    (None, View::Normal) => *normal,
                    (None, View::Eye(eye)) => mirrored(normal, &self.packet.origin, eye),
                };
                let drawn = Drawn::Sky(texels, axes);
                (directions, [[0.0; LANES]; 2], drawn)
            }
        };
        let geometric = &self.surfaces.geometric;
        let folds = task.shading == Shading::Production;
        let mut above = 0;
        for l in 0..LANES {
            let dot = |a: &[Wide; 3]| {
                a[0][l] * directions[0][l] + a[1][l] * directions[1][l] + a[2][l] * directions[2][l]
            };
            let (height, cosine) = (dot(geometric), dot(normal));
            let is_folded = folds & (height < 0.0);
            above |= u32::from((is_folded | (height > 0.0)) & (cosine > 0.0)) << l;
            // What the direction counts and whence its light comes stays its own; only its ray leaves on the side of
            // its image.
            let twice = if is_folded { 2.0 * height } else { 0.0 };
            for a in 0..3 {
                self.packet.direction[a][l] = directions[a][l] - twice * geometric[a][l];
            }
        }
        Step {
            directions,
            weights,
            above,
            drawn,
        }
    }

    /// Directions of Phong's lobes.
    #[inline(always)]
    fn lobe(&self, task: &Task<'_>, [u0, u1]: [&Wide; 2]) -> ([Wide; 3], [Wide; 2], Drawn) {
        let local = sampling::Lobe::sample16(&self.lobe_scale, u0, u1);
        let directions = match task.view {
            View::Normal => self.frames.to_world(&local),
            View::Eye(eye) => {
                let axes = mirrored(&self.frames.normal, &self.packet.origin, eye);
                Frames::about(axes).to_world(&local)
            }
        };
        let mut kernel = Kernel::default();
        if task.sky.map().is_some() {
            // u0 = cos^(n + 1), so cos^n = u0 / cos.
            for l in 0..LANES {
                let scale = self.lobe_scale[l] * std::f32::consts::TAU;
                let density = u0[l] / (scale * local[2][l].max(f32::MIN_POSITIVE));
                kernel.density[l] = self.lobe_share[l] * density;
                kernel.plain[l] = 1.0;
            }
        }
        let weights = [[1.0; LANES], [0.0; LANES]];
        (directions, weights, Drawn::Lobe(kernel))
    }

    /// Directions of the lobes of GGX.
    #[inline(always)]
    fn glossy(
        &self,
        task: &Task<'_>,
        gloss: &LaneGloss,
        u: [&Wide; 2],
    ) -> ([Wide; 3], [Wide; 2], Drawn) {
        let view = self.frames.views_of(task.view, &self.packet.origin);
        let (mixture, share) = (&task.mixture, &self.lobe_share);
        let mut drawn = gloss.draw((&self.frames, &view), u, mixture, share);
        let mut sent = self.guided;
        while sent != 0 {
            let l = sent.trailing_zeros() as usize;
            sent &= sent - 1;
            if let Some(guide) = &self.sent[self.lanes[l].texel] {
                let normal = self.frames.normal.map(|axis| f64::from(axis[l]));
                let by = (mixture, &**guide);
                gloss.guided(&mut drawn, (l, share[l]), DVec3::from(normal), by);
            }
        }
        let mut kernel = Kernel::default();
        if task.sky.map().is_some() {
            for l in 0..LANES {
                kernel.density[l] = share[l] * drawn.lobes.density[l];
                kernel.plain[l] = drawn.lobes.weight[l];
                kernel.white[l] = drawn.lobes.weight[l] * drawn.lobes.fresnel[l];
            }
        }
        (drawn.directions, drawn.weights, Drawn::Lobe(kernel))
    }
}
