//! Light of an illumination map in a step: what open lanes see above its floor, by the power heuristic.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use super::directional::LaneDirections;
use super::step::{Drawn, Step};
use crate::integrate::task::Task;
use ambient::lanes::{LANES, Wide};
use maps::SkyMap;

/// The lobes of the lanes: 1 / (n + 1), and the lanes that need theirs.
pub(super) struct Lobes<'a> {
    pub scale: &'a Wide,
    pub used: u32,
}

/// Adds the light that open lanes see above the floor of a map to `sums`, each by its share of the power heuristic. Returns that light.
#[inline(always)]
pub(super) fn add_map_light(
    task: &Task<'_>,
    sky: &SkyMap,
    step: &Step,
    open: u32,
    normal: &[Wide; 3],
    lobes: Lobes<'_>,
    (sums, directions): (&mut [[Wide; 3]; 2], Option<&mut LaneDirections>),
) -> [Wide; 3] {
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
    let mut kernels = [[0.0; LANES]; 2];
    for l in 0..LANES {
        let by_sky = drawn * (light[0][l] + light[1][l] + light[2][l]);
        kernels[0][l] = match &step.drawn {
            Drawn::Hemisphere => {
                let own = 1.0 / (TAU * step.weights[1][l]);
                step.weights[0][l] * share(own, by_sky)
            }
            Drawn::Lobe(density) => share(density[l], by_sky),
            Drawn::Sky(..) => {
                let mu = normal[0][l] * step.directions[0][l]
                    + normal[1][l] * step.directions[1][l]
                    + normal[2][l] * step.directions[2][l];
                mu * FRAC_1_PI * share_of(by_sky, cosine * mu + uniform)
            }
        };
    }
    if let Drawn::Sky(_, axes) = &step.drawn {
        let mut rest = open & lobes.used;
        while rest != 0 {
            let l = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let [axis, direction] = [axes, &step.directions].map(|of| of.map(|a| a[l]));
            let by_sky = light[0][l] + light[1][l] + light[2][l];
            let density = lobe_density(lobes.scale[l], axis, direction);
            kernels[1][l] = density * share_of(by_sky, density);
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
    for k in 0..2 {
        for c in 0..3 {
            for l in 0..LANES {
                sums[k][c][l] += light[c][l] * kernels[k][l];
            }
        }
    }
    light
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

/// (n + 1)/2pi (R.L)^n with `scale` = 1 / (n + 1); 0 behind the plane of the lobe. 1 - R.L is taken from the chord, which keeps the digits of
/// narrow lobes.
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
