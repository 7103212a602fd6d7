//! The flags of probes, but for those that say where they go.

use super::common::Shining;
use super::parse::{positive, triple, whole};
use super::sky::{SkyArg, sky};
use super::values::{bounces, either, target_error, word};
use crate::error::Error;
use crate::options::Backend;
use crate::probes::{Places, ProbeOptions};
use crate::scene::Scene;
use ::bake::Bounces;
use clap::{ArgGroup, Args};
use glam::DVec3;
use rays::Light;
use std::path::PathBuf;

/// What decides the values of probes.
#[derive(Args)]
#[command(group = ArgGroup::new("asked").required(true).multiple(true))]
pub struct Job {
    /// A volume of probes so many scene units apart, which fills the box of the scene
    #[arg(help_heading = "Places")]
    #[arg(long, value_name = "D", groups = ["places", "asked"], value_parser = positive)]
    pub spacing: Option<f64>,
    /// A volume of so many probes along x, y and z, which fills the box of the scene
    #[arg(help_heading = "Places")]
    #[arg(long, value_name = "NXxNYxNZ", groups = ["places", "asked"], value_parser = counts)]
    pub grid: Option<[u32; 3]>,
    /// Probes at these places, separated by semicolons
    #[arg(help_heading = "Places")]
    #[arg(long, value_name = "X,Y,Z;..", groups = ["places", "asked"], value_delimiter = ';')]
    #[arg(allow_hyphen_values = true, value_parser = triple)]
    pub at: Vec<[f64; 3]>,
    /// Reflection maps of these places, separated by semicolons: cubes with a level for each roughness, and one for
    /// matt surfaces
    #[arg(help_heading = "Places")]
    #[arg(
        long,
        value_name = "X,Y,Z;..",
        group = "asked",
        value_delimiter = ';',
        allow_hyphen_values = true
    )]
    #[arg(value_parser = triple)]
    pub reflections: Vec<[f64; 3]>,
    /// Edge of a face of their largest level in texels: a power of two from 8 to 1024
    #[arg(help_heading = "Places", hide_short_help = true)]
    #[arg(
        long,
        value_name = "N",
        default_value_t = 256,
        requires = "reflections"
    )]
    pub reflection_size: u32,
    /// The box of the volume, by two corners [default: that of the scene]
    #[arg(help_heading = "Places")]
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", conflicts_with = "at", allow_hyphen_values = true, value_parser = corners)]
    pub within: Option<[[f64; 3]; 2]>,
    /// Take the light that surfaces reflect from the finished bake of SCENE in DIR, so that surfaces and probes agree;
    /// sky and lights are those of the bake too, unless others are given. Without it light is followed from surface to
    /// surface
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "DIR")]
    pub bake: Option<PathBuf>,
    /// Order of the harmonics: 4, 9 or 16 of them
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "L", default_value_t = 2, value_parser = whole::<u8>(1..=3))]
    pub order: u8,
    /// Rays of a probe in even directions; as many again are aimed at lamps, at lights with extent and by a mapped sky
    #[arg(help_heading = "Rays")]
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = whole::<u32>(64..=16_777_216))]
    pub rays: u32,
    /// Instead of a fixed number: the rays by which the standard error of each probe is at most E, of the light on a
    /// matt white surface, which an open sky of 1 makes 1
    #[arg(help_heading = "Rays")]
    #[arg(long, value_name = "E", value_parser = target_error, conflicts_with = "rays")]
    pub target_error: Option<f64>,
    /// With --target-error: the most rays that a probe may take
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(
        long,
        value_name = "N",
        default_value_t = 65_536,
        requires = "target_error"
    )]
    #[arg(value_parser = whole::<u32>(64..=16_777_216))]
    pub max_rays: u32,
    /// Gather every second probe of a volume along each axis, and all only where those do not tell a probe between them
    /// within E, of the light on a matt white surface, which an open sky of 1 makes 1; the others are interpolated
    #[arg(help_heading = "Places")]
    #[arg(long, value_name = "E", value_parser = positive, conflicts_with = "at")]
    pub refine: Option<f64>,
    /// Radiance of the sky, linear, as R,G,B, or an illumination map [default: 1,1,1; with --bake that of the bake]
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "R,G,B|FILE", value_parser = sky)]
    pub sky: Option<SkyArg>,
    /// How often light is reflected from surface to surface, without --bake
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = bounces)]
    pub bounces: Bounces,
    /// What to do with the lights of a glTF file (KHR_lights_punctual) [default: none; with --bake those of the bake]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_parser = either(["file", "none"], "file"))]
    pub lights: Option<bool>,
    /// Surfaces farther than this many scene units do not count [default: no limit]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "D", value_parser = positive)]
    pub max_distance: Option<f64>,
    #[command(flatten)]
    pub shining: Shining,
    /// Take so much contrast from probes that no matt surface receives less than no light: few harmonics ring beside a
    /// bright light
    #[arg(help_heading = "Files")]
    #[arg(long)]
    pub window: bool,
    /// Also keep the light of the sky, of lights and of surfaces apart
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long)]
    pub parts: bool,
    /// Random places at which interpolation between probes is tried; 0 for none
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u32>(0..=1_000_000))]
    pub tried: u32,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(help_heading = "Machine", hide_short_help = true)]
    #[arg(long, value_parser = word::<Backend>())]
    pub backend: Option<Backend>,
}

impl Job {
    /// Where probes stand.
    pub fn places(&self) -> Places {
        match (self.spacing, self.grid) {
            (Some(spacing), _) => Places::Spacing(spacing),
            (_, Some(counts)) => Places::Grid(counts),
            _ => Places::At(self.at.clone()),
        }
    }

    /// What decides the values.
    ///
    /// # Errors
    /// The sky's picture cannot be read.
    pub fn options(&self, scene: &Scene, seed: u64) -> Result<ProbeOptions, Error> {
        let mut own = self.shining.lights(DVec3::ZERO);
        if self.lights == Some(true) {
            own.extend(scene.lights.iter().map(Light::from));
        }
        Ok(ProbeOptions {
            within: self.within,
            bake: self.bake.clone(),
            sky: self.sky.as_ref().map(|sky| sky.load()).transpose()?,
            lights: (!own.is_empty() || self.lights.is_some()).then_some(own),
            bounces: self.bounces,
            max_distance: self.max_distance.map(|distance| distance as f32),
            rays: self.rays,
            target_error: self.target_error,
            max_rays: self.max_rays,
            refine: self.refine,
            order: self.order.into(),
            window: self.window,
            parts: self.parts,
            seed,
            backend: self.backend.unwrap_or_else(Backend::best),
            reflections: self.reflections.clone(),
            reflection_size: self.reflection_size,
            tried: self.tried as usize,
        })
    }
}

fn counts(text: &str) -> Result<[u32; 3], String> {
    let numbers: Result<Vec<u32>, _> = text.split(['x', ',']).map(str::parse).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if x > 0 && y > 0 && z > 0 => Ok([x, y, z]),
        _ => Err("expected three numbers from 1, such as 8x4x8".into()),
    }
}

pub fn corners(text: &str) -> Result<[[f64; 3]; 2], String> {
    let (a, b) = text
        .split_once(':')
        .ok_or("expected two corners, X,Y,Z:X,Y,Z")?;
    let (a, b) = (triple(a)?, triple(b)?);
    Ok([
        [0, 1, 2].map(|k| a[k].min(b[k])),
        [0, 1, 2].map(|k| a[k].max(b[k])),
    ])
}
