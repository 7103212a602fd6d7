//! Which layers a page is baked into: the terms that are integrated, and the facts from which the asked layers follow.

use super::compose::{is_composed, is_light};
use crate::choice::Choice;
use crate::options::{AmbientCoefficient, Buried, Denoise, Model, Options, Seams};
use crate::plan::Plan;
use layers::Layer;

/// The layers of a term while its page is in work, and the choice that models it.
#[derive(Debug, Clone, Copy)]
pub(super) struct TermLayers {
    pub value: Layer,
    pub std_err: Layer,
    /// Half of what two halves of the rays differ by.
    pub half: Layer,
    pub choice: Choice,
    /// What the same rays say besides, smoothed as the term is.
    pub rider: Option<Layer>,
}

const fn term([value, std_err, half]: [Layer; 3], choice: Choice) -> TermLayers {
    TermLayers {
        value,
        std_err,
        half,
        choice,
        rider: None,
    }
}

/// What no sky changes.
#[rustfmt::skip]
const SHARES: [TermLayers; 3] = [
    term([Layer::Diffuse, Layer::StdErrDiffuse, Layer::HalfDiffuse], Choice::Diffuse),
    term([Layer::Visibility, Layer::StdErrVisibility, Layer::HalfVisibility], Choice::Visibility),
    term([Layer::Specular, Layer::StdErrSpecular, Layer::HalfSpecular], Choice::Specular),
];

/// The light of a map, which tiles integrate beside the shares.
#[rustfmt::skip]
const LIGHTS: [TermLayers; 2] = [
    term([Layer::Irradiance, Layer::StdErrIrradiance, Layer::HalfIrradiance], Choice::Diffuse),
    term([Layer::Reflection, Layer::StdErrReflection, Layer::HalfReflection], Choice::Specular),
];

/// The terms that tiles integrate for what was asked.
pub(super) fn terms(options: &Options, plan: &Plan) -> Vec<TermLayers> {
    let composed = |layer: &Layer| is_composed(*layer) || is_light(*layer);
    let lights: &[TermLayers] = match options.sky.map() {
        Some(_) if options.kept().iter().any(composed) => &LIGHTS,
        _ => &[],
    };
    let modelled = |term: &&TermLayers| plan.models(term.choice);
    let terms = SHARES.iter().chain(lights).filter(modelled);
    let mut terms: Vec<TermLayers> = terms.copied().collect();
    let lobe = terms.iter_mut().find(|term| term.value == Layer::Specular);
    if let Some(lobe) = lobe.filter(|_| tints(options, plan)) {
        lobe.rider = Some(Layer::White);
    }
    terms
}

/// Whether light that lobes reflect follows from two shares: of what has the material's colour, and of what is white.
fn tints(options: &Options, plan: &Plan) -> bool {
    let follows = |layer: &Layer| is_composed(*layer) || *layer == Layer::Reflection;
    options.model == Model::Ggx
        && options.sky.map().is_none()
        && plan.models(Choice::Specular)
        && options.kept().iter().any(follows)
}

/// The layers that are kept while tiles are baked: the facts from which the asked layers follow when the page is
/// finished.
pub(super) fn working_layers(options: &Options, plan: &Plan, mends: bool) -> Vec<Layer> {
    let mut layers = vec![Layer::Coverage];
    let mut add = |layer: Layer| {
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    };
    let uniform = options.sky.map().is_none();
    let ggx = options.model == Model::Ggx;
    let follows = |layer: Layer| is_composed(layer) || (uniform && is_light(layer));
    let kept = options.kept();
    let asked = kept.iter().copied();
    asked
        .map(super::tangent::source)
        .filter(|&layer| !follows(layer))
        .for_each(&mut add);
    for term in terms(options, plan) {
        add(term.value);
        let steps = options.denoise != Denoise::Off || options.seams != Seams::Off;
        if steps || kept.iter().any(|&layer| is_light(layer)) {
            add(term.std_err);
        }
        if options.denoise == Denoise::Regression {
            add(term.half);
        }
        term.rider.into_iter().for_each(&mut add);
    }
    if tints(options, plan) {
        add(Layer::Tint);
    }
    if options.denoise != Denoise::Off || mends {
        let geometry = [Layer::Position, Layer::Normal, Layer::Object];
        geometry.into_iter().for_each(&mut add);
    }
    if mends {
        add(Layer::Validity);
    }
    if finds_seals(options, plan) {
        add(Layer::Sealed);
    }
    if options.layers.iter().any(|&layer| is_composed(layer)) {
        add(Layer::Albedo);
        if options.ambient != AmbientCoefficient::Albedo {
            add(Layer::Ambient);
        }
        // Where nothing reflects specularly it is 0, and composing takes what is missing for 0.
        if plan.models(Choice::Specular) || options.layers.contains(&Layer::TraditionalClosed) {
            add(Layer::Reflectance);
        }
        if ggx {
            add(Layer::Base);
        }
    }
    for (layer, half) in super::directional::LAYERS {
        let mut asked = options.layers.iter().copied().map(super::tangent::source);
        if asked.any(|asked| asked == layer) && options.denoise == Denoise::Regression {
            add(half);
        }
    }
    if options.layers.contains(&Layer::TraditionalClosed) {
        add(Layer::OpenSpecular);
    }
    layers
}

impl TermLayers {
    /// Its value, and what rides with it.
    pub fn values(&self) -> impl Iterator<Item = Layer> {
        [Some(self.value), self.rider].into_iter().flatten()
    }
}

/// Channels of the terms of a bake with what rides with them: of all, and of the broadest.
pub fn channels_of_terms(options: &Options, plan: &Plan) -> [u64; 2] {
    let terms = terms(options, plan).into_iter();
    let channels = terms.map(|term| {
        term.values()
            .map(|value| value.channels().len() as u64)
            .sum()
    });
    channels.fold([0, 1], |[all, most], own: u64| [all + own, most.max(own)])
}

/// Whether tiles look for what is sealed: fits leave it out.
pub(super) fn finds_seals(options: &Options, plan: &Plan) -> bool {
    let fits = options.denoise == Denoise::Regression || options.kept().contains(&Layer::Sealed);
    fits && plan.models(Choice::Diffuse)
}

/// The layers that are kept while tiles of a bake are baked, coverage first, where solids may bury texels.
pub fn layers_in_work(options: &Options, plan: &Plan) -> Vec<Layer> {
    working_layers(options, plan, options.buried == Buried::Drop)
}

/// The layers of a finished page before light is added to it, and those of the page of light beside it; the latter is
/// empty where none is
/// added.
pub fn layers_of_light(options: &Options, plan: &Plan) -> [Vec<Layer>; 2] {
    let adds = plan.models(Choice::Bounces) || plan.models(Choice::Lights);
    let mends = options.buried == Buried::Drop;
    let light = adds.then(|| light_layers(options, plan, mends));
    [options.kept(), light.unwrap_or_default()]
}

/// The layers of a page of the light that gathers add.
pub(crate) fn light_layers(options: &Options, plan: &Plan, mends: bool) -> Vec<Layer> {
    let denoises = options.denoise != Denoise::Off;
    let mut layers = vec![Layer::Coverage, Layer::Rays];
    for term in lights(plan) {
        layers.extend([term.value, term.std_err]);
        if denoises || options.layers.contains(&term.half) {
            layers.push(term.half);
        }
    }
    if denoises || mends {
        layers.extend([Layer::Position, Layer::Normal, Layer::Object]);
    }
    if mends {
        layers.push(Layer::Validity);
    }
    layers
}

/// The terms of light alone.
pub(super) fn lights(plan: &Plan) -> Vec<TermLayers> {
    let modelled = |term: &&TermLayers| plan.models(term.choice);
    LIGHTS.iter().filter(modelled).copied().collect()
}
