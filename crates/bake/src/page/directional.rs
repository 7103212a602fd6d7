//! Layers that say where a texel is open and whence its light comes, through the last steps of a page.
//!
//! While a page is in work they are kept as sums that are never negative and follow linearly from the rays: the diffuse
//! term plus each axis of the cosine-weighted sum of open directions, and the first harmonic plus each of the others.
//! So every step treats them as it treats light. What is asked for is made of them when gutters are filled: a bent
//! normal gets its unit length last.

use super::planes::BakedPage;
use crate::denoise::{Denoiser, Field, Term, oidn};
use crate::integrate::Terms;
use crate::mend::Mends;
use glam::Vec3;
use layers::Layer;

/// The layers with what two halves of the rays differ by in them.
pub(super) const LAYERS: [(Layer, Layer); 2] =
    [(Layer::Bent, Layer::HalfBent), (Layer::Sh, Layer::HalfSh)];

/// True for these layers and their halves.
pub(super) fn holds(layer: Layer) -> bool {
    LAYERS
        .iter()
        .any(|&(own, half)| layer == own || layer == half)
}

/// A channel of such a layer while its page is in work.
pub(super) fn packed(terms: &Terms, layer: Layer, channel: usize) -> f64 {
    let (diffuse, directional) = match layer {
        Layer::Bent | Layer::Sh => (terms.diffuse.value, &terms.directional),
        _ => (terms.halves.diffuse, &terms.halves.directional),
    };
    match (layer, channel / 3) {
        (Layer::Bent | Layer::HalfBent, _) => diffuse + directional.bent[channel],
        (_, 0) => directional.light[0][channel],
        (_, k) => directional.light[0][channel % 3] + directional.light[k][channel % 3],
    }
}

/// The layers that a page in work has, each with its halves.
pub(super) fn of(page: &BakedPage) -> Vec<(Layer, Layer)> {
    let has = |(layer, _): &(Layer, Layer)| page.layer(*layer).is_some();
    LAYERS.into_iter().filter(has).collect()
}

/// Mends texels that are buried, wholly or in part.
pub(super) fn mend(page: &mut BakedPage, mends: &Mends) {
    for (layer, half) in of(page) {
        page.mend(layer, mends, [0.0, f64::MAX]);
        page.mend(half, mends, [f64::MIN, f64::MAX]);
    }
}

/// Denoises them, by the learned filter where there is no `regression`. What is exact of the diffuse term is exact
/// here.
///
/// * `field`: what the learned filter sees of a page.
pub(super) fn denoise(
    page: &mut BakedPage,
    regression: Option<&Denoiser<'_>>,
    unseen: Option<&Mends>,
    field: impl Fn(&BakedPage) -> Field<'_>,
) {
    let texels = page.texels();
    for (layer, half) in of(page) {
        // Colours of one direction go together; axes of a vector have noise of their own.
        let together = if layer == Layer::Sh { 3 } else { 1 };
        for first in (0..layer.channels().len()).step_by(together) {
            let group = first..first + together;
            let planes = |layer: Layer| {
                let plane = |channel| page.channel(layer, channel).unwrap_or_default();
                group.clone().map(plane).collect()
            };
            let term = Term {
                values: planes(layer),
                riders: Vec::new(),
                halves: regression.map_or(Vec::new(), |_| planes(half)),
                std_err: page.layer(Layer::StdErrDiffuse).unwrap_or_default(),
                sealed: page.layer(Layer::Sealed),
                largest: f32::INFINITY,
                is_smooth: false,
                crosses: true,
            };
            let found = match regression {
                Some(denoiser) => denoiser.denoise(&term),
                None => oidn::denoise(&field(page), &term),
            };
            let values = &mut page.planes_of(layer)[first * texels..][..together * texels];
            for (channel, plane) in values.chunks_mut(texels).enumerate() {
                found
                    .iter()
                    .for_each(|part| part.set_values(channel, plane));
                if let Some(unseen) = unseen {
                    unseen.apply(plane, 0.0, f64::MAX);
                }
            }
        }
    }
}

/// Makes the layers that were asked for of what a page in work holds.
pub(super) fn unpack(page: &mut BakedPage) {
    let texels = page.texels();
    if page.layer(Layer::Bent).is_some() {
        let diffuse = page.layer(Layer::Diffuse).unwrap_or_default().to_vec();
        let planes = page.planes_of(Layer::Bent);
        for (texel, diffuse) in diffuse.iter().enumerate() {
            let at = [texel, texels + texel, 2 * texels + texel];
            let bent = Vec3::from(at.map(|at| planes[at] - diffuse)).normalize_or_zero();
            at.iter()
                .zip(bent.to_array())
                .for_each(|(at, value)| planes[*at] = value);
        }
    }
    if page.layer(Layer::Sh).is_some() {
        let planes = page.planes_of(Layer::Sh);
        for channel in 0..3 {
            for texel in 0..texels {
                let at = |k: usize| (3 * k + channel) * texels + texel;
                let mean = planes[at(0)];
                let axes = Vec3::from([1, 2, 3].map(|k| planes[at(k)] - mean));
                // No light is more one-sided than that of one direction.
                let axes = axes.clamp_length_max(mean.max(0.0));
                for (k, value) in (1..4).zip(axes.to_array()) {
                    planes[at(k)] = value;
                }
            }
        }
    }
}
