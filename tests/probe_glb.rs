//! `probes --for gltf`: the scene with the light of a place, by `EXT_lights_image_based`.

use crate::support::{assert_valid_gltf, bake, run_well, scene};
use serde_json::Value;
use std::path::Path;

/// JSON and binary part of a GLB.
fn parts(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).expect("written");
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4")) as usize;
    let end = 20 + length(12);
    let json = serde_json::from_slice(&bytes[20..end]).expect("JSON");
    (json, bytes[end + 8..].to_vec())
}

/// E / pi toward a normal, as Babylon.js computes it from the coefficients in the axes of its default scene, into which
/// glTF's come with x turned over: the associated Legendre functions have the sign (-1)^m there.
fn shown(coefficients: &Value, [x, y, z]: [f64; 3], channel: usize) -> f64 {
    let x = -x;
    let basis = [
        0.282_095,
        -0.488_603 * y,
        0.488_603 * z,
        -0.488_603 * x,
        1.092_548 * x * y,
        -1.092_548 * y * z,
        0.315_392 * (3.0 * z * z - 1.0),
        -1.092_548 * x * z,
        0.546_274 * (x * x - y * y),
    ];
    let term =
        |(k, basis): (usize, &f64)| basis * coefficients[k][channel].as_f64().expect("a number");
    basis.iter().enumerate().map(term).sum::<f64>() / std::f64::consts::PI
}

#[test]
fn a_glb_holds_the_scene_and_the_light_of_a_place_as_its_reader_shows_it() {
    let file = scene("courtyard.obj");
    let (baked, _) = bake(&file, &["--size=64", "--rays=16", "--bounces=auto"]);
    let out = baked.path().display().to_string();
    let words = [
        "probes",
        file.to_str().expect("UTF-8"),
        "-o",
        &out,
        "--bake",
        &out,
        "--reflections=-4.5,1.2,-4.5",
        "--reflection-size=32",
        "--at=-4.5,1.2,-4.5",
        "--rays=16384",
        "--for=gltf",
        "-q",
    ];
    run_well(words);
    let path = baked.path().join("courtyard.reflection.0.glb");
    assert_valid_gltf(&path);
    let (json, binary) = parts(&path);
    let (bare, _) = parts(&baked.path().join("courtyard.glb"));
    assert_eq!(json["meshes"], bare["meshes"]);
    assert_eq!(
        json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"],
        0
    );
    let light = &json["extensions"]["EXT_lights_image_based"]["lights"][0];
    let coefficients = &light["irradianceCoefficients"];
    // The nine harmonics of a probe at that place say the same.
    let text = std::fs::read_to_string(baked.path().join("courtyard.probes.json"));
    let report: Value = serde_json::from_str(&text.expect("written")).expect("JSON");
    let sh: Vec<[f64; 3]> =
        serde_json::from_value(report["probes"][0]["sh"].clone()).expect("triples");
    for normal in [
        [1.0, 0.0, 0.0],
        [-0.6, 0.8, 0.0],
        [0.0, -0.6, 0.8],
        [0.48, 0.6, -0.64],
    ] {
        for channel in 0..3 {
            let exact = crate::probes::matt(&sh, normal, channel);
            let found = shown(coefficients, normal, channel);
            // Both are noisy by some thousandths of the light.
            assert!(
                (found - exact).abs() < 0.02 * exact,
                "{normal:?}: {found} {exact}"
            );
        }
    }
    // Six faces a level, of which each is half as wide.
    let images = light["specularImages"].as_array().expect("levels");
    assert_eq!(
        (light["specularImageSize"].as_u64(), images.len()),
        (Some(32), 3)
    );
    let picture = |level: usize, face: usize| {
        let image = &json["images"][images[level][face].as_u64().expect("a number") as usize];
        let view = &json["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
        let number = |key: &str| view[key].as_u64().expect("a number") as usize;
        let bytes = &binary[number("byteOffset")..][..number("byteLength")];
        let image = image::load_from_memory(bytes).expect("PNG");
        assert_eq!((image.width(), image.height()), (32 >> level, 32 >> level));
        assert_eq!(image.color(), image::ColorType::Rgba8);
        image.into_bytes()
    };
    // Babylon.js looks faces up as OpenGL does, rows upward and x turned over: so the light comes from where it does.
    let value =
        |pixel: &[u8; 4]| (f64::from(pixel[1]) / 255.0).powf(2.2) * 255.0 / f64::from(pixel[3]);
    let (mut sum, mut from, mut sphere) = (0.0, [0.0; 3], 0.0);
    for face in 0..6 {
        let pixels = picture(0, face);
        for (k, pixel) in pixels.as_chunks::<4>().0.iter().enumerate() {
            let [u, v] = [k % 32, k / 32].map(|k| 2.0 * (k as f64 + 0.5) / 32.0 - 1.0);
            let v = -v;
            let [x, y, z] = match face {
                0 => [1.0, -v, -u],
                1 => [-1.0, -v, u],
                2 => [u, 1.0, v],
                3 => [u, -1.0, -v],
                4 => [u, -v, 1.0],
                _ => [-u, -v, -1.0],
            };
            let length = (1.0 + u * u + v * v).sqrt();
            let light = value(pixel) / length.powi(3);
            let toward = [-x, y, z];
            (0..3).for_each(|axis| from[axis] += light * toward[axis] / length);
            sum += light;
            sphere += length.powi(-3);
        }
        picture(1, face);
        picture(2, face);
    }
    let pi = std::f64::consts::PI;
    let mean = sh[0][1] / (4.0 * pi).sqrt();
    assert!(
        (sum / sphere - mean).abs() < 0.02 * mean,
        "{} {mean}",
        sum / sphere
    );
    for (axis, harmonic) in [(0, 3), (1, 1), (2, 2)] {
        let exact = sh[harmonic][1] / (12.0 * pi).sqrt();
        let found = from[axis] / sphere;
        assert!(
            (found - exact).abs() < 0.02 * mean,
            "{axis}: {found} {exact}"
        );
    }
}
