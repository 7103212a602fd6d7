//! Probes of a scene: light for what moves.

mod kept;
mod lit;
mod shard;
mod task;
mod told;
mod volume;

pub use shard::{ProbePart, ProbeParts};
pub use volume::ProbeVolume;

use crate::error::Error;
use crate::parts::Kind;
use crate::write::names::check_length;
use crate::{Backend, Bounces, Engine, Resume, Scene, Sky};
use ::probes::{LEAST_EDGE, LEAST_RAYS};
use glam::DVec3;
use layers::Progress;
use rays::Light;
use report::{Output, ProbeReport, ProbeSet};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use task::Task;

/// Where probes stand.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Places {
    /// A grid over the scene with so many scene units between neighbours.
    Spacing(f64),
    /// A grid over the scene with so many probes along x, y and z.
    Grid([u32; 3]),
    /// Here.
    At(Vec<[f64; 3]>),
}

/// What decides the values of probes. [`Default`] has the program's own defaults.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ProbeOptions {
    /// The box of a grid, its corners with the least and the largest coordinates; `None` for that of the scene.
    pub within: Option<[[f64; 3]; 2]>,
    /// A finished bake of the scene, whose pages tell what surfaces reflect.
    pub bake: Option<PathBuf>,
    /// Light that comes from nowhere else; `None` for that of the bake, without one for a white sky of 1.
    pub sky: Option<Sky>,
    /// Lights that no ray meets, beside those of the file; `None` for those of the bake.
    pub lights: Option<Vec<Light>>,
    /// How often light is reflected where no bake tells.
    pub bounces: Bounces,
    /// Surfaces farther away do not count.
    pub max_distance: Option<f32>,
    /// Rays of a probe, at least 64.
    pub rays: u32,
    /// In place of a number of rays: the standard error of the light E / π, 1 under an open sky of 1, that each probe
    /// is to have at most.
    pub target_error: Option<f64>,
    /// With a target, the most rays of a probe.
    pub max_rays: u32,
    /// What the probes of a volume may miss where every second one along each axis tells the others: the light E / π of
    /// a probe, 1 under an open sky of 1, root mean square over normals and channels. Where neighbours tell a probe
    /// worse, all around it are gathered; `None` gathers all. Not for shards, of which none knows the others' probes.
    pub refine: Option<f64>,
    /// Order of the harmonics, 1 to 3.
    pub order: usize,
    /// Take the contrast at which a matt surface would receive less than no light.
    pub window: bool,
    /// Keep the light of the sky, of lights and of surfaces apart too.
    pub parts: bool,
    /// Seed of the sample points.
    pub seed: u64,
    /// Places of which reflection maps are made, too.
    pub reflections: Vec<[f64; 3]>,
    /// Edge of the faces of their largest level in texels: a power of two from 8 to 1024.
    pub reflection_size: u32,
    /// Ray library.
    pub backend: Backend,
    /// Random places at which interpolation between the probes of a grid is tried; 0 for none.
    pub tried: usize,
}

impl Default for ProbeOptions {
    fn default() -> Self {
        Self {
            within: None,
            bake: None,
            sky: None,
            lights: None,
            bounces: Bounces::Auto,
            max_distance: None,
            rays: 1024,
            target_error: None,
            max_rays: 65_536,
            refine: None,
            order: 2,
            window: false,
            parts: false,
            seed: 0,
            reflections: Vec::new(),
            reflection_size: 256,
            backend: Backend::best(),
            tried: 1000,
        }
    }
}

/// What the coefficients of a report are.
const CONVENTION: &str = "radiance that arrives, linear RGB, in the axes of the scene's file; real harmonics, \
                          orthonormal over the sphere, by l, then m from -l to l: 1; y, z, x; xy, yz, 3z²-1, xz, \
                          x²-y²; y(3x²-y²), xyz, y(5z²-1), z(5z²-3), x(5z²-1), z(x²-y²), x(x²-3y²)";

/// Most probes of a scene.
const MOST_PROBES: u64 = 1 << 20;

/// How far, in diagonals of a cell, distances are told: what lies farther hides no neighbour.
const REACH: f64 = 1.5;

/// Bounces after which no path goes on, where their number is left open; hardly any gets there.
const MOST_BOUNCES: u32 = 255;

/// The light that arrives at places of a scene, from all directions.
///
/// ```
/// use ambake::{Mesh, Places, ProbeOptions, Probes, Scene};
///
/// # fn main() -> Result<(), ambake::Error> {
/// let mut floor = Mesh::default();
/// floor.positions = vec![[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
/// floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
/// let scene = Scene::from_meshes(vec![floor], vec![])?;
///
/// let places = Places::At(vec![[0.0, 1.0, 0.0]]);
/// let probes = Probes::gather(&scene, &places, &ProbeOptions::default(), &())?;
/// let probe = &probes.report().probes[0];
/// // Nine coefficients of red, green and blue, each with its standard error.
/// assert_eq!((probe.sh.len(), probe.std_err.len()), (9, 9));
/// assert_eq!(probe.validity, 1.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Probes {
    stem: String,
    set: ProbeSet,
    inputs: Vec<PathBuf>,
    scene: Arc<::scene::Scene>,
    /// The bake that told what surfaces reflect.
    bake: Option<PathBuf>,
    /// What was saved while they were gathered.
    leftovers: Vec<PathBuf>,
}

impl Probes {
    /// The probes of a scene at places. Values are a function of the scene, the options and the seed, at any number of
    /// threads.
    ///
    /// # Errors
    /// One line that names the option or the file. [`Error::Cancelled`].
    pub fn gather(
        scene: &Scene,
        places: &Places,
        options: &ProbeOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        Task::with(scene, places, options, |task| {
            let mut kept = task.nothing();
            let span = task.span(progress, task.lacks(&kept, &|_| true));
            task.gather(&mut kept, &|_| true, &span)?;
            task.finish(kept, &span)
        })
    }

    /// The same for a directory: what is gathered is saved there now and then. Where the listener cancels, the process
    /// dies or a file cannot be written, the same call goes on to the same values. [`Self::write`] removes what was
    /// saved.
    ///
    /// * `resume`: what is done about a state that was saved.
    ///
    /// # Errors
    /// As [`Self::gather`]; a directory that cannot be written.
    pub fn gather_into(
        scene: &Scene,
        places: &Places,
        options: &ProbeOptions,
        (dir, resume): (&Path, Resume),
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        Task::with(scene, places, options, |task| {
            let name = Kind::Probes.state_name(&scene.stem(), None);
            let output = Output::create(dir)?;
            check_length(dir, &name)?;
            let state = dir.join(name);
            let mut kept = task.nothing();
            kept.save(output, state.clone(), json!({ "key": task.key }));
            if resume.wants(&state)
                && let Some(line) = kept.resume()?
            {
                progress.note(&line);
            }
            let span = task.span(progress, task.lacks(&kept, &|_| true));
            task.gather(&mut kept, &|_| true, &span)?;
            let mut probes = task.finish(kept, &span)?;
            probes.leftovers.push(state);
            Ok(probes)
        })
    }

    /// What is known of them, probe by probe.
    pub fn report(&self) -> &ProbeReport {
        &self.set.report
    }

    /// Writes `STEM.probes.json`, `STEM.probes.exr`, `STEM.probes.distance.exr` and the files of engines into a
    /// directory, all of them or none, and tells their names. Two engines take volumes alone: Bevy, and three.js for
    /// its texture.
    ///
    /// # Errors
    /// A file cannot be written, or an engine takes no such probes.
    pub fn write(
        &mut self,
        dir: impl AsRef<Path>,
        engines: &[Engine],
    ) -> Result<Vec<PathBuf>, Error> {
        let mut output = Output::create(dir.as_ref())?;
        output.protect(self.inputs.iter().cloned());
        if engines.contains(&Engine::Gltf) && !self.set.reflections.is_empty() {
            self.set.glb = match &self.bake {
                Some(dir) => Some(report::read_gltf(&dir.join(format!("{}.glb", self.stem)))?),
                None => report::source_gltf(&self.scene)?,
            };
        }
        report::stage_probes(&mut output, &self.stem, &mut self.set, engines)?;
        let written = output.publish()?;
        for path in self.leftovers.drain(..) {
            report::remove_journal(&path);
        }
        Ok(written)
    }
}

impl From<::probes::Error> for Error {
    fn from(error: ::probes::Error) -> Self {
        match error {
            ::probes::Error::Cancelled => Self::Cancelled,
        }
    }
}

fn check(options: &ProbeOptions) -> Result<(), Error> {
    for (flag, rays) in [("--rays", options.rays), ("--max-rays", options.max_rays)] {
        if rays < LEAST_RAYS {
            let problem = format!("{rays}; a probe takes at least {LEAST_RAYS}");
            return Err(Error::option(flag, problem));
        }
    }
    if !options
        .target_error
        .is_none_or(|target| target > 0.0 && target < 1.0)
    {
        return Err(Error::option(
            "--target-error",
            "it must be above 0 and below 1",
        ));
    }
    if !options
        .refine
        .is_none_or(|missed| missed > 0.0 && missed.is_finite())
    {
        return Err(Error::option("--refine", "it must be above 0"));
    }
    let edge = options.reflection_size;
    if !edge.is_power_of_two() || !(LEAST_EDGE..=1024).contains(&(edge as usize)) {
        let problem = format!("{edge}; it is a power of two from {LEAST_EDGE} to 1024");
        return Err(Error::option("--reflection-size", problem));
    }
    if !(1..=3).contains(&options.order) {
        let problem = format!("{}; it is 1, 2 or 3", options.order);
        return Err(Error::option("--order", problem));
    }
    Ok(())
}

/// Mean of coefficients.
fn mean(near: &[&Vec<DVec3>]) -> Vec<DVec3> {
    let sum = |k: usize| near.iter().map(|light| light[k]).sum::<DVec3>();
    (0..near[0].len())
        .map(|k| sum(k) / near.len() as f64)
        .collect()
}

fn rgb(values: &[DVec3]) -> Vec<[f32; 3]> {
    values
        .iter()
        .map(|value| value.as_vec3().to_array())
        .collect()
}
