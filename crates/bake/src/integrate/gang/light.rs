//! Light of an illumination map in a step: what open lanes see above its floor, by the power heuristic.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::directional::LaneDirections;
use super::gloss::LaneGloss;
use super::step::{Drawn, Step};
use crate::integrate::task::Task;
use ambient::lanes::{LANES, Wide};
use environment::SkyMap;

/// The lobes of the lanes: 1 / (n + 1) of Phong or those of GGX, their rays for each ray of the others, and the lanes
/// that need theirs.
pub(super) struct Lobes<'a> {
    pub scale: &'a Wide,
    pub share: &'a Wide,
    pub gloss: Option<&'a LaneGloss>,
    pub used: u32,
}

/// Adds the light that open lanes see above the floor of a map to `sums`, each by its share of the power heuristic.
#[inline(always)]
pub(super) fn add_map_light(
    task: &Task<'_>,
    sky: &SkyMap,
    step: &Step,
    open: u32,
    normal: &[Wide; 3],
    lobes: Lobes<'_>,
    (sums, directions): (&mut [[Wide; 3]; 3], Option<&mut LaneDirections>),
) {
    use std::f32::consts::{FRAC_1_PI, TAU};
    let [cosine, uniform] = {
        let share = task.mixture.cosine_share() as f32;
        [2.0 * share / TAU, (1.0 - share) / TAU]
    };
    let texels = match &step.drawn {
        Drawn::Sky(texels, _) => *texels,
        _ => sky.texels16(&step.directions),
    };
    let mut light = [[0.0; LANES]; 3];
    let mut rest = open;
    while rest != 0 {
        let l = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        for (axis, value) in light.iter_mut().zip(sky.excess(texels[l])) {
            axis[l] = value;
        }
    }
    let drawn = if task.draw_sky { 1.0 } else { 0.0 };
    let mut kernels = [[0.0; LANES]; 3];
    let by_sky = |l: usize| drawn * (light[0][l] + light[1][l] + light[2][l]);
    match &step.drawn {
        Drawn::Hemisphere => {
            for l in 0..LANES {
                let own = 1.0 / (TAU * step.weights[1][l]);
                kernels[0][l] = step.weights[0][l] * share(own, by_sky(l));
            }
        }
        Drawn::Lobe(lobe) => {
            for l in 0..LANES {
                let share = share(lobe.density[l], by_sky(l));
                kernels[1][l] = lobe.plain[l] * share;
                kernels[2][l] = lobe.white[l] * share;
            }
        }
        Drawn::Sky(_, axes) => {
            for l in 0..LANES {
                let mu = normal[0][l] * step.directions[0][l]
                    + normal[1][l] * step.directions[1][l]
                    + normal[2][l] * step.directions[2][l];
                kernels[0][l] = mu * FRAC_1_PI * share_of(by_sky(l), cosine * mu + uniform);
            }
            if let Some(gloss) = lobes.gloss {
                let says = gloss.says(normal, axes, &step.directions);
                for l in 0..LANES {
                    let own = lobes.share[l] * says.density[l];
                    let used = (lobes.used >> l & 1) as f32;
                    kernels[1][l] =
                        used * says.weight[l] * says.density[l] * share_of(by_sky(l), own);
                    kernels[2][l] = kernels[1][l] * says.fresnel[l];
                }
            } else {
                let mut rest = open & lobes.used;
                while rest != 0 {
                    let l = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let [axis, direction] = [axes, &step.directions].map(|of| of.map(|a| a[l]));
                    let density = lobe_density(lobes.scale[l], axis, direction);
                    kernels[1][l] = density * share_of(by_sky(l), lobes.share[l] * density);
                }
            }
        }
    }
    if let Some(directions) = directions {
        let (mut shares, mut density) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let by_sky = drawn * (light[0][l] + light[1][l] + light[2][l]);
            match &step.drawn {
                Drawn::Hemisphere => {
                    density[l] = 1.0 / (TAU * step.weights[1][l]);
                    shares[l] = share(density[l], by_sky);
                }
                Drawn::Lobe(_) => {}
                Drawn::Sky(..) => {
                    let mu = normal[0][l] * step.directions[0][l]
                        + normal[1][l] * step.directions[1][l]
                        + normal[2][l] * step.directions[2][l];
                    shares[l] = share_of(by_sky, cosine * mu + uniform);
                }
            }
        }
        directions.add_light(step, &light, &shares, &density);
    }
    for k in 0..3 {
        for c in 0..3 {
            for l in 0..LANES {
                sums[k][c][l] += light[c][l] * kernels[k][l];
            }
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The share of a technique of density `own` beside another in the power heuristic with exponent 2.
#[inline(always)]
fn share(own: f32, other: f32) -> f32 {
    own * share_of(own, other)
}

/// That share divided by `own`.
#[inline(always)]
fn share_of(own: f32, other: f32) -> f32 {
    own / (own * own + other * other).max(f32::MIN_POSITIVE)
}

/// (n + 1)/2pi (R.L)^n with `scale` = 1 / (n + 1); 0 behind the plane of the lobe. 1 - R.L is taken from the chord,
/// which keeps the digits of narrow lobes.
#[inline(always)]
fn lobe_density(scale: f32, axis: [f32; 3], direction: [f32; 3]) -> f32 {
    let chord = [0, 1, 2].map(|a: usize| axis[a] - direction[a]);
    let drop = 0.5 * f64::from(dot(chord, chord));
    let exponent = 1.0 / f64::from(scale) - 1.0;
    let decay = exponent * drop;
    if drop >= 1.0 || decay > 80.0 {
        return 0.0;
    }
    ((exponent * (-drop).ln_1p()).exp() / (std::f64::consts::TAU * f64::from(scale))) as f32
}
