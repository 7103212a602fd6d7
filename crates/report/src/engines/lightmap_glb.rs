//! The scene with its lightmap by `MOZ_lightmap`, the extension that Mozilla Hubs made: `index`, `texCoord`,
//! `intensity`.
//!
//! Its readers (Hubs; three.js' `GLTFLightMapLoaderExtension`) take the texture as linear and the product with
//! `intensity` as irradiance E. So the picture holds E / pi as a share of its largest value m, and `intensity` is pi m.
//! Occlusion would darken the light once more and is taken out.

use super::ao::Dither;
use super::mips::{fill, is_filled};
use super::scene_kind::{Picture, SceneGlb};
use super::{Engine, PageLight};
use png::ColorType;
use serde_json::{Map, Value, json};
use std::f32::consts::PI;

const MOZ: &str = "MOZ_lightmap";

pub const LIGHTMAP: SceneGlb = SceneGlb {
    suffix: "lightmap",
    engines: &[Engine::Gltf, Engine::Three],
    extensions: &[MOZ],
    picture,
    shows,
    beside: &[],
    words: [
        "irradiance E on TEXCOORD_1: the 8-bit linear texture of MOZ_lightmap times its intensity",
        "Readers of MOZ_lightmap (Mozilla Hubs, three.js with a plugin of ten lines) show it lit with its own \
         materials, without lamps. In other viewers it is the scene without its light; for more than 8 bits take \
         STEM.P.lightmap.exr.",
    ],
};

/// RGB, 8 bits, linear, dithered.
fn picture(page: &PageLight<'_>) -> Option<Picture> {
    let texel = |i: usize| [0, 1, 2].map(|c: usize| page.light[c][i].max(0.0));
    let mut pixels: Vec<[f32; 3]> = (0..page.coverage.len()).map(texel).collect();
    let filled = is_filled(&page.coverage, page.size, page.rings);
    fill(&mut pixels, page.size, &filled);
    let most = pixels.iter().flatten().fold(0.0f32, |a, &b| a.max(b));
    let strength = if most > 0.0 { most } else { 1.0 };
    let dither = Dither::new();
    let edge = page.size as usize;
    let bytes: Vec<u8> = pixels
        .iter()
        .enumerate()
        .flat_map(|(i, pixel)| {
            // Each channel has thresholds of its own, so that colours are dithered too, not brightness alone.
            [0, 1, 2]
                .map(|c| dither.byte(pixel[c] / strength, i % edge + 21 * c, i / edge + 37 * c))
        })
        .collect();
    let png = crate::preview::encode([page.size; 2], ColorType::Rgb, &bytes, None);
    Some(Picture { png, strength })
}

fn shows(map: &mut Map<String, Value>, _: usize, texture: u64, strength: f32) {
    let lightmap = json!({ "index": texture, "texCoord": 1, "intensity": PI * strength });
    let extensions = map.entry("extensions").or_insert_with(|| json!({}));
    if let Some(extensions) = extensions.as_object_mut() {
        extensions.insert(MOZ.into(), lightmap);
    }
}

#[cfg(test)]
mod tests {
    use super::super::ao::tests::page;
    use super::*;
    use crate::preview::decoded;
    use std::borrow::Cow;

    #[test]
    fn every_channel_is_dithered_evenly_and_by_thresholds_of_its_own() {
        let mut page = page(100.25 / 255.0);
        // One texel that makes 255 stand for 1.
        for light in &mut page.light {
            Cow::to_mut(light)[0] = 1.0;
        }
        let picture = picture(&page).unwrap();
        assert_eq!(picture.strength, 1.0);
        let (_, bytes) = decoded(&picture.png);
        let edge = page.size as usize;
        let raised = |c: usize, x: usize, y: usize| bytes[3 * (y * edge + x) + c] == 101;
        for c in 0..3 {
            for (x, y) in (8..edge)
                .step_by(8)
                .flat_map(|y| (0..edge).step_by(8).map(move |x| (x, y)))
            {
                let places = (0..64).map(|k| (x + k % 8, y + k / 8));
                let count = places.filter(|&(x, y)| raised(c, x, y)).count();
                assert!(
                    (10..=22).contains(&count),
                    "channel {c}: {count} of 64 at {x}, {y}"
                );
            }
        }
        // A quarter of a quarter, were they drawn apart.
        let both = (edge..edge * edge)
            .filter(|i| raised(0, i % edge, i / edge) && raised(1, i % edge, i / edge));
        assert!(both.count() < edge * edge / 10);
    }
}
