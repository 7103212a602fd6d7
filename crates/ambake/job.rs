//! A bake between its plan and its result.

use crate::earlier::Earlier;
use crate::error::Error;
use crate::layout::{DECIDING, Layout, read};
use crate::memory;
use crate::options::{Backend, Options};
use crate::scene::Scene;
use crate::seen::oracle;
use ::bake::{Baker, Decision, Pilot, Plan};
use atlas::Atlas;
use layers::Progress;
use rays::{RayBackend, World};
use report::{DecisionReport, LayoutReport, PhaseReport, cpu_seconds};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Makes the backend of a bake over the world that its plan built.
pub(crate) type MakeBackend =
    Arc<dyn Fn(&World) -> Result<Box<dyn RayBackend>, rays::Error> + Send + Sync>;

/// What answers the rays of a bake: a library, or what the caller makes.
pub(crate) type Made = (Backend, Option<MakeBackend>);

/// What a bake has beside its scene and its options.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    /// What answers rays.
    pub made: &'a Made,
    /// Threads of its own.
    pub threads: Option<usize>,
    /// The memory that it may take.
    pub limit: memory::Limit,
    /// A layout made before, in memory, and in a file.
    pub layout: Option<&'a Layout>,
    pub layout_file: Option<&'a Path>,
    /// A finished bake of which is kept what still holds.
    pub update: Option<&'a Path>,
    /// Some of what is kept is baked again and compared.
    pub verify: bool,
}

/// A bake that is planned and laid out and whose ray scene is built. It can be run any number of times; clones, and
/// what [`Bake::prepare_on`](crate::Bake::prepare_on) makes of it, share layout and ray scene.
#[derive(Clone)]
pub struct Job {
    scene: Scene,
    options: Options,
    baker: ::bake::Options,
    plan: Arc<Plan>,
    laid: Arc<Laid>,
    pool: Option<Arc<rayon::ThreadPool>>,
    phases: Vec<PhaseReport>,
}

/// What several bakes of a scene can share.
struct Laid {
    world: World,
    atlas: Atlas,
    layout: LayoutReport,
    /// What is updated.
    earlier: Option<Earlier>,
    backend: Box<dyn RayBackend>,
    /// What made it.
    made: Made,
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job")
            .field("scene", &self.scene.path)
            .field("options", &self.options)
            .field("backend", &self.backend().describe())
            .finish_non_exhaustive()
    }
}

impl Job {
    pub(crate) fn prepare(
        scene: Scene,
        mut options: Options,
        given: Given<'_>,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let begin = |phase: &str| match progress.cancelled() {
            true => Err(Error::Cancelled),
            false => {
                progress.phase(phase);
                Ok(())
            }
        };
        if given.layout.is_some() && given.update.is_some() {
            let problem = "has its own in an update: charts keep the places of the earlier bake";
            return Err(Error::option("layout", problem));
        }
        begin("planning")?;
        let mut earlier = match given.update {
            Some(dir) => Some(Earlier::open(dir, &scene, given.verify)?),
            None => None,
        };
        let served = match given.layout {
            None => None,
            Some(layout) => Some(layout.serve(&scene, &options).ok_or_else(|| {
                let problem = "is of another scene or of other options; lay this bake out anew";
                Error::option("layout", problem)
            })?),
        };
        let pool = given.pool()?;
        let mut phases = Vec::new();
        let baker = options.baker().with_order(&scene.0);
        options.layers.clone_from(&baker.layers);
        let (plan, laid) = within(pool.as_deref(), || {
            let (plan, world) = time(&mut phases, "plan", || Plan::of(&scene.0, &baker))?;
            given.check_memory(&scene, options.size, &baker, &plan)?;
            let build = || match given.made {
                (_, Some(make)) => make(&world),
                (backend, None) => {
                    rays::build(backend.kind(), &world, rayon::current_num_threads())
                }
            };
            begin("building the ray scene")?;
            let backend = time(&mut phases, "build", build)?;
            let file = || {
                given
                    .layout_file
                    .and_then(|path| read(path, &scene, &options))
            };
            begin("laying out")?;
            let layout = || {
                let seen = oracle(&options, &world, backend.as_ref());
                let stable = earlier
                    .as_mut()
                    .and_then(|of| of.layout(&scene, &options, seen.as_deref()));
                match stable.or(served).or_else(file) {
                    Some(atlas) => Ok(atlas),
                    None => {
                        atlas::layout_seen(&scene.0, &options.layout(), seen.as_deref(), progress)
                    }
                }
            };
            let atlas = time(&mut phases, "atlas", layout).map_err(|source| match source {
                atlas::Error::Cancelled => Error::Cancelled,
                source => Error::Layout {
                    scene: scene.path.display().to_string(),
                    source,
                },
            })?;
            let layout = LayoutReport::of(&scene, &atlas);
            let laid = Laid {
                world,
                atlas,
                layout,
                earlier,
                backend,
                made: given.made.clone(),
            };
            Ok::<_, Error>((plan, laid))
        })?;
        Ok(Self {
            scene,
            options,
            baker,
            plan: Arc::new(plan),
            laid: Arc::new(laid),
            pool,
            phases,
        })
    }

    /// A bake of the same scene with other options, on the layout and the ray scene of this one.
    pub(crate) fn prepare_again(
        &self,
        scene: &Scene,
        mut options: Options,
        given: Given<'_>,
    ) -> Result<Self, Error> {
        let baker = options.baker().with_order(&self.scene.0);
        options.layers.clone_from(&baker.layers);
        if let Some(name) = self.differs(scene, &options, &baker, given) {
            let problem = "is not that of the earlier job, whose layout and ray scene depend on it; prepare this bake \
                           by itself";
            return Err(Error::option(name, problem));
        }
        let pool = match given.threads {
            None => self.pool.clone(),
            Some(_) => given.pool()?,
        };
        let mut phases = Vec::new();
        let plan = within(pool.as_deref(), || {
            let over = || Plan::over(&self.laid.world, &self.scene.0, &baker);
            let plan = time(&mut phases, "plan", over);
            given.check_memory(&self.scene, options.size, &baker, &plan)?;
            Ok::<_, Error>(plan)
        })?;
        Ok(Self {
            scene: self.scene.clone(),
            options,
            baker,
            plan: Arc::new(plan),
            laid: Arc::clone(&self.laid),
            pool,
            phases,
        })
    }

    /// What stands against a bake on the layout and the ray scene of this one.
    fn differs(
        &self,
        scene: &Scene,
        options: &Options,
        baker: &::bake::Options,
        given: Given<'_>,
    ) -> Option<&'static str> {
        let laid = &self.laid;
        if scene.content_hash != self.scene.content_hash {
            return Some("scene");
        }
        let (before, now) = (self.options.describe(), options.describe());
        if let Some(name) = DECIDING.into_iter().find(|name| before[name] != now[name]) {
            return Some(name);
        }
        let is_made_so = match (&laid.made, given.made) {
            ((_, Some(a)), (_, Some(b))) => Arc::ptr_eq(a, b),
            ((a, None), (b, None)) => a == b,
            _ => false,
        };
        if !is_made_so {
            return Some("backend");
        }
        let update = laid.earlier.as_ref().map(Earlier::asked);
        if update != given.update.map(|dir| (dir, given.verify)) {
            return Some("update");
        }
        baker.differs_in_world(&laid.world, &self.baker)
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
        let report = |decision: &Decision| DecisionReport {
            decision: decision.choice.name().into(),
            modelled: decision.modelled,
            reason: decision.reason.clone(),
            method: decision.method.map(|method| method.name().into()),
        };
        self.plan.decisions.iter().map(report).collect()
    }

    /// Every file that the bake is made from.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let mut inputs = self.scene().inputs.clone();
        inputs.extend(self.options().sky.file.clone());
        inputs
    }

    /// The triangles as the rays see them. Coordinates count from [`World::origin`].
    pub fn world(&self) -> &World {
        &self.laid.world
    }

    /// Where every texel lies.
    pub fn atlas(&self) -> &Atlas {
        &self.laid.atlas
    }

    /// The bake that this one updates.
    pub(crate) fn earlier(&self) -> Option<&Earlier> {
        self.laid.earlier.as_ref()
    }

    /// Where the texels went.
    pub fn layout_report(&self) -> &LayoutReport {
        &self.laid.layout
    }

    /// What answers rays.
    pub fn backend(&self) -> &dyn RayBackend {
        self.laid.backend.as_ref()
    }

    /// Wall time of what has been done so far.
    pub fn phases(&self) -> &[PhaseReport] {
        &self.phases
    }

    /// Runs something in the bake's own pool of threads, or in the current one.
    pub(crate) fn within<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        within(self.pool.as_deref(), job)
    }

    /// Adds the time of a phase that has just ended.
    pub(crate) fn end_phase(&mut self, phase: &str, seconds: f64) {
        self.phases.push(PhaseReport {
            phase: phase.into(),
            seconds,
            ..PhaseReport::default()
        });
    }

    /// Adds the time of a phase that ran before the job was prepared, such as loading.
    pub fn add_phase(&mut self, phase: &str, seconds: f64) {
        let report = PhaseReport {
            phase: phase.into(),
            seconds,
            ..PhaseReport::default()
        };
        self.phases.insert(0, report);
    }

    /// The memory of its pages.
    pub(crate) fn memory(&self) -> memory::Memory {
        memory::Memory::of(&self.baker, &self.plan)
    }

    /// Bakes about `tiles` tiles spread over the atlas, for estimates of time and rays.
    pub fn pilot(&self, tiles: usize) -> Pilot {
        self.within(|| self.baker().pilot(tiles))
    }

    /// What bakes its pages.
    pub(crate) fn baker(&self) -> Baker<'_> {
        let laid = &self.laid;
        Baker::new(
            &laid.world,
            &self.plan,
            laid.backend.as_ref(),
            &laid.atlas,
            &self.baker,
        )
    }
}

impl Given<'_> {
    /// Its own threads; `None` where it runs in those that call it.
    fn pool(&self) -> Result<Option<Arc<rayon::ThreadPool>>, Error> {
        let build = |count: usize| {
            let builder = rayon::ThreadPoolBuilder::new().num_threads(count.max(1));
            builder.build().map(Arc::new)
        };
        Ok(self.threads.map(build).transpose()?)
    }

    /// Refuses a bake that would take more memory than it may.
    fn check_memory(
        &self,
        scene: &Scene,
        size: u32,
        baker: &::bake::Options,
        plan: &Plan,
    ) -> Result<(), Error> {
        let meshes = scene.0.meshes.iter();
        let triangles = meshes.map(|mesh| mesh.triangles.len() as u64).sum();
        let content = [triangles, scene.0.instances.len() as u64];
        let memory = memory::Memory::of(baker, plan);
        memory::check(size, &memory, content, self.limit)
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
    let (started, cpu) = (Instant::now(), cpu_seconds());
    let result = job();
    phases.push(PhaseReport {
        phase: phase.into(),
        seconds: started.elapsed().as_secs_f64(),
        cpu_seconds: cpu.and_then(|before| Some(cpu_seconds()? - before)),
    });
    result
}
