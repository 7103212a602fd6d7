//! Rays meet mathematics: the terms of a tile's texels, from rays or in closed form.
//!
//! **Hemisphere terms.** Directions follow one mixture of cosine-weighted and uniform directions with solid-angle
//! density `(2 a mu + b) / 2 pi`, `mu = cos(theta)`, `a + b = 1`, by one analytic inverse, so that a single
//! low-discrepancy set serves the diffuse term (weight `2 mu / (2 a mu + b)`) and the visibility (weight
//! `1 / (2 a mu + b)`) with bounded weights. Both are divided by the sum of the weights drawn, which makes an open texel
//! exactly 1 and a closed one exactly 0; the ratio's bias is of the order of the weights' own integration error
//! squared and vanishes beside the variance (see the tests).
//!
//! Where a surface is dark, the points are warped toward the few directions that are open (`guides.rs`), and weights with them.
//!
//! **Specular term.** Its own directions from the lobe about the mirrored view R, density `(n+1)/2pi (R.L)^n`, so every
//! open ray counts 1. Directions below the shading horizon count 0 and cost no ray.
//!
//! **Shading normals.** The ray of a direction below the geometric plane leaves along its mirror image in the plane; in exact shading
//! it counts 0 and costs no ray.
//!
//! **Light of a map.** With an illumination map the radiance is a uniform floor, which the two terms above multiply, and what stands
//! out of it, which hemisphere rays and directions drawn from the map share by the power heuristic with exponent 2 (E. Veach, L. Guibas,
//! "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995), and lobe rays and the same directions likewise. Weights are those of equal
//! numbers, whatever the numbers are, so that each technique may stop by itself. These means are not divided by sums of weights.
//!
//! **Lanes.** A texel has [`REPLICATES`] independent randomisations of its points. Each is one lane of a
//! [`Gang`]; `estimate.rs` makes standard errors of their spread. With a target, texels whose error is not yet small enough take
//! more points of the same streams, round by round.

mod cast;
mod closed_form;
mod estimate;
mod gang;
pub(crate) mod ggx;
mod guides;
mod sums;
mod target;
mod task;
mod terms;

pub(crate) use task::Task;
pub use terms::{AnyView, Directional, Halves, Terms};

use crate::options::{Effort, Model, Shading};
use crate::survey::Texel;
use ambient::Estimate;
use ambient::any_view::{count, order_for, stated};
use cast::Caster;
use estimate::{Gathered, Quantity};
use gang::{Beside, DirectionSums, Moments};
use glam::DVec3;
use sums::{REPLICATES, Replicates, Technique, mean};
use target::Target;

/// Integrates the texels of one tile. `reflects` says which of them need the specular term.
pub(crate) fn integrate(task: &Task<'_>, texels: &[Texel], reflects: &[bool]) -> Vec<Terms> {
    if task.model == Model::Phong {
        return with_phong(task, texels, reflects, &mut []);
    }
    let mut beside = ggx::beside(texels, reflects);
    let mut terms = with_phong(task, texels, &vec![false; texels.len()], &mut beside);
    let reflecting = terms.iter_mut().zip(texels).zip(reflects).enumerate();
    for (i, ((terms, texel), _)) in reflecting.filter(|(_, (_, reflects))| **reflects) {
        let lobe = ggx::terms(task, texel, beside.get(i));
        (terms.specular, terms.reflection) = (lobe.specular, lobe.reflection);
        terms.halves.specular = lobe.halves.specular;
        terms.halves.reflection = lobe.halves.reflection;
        terms.rays += lobe.rays;
    }
    terms
}

/// The terms of a tile's texels, Phong's lobe for those that `reflects` names. What hemisphere rays say of GGX lobes is added to `beside`, of
/// all texels or of none.
fn with_phong(
    task: &Task<'_>,
    texels: &[Texel],
    reflects: &[bool],
    beside: &mut [Beside],
) -> Vec<Terms> {
    let lit = task.sky.map().is_some();
    let is_closed = |texel: &Texel| {
        let leans = task.shading == Shading::Exact && texel.tilted;
        texel.open && !lit && !(task.any_view.is_some() && leans)
    };
    let closed: Vec<bool> = texels.iter().map(is_closed).collect();
    let closed_lobe: Vec<bool> = texels
        .iter()
        .zip(&closed)
        .map(|(texel, closed)| *closed && closed_form::has_specular(task, texel))
        .collect();
    let which = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..texels.len()).filter(|&i| wanted(i)).collect()
    };
    let mut moments = vec![<[Moments; REPLICATES as usize]>::default(); moments_of(task, texels)];
    let mut cast = |technique, which| {
        let gathered = match technique {
            Technique::Hemisphere => (moments.as_mut_slice(), &mut *beside),
            _ => (&mut [][..], &mut [][..]),
        };
        rounds(task, texels, reflects, technique, which, gathered)
    };
    let hemisphere = cast(
        Technique::Hemisphere,
        which(&|i| !closed[i] && task.hemisphere),
    );
    let lobe = cast(Technique::Lobe, which(&|i| !closed_lobe[i] && reflects[i]));
    let sky = cast(
        Technique::Sky,
        which(&|i| !closed[i] && lit && task.draw_sky),
    );
    let of = |terms: &[Terms], i: usize| terms.get(i).cloned().unwrap_or_default();
    (0..texels.len())
        .map(|i| {
            let sampled = of(&lobe, i);
            if closed[i] {
                let known = closed_form::terms(task, &texels[i], reflects[i] && closed_lobe[i]);
                return match closed_lobe[i] {
                    true => known,
                    false => Terms {
                        specular: sampled.specular,
                        reflection: sampled.reflection,
                        halves: sampled.halves,
                        rays: sampled.rays,
                        ..known
                    },
                };
            }
            let light = |asked: bool, own: Estimate<DVec3>, drawn: Estimate<DVec3>| match asked {
                false => Estimate::default(),
                true => Estimate {
                    value: own.value + drawn.value,
                    std_err: own.std_err.hypot(drawn.std_err),
                },
            };
            let (above, aimed) = (of(&hemisphere, i), of(&sky, i));
            let (own, drawn) = (&above.halves, &aimed.halves);
            let halves = Halves {
                specular: sampled.halves.specular,
                irradiance: own.irradiance + drawn.irradiance,
                reflection: sampled.halves.reflection + drawn.reflection,
                directional: own.directional.with(&drawn.directional, |a, b| a + b),
                ..*own
            };
            Terms {
                halves,
                any_view: any_view(task, &texels[i], moments.get(i)),
                directional: above.directional.with(&aimed.directional, |a, b| a + b),
                specular: sampled.specular,
                irradiance: light(task.hemisphere, above.irradiance, aimed.irradiance),
                reflection: light(reflects[i], sampled.reflection, aimed.reflection),
                rays: above.rays + sampled.rays + aimed.rays,
                ..above
            }
        })
        .collect()
}

/// How many texels gather harmonics: all or none.
fn moments_of(task: &Task<'_>, texels: &[Texel]) -> usize {
    task.any_view.map_or(0, |_| texels.len())
}

/// What a texel's harmonics are and leave. Orders that would bring its own highlight more noise than light are 0.
fn any_view(
    task: &Task<'_>,
    texel: &Texel,
    moments: Option<&[Moments; REPLICATES as usize]>,
) -> Option<Box<AnyView>> {
    let (order, moments) = (task.any_view?, moments?);
    let (mut coefficients, variances) = gang::coefficients(moments);
    let exponent = texel.material.exponent;
    let order = order.min(order_for(exponent, task.effort.most_rays()));
    coefficients.0[count(order)..].fill(0.0);
    Some(Box::new(AnyView {
        coefficients,
        std_err: stated(&coefficients, &variances, order, exponent),
    }))
}

/// Casts the rays of one technique for the texels `which`, in rounds where a target is set. The terms of all texels; none where `which`
/// is empty.
fn rounds(
    task: &Task<'_>,
    texels: &[Texel],
    reflects: &[bool],
    technique: Technique,
    which: Vec<usize>,
    (moments, beside): (&mut [[Moments; REPLICATES as usize]], &mut [Beside]),
) -> Vec<Terms> {
    if which.is_empty() {
        return Vec::new();
    }
    let gathers = task.directional && technique != Technique::Lobe;
    let none = <[DirectionSums; REPLICATES as usize]>::default();
    let mut caster = Caster {
        task,
        texels,
        reflects,
        technique,
        sums: vec![Replicates::default(); texels.len()],
        points: vec![0; texels.len()],
        guided: vec![false; texels.len()],
        moments,
        directions: vec![none; if gathers { texels.len() } else { 0 }],
        beside,
    };
    match task.effort {
        Effort::Rays(rays) => caster.spend(rays, &which),
        Effort::Target {
            error,
            relative,
            max_rays,
        } => {
            let target = Target {
                error,
                relative,
                max_rays,
            };
            caster.reach(target, &which);
        }
    }
    let Caster {
        sums,
        points,
        guided,
        directions,
        moments,
        ..
    } = caster;
    let gathered = Gathered::new(task.sky, technique, texels, &sums, &points, &guided);
    for (i, moments) in moments.iter_mut().enumerate() {
        let slopes = gathered.slopes(i, Quantity::Visibility);
        for (moments, slope) in moments.iter_mut().zip(slopes) {
            moments.slope = slope;
        }
    }
    let mut terms: Vec<Terms> = (0..texels.len()).map(|i| gathered.terms(i)).collect();
    for (i, directions) in directions.iter().enumerate() {
        if points[i] == 0 {
            continue;
        }
        let [a, b] = DirectionSums::terms(directions, task, &gathered, i);
        terms[i].directional = a.with(&b, |a, b| mean(&sums[i], [a, b]));
        terms[i].halves.directional = a.with(&b, |a, b| 0.5 * (a - b));
    }
    terms
}
