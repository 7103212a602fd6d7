//! Rays meet mathematics: the terms of a tile's texels, from rays or in closed form.
//!
//! **Hemisphere terms.** Directions follow one mixture of cosine-weighted and uniform directions with solid-angle
//! density `(2 a mu + b) / 2 pi`, `mu = cos(theta)`, `a + b = 1`, by one analytic inverse, so that a single
//! low-discrepancy set serves the diffuse term (weight `2 mu / (2 a mu + b)`) and the visibility (weight
//! `1 / (2 a mu + b)`) with bounded weights. What the weights are off by in each half of the
//! rays is corrected by what the other half found (`estimate.rs`), so that an open texel is exactly 1 and a closed
//! one exactly 0, and no mean is moved.
//!
//! Where a surface is dark, the points are warped toward the few directions that are open (`guides.rs`), and weights
//! with them.
//!
//! **Specular term.** Its own directions from the lobe: Phong's about the mirrored view R, density `(n+1)/2pi (R.L)^n`,
//! so every open ray counts 1; GGX's from the normals that the eye sees, and those of the hemisphere beside them where
//! the lobe is wide. Directions below the shading horizon count 0 and cost no ray. `lobe.rs` says how many a lobe is
//! worth.
//!
//! **Shading normals.** The ray of a direction below the geometric plane leaves along its mirror image in the plane; in
//! exact shading it counts 0 and costs no ray.
//!
//! **Light of a map.** With an illumination map the radiance is a uniform floor, which the two terms above multiply,
//! and what stands out of it, which hemisphere rays and directions drawn from the map share by the power heuristic with
//! exponent 2 (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995), and
//! lobe rays and the same directions likewise. Weights are those of equal numbers, whatever the numbers are, so that
//! each technique may stop by itself. These means are not divided by sums of weights.
//!
//! **Lanes.** A texel has [`REPLICATES`] independent randomisations of its points. Each is one lane of a [`Gang`];
//! `estimate.rs` makes standard errors of their spread. How many rays a tile takes is decided before (`page/spend.rs`).

mod cast;
mod closed_form;
mod estimate;
mod gang;
mod guides;
mod lobe;
mod pool;
mod seal;
mod sums;
mod task;
mod terms;

pub(crate) use lobe::{Coat, LobeRays};
pub(crate) use seal::seals;
pub(crate) use task::Task;
pub use terms::{AnyView, Directional, Halves, Terms};

use crate::options::Shading;
use crate::survey::Texel;
use ambient::any_view::{count, order_for, stated};
use cast::{Caster, HemisphereLobes};
use estimate::Quantity;
use gang::{DirectionSums, Moments};
use lobe::Lobe;
use sums::{REPLICATES, Replicates, Technique, mean};

/// Integrates the texels of one tile. `reflects` says which of them need the specular term.
pub(crate) fn integrate(
    task: &Task<'_>,
    texels: &[Texel],
    coats: &[Coat],
    reflects: &[bool],
) -> Vec<Terms> {
    let lit = task.sky.map().is_some();
    let is_closed = |texel: &Texel| {
        let leans = task.shading == Shading::Exact && texel.tilted;
        texel.open && !lit && !(task.any_view.is_some() && leans)
    };
    let closed: Vec<bool> = texels.iter().map(is_closed).collect();
    let known = |i: usize| closed[i] && closed_form::has_specular(task, &texels[i]);
    let start = |i: usize| match closed[i] {
        true => closed_form::terms(task, &texels[i], reflects[i] && known(i)),
        false => Terms::default(),
    };
    let mut terms: Vec<Terms> = (0..texels.len()).map(start).collect();
    let lobe_of = |i: usize| {
        let lobe = || Lobe::of(task, &texels[i].material, &coats[i], closed[i]);
        (reflects[i] && !known(i)).then(lobe)
    };
    let lobes: Vec<Option<Lobe>> = (0..texels.len()).map(lobe_of).collect();
    let which = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..texels.len()).filter(|&i| wanted(i)).collect()
    };
    let mut moments = vec![<[Moments; REPLICATES as usize]>::default(); moments_of(task, texels)];
    let tile = Lit {
        task,
        texels,
        lobes: &lobes,
    };
    let mut rounds = |technique, which: &[usize], moments: &mut [_], beside: &HemisphereLobes| {
        tile.rounds(technique, which, moments, beside, &mut terms)
    };
    let none = HemisphereLobes::default();
    let above = which(&|i| !closed[i] && task.hemisphere);
    let beside = rounds(Technique::Hemisphere, &above, &mut moments, &none);
    let glossy = which(&|i| lobes[i].is_some());
    rounds(Technique::Lobe, &glossy, &mut [], &beside);
    if lit && task.draw_sky {
        rounds(Technique::Sky, &which(&|i| !closed[i]), &mut [], &none);
    }
    for (i, moments) in moments.iter().enumerate().filter(|(i, _)| !closed[*i]) {
        terms[i].any_view = any_view(task, &texels[i], moments);
    }
    terms
}

/// How many texels gather harmonics: all or none.
fn moments_of(task: &Task<'_>, texels: &[Texel]) -> usize {
    task.any_view.map_or(0, |_| texels.len())
}

/// What a texel's harmonics are and leave. Orders that would bring its own highlight more noise than light are 0.
fn any_view(
    task: &Task<'_>,
    texel: &Texel,
    moments: &[Moments; REPLICATES as usize],
) -> Option<Box<AnyView>> {
    let order = task.any_view?;
    let (mut coefficients, variances) = gang::coefficients(moments);
    let lobe = task.model.lobe(texel.material.exponent);
    let order = order.min(order_for(lobe, task.rays));
    coefficients.0[count(order)..].fill(0.0);
    Some(Box::new(AnyView {
        coefficients,
        std_err: stated(&coefficients, &variances, order, lobe),
    }))
}

/// A tile that is lit.
struct Lit<'a> {
    task: &'a Task<'a>,
    texels: &'a [Texel],
    lobes: &'a [Option<Lobe>],
}

impl Lit<'_> {
    /// Casts the rays of one technique for the texels `which`, and adds what they say to the terms of all texels.
    /// `beside` is what the hemisphere has found for lobes; it comes back from the hemisphere.
    fn rounds(
        &self,
        technique: Technique,
        which: &[usize],
        moments: &mut [[Moments; REPLICATES as usize]],
        beside: &HemisphereLobes,
        terms: &mut [Terms],
    ) -> HemisphereLobes {
        if which.is_empty() {
            return HemisphereLobes::default();
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
        caster.spend(task.rays, which);
        let known = caster.gathered();
        known.add_to(terms);
        let slopes: Vec<[f64; 2]> = match caster.moments.is_empty() {
            true => Vec::new(),
            false => (0..texels.len())
                .map(|i| known.slopes(i, Quantity::Visibility))
                .collect(),
        };
        for &i in which.iter().filter(|_| gathers) {
            let directions = &caster.directions[i];
            let [a, b] = DirectionSums::terms(directions, task, &known, i);
            let terms = &mut terms[i];
            let all = a.with(&b, |a, b| mean(&caster.sums[i], [a, b]));
            terms.directional = terms.directional.with(&all, |a, b| a + b);
            let half = a.with(&b, |a, b| 0.5 * (a - b));
            terms.halves.directional = terms.halves.directional.with(&half, |a, b| a + b);
        }
        for (moments, slopes) in caster.moments.iter_mut().zip(slopes) {
            for (moments, slope) in moments.iter_mut().zip(slopes) {
                moments.slope = slope;
            }
        }
        match joins {
            false => HemisphereLobes::default(),
            true => HemisphereLobes {
                sums: caster.sums,
                sent: caster.sent,
            },
        }
    }
}
