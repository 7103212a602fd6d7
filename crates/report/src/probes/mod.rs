//! Files of probes: `STEM.probes.json` says all of them, the others hold the same numbers as pictures and for engines.

mod engines;
mod image_based;
mod reflections;

pub(crate) use engines::polynomial;
pub use engines::{ProbeFile, probe_files};
pub use reflections::{ReflectionLevel, ReflectionReport};

use crate::{Engine, Error, Output, PageHeader, check_regular, write_page_exr};
use ambient::harmonics::count;
use environment::Image;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// Version of [`ProbeReport`]: it grows when a field changes its meaning or goes.
pub const PROBES_SCHEMA: u32 = 1;

/// Everything about the probes of a scene: `STEM.probes.json`. Places are in the coordinates of the scene's file, light
/// is linear RGB.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeReport {
    /// [`PROBES_SCHEMA`].
    pub schema_version: u32,
    /// ambake's version.
    pub version: String,
    /// Name of the scene's file.
    pub scene: String,
    /// Its hash.
    pub scene_hash: String,
    /// What was asked for.
    pub options: Value,
    /// Order of the harmonics.
    pub order: usize,
    /// What the coefficients are of, and which functions they belong to.
    pub convention: String,
    /// Where the probes of a volume stand; their order is x, then y, then z.
    pub grid: Option<ProbeGrid>,
    /// What a look-up between probes of the volume costs.
    pub interpolation: Option<InterpolationReport>,
    /// Distances are cut here, in scene units.
    pub reach: f64,
    /// Files for engines.
    pub files: Vec<ProbeFile>,
    /// Maps of places for what is no matt surface.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reflections: Vec<ReflectionReport>,
    /// The probes.
    pub probes: Vec<ProbeRecord>,
}

impl ProbeReport {
    /// The coefficients of each probe.
    pub fn lights(&self) -> impl Iterator<Item = Vec<DVec3>> {
        let of = |probe: &ProbeRecord| {
            probe
                .sh
                .iter()
                .map(|rgb| DVec3::from(rgb.map(f64::from)))
                .collect()
        };
        self.probes.iter().map(of)
    }
}

/// A grid of probes, each in the middle of its cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProbeGrid {
    /// The corner with the least coordinates.
    pub low: [f64; 3],
    /// Edges of a cell.
    pub cell: [f64; 3],
    /// Cells along x, y and z.
    pub counts: [u32; 3],
}

/// What linear interpolation between probes misses of the light E / pi at random places in the air, all normals
/// together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InterpolationReport {
    /// Places that were looked at.
    pub places: usize,
    /// Mean light of the probes.
    pub mean: f64,
    /// Root mean square of what is missed.
    pub rms: f64,
    /// One place in a hundred misses more.
    pub p99: f64,
    /// What of the root mean square is the standard error of the probes themselves.
    pub noise: f64,
}

/// A probe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeRecord {
    /// Where its light was gathered.
    pub position: [f64; 3],
    /// Where it was asked for, if that is somewhere else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<[f64; 3]>,
    /// True for one in a solid or behind surfaces: its light is that of no air.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub invalid: bool,
    /// True for one whose light is that of the probes around it: nothing was gathered there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub interpolated: bool,
    /// Share of the directions that meet no back of a surface; 0 in a solid.
    pub validity: f32,
    /// Rays in even directions.
    pub rays: u32,
    /// Coefficients of the light.
    pub sh: Vec<[f32; 3]>,
    /// One standard error of each.
    pub std_err: Vec<[f32; 3]>,
    /// The part of the sky, where parts were asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sky: Vec<[f32; 3]>,
    /// The part of lights that no ray meets.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<[f32; 3]>,
    /// The part of surfaces, which shine or reflect.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<[f32; 3]>,
    /// Strength of the window that took the ringing, 0 for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<f64>,
}

/// What the files of probes are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeSet {
    /// What is said of them.
    pub report: ProbeReport,
    /// Coefficients of each probe for engines, invalid ones filled from their neighbours.
    pub filled: Vec<Vec<DVec3>>,
    /// Mean distance and its square of each probe: an octahedron, row by row.
    pub distance: Vec<Vec<[f32; 2]>>,
    /// The pictures of [`ProbeReport::reflections`].
    pub reflections: Vec<ReflectionMaps>,
    /// The scene for files that hold it with its light; without one they hold the light alone.
    pub glb: Option<Vec<u8>>,
}

/// The pictures of a place: six faces below each other, +x -x +y -y +z -z.
#[derive(Debug, Clone, PartialEq)]
pub struct ReflectionMaps {
    /// By level.
    pub levels: Vec<Image>,
    /// Of matt surfaces.
    pub diffuse: Image,
}

/// The name of the report.
pub fn probe_file(stem: &str) -> String {
    format!("{stem}.probes.json")
}

/// Stages the files of probes, those for engines among them; the report comes last.
///
/// # Errors
/// A number is not finite, an engine takes only volumes, or a file cannot be staged.
pub fn stage_probes(
    output: &mut Output,
    stem: &str,
    set: &mut ProbeSet,
    engines: &[Engine],
) -> Result<(), Error> {
    let header = PageHeader {
        version: set.report.version.clone(),
        options: set.report.options.to_string(),
        convention: set.report.convention.clone(),
        scene_hash: set.report.scene_hash.clone(),
        ..PageHeader::default()
    };
    set.report.files.clear();
    if !set.report.probes.is_empty() {
        stage_pictures(output, stem, set, &header)?;
        set.report.files = probe_files(output, stem, set, engines)?;
    }
    let files = reflections::stage(output, stem, set, engines)?;
    set.report.files.extend(files);
    let text =
        serde_json::to_string(&set.report).map_err(|e| Error::write(Path::new(""), e.into()))?;
    // A probe a line: the file can be read, and compared, and is half as large as one that is indented.
    let text = text.replace("{\"position\"", "\n{\"position\"") + "\n";
    output.stage_bytes(&probe_file(stem), text.as_bytes())
}

/// The probes that a file holds.
///
/// # Errors
/// It is absent or holds something else.
pub fn read_probes(path: &Path) -> Result<ProbeReport, Error> {
    check_regular(path).map_err(|e| Error::read(path, e.to_string()))?;
    let text = std::fs::read_to_string(path).map_err(|e| Error::read(path, e.to_string()))?;
    serde_json::from_str(&text)
        .map_err(|e| Error::read(path, format!("{e}; make the probes again")))
}

/// Edge of the smallest square of so many texels.
fn edge(count: usize) -> usize {
    (count as f64).sqrt().ceil() as usize
}

/// Stages the pictures of the probes' numbers.
fn stage_pictures(
    output: &mut Output,
    stem: &str,
    set: &ProbeSet,
    header: &PageHeader,
) -> Result<(), Error> {
    stage_picture(output, &format!("{stem}.probes.exr"), &planes(set), header)?;
    let header = PageHeader {
        convention: "mean distance of surfaces in scene units, and the mean of its square; octahedrons, +z in the \
            middle, y upward".into(),
        ..header.clone()
    };
    let name = format!("{stem}.probes.distance.exr");
    stage_picture(output, &name, &distances(set), &header)
}

/// A channel of a square picture.
type Plane = (String, Vec<f32>);

fn stage_picture(
    output: &mut Output,
    name: &str,
    planes: &[Plane],
    header: &PageHeader,
) -> Result<(), Error> {
    let size = edge(planes[0].1.len()) as u32;
    let channels: Vec<(String, &[f32])> = planes
        .iter()
        .map(|(name, values)| (name.clone(), &values[..]))
        .collect();
    output.stage(name, |file| write_page_exr(file, size, &channels, header))
}

/// A texel a probe, row by row; those after the last probe are 0.
fn planes(set: &ProbeSet) -> Vec<Plane> {
    let probes = &set.report.probes;
    let texels = edge(probes.len()).pow(2);
    let plane = |name: String, of: &dyn Fn(&ProbeRecord) -> f32| -> Plane {
        let mut values: Vec<f32> = probes.iter().map(of).collect();
        values.resize(texels, 0.0);
        (name, values)
    };
    let mut planes = vec![plane("validity".into(), &|probe| probe.validity)];
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        planes.push(plane(format!("position.{name}"), &|probe| {
            probe.position[axis] as f32
        }));
    }
    for k in 0..count(set.report.order) {
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            planes.push(plane(format!("sh.{k}.{name}"), &|probe| probe.sh[k][c]));
            planes.push(plane(format!("std_err.{k}.{name}"), &|probe| {
                probe.std_err[k][c]
            }));
        }
    }
    planes
}

/// A square of texels a probe, row by row.
fn distances(set: &ProbeSet) -> Vec<Plane> {
    let tile = edge(set.distance.first().map_or(1, Vec::len));
    let tiles = edge(set.distance.len());
    let size = tile * tiles;
    let plane = |name: &str, which: usize| {
        let value = |texel: usize| {
            let (x, y) = (texel % size, texel / size);
            let probe = set.distance.get(y / tile * tiles + x / tile);
            probe.map_or(0.0, |of| of[y % tile * tile + x % tile][which])
        };
        (name.to_owned(), (0..size * size).map(value).collect())
    };
    vec![plane("mean", 0), plane("square", 1)]
}
