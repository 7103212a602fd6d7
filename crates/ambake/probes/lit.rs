//! The light that probes are gathered in: what was asked for, or that of the bake.

use super::ProbeOptions;
use crate::error::Error;
use crate::options::check::{check_lights, check_sky};
use crate::{Scene, Sky};
use glam::DVec3;
use rays::{Cone, Light};
use serde_json::Value;
use std::collections::BTreeMap;

/// The light of a scene that does not come from its surfaces.
pub(super) struct Lit {
    pub sky: Sky,
    pub lights: Vec<Light>,
    /// Hashes of the bake's files, by name.
    pub hashes: BTreeMap<String, String>,
}

impl Lit {
    /// What was asked for, and what the bake had where nothing was.
    pub fn of(scene: &Scene, options: &ProbeOptions) -> Result<Self, Error> {
        let baked = match &options.bake {
            Some(dir) => match report::read_record(dir, &scene.stem()) {
                Some(record) => Some(record),
                None => Some(report::read_bake_report(&dir.join(report::REPORT_FILE))?),
            },
            None => None,
        };
        if let Some(baked) = &baked
            && baked.scene.content_hash != scene.content_hash
        {
            let problem = "the scene was changed after this bake; bake it again";
            return Err(Error::option("--bake", problem));
        }
        let known = |name: &str| baked.as_ref().and_then(|bake| bake.options.get(name));
        let sky = match (&options.sky, known("sky")) {
            (Some(sky), _) => sky.clone(),
            (None, Some(sky)) if sky.is_array() => {
                let uniform: Option<[f32; 3]> = serde_json::from_value(sky.clone()).ok();
                uniform.map(Sky::uniform).unwrap_or_default()
            }
            (None, Some(sky)) if sky.get("file").is_some() => {
                let problem = format!(
                    "the bake was lit by {}; give --sky with that file",
                    sky["file"]
                );
                return Err(Error::option("--bake", problem));
            }
            (None, Some(sky)) if sky.is_object() => {
                let problem =
                    "the bake was lit by a sky of pixels; give the same sky to the probes";
                return Err(Error::option("--bake", problem));
            }
            _ => Sky::default(),
        };
        let lights = match (&options.lights, known("lights").and_then(Value::as_array)) {
            (Some(lights), _) => lights.clone(),
            (None, Some(lights)) => lights.iter().filter_map(light_of).collect(),
            (None, None) => Vec::new(),
        };
        check_sky(&sky)?;
        check_lights(&lights)?;
        Ok(Self {
            sky,
            lights,
            hashes: baked.map(|bake| bake.hashes).unwrap_or_default(),
        })
    }
}

/// A light as the report of a bake states it.
fn light_of(value: &Value) -> Option<Light> {
    let triple = |value: &Value| -> Option<DVec3> {
        let numbers: [f64; 3] = serde_json::from_value(value.clone()).ok()?;
        Some(numbers.into())
    };
    let at = |name: &str| value.get(name).and_then(triple);
    if let Some(toward) = at("sun") {
        return Some(Light::Distant {
            toward,
            irradiance: at("irradiance")?,
        });
    }
    if let Some(position) = at("sphere") {
        return Some(Light::Sphere {
            position,
            radius: value["radius"].as_f64()?,
            radiance: at("radiance")?,
        });
    }
    if let Some(corner) = at("rect") {
        return Some(Light::Rect {
            corner,
            sides: [triple(&value["sides"][0])?, triple(&value["sides"][1])?],
            radiance: at("radiance")?,
        });
    }
    let cosines: Option<[f64; 2]> = serde_json::from_value(value["cosines"].clone()).ok();
    Some(Light::Point {
        position: at("point")?,
        intensity: at("intensity")?,
        cone: at("axis")
            .zip(cosines)
            .map(|(axis, cosines)| Cone { axis, cosines }),
        range: value["range"].as_f64().unwrap_or(f64::INFINITY),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_come_back_from_the_report_of_a_bake() {
        let spot = Light::Point {
            position: DVec3::new(1.0, 2.0, 3.0),
            intensity: DVec3::splat(4.0),
            cone: Some(Cone {
                axis: DVec3::NEG_Y,
                cosines: [0.9, 0.5],
            }),
            range: 7.0,
        };
        for light in [
            Light::sun([0.0, 2.0, 0.0], [1.0, 2.0, 3.0]),
            Light::point([1.0, 0.0, 0.0], [5.0; 3]),
            spot,
            Light::sphere([1.0, 2.0, 3.0], 0.5, [2.0; 3]),
            Light::rect([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [3.0; 3]),
        ] {
            assert_eq!(
                light_of(&crate::options::describe::described(&light)),
                Some(light)
            );
        }
    }
}
