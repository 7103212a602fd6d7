//! Cut-out and see-through surfaces over a floor, with answers known on paper, by both ray libraries.

use crate::quads::{self, Quad};
use crate::support::has_embree;
use ambake::{Backend, Bake, Bounces, Layer, Light, Uv};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Edge of the cards, in metres, one above the floor: nearly the whole sky.
const EDGE: f32 = 200.0;

/// A floor on the left of the page and cards, at these heights, on its right.
fn scene(cards: &[f32], change: impl Fn(Quad) -> Quad, extra: Value) -> TempDir {
    let share = 1.0 / cards.len() as f32;
    let rect = |left: f32, top: f32, height: f32| [[left, top], [0.4, 0.0], [0.0, height]];
    let mut floor = Quad::level(0.0, 1.0);
    floor.uvs[1] = rect(0.0, 0.0, 0.4);
    let mut all = vec![floor];
    for (i, &height) in cards.iter().enumerate() {
        let mut card = Quad::level(height, EDGE);
        card.uvs[1] = rect(0.5, i as f32 * share, 0.8 * share);
        card.material = 1;
        all.push(change(card));
    }
    quads::write(&all, extra)
}

/// Mean diffuse and visibility over the floor, by each ray library.
fn floor(folder: &TempDir) -> Vec<[f64; 2]> {
    let scene = ambake::load(folder.path().join("scene.gltf")).expect("the scene loads");
    let mut backends = vec![Backend::Obvhs];
    backends.extend(has_embree().then_some(Backend::Embree));
    let mean = |backend| {
        let bake = Bake::new(&scene).size(32).rays(1024).uv(Uv::Keep);
        let baked = bake.backend(backend).run(&()).expect("it bakes");
        let page = baked.page(0);
        let on_floor = |texel: &usize| texel % 32 < 12 && texel / 32 < 12;
        [Layer::Diffuse, Layer::Visibility].map(|layer| {
            let values = page.layer(layer);
            let floor: Vec<f64> = (0..values.len())
                .filter(on_floor)
                .map(|texel| f64::from(values[texel]))
                .collect();
            floor.iter().sum::<f64>() / floor.len() as f64
        })
    };
    backends.into_iter().map(mean).collect()
}

/// Share of the sky that cards of the given height leave free beside them, weighted by the cosine and not.
fn beside(height: f64) -> [f64; 2] {
    let half = f64::from(EDGE) / 2.0 / height;
    let root = (1.0 + half * half).sqrt();
    let diffuse = 1.0 - 4.0 / std::f64::consts::PI * half / root * (half / root).atan();
    let corner = (half * half / (root * root)).asin();
    [diffuse, 1.0 - 2.0 / std::f64::consts::PI * corner]
}

/// Every library finds what cards let pass of the light that would come through them, within `tolerance`.
fn assert_passes(found: &[[f64; 2]], share: f64, beside: [f64; 2], tolerance: f64) {
    for found in found {
        for (term, (found, beside)) in found.iter().zip(beside).enumerate() {
            let expected = share * (1.0 - beside) + beside;
            assert!(
                (found - expected).abs() < tolerance,
                "term {term}: {found} for {expected}"
            );
        }
    }
}

fn masked(sampler: Value) -> Value {
    json!({
        "materials": [{}, {
            "alphaMode": "MASK",
            "alphaCutoff": 0.5,
            "pbrMetallicRoughness": {
                "baseColorFactor": [1, 1, 1, 0.5],
                "baseColorTexture": { "index": 0 },
            },
        }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [sampler],
        "images": [{ "uri": "checker.png" }],
    })
}

#[test]
fn a_repeated_checker_with_alpha_at_the_cutoff_passes_half_of_the_light() {
    // 32 cells a metre; two cells of the picture make one repeat. Kept cells have an alpha of exactly the cutoff.
    let repeats = EDGE * 32.0 / 2.0;
    let tiled = |mut card: Quad| {
        card.uvs[0] = [[0.0, 0.0], [repeats, 0.0], [0.0, repeats]];
        card
    };
    for wrap in [10497, 33648] {
        let sampler = json!({ "magFilter": 9728, "wrapS": wrap, "wrapT": wrap });
        let folder = scene(&[1.0], tiled, masked(sampler));
        let (hole, kept) = ([255, 255, 255, 0], [255; 4]);
        quads::picture(&folder, "checker.png", [2, 2], &[hole, kept, kept, hole]);
        assert_passes(&floor(&folder), 0.5, beside(1.0), 0.003);
    }
}

#[test]
fn filtering_leaves_no_holes_where_alpha_equals_the_cutoff() {
    let folder = scene(&[1.0], |card| card, masked(json!({ "magFilter": 9729 })));
    quads::picture(&folder, "checker.png", [2, 2], &[[255; 4]; 4]);
    assert_passes(&floor(&folder), 0.0, beside(1.0), 1e-3);
}

#[test]
fn vertex_colours_multiply_the_alpha_of_a_mask() {
    let extra = || json!({ "materials": [{}, { "alphaMode": "MASK" }] });
    for (alpha, share) in [(0.75, 0.0), (0.25, 1.0)] {
        let coloured = |card: Quad| card.with("COLOR_0", &[1.0, 1.0, 1.0, alpha]);
        let folder = scene(&[1.0], coloured, extra());
        assert_passes(&floor(&folder), share, beside(1.0), 1e-3);
    }
}

#[test]
fn see_through_surfaces_pass_what_their_alpha_leaves_layer_by_layer() {
    let extra = json!({ "materials": [{}, {
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.6] },
    }] });
    let coloured = |card: Quad| card.with("COLOR_0", &[1.0, 1.0, 1.0, 0.5]);
    let one = floor(&scene(&[1.0], coloured, extra.clone()));
    assert_passes(&one, 0.7, beside(1.0), 0.003);
    // The same rays pass in every library, but for a ray in ten thousand that meets a border within rounding.
    let [first, last] = [one.first(), one.last()].map(|found| found.expect("a library"));
    assert!((first[0] - last[0]).abs() < 1e-4, "{first:?} and {last:?}");
    // The second card is as large from the floor as the first, but for a hundredth of the sky.
    let two = floor(&scene(&[1.0, 1.01], coloured, extra));
    assert_passes(&two, 0.49, beside(1.0), 0.004);
}

#[test]
fn a_pane_passes_its_transmission_times_its_tint() {
    // The mean of 1, 1/2 and 0 over the channels is a half.
    for (factor, tint, share) in [(1.0, [1.0; 3], 1.0), (0.5, [1.0, 0.5, 0.0], 0.25)] {
        let [r, g, b] = tint;
        let extra = json!({ "materials": [{}, {
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0 },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": factor } },
        }] });
        let found = floor(&scene(&[1.0], |card| card, extra));
        assert_passes(&found, share, beside(1.0), 0.003);
    }
}

#[test]
fn light_of_suns_and_lamps_takes_the_tint_of_a_pane() {
    let extra = json!({ "materials": [{}, {
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0.2, 0, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
    }, {
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 },
        "emissiveFactor": [0.5, 1, 1],
        "doubleSided": true,
    }] });
    // A ceiling that shines lies on the pane.
    let change = |mut card: Quad| {
        card.material = if card.corner[1] > 1.0 { 2 } else { 1 };
        card
    };
    let sun = Light::sun([0.0, 0.8, 0.6], [2.0, 1.0, 1.0]);
    let by_sun = [2.0, 1.0, 1.0].map(|e| 0.8 * e / std::f64::consts::PI);
    let by_ceiling = [0.5, 1.0, 1.0].map(|radiance| radiance * (1.0 - beside(1.0)[0]));
    for (heights, sun, light, tolerance) in [
        (&[1.0][..], Some(sun), by_sun, 1e-6),
        (&[1.0, 1.01], None, by_ceiling, 0.01),
    ] {
        let folder = scene(heights, change, extra.clone());
        let scene = ambake::load(folder.path().join("scene.gltf")).expect("the scene loads");
        let mut backends = vec![Backend::Obvhs];
        backends.extend(has_embree().then_some(Backend::Embree));
        for backend in backends {
            let bake = Bake::new(&scene).size(32).rays(1024).uv(Uv::Keep);
            let bake = bake.layers([Layer::Irradiance]).sky([0.0; 3]);
            let bake = match sun {
                Some(sun) => bake.light(sun),
                None => bake.bounces(Bounces::Most(1)),
            };
            let baked = bake.backend(backend).run(&()).expect("it bakes");
            let values = baked.page(0).layer(Layer::Irradiance);
            for (channel, tint) in [1.0, 0.2, 0.0].into_iter().enumerate() {
                // A texel amid the floor.
                let found = f64::from(values[channel * 32 * 32 + 6 * 32 + 6]);
                let exact = light[channel] * tint;
                assert!(
                    (found - exact).abs() <= tolerance,
                    "{backend:?}, channel {channel}: {found} for {exact}"
                );
            }
        }
    }
}
