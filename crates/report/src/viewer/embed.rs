//! Pages as the viewer embeds them.

use crate::{Channel, Page};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use exr::prelude::f16;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use serde::Serialize;
use std::io::Write;

/// Layers that a viewer has no use for: positions and objects come from the geometry, differences from the models.
const LEFT_OUT: [&str; 4] = ["coverage", "position", "object", "geometric"];

/// How the channels of layers for any view begin, the larger layer first.
const HARMONICS: [&str; 2] = ["any-view.8.", "any-view."];

/// A page, ready to be embedded.
pub struct EmbeddedPage {
    /// Edge of the embedded page.
    pub(super) size: u32,
    /// Edge of the page in its file.
    pub(super) texels: u32,
    pub(super) layers: Vec<EmbeddedLayer>,
    /// One byte a texel, 1 where charts are.
    pub(super) coverage: String,
    /// For each of the layers, the plane of each of its channels; channels that are equal share one.
    pub(super) planes: Vec<Vec<usize>>,
    /// The planes of the harmonics for any view, where the page has all that a view needs; else none.
    pub(super) harmonics: Vec<usize>,
    /// One text for each plane.
    pub(super) texts: Vec<String>,
}

/// What the viewer must know of a layer.
#[derive(Serialize)]
pub(super) struct EmbeddedLayer {
    name: String,
    channels: usize,
    /// How it is shown: `color`, `grey`, `vector` or `heat`.
    kind: &'static str,
}

impl EmbeddedPage {
    /// True for a page without any layer to show.
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// The page with one texel for every `step * step` of its own: their mean over what charts cover.
    ///
    /// # Panics
    /// Where `step` is 0.
    pub fn of(page: &Page, step: u32) -> EmbeddedPage {
        let (edge, step) = (page.size as usize, step as usize);
        let size = edge.div_ceil(step);
        let coverage = page.values("coverage");
        let covered = |i: usize| coverage.is_none_or(|coverage| coverage[i] > 0.0);
        // Where a bilinear look-up may read: the texels of charts and those around them.
        let near = near(edge, &covered);
        let blocks = |value: &(dyn Fn(usize) -> f32 + Sync),
                      counts: &(dyn Fn(usize) -> bool + Sync)|
         -> Vec<f32> {
            let block = |at: usize| {
                let (x, y) = (at % size * step, at / size * step);
                let (mut sum, mut count) = (0.0, 0.0f32);
                for y in y..(y + step).min(edge) {
                    for i in y * edge + x..y * edge + (x + step).min(edge) {
                        if counts(i) {
                            sum += value(i);
                            count += 1.0;
                        }
                    }
                }
                sum / count.max(1.0)
            };
            (0..size * size).map(block).collect()
        };
        let mask = blocks(&|_| 1.0, &covered);
        let mask: Vec<u8> = mask.iter().map(|&value| value as u8).collect();
        let used = page.layers.iter().filter(|layer| {
            let name = layer.name.as_str();
            let skipped = name.starts_with("half.") || name.starts_with("difference.");
            !(LEFT_OUT.contains(&name) || skipped || name.starts_with(HARMONICS[1]))
        });
        let used: Vec<_> = used.collect();
        let harmonics = harmonics(page);
        let shown = used.iter().flat_map(|layer| &layer.channels);
        let channels: Vec<&Channel> = shown.chain(harmonics).collect();
        let packed = channels.par_iter().with_max_len(1).map(|channel| {
            let values = blocks(&|i| channel.values[i], &|i| near[i]);
            blob(&halves(&values))
        });
        let packed: Vec<String> = packed.collect();
        let mut texts: Vec<String> = Vec::new();
        let numbers = packed.into_iter().map(|text| {
            let known = texts.iter().position(|other| *other == text);
            known.unwrap_or_else(|| {
                texts.push(text);
                texts.len() - 1
            })
        });
        let mut numbers = numbers.collect::<Vec<usize>>().into_iter();
        let planes = used
            .iter()
            .map(|layer| numbers.by_ref().take(layer.channels.len()).collect());
        let planes = planes.collect();
        let harmonics = numbers.collect();
        let layer = |layer: &&crate::PageLayer| EmbeddedLayer {
            name: layer.name.clone(),
            channels: layer.channels.len(),
            kind: kind(&layer.name, layer.channels.len()),
        };
        EmbeddedPage {
            size: size as u32,
            texels: page.size,
            layers: used.iter().map(layer).collect(),
            coverage: blob(&mask),
            planes,
            harmonics,
            texts,
        }
    }
}

/// The channels of the layer for any view with the most numbers; none where the page lacks the normal or the exponent,
/// without which no view can be evaluated.
fn harmonics(page: &Page) -> Vec<&Channel> {
    if page.layer("normal").is_none() || page.layer("exponent").is_none() {
        return Vec::new();
    }
    let of = |prefix: &str| -> Vec<&Channel> {
        let name = |number: usize| format!("{prefix}{number:02}");
        let layers = (0..).map_while(|number| page.layer(&name(number)));
        layers.flat_map(|layer| &layer.channels).collect()
    };
    let found = HARMONICS.into_iter().map(of);
    found
        .into_iter()
        .find(|channels| !channels.is_empty())
        .unwrap_or_default()
}

/// How a layer is shown.
fn kind(name: &str, channels: usize) -> &'static str {
    match name {
        "normal" | "bent" | "geometric" => "vector",
        "rays" | "exponent" => "heat",
        _ if name == "error" || name.starts_with("error.") => "heat",
        _ if channels >= 3 => "color",
        _ => "grey",
    }
}

/// True for the texels that are covered or at most two texels from one that is.
fn near(edge: usize, covered: &dyn Fn(usize) -> bool) -> Vec<bool> {
    let mut near: Vec<bool> = (0..edge * edge).map(covered).collect();
    for (stride, along) in [(1, edge), (edge, 1)] {
        let before = near.clone();
        for (i, here) in near.iter_mut().enumerate() {
            let at = if stride == 1 { i % along } else { i / edge };
            let low = i - at.min(2) * stride;
            let high = i + (edge - 1 - at).min(2) * stride;
            *here = (low..=high).step_by(stride).any(|k| before[k]);
        }
    }
    near
}

/// Values as 16-bit floats: differences along the rows, all high bytes before all low ones.
fn halves(values: &[f32]) -> Vec<u8> {
    let mut last = 0u16;
    let steps = values.iter().map(|&value| {
        let bits = f16::from_f32(value.clamp(-65_504.0, 65_504.0)).to_bits();
        let step = bits.wrapping_sub(last);
        last = bits;
        step
    });
    let steps: Vec<u16> = steps.collect();
    let high = steps.iter().map(|step| (step >> 8) as u8);
    high.chain(steps.iter().map(|step| *step as u8)).collect()
}

/// Bytes deflated (RFC 1950) and in base64.
pub(super) fn blob(bytes: &[u8]) -> String {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::new(5));
    // Writing into memory does not fail.
    let packed = match packed.write_all(bytes).and_then(|()| packed.finish()) {
        Ok(packed) => packed,
        Err(error) => unreachable!("memory takes bytes: {error}"),
    };
    STANDARD.encode(packed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PageLayer;
    use std::io::Read;

    fn unpacked(text: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        let packed = STANDARD.decode(text).unwrap();
        flate2::read::ZlibDecoder::new(&packed[..])
            .read_to_end(&mut bytes)
            .unwrap();
        bytes
    }

    #[test]
    fn a_page_comes_back_as_half_floats_and_far_gutters_are_left_out() {
        let mut coverage = vec![0.0; 64];
        coverage[0] = 1.0;
        let values: Vec<f32> = (0..64).map(|i| i as f32 / 64.0).collect();
        let layers = vec![
            PageLayer::scalar("coverage", coverage),
            PageLayer::scalar("diffuse", values.clone()),
            PageLayer::scalar("object", values.clone()),
            PageLayer::scalar("visibility", values.clone()),
        ];
        let page = EmbeddedPage::of(&Page { size: 8, layers }, 1);
        assert_eq!(page.layers.len(), 2);
        assert_eq!(page.planes, [[0], [0]], "equal channels are held once");
        let bytes = unpacked(&page.texts[0]);
        let mut bits = 0u16;
        for (i, expected) in values.iter().enumerate() {
            let step = u16::from(bytes[i]) << 8 | u16::from(bytes[64 + i]);
            bits = bits.wrapping_add(step);
            let near = i % 8 <= 2 && i / 8 <= 2;
            assert_eq!(
                f16::from_bits(bits).to_f32(),
                if near { *expected } else { 0.0 },
                "{i}"
            );
        }
        assert_eq!(unpacked(&page.coverage)[..2], [1, 0]);
    }

    #[test]
    fn light_for_any_view_needs_the_normal_and_the_exponent() {
        let held = |names: &[&str]| {
            let layers = names
                .iter()
                .map(|name| PageLayer::scalar(name, vec![0.5]))
                .collect();
            let page = Page { size: 1, layers };
            harmonics(&page).len()
        };
        let first = format!("{}00", HARMONICS[0]);
        let second = format!("{}01", HARMONICS[0]);
        assert_eq!(held(&[&first, &second, "normal", "exponent"]), 2);
        assert_eq!(held(&[&first, &second, "normal"]), 0);
        assert_eq!(held(&[&first, &second, "exponent"]), 0);
        assert_eq!(held(&["normal", "exponent"]), 0);
    }

    #[test]
    fn a_reduced_page_holds_means_over_what_is_covered() {
        let coverage = [[1.0, 1.0, 0.0], [0.0; 3], [0.0; 3]].concat();
        let values = [[0.25, 0.75, 9.0], [9.0; 3], [9.0; 3]].concat();
        let layers = vec![
            PageLayer::scalar("coverage", coverage),
            PageLayer::scalar("error", values),
        ];
        let page = EmbeddedPage::of(&Page { size: 3, layers }, 2);
        assert_eq!(
            (page.size, page.texels, page.layers[0].kind),
            (2, 3, "heat")
        );
        assert_eq!(unpacked(&page.coverage), [1, 0, 0, 0]);
    }
}
