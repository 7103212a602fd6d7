//! Terms of a page across its seams, and across those that it shares with other pages.

use super::compose::is_light;
use super::directional;
use super::planes::BakedPage;
use super::terms::TermLayers;
use crate::seams::{Across, Known, System};
use layers::Layer;

/// The values that seams give to gutter texels: layer, channel, texels.
pub(super) type Gutters = Vec<(Layer, usize, Vec<(u32, f32)>)>;

/// The seams of a page, and those that it shares with other pages: of terms, or of the light of bounces.
#[derive(Clone, Copy)]
pub(super) struct Joined<'a> {
    pub system: &'a System,
    pub across: &'a Across,
    /// Of the light of bounces.
    pub light: bool,
}

/// Makes the terms agree across seams; `light` is what an open texel receives, about. Texels of charts move here, those
/// of gutters when gutters are filled. What a texel moves by is an error of its own mean, which its standard error
/// takes in.
pub(super) fn solve_seams(
    page: &mut BakedPage,
    light: f64,
    terms: &[TermLayers],
    joined: Option<Joined<'_>>,
) -> Gutters {
    let Some(joined) = joined else {
        return Vec::new();
    };
    let system = joined.system;
    let tied = system.tied();
    let coverage = page.layer(Layer::Coverage).unwrap_or_default();
    let (planes, known): (Vec<_>, Vec<_>) = seamed(page, terms)
        .into_iter()
        .filter_map(|seamed| {
            let Seamed {
                value: term,
                channel,
                std_err,
                ..
            } = seamed;
            let unit = match is_light(term) || term == Layer::Sh {
                true => light,
                false => 1.0,
            };
            let plane = |layer, channel| page.channel(layer, channel).unwrap_or_default();
            let values = plane(term, channel);
            let known = Known {
                tied: joined.across.found(joined.light, term, channel, tied),
                values,
                std_errs: plane(std_err, 0),
                unit,
                most: match is_light(term) || directional::holds(term) {
                    true => brightest(values, coverage),
                    false => 1.0,
                },
            };
            // In the dark every texel holds 0, and both sides agree.
            (unit > 0.0).then_some((seamed, known))
        })
        .unzip();
    let solved = system.solve(&known, coverage);
    let is_gutter: Vec<bool> = coverage.iter().map(|&coverage| coverage == 0.0).collect();
    let texels = page.texels();
    let mut gutters = Vec::new();
    // What the channels of a term so far moved by.
    let mut moves: Vec<f32> = Vec::new();
    for (seamed, moved) in planes.into_iter().zip(solved) {
        let (term, channel) = (seamed.value, seamed.channel);
        if term == Layer::Diffuse {
            page.stats.seams = moved.stats;
        }
        let (gutter, own): (Vec<_>, Vec<_>) = moved
            .values
            .into_iter()
            .partition(|(texel, _)| is_gutter[*texel as usize]);
        let plane = &mut page.planes_of(term)[channel * texels..][..texels];
        if channel == 0 {
            moves = vec![0.0; own.len()];
        }
        for (&(texel, value), moved) in own.iter().zip(&mut moves) {
            let value_before = std::mem::replace(&mut plane[texel as usize], value);
            *moved += value - value_before;
        }
        let channels = term.channels().len();
        if channel + 1 == channels && seamed.counts {
            let errors = page.planes_of(seamed.std_err);
            for (&(texel, _), moved) in own.iter().zip(&moves) {
                let error = &mut errors[texel as usize];
                *error = error.hypot(moved / channels as f32);
            }
        }
        gutters.push((term, channel, gutter));
    }
    gutters
}

/// The largest value of a texel that is covered: light has no other end, and gutters must not outshine all that they
/// surround.
fn brightest(values: &[f32], coverage: &[f32]) -> f64 {
    let covered = values.iter().zip(coverage).filter(|(_, c)| **c > 0.0);
    covered.fold(0.0, |most, (value, _)| f64::max(most, f64::from(*value)))
}

/// A plane that must agree across seams.
struct Seamed {
    value: Layer,
    channel: usize,
    /// The standard error by which its texels weigh.
    std_err: Layer,
    /// Whether what they move by counts there.
    counts: bool,
}

/// The planes that must agree across seams.
fn seamed(page: &BakedPage, terms: &[TermLayers]) -> Vec<Seamed> {
    let terms = terms.iter().flat_map(|term| {
        let of = move |value| (value, term.std_err, value == term.value);
        term.values().map(of)
    });
    let directional = directional::of(page).into_iter();
    terms
        .chain(directional.map(|(layer, _)| (layer, Layer::StdErrDiffuse, false)))
        .flat_map(|(value, std_err, counts)| {
            (0..value.channels().len()).map(move |channel| Seamed {
                value,
                channel,
                std_err,
                counts,
            })
        })
        .collect()
}

/// Keeps what the page holds on seams with pages that are finished later.
pub(super) fn keep_sides(page: &BakedPage, terms: &[TermLayers], joined: Option<Joined<'_>>) {
    let Some(Joined {
        system,
        across,
        light,
    }) = joined
    else {
        return;
    };
    for Seamed { value, channel, .. } in seamed(page, terms) {
        let kept = system.kept(page.channel(value, channel).unwrap_or_default());
        if !kept.is_empty() {
            across.keep(light, value, channel, &kept);
        }
    }
}
