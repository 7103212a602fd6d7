//! Files of reflection maps: cubes with a level for each roughness, and the captured light as other tools take it.

use super::engines::ProbeFile;
use super::{ProbeSet, image_based};
use crate::engines::{BEVY_WHITE, Shape, encode_as};
use crate::{Engine, Error, Output};
use environment::{
    Format, IlluminationMap, Image, Labels, MapLayout, Orientation, Projection, convert_image,
    encode,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What is said of the reflection maps of a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReflectionReport {
    /// Where.
    pub place: [f64; 3],
    /// The cube of glossy surfaces, a KTX2 file; its faces as OpenGL's.
    pub specular: String,
    /// Its levels.
    pub levels: Vec<ReflectionLevel>,
    /// The cube of matt surfaces, E / pi.
    pub diffuse: String,
    /// Standard error of that.
    pub diffuse_error: f64,
    /// Least and largest corner of the box that surfaces make around the place, along the axes, for box projection;
    /// `None` where a side is open.
    pub room: Option<[[f64; 3]; 2]>,
}

/// A level of a cube.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReflectionLevel {
    /// Edge of a face in texels.
    pub size: usize,
    /// GGX roughness, 0 for a mirror.
    pub roughness: f64,
    /// Standard error of its values, root mean square.
    pub error: f64,
}

/// Stages the cubes, and the pictures for engines that filter by themselves.
pub(super) fn stage(
    output: &mut Output,
    stem: &str,
    set: &ProbeSet,
    engines: &[Engine],
) -> Result<Vec<ProbeFile>, Error> {
    let mut files: Vec<ProbeFile> = Vec::new();
    for (number, (maps, report)) in set
        .reflections
        .iter()
        .zip(&set.report.reflections)
        .enumerate()
    {
        let same = |image: &Image| image.clone();
        let matt = std::slice::from_ref(&maps.diffuse);
        output.stage_bytes(&report.specular, &cube(&maps.levels, same))?;
        output.stage_bytes(&report.diffuse, &cube(matt, same))?;
        for (at, engine) in engines.iter().enumerate() {
            if engines[..at].contains(engine) {
                continue;
            }
            let mut add = |file: String, how: &str, scale: f64, bytes: Vec<u8>| {
                output.stage_bytes(&file, &bytes)?;
                files.push(ProbeFile {
                    engine: engine.name().into(),
                    file,
                    how: how.into(),
                    scale,
                    center: Some(report.place),
                    size: None,
                });
                Ok::<(), Error>(())
            };
            let orientation = match engine {
                Engine::Bevy => {
                    let how =
                        "The specular_map of an EnvironmentMapLight with scale as its intensity.";
                    let name = format!("{stem}.reflection.{number}.bevy.specular.ktx2");
                    add(name, how, BEVY_WHITE, cube(&maps.levels, turned))?;
                    let how = "The diffuse_map of that EnvironmentMapLight.";
                    let name = format!("{stem}.reflection.{number}.bevy.diffuse.ktx2");
                    add(name, how, BEVY_WHITE, cube(matt, turned))?;
                    continue;
                }
                Engine::Three => Orientation::Three,
                Engine::Gltf => Orientation::Gltf,
                Engine::Blender => Orientation::Blender,
                _ => continue,
            };
            if *engine == Engine::Gltf {
                let name = format!("{stem}.reflection.{number}.glb");
                let light = format!("{stem}.reflection.{number}");
                let glb = image_based::lit(set.glb.as_deref(), maps, &light);
                let bytes = glb.ok_or_else(|| too_large(&name))?;
                let how = "The scene with the light of this place, by EXT_lights_image_based, which Babylon.js reads.";
                add(name, how, 1.0, bytes)?;
            }
            let name = format!("{stem}.reflection.{number}.{}.exr", engine.name());
            let how = "A polar picture of what a mirror shows; the engine filters it by itself.";
            let bytes = polar(&maps.levels[0], orientation, &name)?;
            add(name, how, 1.0, bytes)?;
        }
    }
    Ok(files)
}

fn too_large(name: &str) -> Error {
    let reason = "it would be over the 4 GiB of its format";
    Error::write(Path::new(name), std::io::Error::other(reason))
}

/// A KTX2 cube with its levels, each as `shown`.
fn cube(levels: &[Image], shown: impl Fn(&Image) -> Image) -> Vec<u8> {
    let most = half::f16::MAX.to_f32();
    let clamped = |image: &Image| -> Vec<[f32; 3]> {
        let pixels = shown(image).pixels;
        pixels
            .iter()
            .map(|p| p.map(|v| v.clamp(0.0, most)))
            .collect()
    };
    let pixels: Vec<Vec<[f32; 3]>> = levels.iter().map(clamped).collect();
    let edge = levels[0].width as u32;
    let shape = Shape {
        extent: [edge, edge, 0],
        layers: 0,
        faces: 6,
        orientation: "rd",
    };
    let levels: Vec<&[[f32; 3]]> = pixels.iter().map(|pixels| &pixels[..]).collect();
    encode_as(&shape, &levels)
}

/// The cube that Bevy looks up with z reversed.
fn turned(image: &Image) -> Image {
    let size = (image.width, image.height);
    let Ok(map) = IlluminationMap::new(image.clone(), Projection::Cube) else {
        return image.clone();
    };
    let texel = |texel: usize| {
        let (x, y) = (texel % size.0, texel / size.0);
        let direction = Projection::Cube.direction(size, x as f64 + 0.5, y as f64 + 0.5);
        let [x, y, z] = direction.unwrap_or_default();
        map.nearest([x, y, -z])
    };
    Image {
        pixels: (0..size.0 * size.1).map(texel).collect(),
        ..image.clone()
    }
}

/// The captured light as a polar picture in a tool's axes.
fn polar(image: &Image, orientation: Orientation, name: &str) -> Result<Vec<u8>, Error> {
    let from = MapLayout {
        projection: Projection::Cube,
        orientation: Orientation::Ambake,
        size: (image.width, image.height),
    };
    let to = MapLayout {
        projection: Projection::Polar,
        orientation,
        size: Projection::Polar.size(4 * image.width),
    };
    let labels = Labels::from([
        ("ambakeProjection".into(), to.projection.name().into()),
        ("ambakeOrientation".into(), orientation.name().into()),
    ]);
    let made = convert_image(image, from, to);
    let bytes = made.and_then(|image| encode(&image, Format::Exr, &labels));
    bytes.map_err(|error| Error::write(Path::new(name), std::io::Error::other(error.to_string())))
}
