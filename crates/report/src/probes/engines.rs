//! Probes as engines take them: volumes as three-dimensional textures, single ones as lists of numbers.

use super::{ProbeRecord, ProbeSet};
use crate::engines::{BEVY_WHITE, Shape, encode_as};
use crate::{Engine, Error, Output};
use ambient::harmonics::{COSINE, ambient_cube, basis, order_of};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A file for an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeFile {
    /// The engine, as `--for` calls it.
    pub engine: String,
    /// The file, beside the report.
    pub file: String,
    /// How to use it.
    #[serde(rename = "use")]
    pub how: String,
    /// What the engine multiplies by, so that a white surface under an open sky of 1 shows as 1.
    pub scale: f64,
    /// Middle of a volume, in the engine's axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[f64; 3]>,
    /// Its edges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 3]>,
}

/// Terms of the light E / pi as a polynomial of the normal: 1; y, z, x; xy, yz, 3z² - 1, xz, x² - y².
const TERMS: usize = 9;

/// Light beyond this is no half float.
const MOST_HALF: f64 = 65_504.0;

/// Stages the files of `engines`.
///
/// # Errors
/// An engine takes only volumes and there is none, or a file cannot be staged.
pub fn probe_files(
    output: &mut Output,
    stem: &str,
    set: &ProbeSet,
    engines: &[Engine],
) -> Result<Vec<ProbeFile>, Error> {
    let mut files: Vec<ProbeFile> = Vec::new();
    for &engine in engines {
        if files.iter().any(|file| file.engine == engine.name()) {
            continue;
        }
        let file = |name: String, how: &str| ProbeFile {
            engine: engine.name().into(),
            file: name,
            how: how.into(),
            scale: 1.0,
            center: None,
            size: None,
        };
        let as_volume = |file: ProbeFile| {
            let grid = set.report.grid.as_ref();
            let size = grid.map(|grid| [0, 1, 2].map(|k| grid.cell[k] * f64::from(grid.counts[k])));
            ProbeFile {
                center: size
                    .zip(grid)
                    .map(|(size, grid)| [0, 1, 2].map(|k| grid.low[k] + 0.5 * size[k])),
                size,
                ..file
            }
        };
        match engine {
            // Places alone make no volume; who asked for cubes gets these.
            Engine::Bevy if set.report.grid.is_none() && !set.reflections.is_empty() => {}
            Engine::Bevy => {
                let name = format!("{stem}.probes.bevy.ktx2");
                output.stage_bytes(&name, &bevy(set, &name)?)?;
                files.push(as_volume(ProbeFile {
                    scale: BEVY_WHITE,
                    ..file(
                        name,
                        "Load it as the voxels of an IrradianceVolume with scale as its intensity, and spawn that \
                         with a LightProbe and a Transform whose translation is center and whose scale is size. \
                         Sample the texture with linear filters.",
                    )
                }));
            }
            Engine::Three => {
                let name = format!("{stem}.probes.three.json");
                output.stage_bytes(&name, &pretty(&three(set)))?;
                files.push(file(
                    name,
                    "An array of LightProbe objects; new THREE.LightProbe().fromJSON(probe.object) makes one.",
                ));
                if set.report.grid.is_some() {
                    let name = format!("{stem}.probes.three.ktx2");
                    output.stage_bytes(&name, &polynomials(set, &name)?)?;
                    files.push(as_volume(file(
                        name,
                        "A volume of nine slabs along z for the shader in the file that ends in probes.glsl.",
                    )));
                    let name = format!("{stem}.probes.glsl");
                    output.stage_bytes(&name, include_bytes!("volume.glsl"))?;
                    files.push(file(
                        name,
                        "GLSL for the volume: multiply what ambake_light returns by the albedo.",
                    ));
                }
            }
            Engine::Unity => {
                let name = format!("{stem}.probes.unity.json");
                output.stage_bytes(&name, &pretty(&unity(set)))?;
                files.push(file(
                    name,
                    "Positions and coefficients of SphericalHarmonicsL2 in its order, red first, with x turned over \
                     as Unity's importers do. Put positions into a LightProbeGroup, and the coefficients into \
                     LightmapSettings.lightProbes.bakedProbes.",
                ));
            }
            Engine::Godot => {
                let name = format!("{stem}.probes.tscn");
                output.stage_bytes(&name, godot(set).as_bytes())?;
                files.push(file(
                    name,
                    "A scene of LightmapProbe nodes at the probes' places. Godot bakes their light itself: the data \
                     of LightmapGI can only be made in its editor.",
                ));
            }
            // They take the pictures of reflections.
            Engine::Gltf | Engine::Blender if !set.reflections.is_empty() => {}
            Engine::Gltf | Engine::Blender => {
                let problem = "it takes reflection maps and no probes; add --reflections X,Y,Z, or take bevy, \
                               godot, three or unity";
                return Err(refused(&format!("--for {}", engine.name()), problem));
            }
            Engine::Unreal => {
                let problem = "takes no probes from files; there are bevy, godot, three and unity";
                return Err(refused(&format!("--for {}", engine.name()), problem));
            }
        }
    }
    Ok(files)
}

fn refused(name: &str, problem: &str) -> Error {
    Error::Mismatched {
        option: name.into(),
        problem: problem.into(),
    }
}

fn pretty(value: &Value) -> Vec<u8> {
    value.to_string().replace("},", "},\n").into_bytes()
}

/// Coefficients of the light E / pi as a polynomial of the normal, by [`TERMS`], from those of the radiance.
pub(crate) fn polynomial(light: &[DVec3]) -> [DVec3; TERMS] {
    // Where each harmonic's polynomial has a value that tells its constant, and that value.
    let root = 0.5f64.sqrt();
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let diagonal = |a: DVec3, b: DVec3| (a + b) * root;
    let at = [
        (z, 1.0),
        (y, 1.0),
        (z, 1.0),
        (x, 1.0),
        (diagonal(x, y), 0.5),
        (diagonal(y, z), 0.5),
        (z, 2.0),
        (diagonal(x, z), 0.5),
        (x, 1.0),
    ];
    std::array::from_fn(|k| {
        let (direction, value) = at[k];
        let factor = basis(direction)[k] / value * COSINE[order_of(k)];
        light.get(k).map_or(DVec3::ZERO, |rgb| *rgb * factor)
    })
}

/// The texture of Bevy's `IrradianceVolume`: (Rx, 2 Ry, 3 Rz) texels, the ambient cube's x, y and z sides one after
/// another along z, and of each the positive side below the negative one along y. So Bevy's shader reads it; the table
/// in its documentation has the signs the other way round.
fn bevy(set: &ProbeSet, name: &str) -> Result<Vec<u8>, Error> {
    let [nx, ny, nz] = counts(set, name)?;
    let cubes: Vec<[DVec3; 6]> = set.filled.iter().map(|light| ambient_cube(light)).collect();
    let mut texels = Vec::with_capacity(6 * cubes.len());
    for axis in 0..3 {
        for z in 0..nz {
            for sign in 0..2 {
                for y in 0..ny {
                    let row = (z * ny + y) * nx;
                    let sides = cubes[row..row + nx]
                        .iter()
                        .map(|cube| cube[2 * axis + sign]);
                    texels.extend(sides.map(|side| side.max(DVec3::ZERO)));
                }
            }
        }
    }
    Ok(texture([nx, 2 * ny, 3 * nz], &texels))
}

/// A volume of the polynomial's coefficients, one after another along z.
fn polynomials(set: &ProbeSet, name: &str) -> Result<Vec<u8>, Error> {
    let [nx, ny, nz] = counts(set, name)?;
    let of: Vec<[DVec3; TERMS]> = set.filled.iter().map(|light| polynomial(light)).collect();
    let texels: Vec<DVec3> = (0..TERMS)
        .flat_map(|k| of.iter().map(move |of| of[k]))
        .collect();
    Ok(texture([nx, ny, TERMS * nz], &texels))
}

/// A KTX2 volume of half floats. Its columns, rows and slices run along the scene's x, y and z.
fn texture(extent: [usize; 3], texels: &[DVec3]) -> Vec<u8> {
    let limit = DVec3::splat(MOST_HALF);
    let texels: Vec<[f32; 3]> = texels
        .iter()
        .map(|value| value.clamp(-limit, limit).as_vec3().to_array())
        .collect();
    let shape = Shape {
        extent: extent.map(|n| n as u32),
        layers: 0,
        faces: 1,
        orientation: "ruo",
    };
    encode_as(&shape, &[&texels])
}

/// How many probes a volume has along each axis.
fn counts(set: &ProbeSet, name: &str) -> Result<[usize; 3], Error> {
    match &set.report.grid {
        Some(grid) => Ok(grid.counts.map(|n| n as usize)),
        None => Err(refused(
            name,
            "it is a volume, and --at makes none; give --spacing or --grid",
        )),
    }
}

/// The probes of files that list them one by one: an engine finds the light between them itself.
fn gathered(set: &ProbeSet) -> impl Iterator<Item = (&ProbeRecord, &Vec<DVec3>)> {
    let probes = set.report.probes.iter().zip(&set.filled);
    probes.filter(|(probe, _)| !probe.interpolated)
}

/// Objects of three.js, whose harmonics are those of the report; it shades them with all nine.
fn three(set: &ProbeSet) -> Value {
    gathered(set)
        .map(|(probe, light)| {
            let first = light.iter().take(TERMS);
            let mut sh: Vec<f32> = first.flat_map(|rgb| rgb.as_vec3().to_array()).collect();
            sh.resize(3 * TERMS, 0.0);
            let [x, y, z] = probe.asked.unwrap_or(probe.position);
            json!({
                "metadata": { "version": 4.6, "type": "Object", "generator": "ambake" },
                "object": {
                    "type": "LightProbe", "intensity": 1, "sh": sh,
                    "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1],
                },
            })
        })
        .collect()
}

/// Harmonics of Unity: E / pi as a polynomial, by channel, in axes whose x runs the other way.
fn unity(set: &ProbeSet) -> Value {
    gathered(set)
        .map(|(probe, light)| {
            let mut terms = polynomial(light);
            // Those that are odd in x.
            for k in [3, 4, 7] {
                terms[k] = -terms[k];
            }
            let [x, y, z] = probe.asked.unwrap_or(probe.position);
            let coefficients: Vec<f32> = (0..3)
                .flat_map(|c| terms.iter().map(move |term| term[c] as f32))
                .collect();
            json!({ "position": [-x, y, z], "coefficients": coefficients })
        })
        .collect()
}

/// A Godot scene of nodes at the probes' places.
fn godot(set: &ProbeSet) -> String {
    let mut text = "[gd_scene format=3]\n\n[node name=\"Probes\" type=\"Node3D\"]\n".to_owned();
    let in_air = gathered(set).filter(|(probe, _)| !probe.invalid);
    for (number, (probe, _)) in in_air.enumerate() {
        let [x, y, z] = probe.position;
        text += &format!(
            "\n[node name=\"Probe{number}\" type=\"LightmapProbe\" parent=\".\"]\n\
             transform = Transform3D(1, 0, 0, 0, 1, 0, 0, 0, 1, {x}, {y}, {z})\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambient::harmonics::matt;

    #[test]
    fn the_polynomial_is_the_light_of_the_harmonics() {
        let light: Vec<DVec3> = (0..16)
            .map(|k| DVec3::new(1.0 + f64::from(k), -0.5 * f64::from(k), 2.0))
            .collect();
        let terms = polynomial(&light);
        for n in [
            DVec3::X,
            DVec3::new(0.48, -0.6, 0.64),
            DVec3::new(-0.6, 0.0, -0.8),
        ] {
            let (x, y, z) = (n.x, n.y, n.z);
            let values = [
                1.0,
                y,
                z,
                x,
                x * y,
                y * z,
                3.0 * z * z - 1.0,
                x * z,
                x * x - y * y,
            ];
            let found: DVec3 = terms.iter().zip(values).map(|(t, v)| *t * v).sum();
            let exact = matt(&light, n);
            assert!(
                (found - exact).length() < 1e-12,
                "{n}: {found}, not {exact}"
            );
        }
    }
}
