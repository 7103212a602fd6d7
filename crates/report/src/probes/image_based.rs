//! `EXT_lights_image_based`: the light of a place as the light of a glTF scene.
//!
//! The specification names neither the sign of its harmonics nor the axes of its cube. These are those of Babylon.js in
//! its default scene, whose authors wrote the specification: the x axis is turned over, rows of faces run upward, and
//! harmonics have the sign (-1)^m. So its harmonics of x keep their sign, and those that are odd in y change it.

use super::ReflectionMaps;
use crate::engines::{parts, whole};
use crate::preview::encode;
use ambient::harmonics::{COSINE, basis, order_of};
use environment::{Image, Projection};
use glam::DVec3;
use png::ColorType;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

const NAME: &str = "EXT_lights_image_based";

/// Harmonics of the extension.
const TERMS: usize = 9;

/// Those that are odd in y.
const ODD: [usize; 3] = [1, 4, 5];

/// The power by which colours of RGBD are stored.
const GAMMA: f32 = 2.2;

/// A GLB with the light of a place in all of its scenes; without one, a scene that holds the light alone. `None` past
/// the format's 4 GiB, or where `glb` is none.
pub(super) fn lit(glb: Option<&[u8]>, maps: &ReflectionMaps, name: &str) -> Option<Vec<u8>> {
    let (mut json, mut bin) = match glb {
        Some(glb) => parts(glb)?,
        None => {
            let asset = json!({ "version": "2.0", "generator": "ambake" });
            let json = json!({ "asset": asset, "scene": 0, "scenes": [{}], "buffers": [{}] });
            (json, Vec::new())
        }
    };
    let images: Option<Vec<Vec<usize>>> = (maps.levels.iter().enumerate())
        .map(|(level, image)| {
            let face = |face: usize| {
                let name = format!("{name}.{level}.{face}");
                embed(&mut json, &mut bin, &name, &face_png(image, face))
            };
            (0..6).map(face).collect()
        })
        .collect();
    let light = json!({
        "name": name,
        "intensity": 1.0,
        "irradianceCoefficients": irradiance(&maps.levels[0]),
        "specularImageSize": maps.levels[0].width,
        "specularImages": images?,
    });
    let root = json.as_object_mut()?;
    let lights = extension(root)?
        .entry("lights")
        .or_insert_with(|| json!([]));
    let lights = lights.as_array_mut()?;
    lights.push(light);
    let number = lights.len() - 1;
    let used = root.entry("extensionsUsed").or_insert_with(|| json!([]));
    let used = used.as_array_mut()?;
    if !used.contains(&NAME.into()) {
        used.push(NAME.into());
    }
    for scene in root.get_mut("scenes")?.as_array_mut()? {
        extension(scene.as_object_mut()?)?.insert("light".into(), number.into());
    }
    whole(&mut json, &bin)
}

/// The extension's own object in an object's `extensions`, made where it is absent.
fn extension(of: &mut Map<String, Value>) -> Option<&mut Map<String, Value>> {
    let all = of.entry("extensions").or_insert_with(|| json!({}));
    let own = all
        .as_object_mut()?
        .entry(NAME)
        .or_insert_with(|| json!({}));
    own.as_object_mut()
}

/// Puts a picture into the binary part; its number.
fn embed(json: &mut Value, bin: &mut Vec<u8>, name: &str, png: &[u8]) -> Option<usize> {
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": png.len() });
    bin.extend(png);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut push = |list: &str, value: Value| {
        let list = json
            .as_object_mut()?
            .entry(list)
            .or_insert_with(|| json!([]));
        let list = list.as_array_mut()?;
        list.push(value);
        Some(list.len() - 1)
    };
    let view = push("bufferViews", view)?;
    let image = json!({ "name": name, "mimeType": "image/png", "bufferView": view });
    push("images", image)
}

/// A face of the extension's cube from one as OpenGL lays it out, as RGBD: linear colour is what is stored to the power
/// of 2.2, divided by alpha.
fn face_png(cube: &Image, face: usize) -> Vec<u8> {
    // Turning x over changes the faces of x with each other and mirrors all; their rows are turned over too.
    let source = [1, 0, 2, 3, 4, 5][face];
    let edge = cube.width;
    let pixels = &cube.pixels[source * edge * edge..(source + 1) * edge * edge];
    let bytes: Vec<u8> = pixels.iter().rev().flat_map(|rgb| rgbd(*rgb)).collect();
    encode([edge as u32; 2], ColorType::Rgba, &bytes, None)
}

/// What is brighter than 255 is cut.
fn rgbd(rgb: [f32; 3]) -> [u8; 4] {
    let most = rgb.into_iter().fold(1.0, f32::max);
    let alpha = (255.0 / most).floor().max(1.0);
    let byte = |value: f32| {
        let share = (value.max(0.0) * alpha / 255.0).min(1.0);
        (255.0 * share.powf(1.0 / GAMMA)).round() as u8
    };
    let [r, g, b] = rgb.map(byte);
    [r, g, b, alpha as u8]
}

/// Coefficients of the irradiance that a cube sheds on a place.
fn irradiance(cube: &Image) -> [[f32; 3]; TERMS] {
    let size = (cube.width, cube.height);
    let mut sums = [DVec3::ZERO; TERMS];
    let mut sphere = 0.0;
    for (texel, rgb) in cube.pixels.iter().enumerate() {
        let (x, y) = (texel % size.0, texel / size.0);
        let toward = Projection::Cube.direction(size, x as f64 + 0.5, y as f64 + 0.5);
        let toward = DVec3::from(toward.unwrap_or_default());
        // Solid angle of a texel, but for a factor: the third power of the cosine to the middle of its face.
        let angle = toward.abs().max_element().powi(3);
        sphere += angle;
        let light = DVec3::from(rgb.map(f64::from)) * angle;
        for (sum, basis) in sums.iter_mut().zip(basis(toward)) {
            *sum += light * basis;
        }
    }
    std::array::from_fn(|k| {
        let sign = if ODD.contains(&k) { -1.0 } else { 1.0 };
        let factor = sign * PI * COSINE[order_of(k)] * 4.0 * PI / sphere;
        (sums[k] * factor).as_vec3().to_array()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube whose radiance is this function of the direction.
    fn cube(edge: usize, radiance: impl Fn([f64; 3]) -> f64) -> Image {
        let size = (edge, 6 * edge);
        let texel = |texel: usize| {
            let (x, y) = ((texel % edge) as f64 + 0.5, (texel / edge) as f64 + 0.5);
            [radiance(Projection::Cube.direction(size, x, y).unwrap()) as f32; 3]
        };
        Image {
            width: edge,
            height: 6 * edge,
            pixels: (0..6 * edge * edge).map(texel).collect(),
        }
    }

    #[test]
    fn coefficients_are_those_of_irradiance_in_the_signs_of_the_reader() {
        // On paper: E of 1 + x + 2 y + 3 z is pi (1 + 2/3 (x + 2 y + 3 z)), and E of x y is pi/4 x y.
        let found = irradiance(&cube(64, |[x, y, z]| 1.0 + x + 2.0 * y + 3.0 * z + x * y));
        let first = 2.0 * PI / 3.0 * (4.0 * PI / 3.0).sqrt();
        let second = PI / 4.0 * (4.0 * PI / 15.0).sqrt();
        let exact = [
            PI * (4.0 * PI).sqrt(),
            -2.0 * first,
            3.0 * first,
            first,
            -second,
            0.0,
            0.0,
            0.0,
            0.0,
        ];
        for (k, (found, exact)) in found.iter().zip(exact).enumerate() {
            // The middle of a texel stands for all of it: a share of 1/64² of the light.
            assert!(
                (f64::from(found[0]) - exact).abs() < 3e-3,
                "{k}: {found:?}, not {exact}"
            );
        }
    }

    #[test]
    fn bright_colours_come_back_from_rgbd() {
        for rgb in [[0.0, 0.2, 1.0], [0.5, 3.0, 7.0], [200.0, 0.1, 90.0]] {
            let stored = rgbd(rgb);
            for (value, byte) in rgb.into_iter().zip(stored) {
                let decode = |byte: f32| (byte / 255.0).powf(GAMMA) * 255.0 / f32::from(stored[3]);
                let byte = f32::from(byte);
                let near = decode(byte - 0.51).min(value) <= value && value <= decode(byte + 0.51);
                assert!(near, "{value}: {stored:?}");
            }
        }
    }

    #[test]
    fn a_scene_keeps_what_it_has_and_gets_the_light() {
        let maps = ReflectionMaps {
            levels: vec![cube(16, |_| 2.0), cube(8, |_| 2.0)],
            diffuse: cube(8, |_| 2.0),
        };
        let alone = lit(None, &maps, "light").unwrap();
        let (json, _) = parts(&alone).unwrap();
        assert_eq!(json["images"].as_array().unwrap().len(), 12);
        // A second one comes beside the first, and the scene shows it.
        let both = lit(Some(&alone), &maps, "other").unwrap();
        let (json, _) = parts(&both).unwrap();
        let lights = json["extensions"][NAME]["lights"].as_array().unwrap();
        assert_eq!(
            (lights.len(), json["images"].as_array().unwrap().len()),
            (2, 24)
        );
        assert_eq!(json["scenes"][0]["extensions"][NAME]["light"], 1);
        assert_eq!(json["extensionsUsed"], json!([NAME]));
    }
}
