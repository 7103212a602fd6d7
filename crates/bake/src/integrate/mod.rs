//! Rays meet mathematics: the terms of a tile's texels, from rays or in closed form.
//!
//! **Hemisphere terms.** Directions follow one mixture of cosine-weighted and uniform directions with solid-angle
//! density `(2 a mu + b) / 2 pi`, `mu = cos(theta)`, `a + b = 1`, by one analytic inverse, so that a single
//! low-discrepancy set serves the diffuse term (weight `2 mu / (2 a mu + b)`) and the visibility (weight
//! `1 / (2 a mu + b)`) with bounded weights. What the weights are off by in each half of the
//! rays is corrected by what the other half found (`estimate.rs`), so that an open texel is exactly 1 and a closed one exactly 0, and no mean is moved.
//!
//! Where a surface is dark, the points are warped toward the few directions that are open (`guides.rs`), and weights with them.
//!
//! **Specular term.** Its own directions from the lobe: Phong's about the mirrored view R, density `(n+1)/2pi (R.L)^n`, so every
//! open ray counts 1; GGX's from the normals that the eye sees, and those of the hemisphere beside them where the lobe is wide. Directions below the
//! shading horizon count 0 and cost no ray. `lobe.rs` says how many a lobe is worth.
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
//! [`Gang`]; `estimate.rs` makes standard errors of their spread. How many rays a tile takes is decided before (`page/spend.rs`).

mod cast;
mod closed_form;
mod estimate;
mod gang;
mod guides;
pub(crate) mod lobe;
mod sums;
mod task;
mod terms;

pub(crate) use task::Task;
pub use terms::{AnyView, Directional, Halves, Terms};

use crate::options::Shading;
use crate::survey::Texel;
use ambient::Estimate;
use ambient::any_view::{count, order_for, stated};
use cast::{Beside, Caster};
use estimate::Quantity;
use gang::{DirectionSums, Moments};
use glam::DVec3;
use lobe::Lobe;
use sums::{REPLICATES, Replicates, Technique, mean};

/// Integrates the texels of one tile. `reflects` says which of them need the specular term.
pub(crate) fn integrate(task: &Task<'_>, texels: &[Texel], reflects: &[bool]) -> Vec<Terms> {
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
    let lobe_of = |i: usize| {
        let mut lobe = Lobe::of(task, &texels[i]);
        // There are no rays over the hemisphere where it is known.
        lobe.joins &= !closed[i];
        (reflects[i] && !closed_lobe[i]).then_some(lobe)
    };
    let lobes: Vec<Option<Lobe>> = (0..texels.len()).map(lobe_of).collect();
    let tile = Lit {
        task,
        texels,
        lobes: &lobes,
    };
    let above = which(&|i| !closed[i] && task.hemisphere);
    let (hemisphere, beside) = tile.rounds(
        Technique::Hemisphere,
        above,
        &mut moments,
        &Beside::default(),
    );
    let glossy = which(&|i| lobes[i].is_some());
    let (lobe, _) = tile.rounds(Technique::Lobe, glossy, &mut [], &beside);
    let aimed = which(&|i| !closed[i] && lit && task.draw_sky);
    let (sky, _) = tile.rounds(Technique::Sky, aimed, &mut [], &Beside::default());
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
    let order = order.min(order_for(exponent, task.rays));
    coefficients.0[count(order)..].fill(0.0);
    Some(Box::new(AnyView {
        coefficients,
        std_err: stated(&coefficients, &variances, order, exponent),
    }))
}

/// A tile that is lit.
struct Lit<'a> {
    task: &'a Task<'a>,
    texels: &'a [Texel],
    lobes: &'a [Option<Lobe>],
}

impl Lit<'_> {
    /// Casts the rays of one technique for the texels `which`. The terms of all texels; none where `which`
    /// is empty. `beside` is what the hemisphere has found for lobes; it comes back from the hemisphere.
    fn rounds(
        &self,
        technique: Technique,
        which: Vec<usize>,
        moments: &mut [[Moments; REPLICATES as usize]],
        beside: &Beside,
    ) -> (Vec<Terms>, Beside) {
        if which.is_empty() {
            return Default::default();
        }
        let Self {
            task,
            texels,
            lobes,
        } = *self;
        let gathers = task.directional && technique != Technique::Lobe;
        let none = <[DirectionSums; REPLICATES as usize]>::default();
        let joins =
            technique == Technique::Hemisphere && lobes.iter().flatten().any(|lobe| lobe.joins);
        let mut caster = Caster {
            task,
            texels,
            lobes,
            technique,
            sums: vec![Replicates::default(); texels.len()],
            points: vec![0; texels.len()],
            guided: vec![false; texels.len()],
            sent: vec![None; if joins { texels.len() } else { 0 }],
            moments,
            directions: vec![none; if gathers { texels.len() } else { 0 }],
            beside,
        };
        caster.spend(task.rays, &which);
        let known = caster.gathered();
        let slopes: Vec<[f64; 2]> = match caster.moments.is_empty() {
            true => Vec::new(),
            false => (0..texels.len())
                .map(|i| known.slopes(i, Quantity::Visibility))
                .collect(),
        };
        let mut terms: Vec<Terms> = (0..texels.len()).map(|i| known.terms(i)).collect();
        for (i, directions) in caster.directions.iter().enumerate() {
            if caster.points[i] == 0 {
                continue;
            }
            let [a, b] = DirectionSums::terms(directions, task, &known, i);
            terms[i].directional = a.with(&b, |a, b| mean(&caster.sums[i], [a, b]));
            terms[i].halves.directional = a.with(&b, |a, b| 0.5 * (a - b));
        }
        for (moments, slopes) in caster.moments.iter_mut().zip(slopes) {
            for (moments, slope) in moments.iter_mut().zip(slopes) {
                moments.slope = slope;
            }
        }
        let beside = match joins {
            false => Beside::default(),
            true => Beside {
                sums: caster.sums,
                sent: caster.sent,
            },
        };
        (terms, beside)
    }
}
