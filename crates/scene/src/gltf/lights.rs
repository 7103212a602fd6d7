//! `KHR_lights_punctual`: suns, point lights and spots, where their nodes stand.

use super::names::own_name;
use super::reader::Reader;
use crate::input::{Input, short};
use crate::{Light, LightKind, WarningKind};
use glam::{DAffine3, DVec3};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

const NAME: &str = "KHR_lights_punctual";

/// The light of a node that stands so in the world. One that cannot be read is counted and left out: a bake may not
/// need it.
pub(super) fn of(
    reader: &mut Reader,
    json: &Value,
    node: &Value,
    extensions: &Value,
    world: &DAffine3,
) -> Option<Light> {
    let extension = reader.object(extensions, NAME);
    let index = reader.index(extension, "light")?;
    let lights = json.pointer(&format!("/extensions/{NAME}/lights"));
    let input = &mut *reader.input;
    let Some(light) = lights.and_then(|lights| lights.get(index)) else {
        return left_out(input, format!("light {index}"), "is not in the file");
    };
    let name = |json: &Value| own_name(json).map(str::to_owned);
    let name = match name(light).or(name(node)) {
        Some(name) => name,
        None => format!("light {index}"),
    };
    match read(light, world) {
        Ok((kind, strength, range)) => Some(Light {
            name,
            kind,
            strength,
            range,
            position: world.translation,
            direction: -world.matrix3.z_axis.normalize(),
        }),
        Err(problem) => left_out(input, format!("light `{}`", short(&name)), problem),
    }
}

fn left_out(input: &mut Input, place: String, problem: &str) -> Option<Light> {
    let message = format!("{NAME}: the light {problem} and is left out");
    input.warn(WarningKind::IgnoredExtensions, place, 1, message);
    None
}

/// Kind, strength and range.
fn read(light: &Value, world: &DAffine3) -> Result<(LightKind, DVec3, f64), &'static str> {
    let or = |value: Option<&Value>, default: f64| match value {
        None => Some(default),
        Some(value) => value.as_f64().filter(|v| v.is_finite() && *v >= 0.0),
    };
    let channel = |i: usize| or(light.get("color").map(|color| &color[i]), 1.0);
    let (Some(r), Some(g), Some(b)) = (channel(0), channel(1), channel(2)) else {
        return Err("has a colour that is none");
    };
    let intensity =
        or(light.get("intensity"), 1.0).ok_or("has an intensity that is no number from 0 on")?;
    let range = or(light.get("range"), f64::INFINITY).filter(|range| *range > 0.0);
    let spot = &light["spot"];
    let angle = |key: &str, default: f64| or(spot.get(key), default);
    let kind = match light.get("type").and_then(Value::as_str) {
        Some("directional") => LightKind::Directional,
        Some("point") => LightKind::Point,
        Some("spot") => match (
            angle("innerConeAngle", 0.0),
            angle("outerConeAngle", FRAC_PI_4),
        ) {
            (Some(inner), Some(outer)) if inner <= outer && 0.0 < outer && outer <= FRAC_PI_2 => {
                LightKind::Spot { inner, outer }
            }
            _ => return Err("has cone angles that are none"),
        },
        _ => return Err("is of a type that is not known"),
    };
    if !(world.translation.is_finite() && world.matrix3.z_axis.try_normalize().is_some()) {
        return Err("shines nowhere, since its node has no scale");
    }
    let range = range.ok_or("has a range that is no number above 0")?;
    Ok((kind, DVec3::new(r, g, b) * intensity, range))
}
