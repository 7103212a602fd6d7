//! Probes of a scene: light for what moves.

mod lit;
mod told;
mod volume;

pub use volume::ProbeVolume;

use crate::error::Error;
use crate::options::check_lamps;
use crate::{Backend, Bounces, Engine, Scene, Sky, VERSION};
use ::probes::{DISTANCE_EDGE, Gather, Grid, LEAST_EDGE, LEAST_RAYS, Placed, State, fill};
use ambient::harmonics::window;
use glam::DVec3;
use layers::Progress;
use lit::Lit;
use rays::{Lamps, Light, Surfaces, World, WorldOptions};
use render::Lightmap;
use report::{InterpolationReport, Output, PROBES_SCHEMA, ProbeGrid, ProbeReport, ProbeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use told::{describe, file_name, pictures, record, reflection};

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
const CONVENTION: &str = "radiance that arrives, linear RGB, in the axes of the scene's file; real harmonics, orthonormal over the sphere, by l, then m from \
                          -l to l: 1; y, z, x; xy, yz, 3z²-1, xz, x²-y²; y(3x²-y²), xyz, y(5z²-1), z(5z²-3), x(5z²-1), z(x²-y²), x(x²-3y²)";

/// Most probes of a scene.
const MOST_PROBES: u64 = 1 << 20;

/// Texels of reflection maps that take as long as a probe, about.
const TEXELS_OF_PROBE: u64 = 64;

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
        check(options)?;
        check_lamps(scene)?;
        let stem = scene.stem();
        let (baked_scene, map) = match &options.bake {
            None => (Arc::clone(&scene.0), None),
            Some(dir) => {
                let (scene, map) = Lightmap::load(dir, &stem, "lambert")?;
                (Arc::new(scene), Some(map))
            }
        };
        let light = Lit::of(scene, options)?;
        let world = World::near(baked_scene, WorldOptions::default())?;
        let backend = rays::build(options.backend.kind(), &world, rayon::current_num_threads())?;
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let origin = world.origin();
        let near = |light: &Light| light.from_origin(origin);
        let lights: Vec<Light> = light.lights.iter().map(near).collect();
        let baked = |hit: &rays::SurfaceHit| {
            let map = map.as_ref()?;
            Some(map.at(map.place(world.scene(), hit)?))
        };
        let within = within(options, &world);
        let (grid, asked) = stand(places, within, origin)?;
        let way = grid.map(|grid| grid.cell.length());
        let gatherer = Gather {
            surfaces: &surfaces,
            backend: backend.as_ref(),
            sky: ::probes::Sky(light.sky.light()),
            lamps: &lamps,
            lights: &lights,
            baked: map.is_some().then_some(&baked),
            bounces: match options.bounces {
                Bounces::Off => 0,
                Bounces::Auto => MOST_BOUNCES,
                Bounces::Most(count) => count,
            },
            max_distance: options.max_distance.unwrap_or(f32::INFINITY),
            rays: match options.target_error {
                Some(_) => options.max_rays,
                None => options.rays,
            },
            target: options.target_error,
            order: options.order,
            reach: way.map_or(world.bounds().diagonal(), |way| REACH * way),
            seed: options.seed,
        };
        let tried = if grid.is_some() { options.tried } else { 0 };
        let texels = 12 * u64::from(options.reflection_size).pow(2);
        let before_maps = (asked.len() + tried) as u64;
        // A texel is a small part of what a probe is.
        let all = before_maps + (options.reflections.len() as u64 * texels) / TEXELS_OF_PROBE;
        let span = |before| Span {
            whole: progress,
            before,
            all,
            part: 1,
        };
        // A probe is moved by half of the way to its neighbours at most, so that none stands in another's cell.
        let most = 0.5 * way.unwrap_or(0.0);
        let placed = ::probes::gather(&gatherer, &asked, 0, most, &span(0))?;
        let mut filled: Vec<Vec<DVec3>> = placed.iter().map(|p| p.probe.light.clone()).collect();
        let mut interpolation = None;
        if let Some(grid) = &grid {
            let valid: Vec<bool> = placed.iter().map(|p| p.state != State::Invalid).collect();
            fill(grid, &mut filled, &valid, mean);
            interpolation = ::probes::interpolation(
                &gatherer,
                grid,
                within,
                &placed,
                &filled,
                tried,
                &span(asked.len() as u64),
            )?;
        }
        let strengths: Vec<Option<f64>> = match options.window {
            true => filled.iter_mut().map(|light| Some(window(light))).collect(),
            false => vec![None; filled.len()],
        };
        let mut reflections = Vec::new();
        for (number, at) in options.reflections.iter().enumerate() {
            let progress = Span {
                part: TEXELS_OF_PROBE,
                ..span(before_maps + number as u64 * texels / TEXELS_OF_PROBE)
            };
            let (place, edge) = (DVec3::from(*at) - origin, options.reflection_size as usize);
            reflections.push(gatherer.reflection(number as u32, place, edge, &progress)?);
        }
        let told = reflections.iter().enumerate();
        let told = told.map(|(number, of)| reflection(&stem, number, of, origin));
        let record = |(placed, strength): (&Placed, &Option<f64>)| {
            record(placed, *strength, options, origin)
        };
        let report = ProbeReport {
            schema_version: PROBES_SCHEMA,
            version: VERSION.into(),
            scene: file_name(&scene.path),
            scene_hash: scene.content_hash.clone(),
            options: describe(places, options, &light),
            order: options.order,
            convention: CONVENTION.into(),
            grid: grid.map(|grid| ProbeGrid {
                low: (grid.low + origin).to_array(),
                cell: grid.cell.to_array(),
                counts: grid.counts.to_array(),
            }),
            interpolation: interpolation.map(|of| InterpolationReport {
                places: of.places,
                mean: of.mean,
                rms: of.rms,
                p99: of.p99,
                noise: of.noise,
            }),
            reach: gatherer.reach,
            files: Vec::new(),
            reflections: told.collect(),
            probes: placed.iter().zip(&strengths).map(record).collect(),
        };
        debug_assert!(
            placed
                .iter()
                .all(|p| p.probe.distance.len() == DISTANCE_EDGE.pow(2))
        );
        let mut inputs = scene.inputs.clone();
        inputs.extend(world.scene().inputs.iter().cloned());
        inputs.extend(light.sky.file.clone());
        inputs.extend(map.iter().flat_map(|map| map.files().to_vec()));
        let set = ProbeSet {
            report,
            filled,
            distance: placed.into_iter().map(|p| p.probe.distance).collect(),
            reflections: reflections.into_iter().map(pictures).collect(),
        };
        Ok(Self { stem, set, inputs })
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
        report::stage_probes(&mut output, &self.stem, &mut self.set, engines)?;
        Ok(output.publish()?)
    }
}

impl From<::probes::Error> for Error {
    fn from(error: ::probes::Error) -> Self {
        match error {
            ::probes::Error::Cancelled => Self::Cancelled,
            ::probes::Error::Map(error) => Self::Sky(error),
        }
    }
}

/// A part of a job, for the job's listener.
struct Span<'a> {
    whole: &'a dyn Progress,
    before: u64,
    all: u64,
    /// So many of its units are one of the whole's.
    part: u64,
}

impl Progress for Span<'_> {
    fn advance(&self, done: u64, _total: u64) {
        self.whole.advance(self.before + done / self.part, self.all);
    }

    fn rays(&self, cast: u64) {
        self.whole.rays(cast);
    }

    fn cancelled(&self) -> bool {
        self.whole.cancelled()
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

/// The box of a grid in the world.
fn within(options: &ProbeOptions, world: &World) -> [DVec3; 2] {
    match options.within {
        Some(corners) => corners.map(|corner| DVec3::from(corner) - world.origin()),
        None => [world.bounds().min, world.bounds().max],
    }
}

/// The grid, where there is one, and where probes are asked for in the world.
fn stand(
    places: &Places,
    [low, high]: [DVec3; 2],
    origin: DVec3,
) -> Result<(Option<Grid>, Vec<DVec3>), Error> {
    let (flag, grid) = match places {
        Places::At(places) => {
            let near = |place: &[f64; 3]| DVec3::from(*place) - origin;
            return Ok((None, places.iter().map(near).collect()));
        }
        Places::Spacing(spacing) => ("--spacing", Grid::of_spacing(low, high, *spacing)),
        Places::Grid(counts) => ("--grid", Grid::of_counts(low, high, *counts)),
    };
    if grid.len() > MOST_PROBES || grid.is_empty() {
        let problem = format!(
            "it makes {} probes, and 1 to {MOST_PROBES} can be made; give other numbers, or a box with --within",
            grid.len()
        );
        return Err(Error::option(flag, problem));
    }
    let places = (0..grid.len() as usize).map(|index| grid.place(index));
    Ok((Some(grid), places.collect()))
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
