//! A bake between its plan and its result.

use crate::bake::MakeBackend;
use crate::baked::{Baked, Page};
use crate::error::Error;
use crate::options::{Backend, Options};
use crate::resume::Saved;
use crate::scene::Scene;
use crate::write::{Writer, decisions};
use ::bake::{Baker, Pilot, Plan};
use atlas::Atlas;
use layers::Progress;
use rays::{RayBackend, World};
use report::{BakeReport, DecisionReport, Output, PhaseReport};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A bake that is planned and laid out and whose ray scene is built.
pub struct Job {
    scene: Scene,
    options: Options,
    baker: ::bake::Options,
    plan: Plan,
    world: World,
    atlas: Atlas,
    backend: Box<dyn RayBackend>,
    pool: Option<rayon::ThreadPool>,
    started: Instant,
    phases: Vec<PhaseReport>,
}

/// What a bake into a directory left there.
#[derive(Debug)]
#[non_exhaustive]
pub struct Written {
    /// The content of `bake.json`.
    pub report: BakeReport,
    /// Every file that was written.
    pub files: Vec<PathBuf>,
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job")
            .field("scene", &self.scene.path)
            .field("options", &self.options)
            .field("backend", &self.backend.describe())
            .finish_non_exhaustive()
    }
}

impl Job {
    pub(crate) fn prepare(
        scene: Scene,
        options: Options,
        backend: Backend,
        make_backend: Option<MakeBackend>,
        threads: Option<usize>,
    ) -> Result<Self, Error> {
        let started = Instant::now();
        let pool = match threads {
            None => None,
            Some(count) => Some(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(count.max(1))
                    .build()?,
            ),
        };
        let mut phases = Vec::new();
        let baker = options.baker();
        let (plan, world, atlas, backend) = within(pool.as_ref(), || {
            let (plan, world) = time(&mut phases, "plan", || Plan::of(&scene.0, &baker))?;
            let layout = || atlas::layout(&scene.0, &options.layout(), &|| false);
            let atlas = time(&mut phases, "atlas", layout).map_err(|source| Error::Layout {
                scene: scene.path.display().to_string(),
                source,
            })?;
            let build = || match &make_backend {
                Some(make) => make(&world),
                None => rays::build(backend.kind(), &world, rayon::current_num_threads()),
            };
            let backend = time(&mut phases, "build", build)?;
            Ok::<_, Error>((plan, world, atlas, backend))
        })?;
        Ok(Self {
            scene,
            options,
            baker,
            plan,
            world,
            atlas,
            backend,
            pool,
            started,
            phases,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The options.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The options as the baker takes them.
    pub fn baker_options(&self) -> &::bake::Options {
        &self.baker
    }

    /// What is modelled and why.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The planner's decisions as `bake.json` carries them.
    pub fn decisions(&self) -> Vec<DecisionReport> {
        decisions(&self.plan)
    }

    /// The triangles as the rays see them.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where every texel lies.
    pub fn atlas(&self) -> &Atlas {
        &self.atlas
    }

    /// What answers rays.
    pub fn backend(&self) -> &dyn RayBackend {
        self.backend.as_ref()
    }

    /// Wall time of what has been done so far.
    pub fn phases(&self) -> &[PhaseReport] {
        &self.phases
    }

    /// When it was begun.
    pub(crate) fn started(&self) -> Instant {
        self.started
    }

    /// Adds the time of a phase that ran before the job was prepared, such as loading.
    pub fn add_phase(&mut self, phase: &str, seconds: f64) {
        let report = PhaseReport {
            phase: phase.into(),
            seconds,
        };
        self.phases.insert(0, report);
        self.started -= std::time::Duration::from_secs_f64(seconds);
    }

    /// Bakes about `tiles` tiles spread over the atlas, for estimates of time and rays.
    pub fn pilot(&self, tiles: usize) -> Pilot {
        within(self.pool.as_ref(), || self.baker().pilot(tiles))
    }

    fn baker(&self) -> Baker<'_> {
        Baker::new(
            &self.world,
            &self.plan,
            self.backend.as_ref(),
            &self.atlas,
            &self.baker,
        )
    }

    /// Bakes every page and keeps the result in memory.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where the listener cancels.
    pub fn run(mut self, progress: &dyn Progress) -> Result<Baked, Error> {
        let started = Instant::now();
        let pages = within(self.pool.as_ref(), || {
            let baker = self.baker();
            (0..self.atlas.page_count)
                .map(|number| {
                    let mut page = baker.start(number);
                    baker.run(&mut page, progress);
                    match page.finished {
                        true => Ok(Page(page)),
                        false => Err(Error::Cancelled),
                    }
                })
                .collect::<Result<Vec<_>, Error>>()
        })?;
        self.phases.push(PhaseReport {
            phase: "bake".into(),
            seconds: started.elapsed().as_secs_f64(),
        });
        Ok(Baked::new(self, pages))
    }

    /// Bakes into a directory: pages are written as they are finished, so that one page is in memory at a time. Nothing stands under a
    /// final name until all of it is complete. Where the listener cancels, the state is saved, and the same call with `resume`
    /// continues it to the same bytes.
    ///
    /// # Errors
    /// The directory cannot be written, an output would replace an input, or [`Error::Cancelled`].
    pub fn run_into(
        &self,
        dir: &Path,
        resume: bool,
        progress: &dyn Progress,
    ) -> Result<Written, Error> {
        let output = Output::create(dir)?;
        let mut writer = Writer::new(self, output)?;
        let key = json!({
            "version": crate::VERSION,
            "options": self.options.describe(),
            "scene": self.scene.content_hash,
            "backend": self.backend.describe(),
        });
        let saved = Saved::new(dir, &self.scene.stem(), key);
        let (mut baking, mut writing) = (0.0, 0.0);
        let baker = self.baker();
        for number in 0..self.atlas.page_count {
            let mut page = baker.start(number);
            if resume {
                saved.restore(&mut page)?;
            }
            let clock = Instant::now();
            if !page.finished {
                within(self.pool.as_ref(), || baker.run(&mut page, progress));
            }
            baking += clock.elapsed().as_secs_f64();
            if !page.finished || self.atlas.page_count > 1 {
                saved.write(&page)?;
            }
            if !page.finished {
                return Err(Error::Cancelled);
            }
            let clock = Instant::now();
            within(self.pool.as_ref(), || writer.page(&page))?;
            writing += clock.elapsed().as_secs_f64();
        }
        let mut phases = self.phases.clone();
        for (phase, seconds) in [("bake", baking), ("write", writing)] {
            phases.push(PhaseReport {
                phase: phase.into(),
                seconds,
            });
        }
        let written = writer.finish(phases)?;
        saved.clear(self.atlas.page_count);
        Ok(written)
    }
}

/// Runs a job in the pool, or in the current one.
fn within<R: Send>(pool: Option<&rayon::ThreadPool>, job: impl FnOnce() -> R + Send) -> R {
    match pool {
        Some(pool) => pool.install(job),
        None => job(),
    }
}

/// Runs and times one phase.
fn time<R>(phases: &mut Vec<PhaseReport>, phase: &str, job: impl FnOnce() -> R) -> R {
    let started = Instant::now();
    let result = job();
    phases.push(PhaseReport {
        phase: phase.into(),
        seconds: started.elapsed().as_secs_f64(),
    });
    result
}
