//! What is to be gathered of a scene, in one row of numbers: probes, places between them, and faces of reflection maps.
//! Each depends on the scene, the options and its number alone, so that any part of the row can be made anywhere.

use super::kept::{Face, Kept};
use super::lit::Lit;
use super::told::{describe, file_name, pictures, record, reflection};
use super::{CONVENTION, MOST_BOUNCES, MOST_PROBES, Places, ProbeOptions, Probes, REACH, mean};
use crate::error::Error;
use crate::options::check::check_lamps;
use crate::{Bounces, Scene, VERSION};
use ::probes::{DISTANCE_EDGE, Gather, Grid, Placed, Reflection, State, fill, tried};
use ambient::harmonics::window;
use environment::Image;
use glam::DVec3;
use layers::Progress;
use rays::{Lamps, Light, Surfaces, World, WorldOptions};
use render::Lightmap;
use report::{InterpolationReport, PROBES_SCHEMA, ProbeGrid, ProbeReport, ProbeSet};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Faces of a cube, once for each half of its rays.
const FACES: u32 = 12;

/// Texels of reflection maps that take as long as a probe, about.
const TEXELS_OF_PROBE: u64 = 64;

/// All that is gathered.
pub(super) struct Task<'a> {
    scene: &'a Scene,
    places: &'a Places,
    options: &'a ProbeOptions,
    light: &'a Lit,
    gatherer: Gather<'a>,
    origin: DVec3,
    grid: Option<Grid>,
    /// Where probes are asked for, then where interpolation between them is tried.
    asked: Vec<DVec3>,
    /// How many of those are probes.
    probes: usize,
    /// Everything that decides the values.
    pub key: Value,
    /// The files that it is made from.
    pub inputs: Vec<PathBuf>,
}

/// Places of two kinds.
#[derive(Clone, Copy)]
enum Row {
    Probes,
    /// Those at which interpolation is tried.
    Tried,
}

/// What is wanted of a row.
pub(super) type Wanted<'a> = &'a dyn Fn(usize) -> bool;

impl<'a> Task<'a> {
    /// Makes a scene ready and calls `then` with what is to be gathered of it.
    ///
    /// # Errors
    /// One line that names the option or the file.
    pub fn with<T>(
        scene: &Scene,
        places: &Places,
        options: &ProbeOptions,
        then: impl FnOnce(&Task<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        super::check(options)?;
        check_lamps(scene)?;
        let (baked_scene, map) = match &options.bake {
            None => (Arc::clone(&scene.0), None),
            Some(dir) => {
                let (scene, map) = Lightmap::load(dir, &scene.stem(), "lambert")?;
                (Arc::new(scene), Some(map))
            }
        };
        let light = Lit::of(scene, options)?;
        let mut world = World::near(baked_scene, WorldOptions::default())?;
        world.turn_over(light.lights.iter().filter_map(Light::place));
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
        let (grid, mut asked) = stand(places, within, origin)?;
        if options.refine.is_some() && grid.is_none() {
            let problem = "it is for volumes; give --spacing or --grid";
            return Err(Error::option("--refine", problem));
        }
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
            reach: match grid {
                Some(grid) => REACH * grid.cell.length(),
                None => world.bounds().diagonal(),
            },
            seed: options.seed,
        };
        let probes = asked.len();
        if grid.is_some() {
            // Numbers after those of the grid: no place shares its points with a probe.
            asked.extend(tried(options.seed, within, options.tried));
        }
        let mut inputs = scene.inputs.clone();
        inputs.extend(world.scene().inputs.iter().cloned());
        inputs.extend(light.sky.file.clone());
        inputs.extend(map.iter().flat_map(|map| map.files().to_vec()));
        let pages = map.iter().flat_map(|map| map.files());
        let pages = pages.map(|path| light.hashes.get(&file_name(path)));
        let key = json!({
            "version": VERSION,
            "revision": crate::REVISION,
            "options": describe(places, options, &light),
            "scene": scene.content_hash,
            "pages": pages.collect::<Vec<_>>(),
            "backend": backend.describe(),
        });
        then(&Task {
            scene,
            places,
            options,
            light: &light,
            gatherer,
            origin,
            grid,
            asked,
            probes,
            key,
            inputs,
        })
    }

    /// Nothing of it.
    pub fn nothing(&self) -> Kept<'_> {
        let texels = self.edge().pow(2);
        Kept::new(&self.asked, self.options.order, self.faces(), texels)
    }

    /// Probes and places.
    pub fn places(&self) -> usize {
        self.asked.len()
    }

    /// Faces of reflection maps; their numbers follow those of places.
    pub fn faces(&self) -> u32 {
        FACES * self.options.reflections.len() as u32
    }

    fn edge(&self) -> usize {
        self.options.reflection_size as usize
    }

    /// How much is `wanted` and not there yet: how many places and how many faces.
    pub fn lacks(&self, kept: &Kept<'_>, wanted: Wanted<'_>) -> [u64; 2] {
        let place = |&place: &usize| wanted(place) && kept.placed[place].is_none();
        let face = |&face: &u32| wanted(self.places() + face as usize) && !kept.has_face(face);
        let places = (0..self.places()).filter(place).count();
        [places, (0..self.faces()).filter(face).count()].map(|count| count as u64)
    }

    /// Gathers the places that are `wanted` and not there yet.
    ///
    /// # Errors
    /// A file cannot be written, or [`Error::Cancelled`], with all that is there on the disk.
    pub fn gather(
        &self,
        kept: &mut Kept<'_>,
        wanted: Wanted<'_>,
        progress: &Span<'_>,
    ) -> Result<(), Error> {
        // A probe is moved by half of the way to its neighbours at most, so that none stands in another's cell.
        let most = self.grid.map_or(0.0, |grid| 0.5 * grid.cell.length());
        let mut before = 0;
        // Where light is uneven between the probes of the first round, a second one gathers the others.
        for (row, most) in [(Row::Probes, most), (Row::Probes, most), (Row::Tried, 0.0)] {
            let lacking = self
                .lacking(kept, row)
                .into_iter()
                .filter(|place| wanted(*place));
            let lacking: Vec<(u32, DVec3)> = lacking
                .map(|place| (place as u32, self.asked[place]))
                .collect();
            let store = Mutex::new(&mut *kept);
            let take = |number, placed| lock(&store).probe(number, placed);
            let span = progress.after(before);
            let gathered = ::probes::gather(&self.gatherer, &lacking, most, &span, take);
            saved(kept, gathered)?;
            before += lacking.len() as u64;
        }
        Ok(())
    }

    /// What is to be gathered next, and not there yet.
    fn lacking(&self, kept: &Kept<'_>, row: Row) -> Vec<usize> {
        let absent = |place: &usize| kept.placed[*place].is_none();
        match (row, self.options.refine.zip(self.grid)) {
            (Row::Probes, Some((missed, grid))) => {
                ::probes::lacking(&grid, &kept.placed[..self.probes], missed)
            }
            (Row::Probes, None) => (0..self.probes).filter(absent).collect(),
            (Row::Tried, _) => (self.probes..self.places()).filter(absent).collect(),
        }
    }

    /// The pixels of a face: those that are there, else gathered.
    ///
    /// # Errors
    /// As [`Self::gather`].
    pub fn face(
        &self,
        kept: &mut Kept<'_>,
        face: u32,
        progress: &dyn Progress,
    ) -> Result<Face, Error> {
        if let Some(pixels) = kept.face(face)? {
            return Ok(pixels);
        }
        let (number, side) = (face / FACES, face % FACES);
        let place = DVec3::from(self.options.reflections[number as usize]) - self.origin;
        let side = [side / 6, side % 6];
        let made = self
            .gatherer
            .capture(number, side, place, self.edge(), progress);
        let pixels = saved(kept, made.map_err(Error::from))?;
        kept.keep_face(face, &pixels)?;
        Ok(pixels)
    }

    /// The whole, of which all places are there; faces that are not are gathered.
    ///
    /// # Errors
    /// A file cannot be written, or [`Error::Cancelled`].
    pub fn finish(&self, mut kept: Kept<'_>, progress: &Span<'_>) -> Result<Probes, Error> {
        let mut reflections = Vec::new();
        let mut before = 0;
        for (number, at) in self.options.reflections.iter().enumerate() {
            let first = FACES * number as u32;
            let mut halves = [0, 6].map(|_| Image {
                width: self.edge(),
                height: 6 * self.edge(),
                pixels: Vec::new(),
            });
            for face in first..first + FACES {
                let is_new = !kept.has_face(face);
                let pixels = self.face(&mut kept, face, &progress.faces(before))?;
                halves[((face - first) / 6) as usize].pixels.extend(pixels);
                before += u64::from(is_new);
            }
            let place = DVec3::from(*at) - self.origin;
            reflections.push(self.gatherer.reflection(place, halves));
        }
        let mut placed = kept.placed;
        let found = placed.split_off(self.probes);
        let found: Vec<Placed> = found.into_iter().flatten().collect();
        let placed = match &self.grid {
            Some(grid) => ::probes::complete(grid, placed),
            None => placed.into_iter().flatten().collect(),
        };
        Ok(self.told(placed, &found, reflections))
    }

    /// What is said of all of it.
    fn told(&self, placed: Vec<Placed>, found: &[Placed], reflections: Vec<Reflection>) -> Probes {
        let Self {
            options, origin, ..
        } = *self;
        let stem = self.scene.stem();
        let mut filled: Vec<Vec<DVec3>> = placed.iter().map(|p| p.probe.light.clone()).collect();
        let mut interpolation = None;
        if let Some(grid) = &self.grid {
            let valid: Vec<bool> = placed.iter().map(|p| p.state != State::Invalid).collect();
            fill(grid, &mut filled, &valid, mean);
            interpolation = ::probes::interpolation(grid, &placed, &filled, found);
        }
        let strengths: Vec<Option<f64>> = match options.window {
            true => filled.iter_mut().map(|light| Some(window(light))).collect(),
            false => vec![None; filled.len()],
        };
        let told = reflections.iter().enumerate();
        let told = told.map(|(number, of)| reflection(&stem, number, of, origin));
        let record = |(placed, strength): (&Placed, &Option<f64>)| {
            record(placed, *strength, options, origin)
        };
        let report = ProbeReport {
            schema_version: PROBES_SCHEMA,
            version: VERSION.into(),
            scene: file_name(&self.scene.path),
            scene_hash: self.scene.content_hash.clone(),
            options: describe(self.places, options, self.light),
            order: options.order,
            convention: CONVENTION.into(),
            grid: self.grid.map(|grid| ProbeGrid {
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
            reach: self.gatherer.reach,
            files: Vec::new(),
            reflections: told.collect(),
            probes: placed.iter().zip(&strengths).map(record).collect(),
        };
        debug_assert!(
            placed
                .iter()
                .all(|p| p.probe.distance.len() == DISTANCE_EDGE.pow(2))
        );
        let set = ProbeSet {
            report,
            filled,
            distance: placed.into_iter().map(|p| p.probe.distance).collect(),
            reflections: reflections.into_iter().map(pictures).collect(),
            glb: None,
        };
        Probes {
            stem,
            set,
            inputs: self.inputs.clone(),
            scene: Arc::clone(&self.scene.0),
            bake: options.bake.clone(),
            leftovers: Vec::new(),
        }
    }

    /// What the job's listener hears of so many places and faces.
    pub fn span<'b>(&self, progress: &'b dyn Progress, [places, faces]: [u64; 2]) -> Span<'b> {
        let own = (self.edge() as u64).pow(2);
        Span {
            whole: progress,
            before: 0,
            places,
            face: own,
            all: places + faces * own / TEXELS_OF_PROBE,
            part: 1,
        }
    }
}

/// What a step of the work gave; where it was stopped, all that is there goes to the disk.
fn saved<T>(kept: &mut Kept<'_>, made: Result<T, Error>) -> Result<T, Error> {
    if let Err(Error::Cancelled) = made {
        kept.flush()?;
    }
    made
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A part of a job, for the job's listener.
pub(super) struct Span<'a> {
    whole: &'a dyn Progress,
    before: u64,
    /// Places of the job, and texels of each face, of which [`TEXELS_OF_PROBE`] are as much as one of them.
    places: u64,
    face: u64,
    all: u64,
    /// So many of its units are one of the whole's.
    part: u64,
}

impl Span<'_> {
    /// That of places after so many.
    fn after(&self, before: u64) -> Span<'_> {
        Span { before, ..*self }
    }

    /// That of a face after so many, and all places.
    pub fn faces(&self, before: u64) -> Span<'_> {
        Span {
            before: self.places + before * self.face / TEXELS_OF_PROBE,
            part: TEXELS_OF_PROBE,
            ..*self
        }
    }
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
