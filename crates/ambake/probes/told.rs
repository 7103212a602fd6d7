//! What the report says of probes.

use super::lit::Lit;
use super::{Places, ProbeOptions};
use crate::Bounces;
use ::probes::{Placed, Reflection, State};
use ambient::harmonics::window;
use glam::DVec3;
use report::{ProbeRecord, ReflectionLevel, ReflectionMaps, ReflectionReport};
use serde_json::{Value, json};
use std::path::Path;

pub(super) fn record(
    placed: &Placed,
    strength: Option<f64>,
    options: &ProbeOptions,
    origin: DVec3,
) -> ProbeRecord {
    let probe = &placed.probe;
    let mut light = probe.light.clone();
    if options.window {
        window(&mut light);
    }
    let part = |number: usize| match options.parts {
        true => super::rgb(&probe.parts[number]),
        false => Vec::new(),
    };
    let moved = placed.state == State::Moved;
    ProbeRecord {
        position: (probe.place + origin).to_array(),
        asked: moved.then(|| (placed.asked + origin).to_array()),
        invalid: placed.state == State::Invalid,
        interpolated: placed.state == State::Between,
        validity: probe.validity as f32,
        rays: probe.rays,
        sh: super::rgb(&light),
        std_err: super::rgb(&probe.std_err),
        sky: part(0),
        lights: part(1),
        surfaces: part(2),
        window: strength,
    }
}

/// What is said of reflection maps.
pub(super) fn reflection(
    stem: &str,
    number: usize,
    of: &Reflection,
    origin: DVec3,
) -> ReflectionReport {
    let [east, west, up, down, south, north] = of.walls;
    let (low, high) = (DVec3::new(west, down, north), DVec3::new(east, up, south));
    let level = |level: &::probes::Level| ReflectionLevel {
        size: level.image.width,
        roughness: level.roughness,
        error: level.error,
    };
    let place = of.place + origin;
    ReflectionReport {
        place: place.to_array(),
        specular: format!("{stem}.reflection.{number}.specular.ktx2"),
        levels: of.levels.iter().map(level).collect(),
        diffuse: format!("{stem}.reflection.{number}.diffuse.ktx2"),
        diffuse_error: of.diffuse.error,
        room: (low + high)
            .is_finite()
            .then(|| [(place - low).to_array(), (place + high).to_array()]),
    }
}

pub(super) fn pictures(of: Reflection) -> ReflectionMaps {
    ReflectionMaps {
        levels: of.levels.into_iter().map(|level| level.image).collect(),
        diffuse: of.diffuse.image,
    }
}

pub(super) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

pub(super) fn describe(places: &Places, options: &ProbeOptions, light: &Lit) -> Value {
    let lights: Vec<Value> = light
        .lights
        .iter()
        .map(crate::options::describe::described)
        .collect();
    json!({
        "spacing": match places { Places::Spacing(spacing) => Some(spacing), _ => None },
        "grid": match places { Places::Grid(counts) => Some(counts), _ => None },
        "at": match places { Places::At(places) => Some(places), _ => None },
        "within": options.within,
        "bake": options.bake.as_deref().map(file_name),
        "sky": light.sky,
        "lights": lights,
        "bounces": match options.bounces {
            Bounces::Off => json!(0),
            Bounces::Auto => json!("auto"),
            Bounces::Most(count) => json!(count),
        },
        "max_distance": options.max_distance,
        "rays": options.target_error.is_none().then_some(options.rays),
        "target_error": options.target_error,
        "max_rays": options.target_error.is_some().then_some(options.max_rays),
        "refine": options.refine,
        "order": options.order,
        "window": options.window,
        "parts": options.parts,
        "reflections": options.reflections,
        "reflection_size": options.reflection_size,
        "seed": options.seed,
        "tried": options.tried,
    })
}
